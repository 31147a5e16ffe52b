//! States in which a machine meets a fault, and assertions on its reaction.

use board_facts::wiring::{MOTORS_ENABLE, OUTPUT_BUFFER_ENABLE};
use sim::world::Fault;
use units::Actuator;

use crate::common::machine::{changes, pin, watch};
use crate::common::velvet::{PROMPT, Plan, SECOND, Velvet};

/// Extra time for telling beyond the reaction: 112 characters at 115200 baud, behind as many that are on
/// their way, and the grid on which words are looked for.
pub const TELLING_MS: f64 = 30.0;
/// Outputs of the hot end and the bed, and the switch of the hot ends' supply.
const HEATERS: [&str; 3] = ["PE0", "PE3", "PD7"];
/// Time for which outputs and motors are watched, to be safe for good.
const WATCHED_MS: u64 = 400;

/// State of the machine when a fault happens.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum State {
    /// The fault is there before power comes.
    PowerOn,
    /// Cold, without a target.
    Idle,
    /// Hot end and bed warm up, two seconds from cold.
    Heating,
    /// The hot end is at its 200 C and held there.
    Holding,
    /// X moves at 10 mm/s.
    Moving,
    /// A file is played, the hot end held at its temperature.
    Printing,
    /// The home switch of X is searched.
    Homing,
    /// Halted, with all heaters cold.
    Halted,
    /// X moves at 100 mm/s, and a laser burns.
    Burning,
    /// A laser is on at rest.
    Fired,
}

impl State {
    /// Returns the state in a person's words.
    pub const fn words(self) -> &'static str {
        match self {
            Self::PowerOn => "from power-on",
            Self::Idle => "idle",
            Self::Heating => "warming up",
            Self::Holding => "holding 200 C",
            Self::Moving => "moving",
            Self::Printing => "printing",
            Self::Homing => "homing",
            Self::Halted => "halted",
            Self::Burning => "burning",
            Self::Fired => "fired at rest",
        }
    }
}

/// Times of the reaction, milliseconds from the fault; none where there was nothing to see.
#[derive(Clone, Copy, Debug, Default)]
pub struct Seen {
    /// Switching-off of the last of the heaters' outputs and their supply.
    pub outputs_ms: Option<f64>,
    /// Last step of any motor.
    pub motion_ms: Option<f64>,
    /// Message to the person.
    pub told_ms: Option<f64>,
}

/// Returns a job that takes longer than any test.
pub fn job() -> String {
    let mut text = String::from("G21\nG90\nM83\nG28.3 X0 Y0 Z0\n");
    for _ in 0..60 {
        text += "G1 X40 E1 F1200\nG1 Y40 E1\nG1 X0 E1\nG1 Y0 E1\n";
    }
    text
}

/// Plans the sample printer with [`job`] on its card.
pub fn printer() -> Plan {
    Plan::new().file("job.g", &job())
}

/// Brings a machine into this state.
#[track_caller]
pub fn enter(plan: Plan, state: State) -> Velvet {
    let hot = matches!(state, State::Holding | State::Printing);
    let mut velvet = if hot { plan.soaked("hotend", 200.0).start() } else { plan.start() };
    if hot {
        velvet.ask("M104 S200", SECOND);
        velvet.hear(2 * SECOND);
    }
    match state {
        State::PowerOn | State::Idle | State::Holding => {}
        State::Burning | State::Fired => unreachable!("a laser's own tests light it"),
        State::Heating => {
            velvet.ask("M104 S200", SECOND);
            velvet.ask("M140 S60", SECOND);
            velvet.hear(2 * SECOND);
        }
        State::Moving => {
            velvet.ask("G28.3 X0", SECOND);
            velvet.type_in("G1 X100 F600");
            velvet.hear(500);
        }
        State::Printing => {
            velvet.type_in("play /sd/job.g");
            velvet.hear(SECOND);
        }
        State::Homing => {
            velvet.type_in("G28 X0");
            velvet.hear(300);
        }
        State::Halted => {
            velvet.type_in("M112");
            velvet.hear(300);
        }
    }
    velvet
}

