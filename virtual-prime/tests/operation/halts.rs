//! M112 and the kill button in every state: time until the outputs are safe, and time until the motors brake.

use board_facts::wiring::{MOTORS_ENABLE, OUTPUT_BUFFER_ENABLE};
use sim::trace::StepEdge;
use virtual_prime::pin_state::Drive;

use crate::common::MS;
use crate::common::machine::{changes, drive, everything, pin, state, watch};
use crate::common::velvet::{SECOND, Velvet};

const KILL: &str = "PJ6";
/// Outputs, and the level at which each is safe: heaters, part fan, fan 2, relays (inverted), the two enables
/// of the output stage.
const OUTPUTS: [(&str, bool); 8] = [
    ("PE0", false),
    ("PE3", false),
    ("PE1", false),
    ("PI11", false),
    ("PI4", true),
    ("PB7", true),
    (OUTPUT_BUFFER_ENABLE, true),
    ("PD7", false),
];
/// Compare registers of the spindle, TIM1 channel 1, and the laser, TIM8 channel 2 (RM0399 section 42.4,
/// boundary addresses).
const COMPARES: [u64; 2] = [0x4001_0034, 0x4001_0438];
/// Longer period of the two (`pwm2.frequency`): a compare value counts from the next period on.
const PWM_PERIOD_NS: u64 = 250_000;

/// Greeting of the GRBL dialect, which has the door.
const BANNER: &str = "Grbl 1.1f ['$' for help]\n";

/// Time limit for every output to be safe.
const OUTPUTS_NS: u64 = MS;
/// Time limit for the motors to brake: 1.5 ms of steps are written ahead; the next longer distance shows a
/// step later, here up to a millisecond.
const BRAKE_NS: u64 = 2_500_000;
/// Interval between two looks at the kill button, which delays its halt.
const KILL_LOOK_NS: u64 = 10 * MS;
/// Time limit for the motors to lose their current after the last step: standstill is looked for every 10 ms.
const MOTORS_NS: u64 = 15 * MS;

/// Event that stops the machine.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Stop {
    M112,
    Kill,
}

/// Times of a stop, nanoseconds from the last byte's arrival or the button's edge.
#[derive(Clone, Copy, Debug)]
struct Times {
    /// Instant from which every output has its safe level, for good; 0 when all had.
    outputs: u64,
    /// Last step before the first longer distance between two steps; none where nothing moves.
    brake: Option<u64>,
    /// Last step of any motor.
    standstill: Option<u64>,
    /// Instant at which the drivers' enable line goes off; 0 when it was off.
    motors: u64,
}

/// Switches on everything that can be, to stay on while the machine works.
#[track_caller]
fn switch_on(velvet: &mut Velvet) {
    for line in ["M104 S200", "M140 S100", "M106 S255", "M42", "M80", "M64", "M3 S50", "M66 S50", "M17", "G91"] {
        assert_eq!(velvet.ask(line, SECOND), "ok\n", "{line}");
    }
    velvet.hear(100);
}

/// Types a line and lets the machine begin it.
fn begin(velvet: &mut Velvet, line: &str) {
    velvet.type_in(line);
    velvet.hear(300);
}

/// Function that brings an idle machine into a state.
type Way = fn(&mut Velvet);

/// States by their name in `get mode`, with the function that brings an idle machine there.
const STATES: [(&str, Way); 11] = [
    ("idle", |_| {}),
    ("run", |velvet| begin(velvet, "G1 X8 F600")),
    ("hold", |velvet| {
        begin(velvet, "G1 X8 F600");
        begin(velvet, "!");
    }),
    ("homing", |velvet| begin(velvet, "$H")),
    ("probing", |velvet| begin(velvet, "G38.2 Z-5 F120")),
    ("jog", |velvet| begin(velvet, "$J=X8 F600")),
    ("suspended", |velvet| begin(velvet, "M600.1")),
    ("check", |velvet| begin(velvet, "$C")),
    ("door", |velvet| {
        begin(velvet, "G1 X8 F600");
        velvet.send_through(b"\x84");
        velvet.hear(300);
    }),
    ("alarm", |velvet| begin(velvet, "M112")),
    ("sleep", |velvet| begin(velvet, "$SLP")),
];

/// Whether an output has its safe level, low but for outputs that rest high.
fn is_safe(velvet: &mut Velvet, name: &'static str, safe: bool) -> bool {
    let wanted = if safe { [Drive::High, Drive::Released] } else { [Drive::Low, Drive::Low] };
    wanted.contains(&state(velvet, name).drive)
}

