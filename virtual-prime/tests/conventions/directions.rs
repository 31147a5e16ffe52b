//! Direction pins: low while a motor counts up.

use crate::common::velvet::{CONFIG, Plan, SECOND, Velvet};

/// A fifth motor, with an external driver on header GF.
const EXTERNAL: &str = "\n[actuator]\n\
    epsilon.steps_per_mm = 100\nepsilon.max_rate = 6000\nepsilon.driver = external\n\
    epsilon.step_pin = PG0\nepsilon.dir_pin = PG1\n";
/// Direction pins of the four sockets and of the fifth motor, with the axis that moves each.
const DIRECTIONS: [(&str, char); 5] = [("PD4", 'X'), ("PG2", 'Y'), ("PG4", 'Z'), ("PG5", 'E'), ("PG1", 'B')];

/// Moves every axis up, down and up again: `high` gives each pin's level while its motor counts up.
#[track_caller]
fn assert_directions(mut velvet: Velvet, pins: &[(&'static str, char)], high: &[bool]) {
    velvet.ask("G91", SECOND);
    for (millimetres, up) in [("1", true), ("-1", false), ("1", true)] {
        let mut axes: Vec<char> = pins.iter().map(|(_, axis)| *axis).collect();
        axes.dedup();
        let words: Vec<String> = axes.iter().map(|axis| format!("{axis}{millimetres}")).collect();
        assert_eq!(velvet.ask(&format!("G1 {} F600", words.join(" ")), SECOND), "ok\n");
        velvet.ask("M400", 20 * SECOND);
        for ((pin, axis), high_for_up) in pins.iter().zip(high) {
            let level = velvet.level(pin);
            let expected = *high_for_up == up;
            assert_eq!(level, expected, "{pin} after {axis}{millimetres} is {}", if level { "high" } else { "low" });
        }
    }
}

/// The level is known from firmware of running boards, which drives every direction pin low for positive
/// motion.
#[test]
fn direction_pins_are_low_for_positive_motion() {
    assert_directions(Plan::new().config(&format!("{CONFIG}{EXTERNAL}")).start(), &DIRECTIONS, &[false; 5]);
}

#[test]
fn direction_pins_with_an_exclamation_mark_are_high_for_positive_motion() {
    let mut text = format!("{CONFIG}{EXTERNAL}");
    for (pin, _) in DIRECTIONS {
        let line = format!("dir_pin = {pin}\n");
        assert!(text.contains(&line), "{line}");
        text = text.replace(&line, &format!("dir_pin = {pin}!\n"));
    }
    assert_directions(Plan::new().config(&text).start(), &DIRECTIONS, &[true; 5]);
}

/// Setting `reversed` is the same as `!`, and both together count once.
#[test]
fn reversed_motors_have_their_direction_pins_high_for_positive_motion() {
    let text = format!("{CONFIG}{EXTERNAL}").replace("dir_pin = PG5\n", "dir_pin = PG5!\n");
    let plan = ["alpha", "delta", "epsilon"]
        .iter()
        .fold(Plan::new().config(&text), |plan, name| plan.set(&format!("[actuator] {name}.reversed = true")));
    assert_directions(plan.start(), &DIRECTIONS, &[true, false, false, true, true]);
}

/// A slave's direction pin follows its own `!`, not its master's.
#[test]
fn slaves_have_their_direction_pins_low_for_positive_motion() {
    let slaved = [
        "[extruder] hotend.enable = false",
        "[actuator] delta.slaved_to = gamma",
        "[actuator] delta.steps_per_mm = 400",
        "[actuator] delta.max_rate = 900",
        "[actuator] delta.acceleration = 200",
    ];
    let plan = || slaved.into_iter().fold(Plan::new(), Plan::set);
    let pins = [("PG4", 'Z'), ("PG5", 'Z')];
    assert_directions(plan().start(), &pins, &[false, false]);
    assert_directions(plan().set("[actuator] delta.dir_pin = PG5!").start(), &pins, &[false, true]);
    assert_directions(plan().set("[actuator] gamma.dir_pin = PG4!").start(), &pins, &[true, false]);
}
