//! Recorded console sessions of Smoothieware v2, replayed to our machine. Each reply is v2's, or differs for
//! a reason that stands in `docs/differences.md`.
//!
//! After a change that is meant, `WRITE_V2=1 cargo test -p scenarios v2_replay::` writes what ours
//! answers into the records. `V2=shell` plays the sessions of that name alone.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};

mod mask;
mod page;
mod play;
mod reasons;
mod record;
mod rules;

use page::Counts;
use play::Desk;
use reasons::Reasons;
use record::{Exchange, Record, Step, differences};
use rules::Rules;
use scenarios::{Bench, Plan};
use sim::world::TimedFault;

impl Desk for Bench {
    fn send(&mut self, bytes: &[u8]) {
        Self::send(self, bytes);
    }

    fn hear(&mut self, seconds: f64) -> String {
        Self::hear(self, seconds)
    }

    fn inject(&mut self, fault: &str) {
        let fault = TimedFault::parse(fault).expect("a fault").fault;
        self.world(|world| world.inject(&fault)).expect("a part of this machine");
    }
}

fn start(record: &Record) -> Bench {
    let (base, settings) = play::machine(record);
    let plan = settings.into_iter().fold(Plan::new(base), Plan::set).folder("sub");
    play::card().iter().fold(plan, |plan, (name, text)| plan.file(name, text)).start()
}

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/v2")
}

fn sessions() -> Vec<(String, PathBuf)> {
    let wanted = std::env::var("V2").unwrap_or_default();
    let mut found: Vec<_> = fs::read_dir(folder())
        .expect("the records")
        .map(|entry| entry.expect("a file").path())
        .filter(|path| path.extension().is_some_and(|ending| ending == "txt"))
        .map(|path| (path.file_stem().expect("a name").to_string_lossy().into_owned(), path))
        .filter(|(name, _)| wanted.is_empty() || *name == wanted)
        .collect();
    found.sort();
    found
}

/// Reasons for different replies: a session in GRBL's dialect has rules for every line.
struct Why {
    reasons: Reasons,
    rules: Rules,
}

impl Why {
    fn read() -> Self {
        Self { reasons: Reasons::read(&folder()), rules: Rules::read(&folder()) }
    }

    /// The topics that explain this difference.
    fn of(&self, session: &str, record: &[String], exchange: &Exchange) -> Option<Vec<&str>> {
        if record.iter().any(|line| line == "set: [general] grbl_mode = true") {
            return self.rules.of(exchange);
        }
        self.reasons.of(session, exchange).map(|topic| vec![topic])
    }
}

#[test]
fn replies_are_those_of_v2_or_listed() {
    let why = Why::read();
    let mut tables = Vec::new();
    let mut complaints = String::new();
    let mut per_reason: BTreeMap<&str, usize> = BTreeMap::new();
    for (name, path) in sessions() {
        let mut record = Record::parse(&fs::read_to_string(&path).expect("a record"));
        for exchange in &mut record.exchanges {
            exchange.theirs = mask::mask(exchange.input(), &exchange.theirs);
            exchange.ours = mask::mask(exchange.input(), &exchange.ours);
        }
        let mut counts = Counts::default();
        let answers = play::play(&mut start(&record), &record);
        for (exchange, answer) in record.exchanges.iter_mut().zip(answers) {
            let answer = reasons::help(mask::mask(exchange.input(), &answer), &exchange.theirs);
            if answer != exchange.ours && !page::writes() {
                complaints += &format!("{name}: {} answers otherwise than before:\n", exchange.input());
                complaints += &shown(&exchange.ours, &answer);
            }
            exchange.ours = answer;
            if exchange.ours == exchange.theirs {
                counts.count(&exchange.theirs, &exchange.ours);
            } else if let Some(topics) = why.of(&name, &record.head, exchange) {
                counts.count(&exchange.theirs, &exchange.ours);
                topics.into_iter().for_each(|topic| *per_reason.entry(topic).or_default() += 1);
            } else {
                counts.other += 1;
                complaints += &format!("{name}: {}\n", exchange.input());
                complaints += &shown(&exchange.theirs, &exchange.ours);
            }
        }
        if page::writes() {
            fs::write(&path, printed(&record)).expect("the record");
        }
        tables.push((name, counts));
    }
    let table = table(&tables);
    println!("{table}");
    let mut reasons = "\n| replies | reason |\n|---|---|\n".to_owned();
    per_reason.iter().for_each(|(reason, count)| reasons += &format!("| {count} | {reason} |\n"));
    if std::env::var_os("V2").is_none() {
        why.reasons.unused().for_each(|pattern| complaints += &format!("reasons: nothing needs `{pattern}`\n"));
        why.rules.unused().for_each(|rule| complaints += &format!("rules.grbl: nothing needs `{rule}`\n"));
        for (heading, text) in [("## On the host\n", table + "\n"), ("## Reasons\n", reasons)] {
            complaints += &page::hold(heading, &text).err().unwrap_or_default();
        }
    }
    assert!(complaints.is_empty(), "{complaints}");
}

/// The record as its file has it.
fn printed(record: &Record) -> String {
    let mut text = String::new();
    for line in &record.head {
        writeln!(text, "{line}").expect("a string");
    }
    for exchange in &record.exchanges {
        for step in &exchange.steps {
            let (sign, rest) = match step {
                Step::Line(rest) => (">", rest),
                Step::Raw(rest) => (">>", rest),
                Step::Wait(rest) => (".", rest),
                Step::Fault(rest) => ("*", rest),
                Step::Ours(rest) => ("!", rest),
            };
            writeln!(text, "{sign} {rest}").expect("a string");
        }
        if let Some(patience) = &exchange.patience {
            writeln!(text, "@ {patience}").expect("a string");
        }
        for (sign, line) in differences(&exchange.theirs, &exchange.ours) {
            writeln!(text, "{sign}{line}").expect("a string");
        }
    }
    text
}

fn shown(before: &[String], after: &[String]) -> String {
    differences(before, after).into_iter().map(|(sign, line)| format!("    {sign}{line}\n")).collect()
}

fn table(sessions: &[(String, Counts)]) -> String {
    let mut text = "\n| session | replies | equal | live numbers | for a reason | unexplained |\n".to_owned();
    text += "|---|---|---|---|---|---|\n";
    let mut sum = Counts::default();
    for (name, counts) in sessions {
        text += &counts.row(name);
        let Counts { equal, live, explained, other } = counts;
        sum.equal += equal;
        sum.live += live;
        sum.explained += explained;
        sum.other += other;
    }
    text + &sum.row("all")
}
