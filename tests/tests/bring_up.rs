//! The console's words in `docs/bring-up.md`: each dialogue is held with a machine in the state of its step.

use scenarios::{Bench, CARTESIAN, Plan};
use sim::runner::CardState;

const PAGE: &str = include_str!("../../docs/bring-up.md");
/// Time within which a line is answered, seconds. The supply monitor runs once a second.
const ANSWER_S: f64 = 2.5;
/// Time within which an unsolicited message comes, seconds.
const EVENT_S: f64 = 30.0;

/// Returns the fenced blocks of this kind: the words after the kind, and the lines.
fn blocks(kind: &str) -> Vec<(&'static str, Vec<&'static str>)> {
    let mut found = Vec::new();
    let mut lines = PAGE.lines();
    while let Some(line) = lines.next() {
        if let Some(rest) = line.strip_prefix("```").and_then(|rest| rest.strip_prefix(kind)) {
            found.push((rest.trim(), lines.by_ref().take_while(|line| *line != "```").collect()));
        }
    }
    found
}

/// Returns the machine of a block, by its name.
fn machine(name: &str) -> Bench {
    let bench = || Plan::new(&blocks("ini")[0].1.join("\n"));
    let printer = || Plan::new(CARTESIAN);
    // A resistor in place of a thermistor: heat does not change it.
    let resistor = || {
        let plan = printer().fault("heater-dead:hotend");
        plan.with("hotend.runaway_heating_timeout = 240", "hotend.runaway_heating_timeout = 20").start()
    };
    match name {
        "no-card" => printer().card(CardState::Missing).start(),
        "dark" => bench().fault("motor-supply:0").fault("fet-supply:0").start(),
        "returns" => bench().fault("motor-supply:0").fault("motor-supply:12@2").start(),
        "bench" => bench().start(),
        "printer" => printer().start(),
        "printer-open" => printer().fault("thermistor-open:hotend").start(),
        "resistor" => resistor(),
        "resistor-late" => {
            let mut machine = resistor();
            machine.run(&["M104 S60"]);
            machine
        }
        "printer-halt" => {
            let mut machine = printer().fault("thermistor-open:hotend@5").start();
            machine.run(&["M104 S60"]);
            machine
        }
        other => panic!("the page has a block of a machine that is not known: {other}"),
    }
}

/// Returns whether a line matches a line of the page, `...` being anything.
fn matches(pattern: &str, line: &str) -> bool {
    let (pattern, line) = (pattern.trim_end(), line.trim_end());
    let Some((head, tail)) = pattern.rsplit_once("...") else { return pattern == line };
    let mut pieces = head.split("...");
    let ends = line.strip_suffix(tail).zip(pieces.next());
    let Some(mut rest) = ends.and_then(|(line, first)| line.strip_prefix(first)) else { return false };
    for piece in pieces {
        let Some(at) = rest.find(piece) else { return false };
        rest = &rest[at + piece.len()..];
    }
    true
}

/// Compares the text with the expected lines; a line that is only `...` stands for any number of lines.
fn difference(said: &str, expected: &[&str]) -> Option<String> {
    let lines: Vec<&str> = said.lines().collect();
    (!fits(&lines, expected)).then(|| format!("expected:\n{}\nsaid:\n{said}", expected.join("\n")))
}

fn fits(lines: &[&str], expected: &[&str]) -> bool {
    match (lines, expected) {
        ([], []) => true,
        (_, ["...", rest @ ..]) => (0..=lines.len()).any(|skip| fits(&lines[skip..], rest)),
        ([line, lines @ ..], [pattern, rest @ ..]) => matches(pattern, line) && fits(lines, rest),
        _ => false,
    }
}

#[test]
fn the_page_s_dialogues_are_what_the_firmware_says() {
    let dialogues = blocks("console");
    assert!(dialogues.len() >= 12, "{} dialogues", dialogues.len());
    let mut differences = Vec::new();
    for (name, lines) in dialogues {
        let mut machine = machine(name);
        let mut parts = lines.split(|line| line.starts_with("> "));
        let alone = parts.next().unwrap_or_default();
        if let [first, ..] = alone {
            let greeting = machine.greeting().to_owned();
            let said = if first.starts_with("Velvet") {
                greeting + &machine.hear(ANSWER_S)
            } else {
                machine.hear_until(alone.last().expect("a line"), EVENT_S)
            };
            differences.extend(difference(&said, alone));
        }
        for (asked, answer) in lines.iter().filter_map(|line| line.strip_prefix("> ")).zip(parts) {
            machine.type_in(&format!("{asked}\n"));
            let said = machine.hear(ANSWER_S);
            differences.extend(difference(&said, answer));
        }
    }
    assert!(differences.is_empty(), "{}", differences.join("\n"));
}

#[test]
fn the_first_configuration_has_no_findings_and_drives_no_output() {
    let text = blocks("ini")[0].1.join("\n");
    let mut findings: Vec<config::Diagnostic> = Vec::new();
    let (machine, _) = config::parse(text.as_bytes(), config::BoardId::Prime2590, &mut findings);
    assert!(findings.is_empty(), "{findings:?}");
    assert!(machine.temperatures.iter().all(|heater| heater.heater_pin.is_none()) && machine.switches.is_empty());
}

#[test]
fn what_is_not_said_does_not_match() {
    assert!(matches("vmotor: ... v", "vmotor: 12.0 v") && !matches("vmotor: ... v", "vfet: 12.0 v"));
    assert!(!matches("ok", "ok then") && !matches("...ok", "ok then") && matches("...ok", "ok, ok"));
    assert!(!fits(&["a", "b"], &["a"]) && !fits(&["a"], &["a", "b"]) && fits(&["a", "x", "b"], &["a", "...", "b"]));
}
