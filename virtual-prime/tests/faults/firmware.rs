//! Faults of the firmware itself: it hangs, ends itself, comes too late, or its clock stops.

use super::scene::{BY_ITSELF, Seen, State, enter, printer, resets};
use super::{Case, Class};
use crate::common::hang::{image_that_hangs_in, image_that_masks_interrupts_in};
use crate::common::switched::{FEED, Failure, HEAT, Interrupt, PLANNER, SLOW_WATCH, image, throw, throw_back};
use crate::common::velvet::{Plan, SECOND, Velvet};

const WATCHDOG: &str = "WARNING: the watchdog reset the board: the firmware had stopped answering\n";
/// Entry that the next start adds to the event ring, after the earlier entries.
const BY_WATCHDOG: &str = "--- started: the watchdog reset the board\n";
/// Time until the watchdog bites: 0.9 s between two feedings, by a clock that may be a tenth slow, and a
/// feeding just before.
const WATCHDOG_MS: f64 = 1_000.0;
/// Time until the watchdog bites when the executor hangs, which may be away for three seconds before that.
const EXECUTOR_MS: f64 = 4_200.0;

/// Starts the sample printer with a copy of the image that is of no use afterwards.
fn with_image(elf: std::path::PathBuf, state: State) -> Velvet {
    let velvet = enter(printer().image(elf.clone()).meaning_faults(), state);
    // The copy is in the board's flash now.
    let _ = std::fs::remove_file(elf);
    velvet
}

fn executor_hangs(case: &Case) -> Seen {
    let velvet = with_image(image_that_hangs_in("report_status"), case.state);
    let kept = ["nothing is heard of the executor\n", BY_WATCHDOG];
    resets(velvet, |velvet| velvet.bench.console.send(b"?"), |_| {}, WATCHDOG, &kept, case.within_ms)
}

#[track_caller]
fn fails(case: &Case, interrupt: Interrupt, failure: Failure, told: &str, kept: &[&str]) -> Seen {
    resets(with_image(image(interrupt, failure), case.state), throw, throw_back, told, kept, case.within_ms)
}

/// Asserts that the firmware ends itself, with these words.
#[track_caller]
fn ends(case: &Case, interrupt: Interrupt, failure: Failure, words: &str) -> Seen {
    let told = format!("WARNING: the firmware had ended itself: {words}");
    let kept = format!("the firmware ended itself: {words}");
    fails(case, interrupt, failure, &told, &[&kept, BY_ITSELF])
}

fn heat_skips(case: &Case) -> Seen {
    fails(case, HEAT, Failure::Skips, WATCHDOG, &[BY_WATCHDOG])
}

fn heat_hangs(case: &Case) -> Seen {
    fails(case, HEAT, Failure::Hangs, WATCHDOG, &[BY_WATCHDOG])
}

fn feed_skips(case: &Case) -> Seen {
    fails(case, FEED, Failure::Skips, WATCHDOG, &["nothing is heard of the step feed\n", BY_WATCHDOG])
}

fn feed_hangs(case: &Case) -> Seen {
    fails(case, FEED, Failure::Hangs, WATCHDOG, &["nothing is heard of the step feed", BY_WATCHDOG])
}

fn planner_skips(case: &Case) -> Seen {
    fails(case, PLANNER, Failure::Skips, WATCHDOG, &["nothing is heard of the planner\n", BY_WATCHDOG])
}

fn watch_skips(case: &Case) -> Seen {
    fails(
        case,
        SLOW_WATCH,
        Failure::Skips,
        WATCHDOG,
        &["nothing is heard of the watch over drivers and supplies", BY_WATCHDOG],
    )
}

fn panics(case: &Case) -> Seen {
    ends(case, SLOW_WATCH, Failure::Panics, "panic at test.rs:42\n")
}

fn bad_code(case: &Case) -> Seen {
    ends(case, SLOW_WATCH, Failure::IsNoCode, "hard fault at 0x0")
}

fn overflows(case: &Case) -> Seen {
    ends(case, HEAT, Failure::OverflowsItsStack, "stack overflow at ")
}

