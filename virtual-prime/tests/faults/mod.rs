//! The fault table: all faults of a machine, its reactions and their time limits, each fault injected while
//! the image runs, in the states where it matters. The first case of every class is part of `make test`;
//! `make faults` runs all and draws the page. The table of `docs/safety.md` is made of the table here:
//! `WRITE_SAFETY=1` writes it.

mod axes;
mod cards;
mod document;
mod drivers;
mod fans;
mod firmware;
mod heaters;
mod laser;
mod page;
mod scene;
mod sensors;
mod supplies;

use crate::power_cuts;
use scene::{Seen, State};

/// A class of faults.
pub struct Class {
    /// Name of the class's test.
    pub name: &'static str,
    /// Fault in words, for the document.
    pub what: &'static str,
    /// Reaction of the machine, for the document.
    pub does: &'static str,
    /// Cases by state, the first of which is in `make test`.
    pub cases: &'static [Case],
}

/// A fault of a class in one state.
pub struct Case {
    /// State of the machine when the fault happens.
    pub state: State,
    /// Time limit of the reaction, milliseconds.
    pub within_ms: f64,
    /// Injects the fault, and asserts the machine's reaction.
    pub run: fn(&Self) -> Seen,
}

impl Case {
    /// Runs the case and compares its times with the limit.
    #[track_caller]
    fn check(&self, class: &Class) -> Seen {
        let seen = (self.run)(self);
        for (what, ms) in [("the outputs were safe", seen.outputs_ms), ("nothing moved any more", seen.motion_ms)] {
            let Some(ms) = ms else { continue };
            assert!(ms <= self.within_ms, "{}, {}: {what} after {ms:.1} ms", class.what, self.state.words());
        }
        // Words take ten bits a character, and are looked for every five milliseconds.
        let told = seen.told_ms.unwrap_or(0.0);
        assert!(told <= self.within_ms + scene::TELLING_MS, "{}: told after {told:.1} ms", class.what);
        println!("{}, {}: {seen:?}", class.what, self.state.words());
        seen
    }
}

/// The whole table, by part of the machine.
const TABLE: &[(&str, &[Class])] = &[
    ("Sensors", sensors::CLASSES),
    ("Heaters", heaters::CLASSES),
    ("Fans", fans::CLASSES),
    ("Supplies", supplies::CLASSES),
    ("Motor drivers", drivers::CLASSES),
    ("Axes, probe, buttons", axes::CLASSES),
    ("Laser", laser::CLASSES),
    ("Card and configuration", cards::CLASSES),
    ("The firmware itself", firmware::CLASSES),
];

/// Runs the first case of a class, as its test.
#[track_caller]
fn share(classes: &[Class], name: &str) {
    let class = classes.iter().find(|class| class.name == name).expect("a class");
    class.cases[0].check(class);
}

/// Makes a test for each class of a file.
macro_rules! tests {
    ($($name:ident)+) => {
        $(#[test]
        fn $name() {
            super::share(CLASSES, stringify!($name));
        })+

        #[test]
        fn every_class_has_its_test() {
            let named = [$(stringify!($name)),+];
            assert!(CLASSES.iter().map(|class| class.name).eq(named), "the tests below the table are to be its rows");
        }
    };
}
use tests;

#[test]
fn the_table_is_whole() {
    let classes: Vec<&Class> = TABLE.iter().flat_map(|(_, classes)| *classes).collect();
    assert!(classes.len() >= 40, "{} classes", classes.len());
    for class in classes {
        assert!(!class.cases.is_empty(), "{} has no case", class.name);
    }
}

/// Tests that take minutes and have no limit: the power goes at each write of a job, and the results are on a
/// page of their own.
const LONG: &[(&str, &str, fn() -> String)] = &[
    ("power_cuts_of_a_large_card", "the power goes at each block write of a job, FAT32", power_cuts::of_a_large_card),
    ("power_cuts_of_a_small_card", "the power goes at each block write of a job, FAT16", power_cuts::of_a_small_card),
];

/// A task to be run, with its names.
enum Task<'a> {
    Case(&'a str, &'a Class, &'a Case),
    Long(fn() -> String),
}