/// Stops the machine and watches it for a while.
#[track_caller]
fn stop(velvet: &mut Velvet, stop: Stop) -> Times {
    let _before = (changes(velvet), velvet.bench.writes.take());
    let since = match stop {
        Stop::M112 => velvet.send_through(b"M112\n"),
        Stop::Kill => {
            // The odd delay meets the machine's periods at any phase.
            velvet.hear_for(1_234_567);
            drive(velvet, KILL, false);
            velvet.bench.vm.now_ns()
        }
    };
    velvet.hear(200);
    if stop == Stop::Kill {
        drive(velvet, KILL, true);
    }
    for (name, safe) in OUTPUTS {
        assert!(is_safe(velvet, name, safe), "{name} is {:?} after {stop:?}", state(velvet, name));
    }
    let all = changes(velvet);
    let last = |name: &'static str| {
        let wanted = pin(name);
        let after = all.iter().filter(move |change| change.pin == wanted && change.at_ns >= since);
        after.map(|change| change.at_ns - since).max().unwrap_or(0)
    };
    let pins = OUTPUTS.iter().map(|(name, _)| last(name)).max();
    let writes = velvet.bench.writes.take();
    let duties = writes.iter().filter(|write| write.at_ns >= since).map(|write| {
        assert_eq!(write.value & 0xFFFF, 0, "{write:?}");
        write.at_ns - since + PWM_PERIOD_NS
    });
    let outputs = pins.into_iter().chain(duties.max()).max().unwrap_or(0);
    let steps = velvet.world(|world| world.trace_mut().take());
    let stood = steps.last().filter(|last| last.time_ns > since).map(|last| last.time_ns - since);
    Times { outputs, brake: stood.map(|_| brake(&steps, since)), standstill: stood, motors: last(MOTORS_ENABLE) }
}

/// Returns the instant of the first step after the stop whose distance to the next is longer than before the
/// stop. The last step of all has no next.
fn brake(steps: &[StepEdge], since: u64) -> u64 {
    let motor = steps[0].actuator;
    let steps: Vec<u64> = steps.iter().filter(|edge| edge.actuator == motor).map(|edge| edge.time_ns).collect();
    let first = steps.iter().position(|at| *at > since).expect("steps go on after a stop");
    let cruise = steps[first - 1] - steps[first - 2];
    let slower = steps[first - 1..].windows(2).find(|pair| pair[1] - pair[0] > cruise + cruise / 200 + 20);
    slower.map_or(steps[steps.len() - 1], |pair| pair[0]).saturating_sub(since)
}

/// Brings the machine back to idle, from an alarm or from sleep.
#[track_caller]
fn recover(velvet: &mut Velvet) {
    velvet.send_through(b"\x18");
    velvet.ask("M999", SECOND);
    velvet.hear(100);
}

/// Returns the state, asked on the other console: on the console of the test a question waits for the answers
/// before it.
#[track_caller]
fn assert_state(velvet: &mut Velvet, name: &str) {
    velvet.bench.uart.receive();
    velvet.bench.uart.send(b"get mode\n");
    velvet.hear(20);
    let said = String::from_utf8_lossy(&velvet.bench.uart.receive()).into_owned();
    assert!(said.starts_with(&format!("[MSG:{name}")), "not {name}: {said}");
}

fn machine() -> Velvet {
    let mut plan = everything().set("[general] grbl_mode = true");
    for address in COMPARES {
        plan = plan.watching(address..address + 4);
    }
    let mut velvet = plan.held();
    velvet.hear_until(BANNER, 2 * SECOND);
    drive(&mut velvet, KILL, true);
    for name in OUTPUTS.iter().map(|(name, _)| *name).chain([MOTORS_ENABLE]) {
        watch(&mut velvet, &[name]);
    }
    velvet
}

fn walk(how: Stop) {
    let mut velvet = machine();
    for (name, reach) in STATES {
        switch_on(&mut velvet);
        reach(&mut velvet);
        assert_state(&mut velvet, name);
        let times = stop(&mut velvet, how);
        println!("{how:?} {name}: {times:?}");
        let seen = if how == Stop::Kill { KILL_LOOK_NS } else { 0 };
        assert!(times.outputs <= seen + OUTPUTS_NS, "{how:?} {name}: {times:?}");
        assert!(times.brake.is_none_or(|brake| brake <= seen + BRAKE_NS), "{how:?} {name}: {times:?}");
        assert!(times.motors <= times.standstill.unwrap_or(seen) + MOTORS_NS, "{how:?} {name}: {times:?}");
        assert_eq!(state(&mut velvet, MOTORS_ENABLE).drive, Drive::High, "{how:?} {name}");
        // A machine that was moving has braked, and a machine that was on has switched off.
        let moves = ["run", "homing", "probing", "jog"].contains(&name);
        assert_eq!(times.brake.is_some(), moves, "{how:?} {name}");
        assert_eq!(times.outputs > 0, !["alarm", "sleep"].contains(&name), "{how:?} {name}");
        recover(&mut velvet);
    }
}

#[test]
fn m112_stops_the_machine_in_every_state() {
    walk(Stop::M112);
}

#[test]
fn the_kill_button_stops_the_machine_in_every_state() {
    walk(Stop::Kill);
}
