//! Runs the lines of a row of the table and measures what they did: the facts that a cell may state.

use std::fmt::Write;

use scenarios::{Bench, CARTESIAN, Plan};
use units::Actuator::{self, Alpha, Beta, Delta, Gamma};

use super::table::Row;

/// Time after which a line counts as never answered, seconds.
const PATIENCE_S: f64 = 600.0;
/// Time after which a file counts as waiting for somebody, seconds.
const FILE_S: f64 = 20.0;
/// The output of a fan is pulses: its mean is taken over so many milliseconds.
const SAMPLES: u32 = 600;
const MOTORS: [(char, Actuator); 4] = [('X', Alpha), ('Y', Beta), ('Z', Gamma), ('E', Delta)];

/// A machine that lines have been run on.
pub struct Trial {
    bench: Bench,
    before: [f64; 4],
    took_s: f64,
    said: String,
    is_done: bool,
    waits: bool,
}

/// Returns the machine of a row, with its consoles in a dialect. `grbl_mode` selects GRBL's.
fn machine(row: &Row, dialect: &str) -> Bench {
    // M42 reaches the fan by this number.
    let plan = Plan::new(CARTESIAN).set("[switch] fan.io_number = 4");
    let plan = match dialect {
        "grbl" => plan.set("[general] grbl_mode = true").set("[general] config-override = false"),
        _ => plan.set(&format!("[general] dialect = {dialect}")),
    };
    let plan = row.settings.iter().fold(plan, |plan, setting| plan.set(setting));
    let text: String = row.lines.iter().fold(String::new(), |text, line| text + line + "\n");
    plan.file("row.g", &text).file("other.g", "G1 X5 F6000\n").start()
}

/// Types a line and returns its answer, however it ends.
fn answer(bench: &mut Bench, line: &str) -> String {
    bench.type_in(&format!("{line}\n"));
    let mut said = String::new();
    let end = bench.now_s() + PATIENCE_S;
    let ends =
        |said: &str| said.lines().any(|line| ["ok", "error", "!!", "rs "].iter().any(|head| line.starts_with(head)));
    while !ends(&said) && bench.now_s() < end {
        said.push_str(&bench.hear(0.02));
    }
    said
}

impl Trial {
    /// Runs the lines of a row.
    pub fn run(row: &Row, dialect: &str) -> Self {
        let mut bench = machine(row, dialect);
        for line in &row.given {
            answer(&mut bench, line);
        }
        while bench.moves() {
            bench.hear(0.02);
        }
        let before = MOTORS.map(|(_, motor)| bench.carriage(motor));
        let begun_s = bench.now_s();
        let (mut said, mut is_done, mut waits) = (String::new(), false, false);
        if row.is_file {
            bench.type_in(&format!("play /sd/row.g -t -f {dialect}\n"));
            while !(is_done || waits) && bench.now_s() < begun_s + FILE_S {
                said.push_str(&bench.hear(0.05));
                is_done = said.contains("Done printing file");
                waits = said.contains("was not carried out")
                    || said.contains("the program waits")
                    || said.contains("Print Suspended")
                    || said.contains("error:");
            }
        } else {
            for line in &row.lines {
                said.push_str(&answer(&mut bench, line));
            }
        }
        while bench.moves() {
            bench.hear(0.02);
        }
        let took_s = bench.now_s() - begun_s;
        said.push_str(&bench.hear(0.3));
        Self { bench, before, took_s, said, is_done, waits }
    }

    /// Returns the facts that do not hold.
    pub fn difference(&mut self, facts: &str) -> Option<String> {
        let mut wrong = String::new();
        let mut rest = facts;
        while !rest.is_empty() {
            // The fact `says` may have commas in its text, and comes last.
            let (fact, others) = match rest.split_once(", ") {
                Some((fact, others)) if !rest.starts_with("says ") => (fact, others),
                _ => (rest, ""),
            };
            rest = others;
            if let Err(is) = self.holds(fact) {
                let _ = write!(wrong, "`{fact}`, but {is}; ");
            }
        }
        if !wrong.is_empty() {
            let _ = write!(wrong, "it said {:?}", self.said);
        }
        Some(wrong).filter(|wrong| !wrong.is_empty())
    }

    fn holds(&mut self, fact: &str) -> Result<(), String> {
        let (name, value) = fact.split_once(' ').unwrap_or((fact, ""));
        let number = || value.parse::<f64>().unwrap_or_else(|_| panic!("no number: {fact}"));
        let near = |is: f64, within: f64| {
            if (is - number()).abs() <= within { Ok(()) } else { Err(format!("{name} {is:.2}")) }
        };
        let moved = |place: usize| self.bench.carriage(MOTORS[place].1) - self.before[place];
        match name {
            "x" => near(moved(0), 0.06),
            "y" => near(moved(1), 0.06),
            "z" => near(moved(2), 0.06),
            "e" => near(moved(3), 0.06),
            "time" => near(self.took_s, 0.35),
            "hotend" => near(self.target("T"), 0.1),
            "bed" => near(self.target("B"), 0.1),
            "fan" => near(self.fan(), 1.0),
            "motors" => same(&self.energised(), value),
            "done" => same(if self.is_done { "" } else { "it did not end" }, value),
            "waits" => same(if self.waits { "" } else { "it did not wait" }, value),
            "says" if self.said.contains(value) => Ok(()),
            "says" => Err("it did not".into()),
            _ => panic!("no fact: {fact}"),
        }
    }

    /// Returns the target that M105 gives after this designator: `T:25.0 /200.0 @255`.
    fn target(&mut self, designator: &str) -> f64 {
        let said = answer(&mut self.bench, "M105");
        let rest = said.split(&format!("{designator}:")).nth(1).unwrap_or_else(|| panic!("no {designator}: {said}"));
        let target = rest.split('/').nth(1).and_then(|rest| rest.split([' ', ']']).next());
        target.and_then(|target| target.parse().ok()).unwrap_or_else(|| panic!("no target: {said}"))
    }

    /// Returns the duty of the part's fan, of 255.
    fn fan(&mut self) -> f64 {
        let index = self.bench.world(|world| world.config().fans.iter().position(|fan| fan.name == "fan"));
        let index = index.expect("a fan of this machine");
        let mut sum = 0.0;
        for _ in 0..SAMPLES {
            self.bench.hear(0.001);
            sum += self.bench.world(|world| world.fan_speed(index));
        }
        255.0 * sum / f64::from(SAMPLES)
    }

    fn energised(&self) -> String {
        let on: String =
            MOTORS.iter().filter(|(_, motor)| self.bench.is_energised(*motor)).map(|(letter, _)| *letter).collect();
        if on.is_empty() { "none".into() } else { on }
    }
}

fn same(is: &str, stated: &str) -> Result<(), String> {
    if is == stated { Ok(()) } else { Err(is.into()) }
}
