//! Faults of the supplies of motors and heaters.

use sim::world::Fault;
use units::Actuator;

use super::scene::{BY_ITSELF, Seen, State, enter, fault_halts, halted, printer, refuses, resets, tells};
use super::{Case, Class};
use crate::common::machine::{changes, pin, watch};
use crate::common::velvet::{Plan, SECOND, Velvet};

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

/// Lets the heaters' supply break down to 9 V, which gives a seventh of the power.
fn heaters_low(case: &Case) -> Seen {
    let heaters = ["PE0", "PE3", "PD7"];
    let mut velvet = enter(printer(), case.state);
    let holds =
        [Actuator::Alpha, Actuator::Beta].map(|motor| velvet.world(|world| world.driver(motor as usize).drives()));
    watch(&mut velvet, &heaters);
    changes(&mut velvet);
    let from_ns = velvet.bench.vm.now_ns();
    velvet.inject(&Fault::FetSupply(9.0));
    velvet.hear_until("ERROR: the heaters' supply has fallen to 9.0 V", case.within_ms as u64 + SECOND);
    velvet.hear(SECOND);
    let pins = heaters.map(pin);
    let off = changes(&mut velvet).into_iter().filter(|change| pins.contains(&change.pin)).last();
    heaters.iter().for_each(|name| assert!(!velvet.level(name), "{name} is on"));
    let held =
        [Actuator::Alpha, Actuator::Beta].map(|motor| velvet.world(|world| world.driver(motor as usize).drives()));
    assert_eq!(held, holds, "what had its current keeps it");
    Seen {
        outputs_ms: off.map(|change| change.at_ns.saturating_sub(from_ns) as f64 / 1e6),
        motion_ms: None,
        told_ms: None,
    }
}

/// Asserts that a halted machine stays halted, cold and without the switch, when the supply is back.
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

/// Asserts that drivers that have forgotten their registers get them again, and that the machine must be
/// homed anew.
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
    // At least five registers were written, and read back.
    assert!(velvet.world(|world| world.driver(Actuator::Alpha as usize).frames()) > frames + 5);
    Seen { told_ms: Some(told_ms), ..Seen::default() }
}

/// Slope of a falling supply: 4 A out of 10 mF. A quarter of that is in the board's and a supply's own
/// capacitors.
const FALL_V_PER_MS: f64 = 0.4;
/// Voltage below which the board's regulators end, and the drivers lock themselves out (TMC2590 data sheet: 8
/// V at most).
const GONE_VOLTS: f64 = 8.0;
/// Limit of the brown-out case: 15 ms from 24 V to three quarters of it; two looks that agree, 3 ms apart
/// each; 2 ms until braking begins; 10 ms from 20 mm/s at 2,000 mm/s^2. The job moves at 20 mm/s nearly all
/// the time, and slower at corners.
const BROWN_OUT_MS: f64 = 34.0;
const FALLEN: &str = "supply has fallen to ";

/// Asserts that heaters go off first, that the motors brake and have their current until the end, and that
/// the next start tells, once.
fn browns_out(case: &Case) -> Seen {
    let heaters = ["PE0", "PE3", "PD7"];
    let mut velvet = enter(printer(), case.state);
    // The heater is full on, so that its pin shows an edge.
    // The command rides on motion: its `ok` waits for room in the queue, whose moves take two seconds each.
    velvet.ask("M104 S240", 4 * SECOND);
    velvet.hear(100);
    watch(&mut velvet, &heaters);
    changes(&mut velvet);
    velvet.world(|world| world.trace_mut().take());
    let from_ns = velvet.bench.vm.now_ns();
    let ms = |at_ns: u64| at_ns.saturating_sub(from_ns) as f64 / 1e6;
    let mut volts = 24.0;
    while volts > GONE_VOLTS {
        volts -= FALL_V_PER_MS;
        velvet.inject(&Fault::MotorSupply(volts));
        velvet.inject(&Fault::FetSupply(volts));
        velvet.hear(1);
    }
    let pins = heaters.map(pin);
    let off = changes(&mut velvet).into_iter().filter(|change| pins.contains(&change.pin)).last();
    for name in heaters {
        assert!(!velvet.level(name), "{name} is on");
    }
    let edges = velvet.world(|world| world.trace_mut().take());
    let (outputs_ms, motion_ms) = (off.map(|change| ms(change.at_ns)), edges.last().map(|edge| ms(edge.time_ns)));
    assert!(outputs_ms < motion_ms, "{outputs_ms:?} {motion_ms:?}");
    // The machine stands while the supply is still there, and the motors have their current.
    assert!(motion_ms.is_some_and(|at_ms| at_ms < ms(velvet.bench.vm.now_ns()) - 2.0), "{motion_ms:?}");
    let motors = [Actuator::Alpha, Actuator::Beta, Actuator::Gamma];
    assert!(motors.iter().all(|motor| velvet.world(|world| world.driver(*motor as usize).drives())), "not held");
    let card = velvet.card(|card| card.content().to_vec());
    let card = told_at_the_next_start(card, true);
    told_at_the_next_start(card, false);
    Seen { outputs_ms, motion_ms, told_ms: None }
}