fn ms(from_ns: u64, at_ns: u64) -> f64 {
    at_ns.saturating_sub(from_ns) as f64 / 1e6
}

/// Makes something happen and waits for the words, at most as long as the limit. Returns the instant of the
/// event and the time until the words came.
#[track_caller]
fn strike(velvet: &mut Velvet, strike: impl FnOnce(&mut Velvet), told: &str, within_ms: f64) -> (u64, f64) {
    watch(velvet, &HEATERS);
    watch(velvet, &[OUTPUT_BUFFER_ENABLE]);
    changes(velvet);
    let from_ns = velvet.bench.vm.now_ns();
    strike(velvet);
    velvet.hear_until(told, (within_ms + TELLING_MS) as u64 + 1);
    (from_ns, ms(from_ns, velvet.bench.vm.now_ns()))
}

/// Returns the time at which the last output went off; asserts that all are off, and stay so.
#[track_caller]
fn outputs_off(velvet: &mut Velvet, from_ns: u64) -> Option<f64> {
    for name in HEATERS {
        assert!(!velvet.level(name), "{name} is on; it said: {}", velvet.said());
    }
    let heaters = HEATERS.map(pin);
    let is_end = |change: &&virtual_prime::board::PinChange| heaters.contains(&change.pin);
    changes(velvet).iter().filter(is_end).map(|change| ms(from_ns, change.at_ns)).last()
}

/// Returns the last step since then; asserts that the machine stands.
#[track_caller]
fn standstill(velvet: &mut Velvet, from_ns: u64) -> Option<f64> {
    let edges = velvet.world(|world| world.trace_mut().take());
    edges.last().filter(|edge| edge.time_ns >= from_ns).map(|edge| ms(from_ns, edge.time_ns))
}

/// Asserts that nothing heats, moves or has current any more, and that the console answers.
#[track_caller]
fn at_rest(velvet: &mut Velvet, from_ns: u64) -> (Option<f64>, Option<f64>) {
    velvet.hear(WATCHED_MS);
    let (outputs, motion) = (outputs_off(velvet, from_ns), standstill(velvet, from_ns));
    velvet.hear(WATCHED_MS);
    assert!(outputs_off(velvet, from_ns).is_none(), "an output came on again");
    assert!(standstill(velvet, from_ns).is_none(), "something still moves");
    for motor in [Actuator::Alpha, Actuator::Beta, Actuator::Gamma, Actuator::Delta] {
        assert!(!velvet.world(|world| world.driver(motor as usize).drives()), "{} has current", motor.name());
    }
    velvet.type_in("version");
    velvet.hear_until("Prime", SECOND);
    (outputs, motion)
}

/// Messages that follow from a fault, in lines of their own.
const BESIDES: [&str; 5] = [
    "hard limits are disabled until all have been cleared",
    "Homing cycle failed",
    "Entering Alarm/Halt state",
    "Overtemperature Prewarning",
    "WARNING: hotend: no MAX31865 answers",
];

/// Asserts that the words were said exactly once since power-on, and no other trouble but [`BESIDES`].
#[track_caller]
fn told_once(velvet: &Velvet, told: &str) {
    let told = told.trim_end();
    assert_eq!(velvet.said().matches(told).count(), 1, "{told:?} in: {}", velvet.said());
    let trouble = |line: &&str| {
        let lower = line.to_ascii_lowercase();
        ["error", "warning", "alarm"].iter().any(|word| lower.contains(word))
            && !line.contains(told)
            && !BESIDES.iter().any(|besides| line.contains(besides))
    };
    let others: Vec<_> = velvet.said().lines().filter(trouble).collect();
    assert!(others.is_empty(), "besides {told:?}: {others:?}");
}

/// Asserts that the console answers this line with these words within a second.
#[track_caller]
pub fn answers(velvet: &mut Velvet, line: &str, words: &str) {
    velvet.type_in(line);
    velvet.hear_until(words, SECOND);
}

