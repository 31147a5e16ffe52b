//! The state walk: every state times every event, from the table itself (`base/src/safety/state.rs`).
//!
//! The table's own transitions say which modes there are (a state, what it interrupted, whether a job is
//! suspended) and how to get there. A real machine is brought into each of them by what people do and what
//! can happen to it, and then everything that can happen in it happens; what the machine says it is must be
//! what the table says. An event or a state that is added has no walk, and then this does not compile.
//!
//! And wherever the machine is: M112, the kill button and a fault make it safe within a millisecond.

use std::collections::VecDeque;

use base::safety::{Event, Mode};
use base::sessions::{ConsoleKind, SessionProfile};
use base::sessions::{Rights, SessionId};
use program::Dialect;
use program::State;
use scenarios::{Bench, CARTESIAN, Plan};
use units::Actuator;

/// Session that causes events: lines wait there, while the debug console asks for the machine's mode.
const ACTS: SessionId = SessionId(1);
/// Session that signals the door, by a byte of GRBL's dialect.
const DOOR: SessionId = SessionId(2);
const DOOR_SENSOR: SessionProfile =
    SessionProfile { kind: ConsoleKind::Memory, rights: Rights::Operate, dialect: Some(Dialect::Grbl), greeting: "" };
/// Time in which an event without meaning must change nothing, seconds: several polls of the inputs.
const QUIET_S: f64 = 0.03;
/// Longest time until an event with meaning has its effect, seconds: homing is the longest.
const PATIENCE_S: f64 = 20.0;
/// Turns of the machine's work in half a millisecond: few, so that the walk is quick.
const TURNS: u32 = 4;

/// A printer with a laser, a probe, a kill button and GRBL's door, without scripts that move.
fn plan() -> Plan {
    Plan::new(CARTESIAN)
        .visitor(DOOR_SENSOR)
        .set("[zprobe] enable = true")
        .set("[zprobe] probe_pin = PB10^")
        .set("[kill button] enable = true")
        .set("[kill button] pin = PB7^")
        .set("[pwm1] frequency = 5000")
        .set("[switch] laser.enable = true")
        .set("[switch] laser.input_on_command = M3")
        .set("[switch] laser.input_off_command = M5")
        .set("[switch] laser.output_pin = PWM1_1")
        .set("[switch] laser.output_type = hwpwm")
        .set("[switch] laser.startup_value = 0")
        .set("[conveyor] queue_delay_time_ms = 1")
}

