//! Faults while a laser burns: how soon its output is forced inactive, and its gate is off.

use super::scene::{Seen, State};
use super::{Case, Class};
use crate::common::hang::image_that_hangs_in;
use crate::common::machine::{changes, drive, pin, watch};
use crate::common::switched::{FEED, Failure, HEAT, Interrupt, image, throw};
use crate::common::velvet::{PROMPT, Plan, SECOND, Velvet};
use crate::common::writes::Written;

/// TIM8 (RM0399 section 42.4): mode and compare value of channel 1.
const MODE: u64 = 0x4001_0418;
const COMPARE: u64 = 0x4001_0434;
/// Mode "forced inactive" (section 42.4.8, OCxM = 100).
const FORCED_INACTIVE: u64 = 0x40;
/// Status register of TIM7 (section 46.4.4): written as each heat tick begins.
const HEAT_TICK: u64 = 0x4000_1410;
const HEAT_TICK_NS: u64 = 500_000;
const GATE: &str = "PD9";
const KILL: &str = "PJ6";
const DOOR: &str = "PJ9";
const LID: &str = "PB7";

/// Machine with a laser, a kill button, a door and a lid, all closed.
fn plan() -> Plan {
    let lines = [
        "[laser] enable = true",
        "[laser] pwm_pin = PWM2_1",
        "[laser] ttl_pin = PD9",
        "[laser] maximum_s_value = 1000",
        "[laser] interlock_switches = lid",
        "[switch] lid.enable = true",
        "[switch] lid.input_pin = PB7^",
        "[kill button] enable = true",
        "[kill button] pin = PJ6^",
        "[safety door] enable = true",
        "[safety door] pin = PJ9^",
    ];
    let plan = lines.iter().fold(Plan::new(), |plan, line| plan.set(line));
    [MODE, COMPARE, HEAT_TICK].into_iter().fold(plan, |plan, register| plan.watching(register..register + 4))
}

/// Starts the machine, and lights its laser: along a move of some seconds, or at rest.
#[track_caller]
fn lit(plan: Plan, state: State) -> Velvet {
    let mut velvet = plan.meaning_faults().held();
    // Closed contacts of the door pull its input low; those of the lid do too.
    [DOOR, LID].into_iter().for_each(|input| drive(&mut velvet, input, false));
    drive(&mut velvet, KILL, true);
    velvet.hear_until(PROMPT, 2 * SECOND);
    velvet.ask("G28.3 X0 Y0 Z0", SECOND);
    if state == State::Fired {
        velvet.ask("fire 50 60000", SECOND);
    } else {
        velvet.ask("M3 S500", SECOND);
        velvet.type_in("G1 X200 F6000");
        velvet.hear(500);
    }
    watch(&mut velvet, &[GATE]);
    assert!(velvet.level(GATE), "the laser is on; it said: {}", velvet.said());
    velvet.bench.writes.take();
    changes(&mut velvet);
    velvet
}

/// Returns the time from the cause to the laser's end, milliseconds: its output inactive and its gate off.
#[track_caller]
fn off_after(velvet: &mut Velvet, writes: &[Written], from_ns: u64) -> f64 {
    let ends = |write: &&Written| match write.address {
        MODE => write.value & 0xFF == FORCED_INACTIVE,
        COMPARE => write.value & 0xFFFF == 0,
        _ => false,
    };
    let output_ns = writes.iter().filter(|write| write.at_ns >= from_ns).find(ends).expect("the output ends").at_ns;
    let gate = changes(velvet).into_iter().find(|change| change.pin == pin(GATE) && !change.high);
    let gate_ns = gate.expect("the gate goes off").at_ns;
    assert!(!velvet.level(GATE), "the gate is on again");
    let last = writes.iter().rfind(|write| write.address == COMPARE).map_or(0, |write| write.value & 0xFFFF);
    assert_eq!(last, 0, "the output is on again");
    (output_ns.max(gate_ns) - from_ns) as f64 / 1e6
}

/// Lights the laser, has something happen at an instant that is returned, and asserts that the laser ends.
#[track_caller]
fn ends(case: &Case, plan: Plan, cause: impl FnOnce(&mut Velvet) -> u64) -> Seen {
    let mut velvet = lit(plan, case.state);
    let from_ns = cause(&mut velvet);
    velvet.hear(20);
    let writes = velvet.bench.writes.take();
    Seen { outputs_ms: Some(off_after(&mut velvet, &writes, from_ns)), ..Seen::default() }
}

fn byte(case: &Case) -> Seen {
    ends(case, plan(), |velvet| velvet.send_through(b"\x18"))
}