/// Asserts that the machine halts: heaters and their supply off, motion braked, motors without current, told
/// once and nothing else, nothing to be done but M999.
#[track_caller]
pub fn halts(velvet: Velvet, blow: impl FnOnce(&mut Velvet), told: &str, within_ms: f64) -> Seen {
    halted(velvet, blow, told, within_ms).1
}

/// Like [`halts`], and returns the machine.
#[track_caller]
pub fn halted(mut velvet: Velvet, blow: impl FnOnce(&mut Velvet), told: &str, within_ms: f64) -> (Velvet, Seen) {
    let (from_ns, told_ms) = strike(&mut velvet, blow, told, within_ms);
    let (outputs_ms, motion_ms) = at_rest(&mut velvet, from_ns);
    told_once(&velvet, told);
    velvet.type_in("G1 X1 F600");
    velvet.hear_until("!!", SECOND);
    (velvet, Seen { outputs_ms, motion_ms, told_ms: Some(told_ms) })
}

/// Asserts that a command is refused with these words, and that nothing moves or heats.
#[track_caller]
pub fn refuses(mut velvet: Velvet, line: &str, told: &str, within_ms: f64) -> Seen {
    let (from_ns, told_ms) = strike(&mut velvet, |velvet| velvet.type_in(line), told, within_ms);
    velvet.hear(WATCHED_MS);
    assert_eq!(standstill(&mut velvet, from_ns), None, "it moved: {}", velvet.said());
    for name in ["PE0", "PE3"] {
        assert!(!velvet.level(name), "{name} is on");
    }
    assert!(!changes(&mut velvet).iter().any(|change| [pin("PE0"), pin("PE3")].contains(&change.pin)), "it heated");
    Seen { told_ms: Some(told_ms), ..Seen::default() }
}

/// Asserts that the machine tells the fault, once, and goes on.
#[track_caller]
pub fn tells(mut velvet: Velvet, blow: impl FnOnce(&mut Velvet), told: &str, within_ms: f64) -> Seen {
    let (_, told_ms) = strike(&mut velvet, blow, told, within_ms);
    velvet.hear(WATCHED_MS);
    told_once(&velvet, told);
    answers(&mut velvet, "M114", "X:");
    Seen { told_ms: Some(told_ms), ..Seen::default() }
}

/// Entry of the event ring about such a reset.
pub const BY_ITSELF: &str = "--- started: the firmware reset itself\n";

