//! Faults of fans, seen by their tachometers.

use sim::world::Fault;

use super::scene::{Seen, State, enter, halts, printer, tells};
use super::{Case, Class};
use crate::common::velvet::{Plan, SECOND, Velvet};

/// Plans a machine with a tachometer of two pulses a turn at the fan on the second MOSFET; the fan turns
/// 6,000 times a minute.
fn machine(when_stopped: &str) -> Plan {
    let settings = ["enable = true", "tachometer_pin = PD12^", "min_rpm = 1500", "stopped_after = 2"];
    let plan = settings.iter().fold(printer(), |plan, line| plan.set(&format!("[fan] fan.{line}")));
    plan.set(&format!("[fan] fan.when_stopped = {when_stopped}"))
}

/// Runs the fan at its full speed, which M123 reports.
#[track_caller]
fn blows(when_stopped: &str, state: State) -> Velvet {
    // The fan is switched on before the job: M106 rides on motion, behind all of the queue, whose moves take
    // two seconds each.
    let prints = state == State::Printing;
    let mut velvet = enter(machine(when_stopped), if prints { State::Holding } else { state });
    velvet.ask("M106 S255", SECOND);
    // The fan cools the heated part, so the heater needs time to follow.
    velvet.hear(4 * SECOND);
    let said = velvet.ask("M123", SECOND);
    let turns = said.split_whitespace().filter_map(|word| word.parse::<f64>().ok()).fold(0.0, f64::max);
    assert!((5_800.0..6_200.0).contains(&turns), "{said}");
    if prints {
        velvet.type_in("play /sd/job.g");
        velvet.hear(SECOND);
    }
    velvet
}

fn stops(case: &Case) -> Seen {
    let fault = Fault::FanStopped("fan".into());
    halts(blows("halt", case.state), |velvet| velvet.inject(&fault), "ERROR: fan ", case.within_ms)
}

fn is_slow(case: &Case) -> Seen {
    let fault = Fault::FanSlow("fan".into());
    tells(blows("tell", case.state), |velvet| velvet.inject(&fault), "WARNING: fan ", case.within_ms)
}

pub const CLASSES: &[Class] = &[
    Class {
        name: "a_fan_that_stops",
        what: "a fan with a tachometer is held",
        does: "halt where `when_stopped` says so, two seconds (`stopped_after`) after it is slower than `min_rpm`",
        cases: &[
            Case { state: State::Idle, within_ms: 4_500.0, run: stops },
            Case { state: State::Holding, within_ms: 4_500.0, run: stops },
            Case { state: State::Printing, within_ms: 4_500.0, run: stops },
        ],
    },
    Class {
        name: "a_fan_that_is_slow",
        what: "a fan with a tachometer turns too slowly: its bearings are dry",
        does: "told once, and on it goes, where `when_stopped` says so",
        cases: &[
            Case { state: State::Idle, within_ms: 4_500.0, run: is_slow },
            Case { state: State::Printing, within_ms: 4_500.0, run: is_slow },
        ],
    },
];

super::tests! {
    a_fan_that_stops
    a_fan_that_is_slow
}
