//! The fault table: everything that goes wrong with a machine, what it does then, and how soon, each fault
//! injected while the image runs, in the states where it matters. The first case of every class is part of
//! `make test`; `make faults` runs all and draws the page. The table of `docs/safety.md` is made of this one:
//! `WRITE_SAFETY=1` writes it.

mod axes;
mod cards;
mod document;
mod drivers;
mod firmware;
mod heaters;
mod page;
mod scene;
mod sensors;
mod supplies;

use scene::{Seen, State};

/// A class of faults.
pub struct Class {
    /// Its test's name.
    pub name: &'static str,
    /// What fails.
    pub what: &'static str,
    /// What the machine does.
    pub does: &'static str,
    /// In which states, the first one in `make test`.
    pub cases: &'static [Case],
}

/// A fault of a class in one state.
pub struct Case {
    /// What the machine does when it happens.
    pub state: State,
    /// How soon the machine must have reacted, milliseconds.
    pub within_ms: f64,
    /// Makes it happen, and asserts what the machine does.
    pub run: fn(&Self) -> Seen,
}

impl Case {
    /// Runs it and holds its times against the limit.
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
    ("Supplies", supplies::CLASSES),
    ("Motor drivers", drivers::CLASSES),
    ("Axes, probe, buttons", axes::CLASSES),
    ("Card and configuration", cards::CLASSES),
    ("The firmware itself", firmware::CLASSES),
];

/// Runs the first case of a class.
#[track_caller]
fn share(classes: &[Class], name: &str) {
    let class = classes.iter().find(|class| class.name == name).expect("a class");
    class.cases[0].check(class);
}

/// A test for each class of a file.
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

/// Two at a time, as the machine has cores.
#[test]
#[ignore = "long: make faults"]
fn every_case_and_the_page() {
    let all: Vec<(&str, &Class, &Case)> = TABLE
        .iter()
        .flat_map(|(part, classes)| classes.iter().map(move |class| (*part, class)))
        .flat_map(|(part, class)| class.cases.iter().map(move |case| (part, class, case)))
        .collect();
    let next = std::sync::atomic::AtomicUsize::new(0);
    let results: Vec<std::sync::Mutex<Option<Seen>>> = all.iter().map(|_| std::sync::Mutex::default()).collect();
    std::thread::scope(|scope| {
        let work = || {
            while let Some((number, (_, class, case))) =
                Some(next.fetch_add(1, std::sync::atomic::Ordering::Relaxed)).and_then(|n| Some((n, all.get(n)?)))
            {
                let done = std::panic::catch_unwind(|| case.check(class));
                *results[number].lock().expect("nobody panics with it") = done.ok();
            }
        };
        let cores = std::thread::available_parallelism().map_or(1, std::num::NonZeroUsize::get);
        (0..cores).for_each(|_| drop(scope.spawn(work)));
    });
    let rows: Vec<page::Row> = all
        .iter()
        .zip(results)
        .map(|((part, class, case), seen)| page::Row { part, class, case, seen: seen.into_inner().expect("done") })
        .collect();
    if let Some(folder) = std::env::var_os("FAULTS_OUT") {
        std::fs::write(std::path::Path::new(&folder).join("faults.html"), page::draw(&rows)).expect("the page");
    }
    let missed: Vec<_> = rows.iter().filter(|row| row.seen.is_none()).map(page::Row::name).collect();
    assert!(missed.is_empty(), "{} of {} failed: {missed:#?}", missed.len(), rows.len());
}

#[test]
fn the_machine_listens_within_two_seconds_of_power_on() {
    use crate::common::velvet::{Plan, SECOND};
    let velvet = Plan::new().start();
    assert!(velvet.now_ms() < 2 * SECOND, "{} ms", velvet.now_ms());
}
