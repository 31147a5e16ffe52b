//! Recorded console sessions of Smoothieware v2, played to the image on the board: it answers as the same
//! machine does on a desk, where `tests/tests/v2_replay` holds each reply against v2's.

use std::sync::{Mutex, PoisonError};

use sim::world::TimedFault;

#[path = "../../tests/tests/v2_replay/mask.rs"]
mod mask;
#[path = "../../tests/tests/v2_replay/page.rs"]
mod page;
#[path = "../../tests/tests/v2_replay/play.rs"]
mod play;
#[path = "../../tests/tests/v2_replay/record.rs"]
mod record;

use crate::common::velvet::{Plan, Velvet};
use page::Counts;
use play::Desk;
use record::{Record, differences};

/// Inputs about the board itself, or about moments that a faster or slower board has elsewhere.
const OWN: &[&str] =
    &["version", "version ;x", "mem", "M115", "get volts", "get steps", "dfu", "?", "\\x18", "\\x19", "$I"];

/// Heading of the page's section with the numbers of the board.
const HEADING: &str = "## On the virtual board\n";

/// Greetings of a machine that is ready.
const GREETINGS: &[&str] = &["Welcome to Smoothie\nok\n", "['$' for help]"];

impl Desk for Velvet {
    fn send(&mut self, bytes: &[u8]) {
        self.bench.console.send(bytes);
    }

    fn hear(&mut self, seconds: f64) -> String {
        Self::hear(self, (seconds * 1_000.0) as u64)
    }

    fn inject(&mut self, fault: &str) {
        let fault = TimedFault::parse(fault).expect("a fault").fault;
        self.world(|world| world.inject(&fault)).expect("a part of this machine");
    }
}

fn replay(name: &str, text: &str) {
    let mut record = Record::parse(text);
    let (base, settings) = play::machine(&record);
    let plan = settings.into_iter().fold(Plan::new().config(base), Plan::set);
    let plan = play::card().iter().fold(plan, |plan, (name, text)| plan.file(name, text));
    let mut velvet = plan.held();
    while !GREETINGS.iter().any(|greeting| velvet.said().contains(greeting)) {
        assert!(velvet.now_ms() < 5_000, "{}", velvet.said());
        Velvet::hear(&mut velvet, 100);
    }
    velvet.send(b"mkdir sub\n");
    Velvet::hear(&mut velvet, 500);
    // The machine on the desk does not start again.
    if let Some(reset) = record.exchanges.iter().position(|exchange| exchange.input() == "reset") {
        record.exchanges.truncate(reset);
    }
    let answers = play::play(&mut velvet, &record);
    let (mut counts, mut complaints) = (Counts::default(), String::new());
    for (exchange, answer) in record.exchanges.iter().zip(answers) {
        let input = exchange.input();
        let mut answer = mask::mask(input, &answer);
        let mut ours = mask::mask(input, &exchange.ours);
        // Lines about temperature are left out, as the virtual chip is warmer than the host runner, and a
        // motor stopped on its way stands elsewhere.
        for reply in [&mut answer, &mut ours] {
            reply.retain(|line| !line.starts_with("chip temp") && !line.starts_with("Microstep position"));
        }
        // A text of help is the same on both, and its record says only that there is one.
        let is_help = ours.first().is_some_and(|line| line == "<help>");
        if OWN.contains(&input) {
            counts.other += 1;
        } else if is_help || answer == ours || input.starts_with("M114") && are_nearly_equal(&ours, &answer) {
            counts.count(&mask::mask(input, &exchange.theirs), &mask::mask(input, &exchange.ours));
        } else {
            complaints += &format!("{name}: {input}\n");
            for (sign, line) in differences(&ours, &answer) {
                complaints += &format!("    {sign}{line}\n");
            }
        }
    }
    println!("{}", counts.row(name).trim_end());
    assert!(complaints.is_empty(), "{complaints}");
    hold_row(name, &counts);
}

/// Adds the row of a session to the table, and updates the sum.
fn with_row(table: &str, name: &str, counts: &Counts) -> String {
    let name_of = |line: &str| line.split(' ').nth(1).unwrap_or("").to_owned();
    let mut rows: Vec<String> = table.lines().skip(2).filter(|line| !line.is_empty()).map(str::to_owned).collect();
    rows.retain(|row| name_of(row) != name && name_of(row) != "all");
    rows.push(counts.row(name).trim_end().to_owned());
    rows.sort_by_key(|row| name_of(row));
    let mut sum = [0; 5];
    for row in &rows {
        let numbers = row.split('|').skip(2).filter_map(|cell| cell.trim().parse::<usize>().ok());
        sum.iter_mut().zip(numbers).for_each(|(sum, number)| *sum += number);
    }
    let [replies, equal, live, explained, other] = sum;
    rows.push(format!("| all | {replies} | {equal} | {live} | {explained} | {other} |\n\n"));
    let head: Vec<_> = table.lines().take(2).collect();
    head.join("\n") + "\n" + &rows.join("\n")
}

/// Asserts that the page has these numbers for a session, or writes them. Sessions are played at the same
/// time.
fn hold_row(name: &str, counts: &Counts) {
    static PAGE: Mutex<()> = Mutex::new(());
    let _one_at_a_time = PAGE.lock().unwrap_or_else(PoisonError::into_inner);
    let page = page::read();
    let intro_and_table = page::part(&page, HEADING);
    let table = intro_and_table.find("\n|").expect("a table");
    let (intro, table) = intro_and_table.split_at(table + 1);
    page::hold(HEADING, &(intro.to_owned() + &with_row(table, name, counts))).expect("the same counts");
}

/// Whether two answers are equal, but for a place where a motion was stopped on its way.
fn are_nearly_equal(desk: &[String], board: &[String]) -> bool {
    let is_near = |(a, b): (&str, &str)| {
        let number = |word: &str| word.rsplit(':').next().and_then(|number| number.parse::<f64>().ok());
        let name = |word: &str| word.rsplit_once(':').map(|(name, _)| name.to_owned());
        let near = number(a).zip(number(b)).is_some_and(|(a, b)| (a - b).abs() < 0.2);
        a == b || (name(a).is_some() && name(a) == name(b) && near)
    };
    let are_near = |(a, b): (&String, &String)| {
        a.split(' ').count() == b.split(' ').count() && a.split(' ').zip(b.split(' ')).all(is_near)
    };
    desk.len() == board.len() && desk.iter().zip(board).all(are_near)
}

macro_rules! sessions {
    ($($name:ident)*) => {
        $(
            #[test]
            fn $name() {
                replay(stringify!($name), include_str!(concat!("../../tests/tests/data/v2/", stringify!($name), ".txt")));
            }
        )*
    };
}

sessions! { homed mcodes }

/// Sessions whose machine is told the same on both: some minutes.
mod all {
    use super::replay;

    macro_rules! long_sessions {
        ($($name:ident)*) => {
            $(
                #[test]
                #[ignore = "long: make replay runs it"]
                fn $name() {
                    replay(stringify!($name), include_str!(concat!("../../tests/tests/data/v2/", stringify!($name), ".txt")));
                }
            )*
        };
    }

    // Session `files` is left out: the places of its jobs when they are asked for depend on the speed of the
    // card.
    long_sessions! { delta dollar drill ext faults gcodes gcodes2 grbl grid h2 halt laser laser_cnc malformed malformed2
    malformed_grbl misc misc2 names over probe probe2 shell temps three upload }
}
