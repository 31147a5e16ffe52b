//! Golden registers: the contents that the real image leaves in every register of the chip, and the words it
//! sends to the driver chips, compared with tables that give each value's reason.
//!
//! A register that differs from its reset value and has no row fails the test; so does a row without a
//! reason, or with one that names no source. A failure prints every value that is not as its row says.

mod registers;
mod table;
mod words;

use std::fmt::Write as _;

use crate::common::machine;
use crate::common::velvet::{PROMPT, Plan, SECOND, Velvet};
use registers::{Registers, registers};
use sim::models::tmc26x::Chip;
use table::{Expected, Row};

const TABLE: &str = include_str!("registers.txt");
/// Job that homes, moves every motor, runs a fan, and comes to rest.
const JOB: &str = "G28\nG1 X20 Y20 Z5 F6000\nG91\nG1 E2 F300\nG90\nM106 S128\nG1 X30 B2\nM107\nM84\n";

/// Starts the machine of the conventions and waits for a second after its prompt. Returns it with the
/// register values before the first instruction.
fn ready() -> (Velvet, Registers) {
    let mut velvet = machine::everything().file("job.g", JOB).held();
    let reset = registers(&mut velvet);
    velvet.hear_until(PROMPT, 2 * SECOND);
    velvet.hear(SECOND);
    (velvet, reset)
}

fn play(velvet: &mut Velvet) {
    velvet.ask("M23 job.g", SECOND);
    velvet.type_in("M24");
    velvet.hear_until("Done printing file", 60 * SECOND);
    velvet.hear(2 * SECOND);
}

/// Lists every difference between the table and the registers, in the form of corrected rows.
#[track_caller]
fn assert_as_in_the_table(found: &Registers, reset: &Registers, state: fn(&Row) -> Expected) {
    let rows = table::parse(TABLE);
    let mut wrong = String::new();
    for row in &rows {
        let Some(value) = found.get(&row.name) else {
            // Writing to a String cannot fail.
            let _ = writeln!(wrong, "{}: there is no such register", row.name);
            continue;
        };
        if let Expected::Value { value: expected, mask } = state(row)
            && (value ^ expected) & mask != 0
        {
            let _ = writeln!(
                wrong,
                "{} = {value:#010x}, not {expected:#010x} (mask {mask:#010x}): {}",
                row.name, row.reason
            );
        }
    }
    for (name, value) in found {
        if reset.get(name) != Some(value) && !rows.iter().any(|row| row.name == *name) {
            let _ = writeln!(wrong, "{name} = {value:#010x} : has no row; reset is {:#010x}", reset[name]);
        }
    }
    assert!(wrong.is_empty(), "\n{wrong}");
}

#[test]
fn ready_every_register_has_the_value_of_the_table() {
    let (mut velvet, reset) = ready();
    assert_as_in_the_table(&registers(&mut velvet), &reset, |row| row.ready);
}

#[test]
fn after_a_job_every_register_has_the_value_of_the_table() {
    let (mut velvet, reset) = ready();
    play(&mut velvet);
    assert_as_in_the_table(&registers(&mut velvet), &reset, |row| row.after);
}

#[test]
fn a_tmc2590_is_sent_the_words_of_its_table() {
    words::assert_sent(machine::everything(), Chip::Tmc2590, include_str!("tmc2590.txt"));
}

#[test]
fn a_tmc2660_is_sent_the_words_of_its_table() {
    let text = crate::common::velvet::CONFIG
        .replace("tmc2590", "tmc2660")
        .replace("sense_resistor = 50", "sense_resistor = 100");
    words::assert_sent(Plan::new().config(&text), Chip::Tmc2660, include_str!("tmc2660.txt"));
}