fn line(case: &Case) -> Seen {
    ends(case, plan(), |velvet| velvet.send_through(b"M112\n"))
}

#[track_caller]
fn pressed(case: &Case, input: &'static str, level: bool) -> Seen {
    ends(case, plan(), |velvet| {
        drive(velvet, input, level);
        velvet.bench.vm.now_ns()
    })
}

fn kill(case: &Case) -> Seen {
    pressed(case, KILL, false)
}

fn door(case: &Case) -> Seen {
    pressed(case, DOOR, true)
}

fn lid(case: &Case) -> Seen {
    pressed(case, LID, true)
}

/// The duty follows the path while the machine brakes, but nothing of it leaves the output.
fn hold(case: &Case) -> Seen {
    let mut velvet = lit(plan(), case.state);
    let from_ns = velvet.send_through(b"!");
    velvet.hear(400);
    let modes = velvet.bench.writes.take().into_iter().filter(|write| write.address == MODE && write.at_ns >= from_ns);
    let modes: Vec<_> = modes.map(|write| (write.value & 0xFF, write.at_ns)).collect();
    let [(FORCED_INACTIVE, output_ns)] = modes[..] else { panic!("the output is not forced once: {modes:?}") };
    let gates: Vec<_> = changes(&mut velvet).into_iter().filter(|change| change.pin == pin(GATE)).collect();
    let [gate] = &gates[..] else { panic!("the gate changes {} times", gates.len()) };
    assert!(!gate.high);
    Seen { outputs_ms: Some((output_ns.max(gate.at_ns) - from_ns) as f64 / 1e6), ..Seen::default() }
}

fn hold_at_rest(case: &Case) -> Seen {
    ends(case, plan(), |velvet| velvet.send_through(b"!"))
}

/// Has an interrupt fail from the next heat tick on.
#[track_caller]
fn from_a_tick_on(case: &Case, interrupt: Interrupt, failure: Failure) -> Seen {
    let elf = image(interrupt, failure);
    let seen = ends(case, plan().image(elf.clone()), |velvet| {
        velvet.hear(2);
        let writes = velvet.bench.writes.take();
        let tick = writes.iter().rfind(|write| write.address == HEAT_TICK).expect("heat ticks").at_ns;
        throw(velvet);
        // The next one that comes after this moment.
        let passed = velvet.bench.vm.now_ns().saturating_sub(tick);
        tick + HEAT_TICK_NS * (passed / HEAT_TICK_NS + 1)
    });
    let _ = std::fs::remove_file(elf);
    seen
}

fn panics(case: &Case) -> Seen {
    from_a_tick_on(case, HEAT, Failure::Panics)
}

fn bad_code(case: &Case) -> Seen {
    from_a_tick_on(case, HEAT, Failure::IsNoCode)
}

fn overflows(case: &Case) -> Seen {
    from_a_tick_on(case, HEAT, Failure::OverflowsItsStack)
}

/// Has the step feed do nothing more: the laser ends 250 us after the feed was to come, and steps end.
#[track_caller]
fn starves(case: &Case, failure: Failure) -> Seen {
    let elf = image(FEED, failure);
    let mut velvet = lit(plan().image(elf.clone()), case.state);
    let _ = std::fs::remove_file(elf);
    velvet.world(|world| world.trace_mut().take());
    velvet.hear(2);
    throw(&mut velvet);
    let from_ns = velvet.bench.vm.now_ns();
    velvet.hear(20);
    let edges = velvet.world(|world| world.trace_mut().take());
    let last_step_ms = (edges.last().expect("steps that were written before").time_ns as f64 - from_ns as f64) / 1e6;
    let writes = velvet.bench.writes.take();
    // Off before the steps end is early enough.
    let off_ms = off_after(&mut velvet, &writes, from_ns);
    println!("steps ended after {last_step_ms} ms, the laser after {off_ms} ms");
    Seen { outputs_ms: Some((off_ms - last_step_ms).max(0.0)), ..Seen::default() }
}

fn feed_skips(case: &Case) -> Seen {
    starves(case, Failure::Skips)
}

fn feed_hangs(case: &Case) -> Seen {
    starves(case, Failure::Hangs)
}

fn executor_hangs(case: &Case) -> Seen {
    let elf = image_that_hangs_in("report_status");
    let mut velvet = lit(plan().image(elf.clone()), case.state);
    let _ = std::fs::remove_file(elf);
    let from_ns = velvet.send_through(b"?");
    velvet.hear(200);
    let writes = velvet.bench.writes.take();
    Seen { outputs_ms: Some(off_after(&mut velvet, &writes, from_ns)), ..Seen::default() }
}