/// Stops the crystal: the clock security system switches to the internal oscillator and raises the NMI.
fn crystal_stops(case: &Case) -> Seen {
    let velvet = with_image(image(HEAT, Failure::RaisesNmi), case.state);
    let stops = |velvet: &mut Velvet| {
        let stopped = |stopped: &mut virtual_prime::vm::Stopped<'_>| {
            let at = stopped.stop.at;
            stopped.session.board_mut().mcu.stop_crystal(at)
        };
        assert_eq!(velvet.bench.vm.with(stopped), Some(true), "the clock security system does not watch");
        throw(velvet);
    };
    let told = "WARNING: the firmware had ended itself: the 25 MHz crystal stopped\n";
    let kept: &[&str] = &["the firmware ended itself: the 25 MHz crystal stopped\n", BY_ITSELF];
    let seen = resets(velvet, stops, throw_back, told, kept, case.within_ms + SLOW_TICK_MS);
    let without_waiting = |ms: f64| (ms - SLOW_TICK_MS).max(0.0);
    Seen { outputs_ms: seen.outputs_ms.map(without_waiting), motion_ms: seen.motion_ms.map(without_waiting), ..seen }
}

/// Starts a move along X, at this speed (an F word), of firmware that masks all interrupts for twice so many
/// instructions whenever it is asked for its status.
fn masking(loops: u16, speed: &str) -> Velvet {
    let elf = image_that_masks_interrupts_in("report_status", loops);
    let mut velvet = Plan::new().image(elf.clone()).start();
    // The copy is in the board's flash now.
    let _ = std::fs::remove_file(elf);
    velvet.ask("G28.3 X30 Y30 Z30", SECOND);
    velvet.type_in(&format!("G1 X130 {speed}"));
    velvet.hear(300);
    velvet
}

fn x_mm(velvet: &mut Velvet) -> f64 {
    velvet.world(|world| world.carriage_mm(units::Actuator::Alpha)).expect("a motor")
}

fn late_steps(_: &Case) -> Seen {
    // Interrupts are off for 60 us of 122 from step to step: a step in two is delayed, and the next is on
    // time.
    let mut velvet = masking(12_000, "F6131");
    for _ in 0..10 {
        velvet.bench.console.send(b"?");
        velvet.hear(30);
    }
    let said = velvet.ask("get steps", SECOND);
    assert!(velvet.said().contains("WARNING: 1 steps came late, by up to "), "{}", velvet.said());
    assert!(said.contains("delayed: 0\n"), "{said}");
    velvet.hear(2 * SECOND);
    assert!((x_mm(&mut velvet) - 130.0).abs() < 1e-6);
    Seen::default()
}

fn steps_too_late(case: &Case) -> Seen {
    // Interrupts are off for 100 us of 42 from step to step: at least two steps of the motor are due at once.
    // Steps are written 125 us ahead or more: beyond that there would be a gap instead.
    let velvet = masking(20_000, "F18000");
    let told = "had to be delayed for their driver";
    let strike = |velvet: &mut Velvet| {
        velvet.world(|world| world.trace_mut().take());
        velvet.bench.console.send(b"?");
    };
    let (mut velvet, seen) = super::scene::halted(velvet, strike, told, case.within_ms);
    velvet.type_in("M114.2");
    let (real, said) = (x_mm(&mut velvet), velvet.hear(100));
    let x = said.split("X:").nth(1).and_then(|rest| rest.split(' ').next()).and_then(|x| x.parse::<f64>().ok());
    assert!(x.is_some_and(|x| (x - real).abs() < 0.01 && x < 125.0), "{said}, but it is at {real} mm");
    seen
}

fn second_core(_: &Case) -> Seen {
    const TOLD: &str = "set the option byte BCM4 to 0";
    let mut velvet = Plan::new().with_second_core().start();
    assert!(velvet.said().contains(TOLD), "{}", velvet.said());
    // The machine works in spite of that.
    assert!(velvet.ask("M119", SECOND).contains("ok"));
    let without = Plan::new().start();
    assert!(!without.said().contains(TOLD), "{}", without.said());
    Seen::default()
}

/// Limit for a hard fault, a panic and an overflow, which end in the same handler.
const AT_ONCE_MS: f64 = 1.0;
/// Limit for the NMI, which comes with the failure on silicon; here the stub of a tick raises it. Ticks come
/// every half a millisecond of a timer at 200 MHz, which without the crystal runs at 32.
const SLOW_TICK_MS: f64 = 0.5 * 200.0 / 32.0;
/// Time until the next turn of the slow watch, which comes every 100 ms.
const NEXT_LOOK_MS: f64 = 101.0;