/// Cause of an event in a mode.
enum Cause {
    /// Bytes typed by somebody.
    Typed(&'static [u8]),
    /// The event comes by itself, after a while.
    ByItself,
    /// The machine starts with a configuration that nobody can use.
    AtBoot,
    /// The event cannot come about in this mode, for the given reason.
    Never(&'static str),
}

use Cause::{AtBoot, ByItself, Never, Typed};

/// A search is under way, or held: the executor is in it, and lines wait for its end.
fn is_searching(mode: Mode) -> bool {
    mode.is_in(State::Homing) || mode.is_in(State::Probing)
}

/// Every event has its cause.
fn cause(mode: Mode, event: Event) -> Cause {
    let state = mode.state();
    match event {
        Event::ConfigurationFails if mode == Mode::default() => AtBoot,
        Event::ConfigurationFails => Never("the configuration is read at boot"),
        _ if state == State::Invalid && matches!(event, Event::Drained | Event::HomingEnds | Event::ProbingEnds) => {
            Never("nothing has begun")
        }
        Event::Started => Typed(b"G91 G1 X20 F600\n"),
        Event::Drained if state == State::Probing => Never("the end of its move is the end of the search"),
        Event::Drained => ByItself,
        Event::HomingBegins => Typed(b"$H\n"),
        Event::HomingEnds if state == State::Homing => ByItself,
        Event::HomingEnds => Never("no switch is searched for"),
        Event::ProbingBegins => Typed(b"G38.2 Z-15 F300\n"),
        Event::ProbingEnds if state == State::Probing => ByItself,
        Event::ProbingEnds => Never("no contact is searched for"),
        Event::JogBegins => Typed(b"$J X20 F600\n"),
        Event::Hold => Typed(b"!"),
        Event::Resume => Typed(b"~"),
        Event::Suspend if mode.is_suspended() => Never("it is suspended already, and says so"),
        // Heaters keep their targets, so that there is something to switch off.
        Event::Suspend => Typed(b"suspend h\n"),
        Event::Unsuspend => Typed(b"abort\n"),
        Event::CheckBegins if state == State::Check => Never("the same line ends it"),
        Event::CheckEnds if state == State::Idle => Never("the same line begins it"),
        Event::CheckBegins | Event::CheckEnds => Typed(b"$C\n"),
        Event::DoorOpens => Typed(b"\x84"),
        Event::Halt => Typed(b"M112\n"),
        Event::Release => Typed(b"$X\n"),
        Event::Sleep => Typed(b"$SLP\n"),
        Event::Wake if state == State::Sleep => Typed(b"\x18"),
        Event::Wake => Never("Ctrl-X halts here"),
    }
}

/// The modes that an event leads through, the last of which lasts. Behind a search lines wait, and while the
/// door is open those that move; what begins at standstill waits for it.
fn course(mode: Mode, event: Event) -> Vec<Mode> {
    use Event::{Drained, HomingBegins, JogBegins, ProbingBegins, Started, Suspend, Unsuspend};
    let sequence: &[Event] = match event {
        // The event is answered like a query.
        Event::Release => &[event],
        _ if is_line(mode, event) && is_searching(mode) => &[],
        Started | HomingBegins | ProbingBegins | JogBegins | Suspend if mode.state() == State::Door => &[],
        // Such events are not carried out.
        HomingBegins if matches!(mode.state(), State::Alarm | State::Sleep | State::Invalid) => &[],
        HomingBegins | ProbingBegins | Suspend => &[Drained, event],
        // A moving machine brakes first.
        Unsuspend if matches!(mode.state(), State::Run | State::Jog) => &[Drained, event],
        _ => &[event],
    };
    let mut course = vec![mode];
    for event in sequence {
        course.extend(course.last().and_then(|mode| mode.next(*event)));
    }
    course
}

/// A line is typed for it, which the executor takes when it is its turn.
fn is_line(mode: Mode, event: Event) -> bool {
    matches!(cause(mode, event), Typed(bytes) if bytes.len() > 1 && event != Event::Halt)
}

/// Returns the mode that an event leads to.
fn outcome(mode: Mode, event: Event) -> Mode {
    course(mode, event).last().copied().unwrap_or(mode)
}

/// Returns every mode that can be reached, each with the events that lead there.
fn modes() -> Vec<(Mode, Vec<Event>)> {
    let mut found = vec![(Mode::default(), Vec::new())];
    let mut queue = VecDeque::from(found.clone());
    while let Some((mode, path)) = queue.pop_front() {
        for event in Event::ALL.into_iter().filter(|event| !matches!(cause(mode, *event), Never(_))) {
            let next = outcome(mode, event);
            if !found.iter().any(|(known, _)| *known == next) {
                let path: Vec<Event> = path.iter().copied().chain([event]).collect();
                found.push((next, path.clone()));
                queue.push_back((next, path));
            }
        }
    }
    found
}

/// Returns the name of a mode in `get mode`.
fn name(mode: Mode) -> String {
    let suspended = if mode.is_suspended() { " (suspended)" } else { "" };
    format!("{:?}{suspended}", mode.state()).to_lowercase()
}

/// A machine on its walk.
struct Walk {
    bench: Bench,
    mode: Mode,
    path: Vec<Event>,
}

impl Walk {
    /// A machine that was homed, with everything on that can be on, brought into a mode.
    fn to(path: &[Event]) -> Self {
        let mut plan = plan();
        if path == [Event::ConfigurationFails] {
            plan = plan.set("[motion control] arm_solution = teapot");
        }
        let mut bench = plan.start();
        bench.set_open(DOOR, true);
        bench.set_turns(TURNS);
        let mut walk = Self { bench, mode: Mode::default(), path: path.to_vec() };
        if path == [Event::ConfigurationFails] {
            walk.mode = outcome(walk.mode, Event::ConfigurationFails);
        } else {
            walk.bench.run(&["G28.3 X30 Y40 Z10", "M104 S200", "M140 S80", "M106 S255", "M3 S50"]);
            for event in path {
                walk.takes(*event);
            }
        }
        assert_eq!(walk.says(), name(walk.mode), "{path:?}");
        walk
    }

    fn says(&mut self) -> String {
        self.bench.type_in("get mode\n");
        let end = self.bench.now_s() + 0.1;
        let mut said = String::new();
        while !said.contains("ok\n") {
            assert!(self.bench.now_s() < end, "no answer to a question in {:?}: {said}", self.mode);
            said.push_str(&self.bench.hear(0.000_5));
        }
        // Messages to everybody may come before and behind it.
        let is_answer =
            |line: &&str| State::ALL.iter().any(|state| line.starts_with(&format!("{state:?}").to_lowercase()));
        said.lines().find(is_answer).unwrap_or_else(|| panic!("no state in {said}")).to_owned()
    }

    /// Makes an event happen; the machine must follow the table.
    fn takes(&mut self, event: Event) {
        match cause(self.mode, event) {
            Typed(bytes) => self.bench.send_on(if event == Event::DoorOpens { DOOR } else { ACTS }, bytes),
            ByItself => {}
            AtBoot | Never(_) => unreachable!("{event:?} in {:?}", self.mode),
        }
        let course = course(self.mode, event);
        let after = outcome(self.mode, event);
        let lasts = after == self.mode;
        let end = self.bench.now_s() + if lasts { QUIET_S } else { PATIENCE_S };
        // A search may end with a way back, which begins at once.
        let goes_back = after.next(Event::Started).filter(|_| matches!(event, Event::HomingEnds | Event::ProbingEnds));
        loop {
            let said = self.says();
            if said == name(after) && !lasts {
                break;
            }
            let is_on_course = course.iter().copied().chain(goes_back).any(|mode| name(mode) == said);
            let (mode, path) = (self.mode, &self.path);
            assert!(is_on_course, "{event:?} in {mode:?} by {path:?} leads to {said}, not {}", name(after));
            if self.bench.now_s() >= end {
                assert!(lasts, "{event:?} in {mode:?} by {path:?} leads nowhere, not to {}", name(after));
                break;
            }
        }
        self.mode = after;
    }
}

#[test]
fn every_state_is_reached_by_ordinary_means() {
    let modes = modes();
    for state in State::ALL {
        assert!(modes.iter().any(|(mode, _)| mode.state() == state), "nothing leads to {state:?}");
    }
    // A mode that interrupts others comes once for each of them.
    assert!(modes.len() >= 25, "{} modes: {modes:#?}", modes.len());
}

#[test]
fn what_cannot_come_about_means_nothing() {
    for (mode, _) in modes() {
        for event in Event::ALL {
            if let Never(why) = cause(mode, event)
                && let Some(next) = mode.next(event)
            {
                // Of these the table says something, and it is never asked.
                let is_known = match event {
                    Event::ConfigurationFails => next.state() == State::Invalid,
                    _ => next == mode,
                };
                assert!(is_known, "{event:?} in {mode:?} ({why}) would lead to {next:?}");
            }
        }
    }
}

/// The walk, one part of the modes each, so that they run side by side.
fn walk(part: usize, parts: usize) {
    let mut steps = 0;
    for (number, (mode, path)) in modes().into_iter().enumerate() {
        if number % parts != part {
            continue;
        }
        for event in Event::ALL.into_iter().filter(|event| !matches!(cause(mode, *event), Never(_) | AtBoot)) {
            let mut walk = Walk::to(&path);
            let edges = walk.bench.world(|world| world.trace().total());
            walk.takes(event);
            if matches!(mode.state(), State::Check | State::Alarm | State::Sleep | State::Invalid) {
                walk.bench.hear(0.2);
                let now = walk.bench.world(|world| world.trace().total());
                assert_eq!(now, edges, "{event:?} in {mode:?} moves something");
            }
            steps += 1;
        }
    }
    println!("{steps} steps of the walk");
}

#[test]
fn every_event_in_every_state_first_part() {
    walk(0, 3);
}

#[test]
fn every_event_in_every_state_second_part() {
    walk(1, 3);
}

#[test]
fn every_event_in_every_state_third_part() {
    walk(2, 3);
}

/// Asserts that nothing heats, burns or turns.
fn assert_off(bench: &Bench, what: &str) {
    assert!(!bench.heats(), "{what}: a heater is on");
    assert_eq!(bench.world(|world| world.vfet_v()), 0.0, "{what}: hot end and fans have their supply");
    assert_eq!(bench.world(|world| world.pwm_duty(0, 0)), 0.0, "{what}: the laser is on");
}

/// Actions that make the machine safe.
type Stop = (&'static str, fn(&mut Bench));

const STOPS: [Stop; 3] = [
    ("M112", |bench| bench.send_on(ACTS, b"M112\n")),
    ("Ctrl-X", |bench| bench.send_on(ACTS, &[0x18])),
    ("the kill button", |bench| {
        let at_ns = (bench.now_s() * 1e9) as u64;
        bench.world(|world| world.press(at_ns, "kill", true)).expect("a kill button");
        // The runner shows pins as they are at the end of a slot: now it is pressed.
        bench.hear(0.000_5);
    }),
];

#[test]
fn wherever_it_is_it_is_safe_within_a_millisecond() {
    for (mode, path) in modes() {
        for (what, stop) in STOPS {
            let mut walk = Walk::to(&path);
            let bench = &mut walk.bench;
            let what = format!("{what} in {mode:?}");
            let is_off = matches!(mode.state(), State::Alarm | State::Sleep | State::Invalid);
            assert_eq!(bench.heats(), !is_off, "{what}: there is something to switch off");
            // Between two turns of the machine's work.
            bench.hear(0.000_5);
            stop(bench);
            bench.hear(0.001);
            assert_off(bench, &what);
            // Motors brake, for a second at most, and then lose their current.
            bench.hear(1.1);
            let edges = bench.world(|world| world.trace().total());
            bench.hear(0.1);
            assert_eq!(bench.world(|world| world.trace().total()), edges, "{what}: something moves");
            for actuator in [Actuator::Alpha, Actuator::Beta, Actuator::Gamma, Actuator::Delta] {
                assert!(!bench.is_energised(actuator), "{what}: {} has current", actuator.name());
            }
            assert_off(bench, &what);
            let said = walk.says();
            assert!(["alarm", "sleep", "invalid"].contains(&said.as_str()), "{what}: {said}");
        }
    }
}