/// Switches on a board that knows nothing but the card. Returns the card's bytes after that.
#[track_caller]
fn told_at_the_next_start(card: Vec<u8>, is_news: bool) -> Vec<u8> {
    let mut velvet = Plan::new().with_card(move |_| card.clone()).start();
    let told = velvet.said().lines().find(|line| line.contains("when the machine was on last")).map(str::to_owned);
    assert_eq!(told.is_some(), is_news, "{}", velvet.said());
    if let Some(told) = told {
        assert!(told.starts_with("WARNING: ") && told.contains(FALLEN) && told.contains("/sd/job.g"), "{told}");
    }
    velvet.hear(SECOND);
    velvet.card(|card| card.content().to_vec())
}

pub(super) fn rail(velvet: &mut Velvet, millivolts: u32) {
    velvet.bench.vm.with(move |stopped| {
        let at = stopped.stop.at;
        stopped.session.board_mut().mcu.change_supply(at, millivolts);
    });
}

/// Lets VDD fall: the chip's detector (PVD) sees that, and the firmware tells it if the supply is back.
fn logic_falls(case: &Case) -> Seen {
    let velvet = enter(printer().meaning_faults(), case.state);
    let words = "the 3.3 V supply fell below 2.8 V: check the 24 V and 5 V supply\n";
    let told = format!("WARNING: the firmware had ended itself: {words}");
    let kept: &[&str] = &[&format!("the firmware ended itself: {words}"), BY_ITSELF];
    resets(velvet, |velvet| rail(velvet, 2_600), |velvet| rail(velvet, 3_300), &told, kept, case.within_ms)
}

/// Time for two looks a second apart, and the halt.
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
        does: "below three quarters of what it usually has: heaters off, motors brake and are held; halt",
        cases: &[
            Case { state: State::Holding, within_ms: 20.0, run: heaters_low },
            Case { state: State::Printing, within_ms: 20.0, run: heaters_low },
        ],
    },
    Class {
        name: "a_heater_supply_that_comes_back",
        what: "heater supply back after it was lost",
        does: "nothing heats; targets are forgotten, and only M999 ends the halt",
        cases: &[Case { state: State::Heating, within_ms: TWO_LOOKS_MS, run: heaters_back }],
    },
    Class {
        name: "supplies_that_fall",
        what: "brown-out: the supplies of motors and heaters fall, by 0.4 V a millisecond",
        does: "below three quarters of what they usually have heaters go off, then the motors brake and are held while the voltage lasts; the event is kept on the card, and the next start tells it once",
        cases: &[Case { state: State::Printing, within_ms: BROWN_OUT_MS, run: browns_out }],
    },
    Class {
        name: "a_logic_supply_that_falls",
        what: "the chip's own 3.3 V falls below 2.8 V",
        does: "outputs off at once, motors without current, reset; the next start tells",
        cases: &[
            Case { state: State::Heating, within_ms: 2.0, run: logic_falls },
            Case { state: State::Printing, within_ms: 2.0, run: logic_falls },
            Case { state: State::Idle, within_ms: 2.0, run: logic_falls },
        ],
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
    supplies_that_fall
    a_logic_supply_that_falls
    a_motor_supply_that_is_missing
    a_motor_supply_that_is_lost
    a_motor_supply_that_comes_back
}