pub const CLASSES: &[Class] = &[
    Class {
        name: "an_executor_that_hangs",
        what: "executor hangs",
        does: "the watchdog resets the board; it comes up cold, and says why",
        cases: &[
            Case { state: State::Heating, within_ms: EXECUTOR_MS, run: executor_hangs },
            Case { state: State::Printing, within_ms: EXECUTOR_MS, run: executor_hangs },
        ],
    },
    Class {
        name: "heat_control_that_stops",
        what: "heat control stops or hangs",
        does: "the same, sooner: a pin is on only while its control ran in the last second",
        cases: &[
            Case { state: State::Heating, within_ms: WATCHDOG_MS, run: heat_skips },
            Case { state: State::Holding, within_ms: WATCHDOG_MS, run: heat_skips },
            Case { state: State::Heating, within_ms: WATCHDOG_MS, run: heat_hangs },
        ],
    },
    Class {
        name: "a_step_feed_that_stops",
        what: "step feed stops or hangs",
        does: "the same",
        cases: &[
            Case { state: State::Printing, within_ms: WATCHDOG_MS, run: feed_skips },
            Case { state: State::Heating, within_ms: WATCHDOG_MS, run: feed_hangs },
        ],
    },
    Class {
        name: "a_planner_that_stops",
        what: "planner stops",
        does: "the same",
        cases: &[
            Case { state: State::Heating, within_ms: WATCHDOG_MS, run: planner_skips },
            Case { state: State::Printing, within_ms: WATCHDOG_MS, run: planner_skips },
        ],
    },
    Class {
        name: "a_slow_watch_that_stops",
        what: "the watch over drivers and supplies stops",
        does: "the same",
        cases: &[
            Case { state: State::Heating, within_ms: WATCHDOG_MS, run: watch_skips },
            Case { state: State::Printing, within_ms: WATCHDOG_MS, run: watch_skips },
        ],
    },
    Class {
        name: "a_panic",
        what: "panic",
        does: "outputs off at once, then a reset; the next start says where it was",
        cases: &[
            Case { state: State::Heating, within_ms: NEXT_LOOK_MS, run: panics },
            Case { state: State::Printing, within_ms: NEXT_LOOK_MS, run: panics },
        ],
    },
    Class {
        name: "a_hard_fault",
        what: "hard fault (an instruction that is none)",
        does: "the same",
        cases: &[
            Case { state: State::Heating, within_ms: NEXT_LOOK_MS, run: bad_code },
            Case { state: State::Printing, within_ms: NEXT_LOOK_MS, run: bad_code },
        ],
    },
    Class {
        name: "a_stack_overflow",
        what: "stack of the interrupts overflows",
        does: "a guard region ends it in a hard fault; the same",
        cases: &[
            Case { state: State::Heating, within_ms: AT_ONCE_MS, run: overflows },
            Case { state: State::Printing, within_ms: AT_ONCE_MS, run: overflows },
        ],
    },
    Class {
        name: "a_crystal_that_stops",
        what: "the 25 MHz crystal stops",
        does: "the core goes on from its own oscillator: outputs off at once, then a reset; without a crystal it stays off",
        cases: &[
            Case { state: State::Heating, within_ms: AT_ONCE_MS, run: crystal_stops },
            Case { state: State::Printing, within_ms: AT_ONCE_MS, run: crystal_stops },
        ],
    },
    Class {
        name: "steps_that_come_late",
        what: "steps late: something kept the step interrupt or the step feed from running",
        does: "told; every step is made",
        cases: &[Case { state: State::Moving, within_ms: 500.0, run: late_steps }],
    },
    Class {
        name: "steps_that_come_too_late",
        what: "steps so late that a driver's least distance had to be kept by delaying them",
        does: "brake, halt; every step is given, so positions are kept",
        cases: &[Case { state: State::Moving, within_ms: 500.0, run: steps_too_late }],
    },
    Class {
        name: "a_second_core_that_runs",
        what: "the chip is set to start its second core",
        does: "told at the start, with what to do",
        cases: &[Case { state: State::PowerOn, within_ms: 0.0, run: second_core }],
    },
];

super::tests! {
    an_executor_that_hangs
    heat_control_that_stops
    a_step_feed_that_stops
    a_planner_that_stops
    a_slow_watch_that_stops
    a_panic
    a_hard_fault
    a_stack_overflow
    a_crystal_that_stops
    steps_that_come_late
    steps_that_come_too_late
    a_second_core_that_runs
}
