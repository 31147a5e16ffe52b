//! Levels of every row of the table in reset, at boot, idle and halted; pins without a row are left alone.

use std::collections::BTreeMap;

use board_facts::signals::{Level, SIGNALS};
use sim::world::Pin;
use virtual_prime::pin_state::{Drive, PinState};
use virtual_prime::pins::{PINS, PORTS};

use crate::common::machine::everything;
use crate::common::velvet::{Plan, SECOND, Velvet};

/// Pins in alternate function out of reset: the debug port.
const DEBUG_PORT: [&str; 5] = ["PA13", "PA14", "PA15", "PB3", "PB4"];
/// Pins of the crystals, which RM0399 section 12.3.14 gives to the oscillators in any mode of the pins.
const CRYSTALS: [&str; 4] = ["PC14", "PC15", "PH0", "PH1"];

/// Returns the state of every pin.
fn states(velvet: &mut Velvet) -> BTreeMap<String, PinState> {
    velvet
        .bench
        .vm
        .with(|stopped| {
            let all = (0..PORTS * PINS).map(|n| Pin { port: (n / PINS) as u8, number: (n % PINS) as u8 });
            all.map(|pin| (pin.to_string(), stopped.session.board().mcu.pin_state(pin))).collect()
        })
        .expect("the run goes on")
}

fn fits(level: Level, drive: Drive) -> bool {
    match level {
        Level::Released => drive == Drive::Released,
        Level::PulledUp => drive == Drive::PulledUp,
        Level::Low => drive == Drive::Low,
        Level::High => drive == Drive::High,
        Level::Either => matches!(drive, Drive::Low | Drive::High),
        Level::Function(number) => drive == Drive::Function(number),
    }
}

/// Asserts that every row's pins are at the level that `level` takes from the row, and all others released.
#[track_caller]
fn assert_levels(velvet: &mut Velvet, level: impl Fn(&board_facts::signals::Signal) -> Level) {
    let mut states = states(velvet);
    for name in DEBUG_PORT.iter().chain(&CRYSTALS) {
        states.remove(*name);
    }
    let mut wrong = Vec::new();
    for signal in SIGNALS {
        for pin in signal.pins {
            let state = states.remove(*pin).expect("a pin of the chip, in one row");
            if !fits(level(signal), state.drive) {
                wrong.push(format!("{}, {pin}: {:?}, not {:?}", signal.name, state.drive, level(signal)));
            }
        }
    }
    for (pin, state) in states {
        if state.drive != Drive::Released {
            wrong.push(format!("{pin} is in no row, and is {:?}", state.drive));
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

/// All pins out of reset are analog but the debug port, RM0399 section 12.3.1.
#[test]
fn in_reset_every_pin_is_released() {
    let mut velvet = Plan::new().held();
    assert_levels(&mut velvet, |_| Level::Released);
}

/// Without a card nothing is wired, so the levels are the board's own.
#[test]
fn at_boot_every_signal_has_its_level() {
    let mut velvet = Plan::new().without_card().start();
    velvet.hear(SECOND);
    assert_levels(&mut velvet, |signal| signal.boot);
}

#[test]
fn idle_every_signal_has_its_level_and_speed() {
    let mut velvet = everything().start();
    velvet.hear(SECOND);
    assert_levels(&mut velvet, |signal| signal.idle);
    let states = states(&mut velvet);
    for signal in SIGNALS {
        for pin in signal.pins {
            if let Some(speed) = signal.speed {
                assert_eq!(states[*pin].speed, speed as u8, "{}, {pin}", signal.name);
            }
        }
    }
}

/// Tests the halt of a machine with everything on: heaters, fans, relays, PWM, motors.
#[test]
fn halted_every_signal_has_its_level() {
    let mut velvet = everything().start();
    for line in ["M104 S60", "M104 T1 S60", "M140 S50", "M106 S255", "M42", "M80", "M64", "M3 S50", "M66 S50", "G91"] {
        assert_eq!(velvet.ask(line, SECOND), "ok\n", "{line}");
    }
    assert_eq!(velvet.ask("G1 X20 Y20 Z2 B5 F1200", SECOND), "ok\n");
    velvet.hear(500);
    velvet.type_in("M112");
    velvet.hear(3 * SECOND);
    assert_levels(&mut velvet, |signal| signal.halted);
}

/// A pin that `gpio` drives is driven for its time, and afterwards as after a reset; a pin with an owner is
/// never touched.
#[test]
fn a_pin_that_is_tried_out_is_released_again() {
    let mut velvet = everything().start();
    velvet.hear(SECOND);
    let drives = |velvet: &mut Velvet| -> BTreeMap<String, Drive> {
        // The lamp that says that the board is alive goes on and off.
        states(velvet).into_iter().filter(|(pin, _)| pin != "PH9").map(|(pin, state)| (pin, state.drive)).collect()
    };
    let before = drives(&mut velvet);
    for (word, driven) in [("on", Drive::High), ("off", Drive::Low)] {
        velvet.type_in(&format!("gpio PJ1 out {word} 300"));
        velvet.hear(100);
        let mut now = drives(&mut velvet);
        assert_eq!(now.insert("PJ1".into(), before["PJ1"]), Some(driven));
        assert_eq!(now, before, "no other pin changes");
        velvet.hear(400);
        assert_eq!(drives(&mut velvet), before);
    }
    assert_eq!(velvet.ask("gpio PJ1", SECOND), "PJ1^:1\nok\n", "nothing is wired to it: its pull-up");
    assert_eq!(velvet.ask("gpio PJ1v", SECOND), "PJ1v:0\nok\n");
    // The pins are a heater's, a motor's, a driver's select, the drivers' bus, the card's, the console's, an
    // end stop's.
    for pin in ["PE0", "PD3", "PJ13", "PE12", "PC8", "PD5", "PD0"] {
        let said = velvet.ask(&format!("gpio {pin} out on"), SECOND);
        assert!(said.starts_with("error:"), "{pin}: {said}");
    }
    assert_eq!(drives(&mut velvet), before);
}