fn logic_falls(case: &Case) -> Seen {
    ends(case, plan(), |velvet| {
        super::supplies::rail(velvet, 2_600);
        velvet.bench.vm.now_ns()
    })
}

/// Limit of the laser for every cause that the firmware sees.
const AT_ONCE_MS: f64 = 0.3;

pub const CLASSES: &[Class] = &[
    Class {
        name: "a_halt_while_a_laser_burns",
        what: "Ctrl-X or M112 while the laser burns",
        does: "the laser's output is forced inactive, its gate is off",
        cases: &[
            Case { state: State::Burning, within_ms: AT_ONCE_MS, run: byte },
            Case { state: State::Fired, within_ms: AT_ONCE_MS, run: byte },
            Case { state: State::Burning, within_ms: AT_ONCE_MS, run: line },
        ],
    },
    Class {
        name: "a_kill_button_while_a_laser_burns",
        what: "kill button pressed while the laser burns",
        does: "the same",
        cases: &[
            Case { state: State::Burning, within_ms: AT_ONCE_MS, run: kill },
            Case { state: State::Fired, within_ms: AT_ONCE_MS, run: kill },
        ],
    },
    Class {
        name: "a_door_that_opens_while_a_laser_burns",
        what: "safety door opened while the laser burns",
        does: "the same, and brake",
        cases: &[
            Case { state: State::Burning, within_ms: AT_ONCE_MS, run: door },
            Case { state: State::Fired, within_ms: AT_ONCE_MS, run: door },
        ],
    },
    Class {
        name: "an_interlock_that_opens_while_a_laser_burns",
        what: "one of `interlock_switches` opened while the laser burns",
        does: "the same",
        cases: &[
            Case { state: State::Burning, within_ms: AT_ONCE_MS, run: lid },
            Case { state: State::Fired, within_ms: AT_ONCE_MS, run: lid },
        ],
    },
    Class {
        name: "a_hold_while_a_laser_burns",
        what: "feed hold (`!`) while the laser burns, with `hold = off`, the default",
        does: "the same, and brake",
        cases: &[
            Case { state: State::Burning, within_ms: AT_ONCE_MS, run: hold },
            Case { state: State::Fired, within_ms: AT_ONCE_MS, run: hold_at_rest },
        ],
    },
    Class {
        name: "a_step_feed_that_stops_while_a_laser_burns",
        what: "step feed stops or hangs while the laser burns, so that steps end",
        does: "the laser's watch ends its power 250 us after the feed was to come; told, and a machine that still moves holds",
        cases: &[
            Case { state: State::Burning, within_ms: AT_ONCE_MS, run: feed_skips },
            Case { state: State::Burning, within_ms: AT_ONCE_MS, run: feed_hangs },
        ],
    },
    Class {
        name: "an_executor_that_hangs_while_a_laser_is_fired",
        what: "executor hangs while it keeps a beam at rest",
        does: "the watch ends the beam after 100 ms, the watchdog resets the board later",
        cases: &[Case { state: State::Fired, within_ms: 101.0, run: executor_hangs }],
    },
    Class {
        name: "a_firmware_that_ends_itself_while_a_laser_burns",
        what: "panic, hard fault or stack overflow while the laser burns",
        does: "both PWM timers are forced inactive and the gate is off before anything is written down, then the board resets",
        cases: &[
            Case { state: State::Burning, within_ms: AT_ONCE_MS, run: panics },
            Case { state: State::Burning, within_ms: AT_ONCE_MS, run: bad_code },
            Case { state: State::Burning, within_ms: AT_ONCE_MS, run: overflows },
            Case { state: State::Fired, within_ms: AT_ONCE_MS, run: panics },
        ],
    },
    Class {
        name: "a_logic_supply_that_falls_while_a_laser_burns",
        what: "the chip's own 3.3 V falls below 2.8 V while the laser burns",
        does: "the same",
        cases: &[Case { state: State::Burning, within_ms: AT_ONCE_MS, run: logic_falls }],
    },
];

super::tests! {
    a_halt_while_a_laser_burns
    a_kill_button_while_a_laser_burns
    a_door_that_opens_while_a_laser_burns
    an_interlock_that_opens_while_a_laser_burns
    a_hold_while_a_laser_burns
    a_step_feed_that_stops_while_a_laser_burns
    an_executor_that_hangs_while_a_laser_is_fired
    a_firmware_that_ends_itself_while_a_laser_burns
    a_logic_supply_that_falls_while_a_laser_burns
}