/// Lists the requested tasks: everything, or the classes whose names contain `FAULTS_ONLY`.
fn tasks() -> Vec<Task<'static>> {
    let only = std::env::var("FAULTS_ONLY").unwrap_or_default();
    let long = LONG.iter().filter(|(name, ..)| name.contains(&only)).map(|(_, _, run)| Task::Long(*run));
    let short = TABLE
        .iter()
        .flat_map(|(part, classes)| classes.iter().map(move |class| (*part, class)))
        .filter(|(_, class)| class.name.contains(&only))
        .flat_map(|(part, class)| class.cases.iter().map(move |case| Task::Case(part, class, case)));
    // Long tasks go first, so that no core waits for one in the end.
    let tasks: Vec<Task> = long.chain(short).collect();
    let names = || TABLE.iter().flat_map(|(_, classes)| *classes).map(|class| class.name);
    let all = || names().chain(LONG.iter().map(|(name, ..)| *name)).collect::<Vec<_>>().join(" ");
    // Tests on the host were run beforehand, or were not asked for.
    let is_run = !tasks.is_empty() || !std::env::var("FAULTS_HOST").unwrap_or_default().is_empty();
    assert!(is_run, "no class has {only:?} in its name; there are: {}", all());
    tasks
}

/// Runs two tasks at a time, as the machine has cores.
#[test]
#[ignore = "long: make faults"]
fn every_case_and_the_page() {
    let tasks = tasks();
    let next = std::sync::atomic::AtomicUsize::new(0);
    let ends: Vec<std::sync::Mutex<Option<End>>> = tasks.iter().map(|_| std::sync::Mutex::default()).collect();
    std::thread::scope(|scope| {
        let work = || {
            while let Some((number, task)) =
                Some(next.fetch_add(1, std::sync::atomic::Ordering::Relaxed)).and_then(|n| Some((n, tasks.get(n)?)))
            {
                *ends[number].lock().expect("nobody panics with it") = Some(end(task));
            }
        };
        let cores = std::thread::available_parallelism().map_or(1, std::num::NonZeroUsize::get);
        (0..cores).for_each(|_| drop(scope.spawn(work)));
    });
    let mut rows = Vec::new();
    let mut others = Vec::new();
    for (task, end) in tasks.iter().zip(ends) {
        match (task, end.into_inner().expect("done").expect("each was run")) {
            (Task::Case(part, class, case), End::Case(seen)) => rows.push(page::Row { part, class, case, seen }),
            (Task::Long(run), End::Long(text)) => {
                let (name, what, _) =
                    LONG.iter().find(|(.., long)| std::ptr::fn_addr_eq(*long, *run)).expect("its row");
                others.push(page::Other { name, what, text });
            }
            _ => unreachable!("a task ends as what it is"),
        }
    }
    // Result of the tests that were run on the host beforehand.
    match std::env::var("FAULTS_HOST").as_deref() {
        Ok("ok") => others.push(page::Other { name: HOST.0, what: HOST.1, text: Ok("none made another part".into()) }),
        Ok("failed") => others.push(page::Other { name: HOST.0, what: HOST.1, text: Err("see the console".into()) }),
        _ => {}
    }
    if let Some(folder) = std::env::var_os("FAULTS_OUT") {
        let folder = std::path::Path::new(&folder);
        std::fs::write(folder.join("report.html"), page::draw(&rows, &others)).expect("the page");
        std::fs::write(folder.join("summary.json"), page::summary(&rows, &others)).expect("the summary");
    }
    let missed = page::failed(&rows, &others);
    assert!(missed.is_empty(), "{} of {} failed: {missed:#?}", missed.len(), rows.len() + others.len());
}

const HOST: (&str, &str) = ("power_cuts_on_the_host", "the power goes at each block write of a job, on the host");

/// Result of a task.
enum End {
    Case(Result<Seen, String>),
    Long(Result<String, String>),
}

fn end(task: &Task) -> End {
    let words = |why: Box<dyn std::any::Any + Send>| match why.downcast::<String>() {
        Ok(text) => *text,
        Err(why) => why.downcast_ref::<&str>().map_or("it panicked", |text| text).to_owned(),
    };
    match task {
        Task::Case(_, class, case) => End::Case(std::panic::catch_unwind(|| case.check(class)).map_err(words)),
        Task::Long(run) => End::Long(std::panic::catch_unwind(run).map_err(words)),
    }
}

#[test]
fn the_machine_listens_within_two_seconds_of_power_on() {
    use crate::common::velvet::{Plan, SECOND};
    let velvet = Plan::new().start();
    assert!(velvet.now_ms() < 2 * SECOND, "{} ms", velvet.now_ms());
}
