//! The supplies of motors and heaters.

use sim::world::Fault;
use units::Actuator;

use super::scene::{Seen, State, enter, fault_halts, halted, printer, refuses, tells};
use super::{Case, Class};
use crate::common::velvet::{Plan, SECOND};

const NO_HEAT: &str = "ERROR: heater supply lost while heating (vfet below 6 V)";
const NO_MOTORS: &str = "ERROR: motor supply lost while moving";

fn heaters_missing(case: &Case) -> Seen {
    let mut velvet = Plan::new().fault("fet-supply:0").start();
    velvet.hear(3 * SECOND);
    velvet.assert_told_once("WARNING: heater supply is off (vfet below 6 V), heaters and fans do nothing\n");
    let told = "Error: heater supply is off (vfet below 6 V): switch it on, then M999";
    refuses(velvet, "M104 S200", told, case.within_ms)
}

fn heaters_lost(case: &Case) -> Seen {
    fault_halts(printer(), case.state, &Fault::FetSupply(0.0), NO_HEAT, case.within_ms)
}

/// A supply that breaks down to 9 V gives a seventh of the power.
fn heaters_low(case: &Case) -> Seen {
    fault_halts(printer(), case.state, &Fault::FetSupply(9.0), "ERROR: ", case.within_ms)
}

/// What has halted stays halted, cold and without the switch, when the supply is back.
fn heaters_back(case: &Case) -> Seen {
    let velvet = enter(printer(), case.state);
    let (mut velvet, _) = halted(velvet, |velvet| velvet.inject(&Fault::FetSupply(0.0)), NO_HEAT, 2_500.0);
    velvet.inject(&Fault::Repaired);
    velvet.hear(3 * SECOND);
    velvet.assert_safe();
    velvet.ask("M999", SECOND);
    velvet.hear(SECOND);
    let hot_end = velvet.world(|world| world.heater_index("hotend")).expect("the sample has one");
    assert!(velvet.world(|world| world.heater_mean_duty(hot_end)) < 0.01, "it heats");
    super::scene::answers(&mut velvet, "M105", "/0.0 @0 \n");
    Seen::default()
}

fn motors_missing(case: &Case) -> Seen {
    let mut velvet = Plan::new().fault("motor-supply:0").start();
    velvet.hear(3 * SECOND);
    velvet.assert_told_once("WARNING: motor supply is off (vmotor below 6 V)");
    let told = "Error: motor supply is off (vmotor below 6 V): switch it on, then M999";
    refuses(velvet, "G28", told, case.within_ms)
}

fn motors_lost(case: &Case) -> Seen {
    fault_halts(printer(), case.state, &Fault::MotorSupply(0.5), NO_MOTORS, case.within_ms)
}

fn motors_lost_standing(case: &Case) -> Seen {
    let velvet = enter(printer(), case.state);
    let lost = Fault::MotorSupply(0.5);
    tells(velvet, |velvet| velvet.inject(&lost), "motor supply is off", case.within_ms)
}

/// The drivers have forgotten their registers; they get them again, and the machine must be homed anew.
fn motors_back(case: &Case) -> Seen {
    let mut velvet = enter(Plan::new(), case.state);
    velvet.inject(&Fault::MotorSupply(0.5));
    velvet.hear_until("motor supply is off", 3 * SECOND);
    let frames = velvet.world(|world| world.driver(Actuator::Alpha as usize).frames());
    let from = velvet.now_ms();
    velvet.inject(&Fault::MotorSupply(24.0));
    velvet.hear_until("motor supply is on", case.within_ms as u64);
    let told_ms = (velvet.now_ms() - from) as f64;
    velvet.hear(500);
    // Five registers, and what reads them back.
    assert!(velvet.world(|world| world.driver(Actuator::Alpha as usize).frames()) > frames + 5);
    Seen { told_ms: Some(told_ms), ..Seen::default() }
}

/// Two looks a second apart, and the halt.
const TWO_LOOKS_MS: f64 = 2_200.0;

pub const CLASSES: &[Class] = &[
    Class {
        name: "a_heater_supply_that_is_missing",
        what: "heater supply missing",
        does: "told at the start; heating is refused",
        cases: &[Case { state: State::PowerOn, within_ms: 100.0, run: heaters_missing }],
    },
    Class {
        name: "a_heater_supply_that_is_lost",
        what: "heater supply lost while heating",
        does: "halt",
        cases: &[
            Case { state: State::Heating, within_ms: TWO_LOOKS_MS, run: heaters_lost },
            Case { state: State::Holding, within_ms: TWO_LOOKS_MS, run: heaters_lost },
            Case { state: State::Printing, within_ms: TWO_LOOKS_MS, run: heaters_lost },
        ],
    },
    Class {
        name: "a_heater_supply_that_sags",
        what: "heater supply down to 9 V",
        does: "halt: it sinks below its target",
        cases: &[
            Case { state: State::Holding, within_ms: 30_000.0, run: heaters_low },
            Case { state: State::Printing, within_ms: 30_000.0, run: heaters_low },
        ],
    },
    Class {
        name: "a_heater_supply_that_comes_back",
        what: "heater supply back after it was lost",
        does: "nothing heats; targets are forgotten, and only M999 ends the halt",
        cases: &[Case { state: State::Heating, within_ms: TWO_LOOKS_MS, run: heaters_back }],
    },
    Class {
        name: "a_motor_supply_that_is_missing",
        what: "motor supply missing",
        does: "told at the start; moves are refused",
        cases: &[Case { state: State::PowerOn, within_ms: 100.0, run: motors_missing }],
    },
    Class {
        name: "a_motor_supply_that_is_lost",
        what: "motor supply lost",
        does: "halt where something moves; told otherwise; homing is forgotten",
        cases: &[
            Case { state: State::Moving, within_ms: TWO_LOOKS_MS, run: motors_lost },
            Case { state: State::Printing, within_ms: TWO_LOOKS_MS, run: motors_lost },
            Case { state: State::Homing, within_ms: TWO_LOOKS_MS, run: motors_lost },
            Case { state: State::Idle, within_ms: TWO_LOOKS_MS, run: motors_lost_standing },
        ],
    },
    Class {
        name: "a_motor_supply_that_comes_back",
        what: "motor supply back",
        does: "told, and every driver gets its registers anew",
        cases: &[Case { state: State::Idle, within_ms: TWO_LOOKS_MS, run: motors_back }],
    },
];

super::tests! {
    a_heater_supply_that_is_missing
    a_heater_supply_that_is_lost
    a_heater_supply_that_sags
    a_heater_supply_that_comes_back
    a_motor_supply_that_is_missing
    a_motor_supply_that_is_lost
    a_motor_supply_that_comes_back
}
