//! Faults of the axes' switches, the probe, and buttons.

use sim::world::Fault;
use units::Actuator;

use super::scene::{Seen, State, enter, halts, printer, refuses};
use super::{Case, Class};
use crate::common::machine::drive;
use crate::common::velvet::{Plan, SECOND};

fn never(case: &Case) -> Seen {
    // Travels are short, so that the search is short: the switch is 30 mm away, and the frame 3 mm behind it.
    let plan = Plan::new().with("minx.max_travel = 220 ", "minx.max_travel = 32 ").fault("switch-never:minx");
    let velvet = enter(plan, State::Idle);
    halts(velvet, |velvet| velvet.type_in("G28 X0"), "endstop was not reached within its travel", case.within_ms)
}

fn stuck(case: &Case) -> Seen {
    let velvet = enter(Plan::new().fault("switch-always:minx"), State::Idle);
    let told = "endstop does not open when backed off: stuck, or wired inverted";
    let (mut velvet, seen) = super::scene::halted(velvet, |velvet| velvet.type_in("G28 X0"), told, case.within_ms);
    assert_eq!(velvet.world(|world| world.lost_mm(Actuator::Alpha)), 0.0, "the carriage was pushed against its stop");
    seen
}

fn bounces(case: &Case) -> Seen {
    let mut velvet = enter(Plan::new(), State::Idle);
    velvet.inject(&Fault::SwitchBounces("minx".into()));
    let from = velvet.now_ms();
    let said = velvet.ask("G28 X0", case.within_ms as u64);
    assert!(!said.contains("rror"), "{said}");
    let motion_ms = Some((velvet.now_ms() - from) as f64);
    super::scene::answers(&mut velvet, "M114", "X:0.0");
    Seen { motion_ms, ..Seen::default() }
}

fn hard_limit(case: &Case) -> Seen {
    let plan = printer().set("[endstops] minx.limit_enable = true");
    let velvet = enter(plan, case.state);
    let told = "ALARM: Hard limit -X was hit (minx)";
    halts(velvet, |velvet| velvet.inject(&Fault::SwitchAlwaysOperated("minx".into())), told, case.within_ms)
}

fn with_probe() -> Plan {
    ["[zprobe] enable = true", "[zprobe] probe_pin = PB10^", "[zprobe] max_travel = 15"]
        .into_iter()
        .fold(Plan::new(), Plan::set)
}

fn probe_closed(case: &Case) -> Seen {
    let velvet = enter(with_probe().fault("switch-always:probe"), State::Idle);
    refuses(velvet, "G30", "error:ZProbe triggered before move, aborting command.\n", case.within_ms)
}

fn probe_never(case: &Case) -> Seen {
    let velvet = enter(with_probe().fault("switch-never:probe"), State::Idle);
    halts(velvet, |velvet| velvet.type_in("G38.2 Z-1 F600"), "ALARM: Probe fail", case.within_ms)
}

fn kill(case: &Case) -> Seen {
    let plan = printer().set("[kill button] enable = true").set("[kill button] pin = PJ6^");
    let velvet = enter(plan, case.state);
    halts(velvet, |velvet| drive(velvet, "PJ6", false), "ALARM: Kill button pressed", case.within_ms)
}

/// Breaks the wire of a kill button whose contacts open.
fn kill_wire(case: &Case) -> Seen {
    let plan = printer().set("[kill button] enable = true").set("[kill button] pin = PJ6!^");
    let mut velvet = plan.held();
    drive(&mut velvet, "PJ6", false);
    velvet.hear_until(crate::common::velvet::PROMPT, 2 * SECOND);
    velvet.ask("M104 S200", SECOND);
    velvet.hear(SECOND);
    halts(velvet, |velvet| drive(velvet, "PJ6", true), "ALARM: Kill button pressed", case.within_ms)
}

