//! Faults of heaters and of their switches.

use sim::world::Fault;

use super::scene::{Seen, State, at_rest_told, enter, fault_halts, halts, printer};
use super::{Case, Class};
use crate::common::velvet::{Plan, SECOND, Velvet};

/// Plans the sample printer with a hot end that must be 2 C warmer after this many seconds at full output, so
/// that the same law answers sooner.
fn impatient(seconds: u32) -> Plan {
    printer().set(&format!("[temperature control] hotend.verify_gain_time = {seconds}"))
}

const GAIN_S: u32 = 5;

fn dead(case: &Case) -> Seen {
    let fault = Fault::HeaterDead("hotend".into());
    match case.state {
        State::Idle => {
            let mut velvet = enter(impatient(GAIN_S), State::Idle);
            velvet.inject(&fault);
            halts(velvet, |velvet| velvet.type_in("M104 S200"), "ERROR: ", case.within_ms)
        }
        state => fault_halts(printer(), state, &fault, "ERROR: ", case.within_ms),
    }
}

fn weak(case: &Case) -> Seen {
    let mut velvet = enter(impatient(GAIN_S).soaked("hotend", 140.0), State::Idle);
    velvet.inject(&Fault::HeaterWeak("hotend".into(), 0.3));
    halts(velvet, |velvet| velvet.type_in("M104 S200"), "ERROR: ", case.within_ms)
}

const WARMED: &str = "ERROR: T is switched off and has warmed by ";

fn stuck_on(case: &Case) -> Seen {
    let fault = Fault::HeaterStuckOn("hotend".into());
    let told = if case.state == State::Holding { "ERROR: " } else { WARMED };
    let mut velvet = enter(printer(), case.state);
    if case.state == State::Halted {
        // The machine was halted before: nothing new but the words. The supply is off already.
        velvet.world(|world| world.inject(&Fault::FetSwitchStuckOn)).expect("a fault of the board");
        return at_rest_told(velvet, |velvet| velvet.inject(&fault), told, case.within_ms);
    }
    halts(velvet, |velvet| velvet.inject(&fault), told, case.within_ms)
}

fn bed_stuck_on(case: &Case) -> Seen {
    let velvet = enter(printer(), case.state);
    let stuck = Fault::HeaterStuckOn("bed".into());
    halts(velvet, |velvet| velvet.inject(&stuck), "ERROR: B is switched off and has warmed by ", case.within_ms)
}

/// Both the heater's switch and the supply's switch before it are stuck: the firmware can tell, and no more.
fn both_switches(case: &Case) -> Seen {
    let mut velvet = enter(printer(), case.state);
    let both = |velvet: &mut Velvet| {
        velvet.inject(&Fault::FetSwitchStuckOn);
        velvet.inject(&Fault::HeaterStuckOn("hotend".into()));
    };
    both(&mut velvet);
    let from = velvet.now_ms();
    velvet.hear_until(WARMED, case.within_ms as u64);
    let told_ms = (velvet.now_ms() - from) as f64;
    // The error is told again as the heater goes on.
    velvet.hear_until("has warmed by ", 20 * SECOND);
    Seen { told_ms: Some(told_ms), ..Seen::default() }
}

pub const CLASSES: &[Class] = &[
    Class {
        name: "a_heater_that_gives_no_heat",
        what: "heater not connected or burnt out",
        does: "halt: `verify_gain_time` (20 s; a bed: 60 s; the first case has 5 s) of full output without 2 C more; or it cools at full output",
        cases: &[
            Case { state: State::Idle, within_ms: 6_000.0, run: dead },
            Case { state: State::Heating, within_ms: 25_000.0, run: dead },
            Case { state: State::Holding, within_ms: 25_000.0, run: dead },
            Case { state: State::Printing, within_ms: 25_000.0, run: dead },
        ],
    },
    Class {
        name: "a_heater_that_is_weak",
        what: "heater gives a third of its power",
        does: "halt as soon as full output does not warm it by 2 C in `verify_gain_time` (here 5 s)",
        cases: &[Case { state: State::Idle, within_ms: 12_000.0, run: weak }],
    },
    Class {
        name: "a_heater_that_is_on_by_itself",
        what: "heater on although it is switched off (shorted MOSFET, welded relay)",
        does: "halt, and the supply of hot ends and fans cut (PD7), when it has warmed by 20 C beyond what its surroundings explain (30 C in the first minute after use)",
        cases: &[
            Case { state: State::Idle, within_ms: 12_000.0, run: stuck_on },
            Case { state: State::Holding, within_ms: 30_000.0, run: stuck_on },
            Case { state: State::Halted, within_ms: 25_000.0, run: stuck_on },
        ],
    },
    Class {
        name: "a_bed_that_is_on_by_itself",
        what: "the bed's MOSFET shorted",
        does: "halt, and told again every 20 C: the board cannot cut its supply",
        cases: &[Case { state: State::Idle, within_ms: 65_000.0, run: bed_stuck_on }],
    },
    Class {
        name: "a_heater_whose_supply_cannot_be_cut_either",
        what: "hot end's MOSFET and the switch of its supply both shorted",
        does: "halt, and told again every 20 C",
        cases: &[Case { state: State::Idle, within_ms: 12_000.0, run: both_switches }],
    },
];

super::tests! {
    a_heater_that_gives_no_heat
    a_heater_that_is_weak
    a_heater_that_is_on_by_itself
    a_bed_that_is_on_by_itself
    a_heater_whose_supply_cannot_be_cut_either
}
