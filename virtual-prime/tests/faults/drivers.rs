//! Faults of the motors' driver chips and their bus.

use sim::world::Fault;
use units::Actuator::{Alpha, Beta};

use super::scene::{Seen, State, answers, enter, fault_halts, goes_on, halted, printer, refuses, tells};
use super::{Case, Class};
use crate::common::velvet::{Plan, SECOND};

/// Time for two looks a second apart, and the halt.
const TWO_LOOKS_MS: f64 = 2_300.0;
/// Time for the next look, and the halt.
const ONE_LOOK_MS: f64 = 1_300.0;

fn silent_from_the_start(case: &Case) -> Seen {
    let mut velvet = Plan::new().fault("driver-silent:beta").start();
    velvet.hear(2 * SECOND);
    velvet.assert_told_once("ERROR: motor driver beta does not answer, check its supply and wiring\n");
    refuses(velvet, "G1 X10 Y10 F600", "Error: motor driver beta does not answer", case.within_ms)
}

fn silent(case: &Case) -> Seen {
    let told = "ERROR: motor driver X: driver does not answer, check its supply and wiring";
    fault_halts(printer(), case.state, &Fault::DriverSilent(Alpha), told, case.within_ms)
}

fn bit_errors(case: &Case) -> Seen {
    let velvet = enter(printer(), case.state);
    goes_on(velvet, |velvet| velvet.inject(&Fault::DriverBitErrors(Alpha, 3)), case.within_ms)
}

fn lost_settings(case: &Case) -> Seen {
    let told = "ERROR: motor driver X: the driver was without power";
    let (mut velvet, seen) =
        halted(enter(printer(), case.state), |velvet| velvet.inject(&Fault::DriverReset(Alpha)), told, case.within_ms);
    // The driver is set up again, and off; a move is only possible once a person has released the halt.
    let words = velvet.world(|world| world.driver(Alpha as usize).registers());
    assert_eq!(words, velvet.world(|world| world.driver(Beta as usize).registers()));
    velvet.type_in("M999");
    velvet.hear(SECOND);
    answers(&mut velvet, "G28.6", "X:0");
    seen
}

fn open_load(case: &Case) -> Seen {
    let velvet = enter(printer(), case.state);
    let told = "WARNING: X: no current through coil A: check the motor's plug and cable";
    tells(velvet, |velvet| velvet.inject(&Fault::DriverOpenLoad(Alpha)), told, case.within_ms)
}

fn short(case: &Case) -> Seen {
    let told = "ERROR: motor driver X: SHORT to ground on channel A";
    fault_halts(printer(), case.state, &Fault::DriverShort(Alpha), told, case.within_ms)
}

fn short_to_supply(case: &Case) -> Seen {
    let told = "ERROR: motor driver X: SHORT to supply on channel A";
    fault_halts(printer(), case.state, &Fault::DriverShortToSupply(Alpha), told, case.within_ms)
}

fn warm(case: &Case) -> Seen {
    let velvet = enter(printer(), case.state);
    tells(velvet, |velvet| velvet.inject(&Fault::DriverTemperature(Beta, 125)), "WARNING: ", case.within_ms)
}

fn hot(case: &Case) -> Seen {
    let told = "ERROR: motor driver X: Overtemperature Shutdown";
    fault_halts(printer(), case.state, &Fault::DriverTemperature(Alpha, 160), told, case.within_ms)
}

pub const CLASSES: &[Class] = &[
    Class {
        name: "a_driver_that_is_silent_from_the_start",
        what: "motor driver silent from power-on",
        does: "told by name; moves are refused",
        cases: &[Case { state: State::PowerOn, within_ms: 200.0, run: silent_from_the_start }],
    },
    Class {
        name: "a_driver_that_falls_silent",
        what: "motor driver falls silent",
        does: "halt; the driver is named",
        cases: &[
            Case { state: State::Moving, within_ms: TWO_LOOKS_MS, run: silent },
            Case { state: State::Printing, within_ms: TWO_LOOKS_MS, run: silent },
            Case { state: State::Homing, within_ms: TWO_LOOKS_MS, run: silent },
        ],
    },
    Class {
        name: "a_driver_that_loses_its_settings",
        what: "a driver chip resets by itself: its registers are lost, its motor is off",
        does: "the same, where `halt_on_driver_alarm` says so; it is set up again, and its axis not homed any more",
        cases: &[
            Case { state: State::Moving, within_ms: ONE_LOOK_MS, run: lost_settings },
            Case { state: State::Printing, within_ms: ONE_LOOK_MS, run: lost_settings },
        ],
    },
    Class {
        name: "a_bus_with_bit_errors",
        what: "one bit wrong in every third answer of a driver",
        does: "nothing: a fault counts when it is seen twice",
        cases: &[
            Case { state: State::Moving, within_ms: 6_000.0, run: bit_errors },
            Case { state: State::Printing, within_ms: 20_000.0, run: bit_errors },
        ],
    },
    Class {
        name: "a_motor_with_an_open_coil",
        what: "a motor's coil not connected",
        does: "told, by name and coil, after three looks a second apart in slow motion, the only time when the driver can know",
        cases: &[Case { state: State::Moving, within_ms: 4_500.0, run: open_load }],
    },
    Class {
        name: "a_motor_shorted_to_ground",
        what: "a coil shorted to ground",
        does: "halt, where `halt_on_driver_alarm` says so, as in the sample; a warning otherwise",
        cases: &[
            Case { state: State::Moving, within_ms: TWO_LOOKS_MS, run: short },
            Case { state: State::Printing, within_ms: TWO_LOOKS_MS, run: short },
        ],
    },
    Class {
        name: "a_motor_shorted_to_its_supply",
        what: "a coil shorted to the motor supply (TMC2590)",
        does: "the same",
        cases: &[Case { state: State::Moving, within_ms: TWO_LOOKS_MS, run: short_to_supply }],
    },
    Class {
        name: "a_driver_that_gets_hot",
        what: "motor driver over its first temperature",
        does: "told, and on it goes",
        cases: &[
            Case { state: State::Moving, within_ms: TWO_LOOKS_MS, run: warm },
            Case { state: State::Printing, within_ms: TWO_LOOKS_MS, run: warm },
        ],
    },
    Class {
        name: "a_driver_that_overheats",
        what: "motor driver over its last temperature: it has switched itself off",
        does: "halt, as for a short",
        cases: &[
            Case { state: State::Moving, within_ms: TWO_LOOKS_MS, run: hot },
            Case { state: State::Printing, within_ms: TWO_LOOKS_MS, run: hot },
        ],
    },
];

super::tests! {
    a_driver_that_is_silent_from_the_start
    a_driver_that_falls_silent
    a_driver_that_loses_its_settings
    a_bus_with_bit_errors
    a_motor_with_an_open_coil
    a_motor_shorted_to_ground
    a_motor_shorted_to_its_supply
    a_driver_that_gets_hot
    a_driver_that_overheats
}