/// Opens the safety door during a move; a closed door pulls its input low.
fn door(case: &Case) -> Seen {
    let plan = printer().set("[safety door] enable = true").set("[safety door] pin = PJ9^");
    let plan = [
        "enable = true",
        "output_pin = PI11",
        "output_type = digital",
        "input_on_command = M3",
        "input_off_command = M5",
    ]
    .iter()
    .fold(plan, |plan, line| plan.set(&format!("[switch] mill.{line}")));
    let mut velvet = plan.held();
    drive(&mut velvet, "PJ9", false);
    velvet.hear_until(crate::common::velvet::PROMPT, 2 * SECOND);
    velvet.ask("G28.3 X0", SECOND);
    assert_eq!(velvet.ask("M3", SECOND), "ok\n");
    velvet.type_in("G1 X60 F600");
    velvet.hear(500);
    assert!(velvet.level("PI11"), "the spindle is off");
    crate::common::machine::watch(&mut velvet, &["PI11"]);
    let from_ns = velvet.bench.vm.now_ns();
    drive(&mut velvet, "PJ9", true);
    velvet.hear_until("the door is open", case.within_ms as u64);
    velvet.hear(300);
    let ms = |at_ns: u64| at_ns.saturating_sub(from_ns) as f64 / 1e6;
    let outputs_ms = crate::common::machine::changes(&mut velvet).last().map(|change| ms(change.at_ns));
    let motion_ms = velvet.world(|world| world.trace_mut().take()).last().map(|edge| ms(edge.time_ns));
    assert!(!velvet.level("PI11"), "the spindle turns");
    // No motion goes on while the door is open.
    velvet.bench.console.send(b"~");
    velvet.hear_until("the door is still open", SECOND);
    velvet.hear(300);
    assert!(velvet.world(|world| world.trace_mut().take()).is_empty(), "it moves");
    super::scene::answers(&mut velvet, "?", "<Door|");
    drive(&mut velvet, "PJ9", false);
    velvet.hear(100);
    velvet.bench.console.send(b"~");
    velvet.hear(8 * SECOND);
    assert!((velvet.world(|world| world.carriage_mm(Actuator::Alpha)).expect("a motor") - 90.0).abs() < 1e-6);
    assert!(velvet.level("PI11"), "the spindle is off");
    Seen { outputs_ms, motion_ms, told_ms: None }
}

pub const CLASSES: &[Class] = &[
    Class {
        name: "an_end_switch_that_never_closes",
        what: "end switch never closes",
        does: "the search ends after the travel; halt; the axis is named",
        cases: &[Case { state: State::PowerOn, within_ms: 3_000.0, run: never }],
    },
    Class {
        name: "an_end_switch_that_is_stuck",
        what: "end switch already closed, or does not open again",
        does: "refused or halt; the axis is named; nothing grinds on",
        cases: &[Case { state: State::PowerOn, within_ms: 3_000.0, run: stuck }],
    },
    Class {
        name: "an_end_switch_that_bounces",
        what: "end switch bounces",
        does: "homes to the same place",
        cases: &[Case { state: State::Idle, within_ms: 8_000.0, run: bounces }],
    },
    Class {
        name: "a_hard_limit_that_is_hit",
        what: "hard limit hit while moving",
        does: "brake, halt",
        cases: &[
            Case { state: State::Moving, within_ms: 60.0, run: hard_limit },
            Case { state: State::Printing, within_ms: 60.0, run: hard_limit },
        ],
    },
    Class {
        name: "a_probe_that_is_stuck",
        what: "probe stuck closed",
        does: "refused before anything moves; a file being played waits there",
        cases: &[Case { state: State::PowerOn, within_ms: 100.0, run: probe_closed }],
    },
    Class {
        name: "a_probe_that_never_closes",
        what: "probe never closes",
        does: "the search ends after its travel; G38.2 and G38.4 halt",
        cases: &[Case { state: State::PowerOn, within_ms: 3_000.0, run: probe_never }],
    },
    Class {
        name: "a_door_that_opens",
        what: "the safety door is opened, or its wire breaks",
        does: "spindle, laser and coolant off, brake; nothing goes on while it is open, and closed only on `~` or M24",
        cases: &[Case { state: State::Moving, within_ms: 60.0, run: door }],
    },
    Class {
        name: "a_kill_button",
        what: "kill button pressed",
        does: "heaters off and brake at the next look; halt",
        cases: &[
            Case { state: State::Printing, within_ms: 60.0, run: kill },
            Case { state: State::Heating, within_ms: 20.0, run: kill },
            Case { state: State::Homing, within_ms: 60.0, run: kill },
        ],
    },
    Class {
        name: "a_kill_buttons_wire_that_breaks",
        what: "the wire of a kill button with opening contacts breaks",
        does: "the same",
        cases: &[Case { state: State::Heating, within_ms: 20.0, run: kill_wire }],
    },
];

super::tests! {
    an_end_switch_that_never_closes
    an_end_switch_that_is_stuck
    an_end_switch_that_bounces
    a_hard_limit_that_is_hit
    a_probe_that_is_stuck
    a_probe_that_never_closes
    a_door_that_opens
    a_kill_button
    a_kill_buttons_wire_that_breaks
}