/// Asserts that the board resets with everything off, comes up cold and tells the reason. `mend` is called as
/// soon as outputs are off, or with these words where the fault is one of silence. The event ring has `kept`
/// its entries over the reset, in this order.
#[track_caller]
pub fn resets(
    mut velvet: Velvet,
    blow: impl FnOnce(&mut Velvet),
    mend: impl FnOnce(&mut Velvet),
    told: &str,
    kept: &[&str],
    within_ms: f64,
) -> Seen {
    watch(&mut velvet, &[&HEATERS[..], &[MOTORS_ENABLE]].concat());
    changes(&mut velvet);
    let greeted = velvet.said().len();
    let from_ns = velvet.bench.vm.now_ns();
    let mut released_ms = f64::INFINITY;
    let was_on = HEATERS.iter().any(|name| velvet.level(name));
    blow(&mut velvet);
    let mut outputs_ms = None;
    let mut mend = Some(mend);
    let patience = velvet.now_ms() + within_ms as u64 + 3 * SECOND;
    while !velvet.said()[greeted..].contains(told) {
        assert!(velvet.now_ms() < patience, "no {told:?}; it said: {}", &velvet.said()[greeted..]);
        velvet.hear(1);
        let (motors, heaters): (Vec<_>, Vec<_>) =
            changes(&mut velvet).into_iter().partition(|change| change.pin == pin(MOTORS_ENABLE));
        let released = motors.iter().filter(|change| change.high).map(|change| ms(from_ns, change.at_ns)).next();
        released_ms = released.map_or(released_ms, |at_ms| released_ms.min(at_ms));
        let last = heaters.iter().map(|change| ms(from_ns, change.at_ns)).last();
        let is_off = !HEATERS.iter().any(|name| velvet.level(name));
        if mend.is_some() {
            outputs_ms = last.or(outputs_ms);
        }
        // A modulated output is off for moments; the switch of the supply is not.
        let now_ms = ms(from_ns, velvet.bench.vm.now_ns());
        if is_off && now_ms > 1.0 {
            // A reset lets pins go without any announced change.
            outputs_ms = outputs_ms.or((was_on && mend.is_some()).then_some(now_ms));
            mend.take().into_iter().for_each(|mend| mend(&mut velvet));
        }
    }
    // The prompt may have begun already.
    while !velvet.said()[greeted..].contains(PROMPT) {
        assert!(velvet.now_ms() < patience + 2 * SECOND, "{}", &velvet.said()[greeted..]);
        velvet.hear(5);
    }
    assert_eq!(velvet.said()[greeted..].matches(told).count(), 1, "{}", &velvet.said()[greeted..]);
    // Motors without current do not follow: a reset lets the STEP pins go, and some fall.
    let edges = velvet.world(|world| world.trace_mut().take());
    let moved = edges.iter().filter(|edge| edge.time_ns >= from_ns).map(|edge| ms(from_ns, edge.time_ns));
    let motion_ms = moved.filter(|at_ms| *at_ms <= released_ms).last();
    velvet.hear(WATCHED_MS);
    assert!(standstill(&mut velvet, from_ns).is_none(), "it moves");
    velvet.type_in("M105");
    let answer = velvet.hear_until("T:", SECOND) + &velvet.hear(100);
    assert!(answer.contains("/0.0 @0"), "{answer}");
    kept_over_the_reset(&mut velvet, kept);
    Seen { outputs_ms, motion_ms, told_ms: None }
}

/// Asserts that events from before the reset, then `kept`, then the next start are told, in this order.
#[track_caller]
fn kept_over_the_reset(velvet: &mut Velvet, kept: &[&str]) {
    velvet.type_in("events all");
    let told = velvet.hear_until("ok\n", 2 * SECOND);
    let before = ["--- started: power came", "card mounted", "config.ini was read in "];
    let mut rest = told.as_str();
    for words in before.iter().chain(kept).chain(&["config.ini was read in "]) {
        let Some((_, behind)) = rest.split_once(words) else { panic!("no {words:?} in its place: {told}") };
        rest = behind;
    }
}

/// Asserts by [`halts`] that a fault of the machine halts it.
#[track_caller]
pub fn fault_halts(plan: Plan, state: State, fault: &Fault, told: &str, within_ms: f64) -> Seen {
    halts(enter(plan, state), |velvet| velvet.inject(fault), told, within_ms)
}

/// Asserts that the machine stays at rest, as it was, and tells the fault.
#[track_caller]
pub fn at_rest_told(mut velvet: Velvet, blow: impl FnOnce(&mut Velvet), told: &str, within_ms: f64) -> Seen {
    let (from_ns, told_ms) = strike(&mut velvet, blow, told, within_ms);
    let (outputs_ms, motion_ms) = at_rest(&mut velvet, from_ns);
    Seen { outputs_ms, motion_ms, told_ms: Some(told_ms) }
}

/// Asserts that the machine goes on for so long as if nothing had happened, and says nothing.
#[track_caller]
pub fn goes_on(mut velvet: Velvet, blow: impl FnOnce(&mut Velvet), for_ms: f64) -> Seen {
    let said = velvet.said().len();
    blow(&mut velvet);
    let from_ns = velvet.bench.vm.now_ns();
    velvet.hear(for_ms as u64);
    let rest = &velvet.said()[said..];
    for word in ["rror", "WARN", "ALARM"] {
        assert!(!rest.contains(word), "{rest}");
    }
    assert!(standstill(&mut velvet, from_ns).is_some(), "it does not move");
    answers(&mut velvet, "M114", "X:");
    Seen::default()
}
