//! Tests of an axis: `test endstop`, how well it homes; `test speed`, whether it loses steps; `test sweep`,
//! at which frequency the frame rings; `test backlash`, how much way it loses when it turns.

pub(crate) mod command;

use base::Ports;
use base::failure::{Failure, Outcome};
use base::hands::Hands;
use config::MachineConfig;
use motion::{Limits, Mode};
use procedures::homing;
use procedures::probing::ProbeHands;
use program::Interpreter;
use units::{Actuator, Axis, AxisSet, MmPerSecond, MmPerSecond2, PerAxis};

use crate::machine::hands::MachineHands;
use crate::machine::moments::Served as _;

/// Number of approaches where none is given.
pub(crate) const APPROACHES: u8 = 10;
/// Number of ways back and forth where none is given.
pub(crate) const TIMES: u32 = 10;
/// Acceleration of a sweep for each Hz, mm/s2: the speed at its peak is the same at any frequency (18.75
/// mm/s).
const SWEEP_ACCELERATION: f64 = 75.0;
/// Feed rate of a sweep, above any speed reached on such ways.
const SWEEP_RATE: MmPerSecond = MmPerSecond(100.0);
/// Full steps lost at least: a motor loses four, or several times as many, the turn of its field.
const FULL_STEPS_LOST: f64 = 4.0;

/// Moves back and forth at the speed asked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Speed {
    pub axis: Axis,
    /// Length of one way, mm.
    pub way: f64,
    pub rate: MmPerSecond,
    pub times: u32,
}

/// The machine in the hands of a test.
pub(crate) trait TestHands<'c>: ProbeHands<'c> {
    /// Returns the program, whose modes figures are drawn in.
    fn program(&mut self) -> &mut Interpreter;

    /// Runs a line of codes in the dialect of the recipient that asked.
    ///
    /// # Errors
    /// Those of its codes.
    fn run_line(&mut self, line: &str) -> Outcome;

    /// Has the program go on from where the machine is.
    fn resynchronise(&mut self) {
        let position = self.position();
        self.program().resynchronise(position);
    }

    /// Has the program go on from where the machine is, if the machine stands.
    fn resynchronise_if_still(&mut self) {
        if self.motion(|motion| motion.is_idle()) {
            self.resynchronise();
        }
    }

    /// Whether a straight move stays within the travel.
    ///
    /// # Errors
    /// When it does not.
    fn stays_within(&mut self, from: &PerAxis<f64>, to: &PerAxis<f64>) -> Result<(), Failure> {
        let homed = self.axes().homed();
        let checked = self.travel().check(from, to, homed);
        checked.map_err(|out| out.failure(self.texts(), self.config()))
    }
}

impl<'c, P: Ports> TestHands<'c> for MachineHands<'_, 'c, P> {
    fn program(&mut self) -> &mut Interpreter {
        &mut self.machine.program
    }

    fn run_line(&mut self, line: &str) -> Outcome {
        let dialect = self.machine.world.sessions.dialect_of(self.to);
        P::run_text(self.machine, line, dialect, self.to)
    }
}

fn is_alone(config: &MachineConfig, axis: Axis) -> Result<(), Failure> {
    if procedures::arms::homes_by_motor(config) && AxisSet::PRIMARY.has(axis) {
        return Err(Failure::refused(&"towers and arms home together: no axis can be looked at alone"));
    }
    Ok(())
}

/// Homes the axis in so many approaches, and says how well they agree.
pub(crate) fn endstop<'c>(hands: &mut impl TestHands<'c>, axis: Axis, count: u8) -> Result<(), Failure> {
    is_alone(hands.config(), axis)?;
    let homed = homing::measure(hands, axis, count);
    hands.resynchronise_if_still();
    homed.map(drop)
}

/// Homes the axis, moves it back and forth, and homes it again: the difference of its place is the loss.
pub(crate) fn speed<'c>(hands: &mut impl TestHands<'c>, test: &Speed) -> Result<(), Failure> {
    endstop(hands, test.axis, 2)?;
    let from = hands.position();
    let mut target = from;
    target[test.axis] += test.way;
    hands.stays_within(&from, &target)?;
    for _ in 0..test.times {
        hands.go(target, test.rate, Mode::Rapid)?;
        hands.go(from, test.rate, Mode::Rapid)?;
        if hands.stop_requested() {
            hands.standstill()?;
            return Ok(());
        }
    }
    hands.standstill()?;
    let off = homing::measure(hands, test.axis, 2);
    hands.resynchronise_if_still();
    let off = off?;
    let letter = test.axis.letter();
    let motor = Actuator::from_index(test.axis as usize).map(|motor| &hands.config().actuators[motor]);
    let turn = motor.map_or(0.0, |motor| FULL_STEPS_LOST * f64::from(motor.microsteps.max(1)) / motor.steps_per_mm);
    if libm::fabs(off) < turn / 2.0 {
        hands.say(format_args!("{letter} is where it was, within {:.3} mm: no step was lost\n", libm::fabs(off)));
        return Ok(());
    }
    let steps = libm::round(off / turn) * FULL_STEPS_LOST;
    Err(hands.texts().refused(format_args!(
        "{letter} is {off:.3} mm off: {} full steps were lost: less speed or acceleration, or more current",
        libm::fabs(steps)
    )))
}

/// Shaking of an axis, from one frequency to another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Sweep {
    pub axis: Axis,
    /// Frequency at the start, Hz.
    pub from: f64,
    pub to: f64,
    /// Seconds for each Hz of the sweep.
    pub pace: f64,
}

/// Shakes an axis and says at which frequency: input shaping belongs where the frame rings loudest, or a pen
/// on the bed draws widest. Filters are off meanwhile, or there would be nothing to hear.
pub(crate) fn sweep<'c>(hands: &mut impl TestHands<'c>, test: &Sweep) -> Result<(), Failure> {
    let here = hands.position();
    // The lowest frequency has the widest way.
    let widest = way_at(test.from.min(test.to));
    let mut reach = here;
    reach[test.axis] += widest;
    hands.stays_within(&here, &reach)?;
    let limits = hands.motion_config()?.limits;
    let needed = SWEEP_ACCELERATION * test.from.max(test.to);
    let motor = Actuator::from_index(test.axis as usize).and_then(|motor| limits.actuator_acceleration[motor]);
    if let Some(most) = motor.filter(|most| most.0 < needed) {
        let letter = test.axis.letter();
        return Err(hands.texts().refused(format_args!(
            "test sweep: this needs {needed} mm/s2, and motor {letter} may take {}: M204 {letter} changes it",
            most.0
        )));
    }
    hands.standstill()?;
    hands.motion(|motion| motion.bypass_filters(true));
    let shaken = shake(hands, test, &here, &limits);
    hands.motion(|motion| motion.bypass_filters(false));
    // The old limits come back, whatever happened.
    let restored = hands.motion(|motion| motion.set_limits(limits));
    debug_assert!(restored.is_ok(), "they were in force before");
    hands.resynchronise_if_still();
    shaken
}

/// Returns the way at this frequency, mm: half a period accelerates, and half of it brakes.
fn way_at(hertz: f64) -> f64 {
    let quarter = 0.25 / hertz;
    SWEEP_ACCELERATION * hertz * quarter * quarter
}

fn shake<'c>(hands: &mut impl Hands<'c>, test: &Sweep, here: &PerAxis<f64>, limits: &Limits) -> Result<(), Failure> {
    let (mut hertz, direction) = (test.from, if test.to < test.from { -1.0 } else { 1.0 });
    let mut said = f64::NEG_INFINITY;
    while (test.to - hertz) * direction >= 0.0 {
        if libm::fabs(hertz - said) >= 5.0 {
            said = hertz;
            hands.say(format_args!("{hertz:.0} Hz\n"));
        }
        let own = Limits { acceleration: MmPerSecond2(SWEEP_ACCELERATION * hertz), ..*limits };
        hands.motion(|motion| motion.set_limits(own)).map_err(|error| hands.texts().refusal(error))?;
        let mut far = *here;
        far[test.axis] += way_at(hertz);
        // Each Hz takes `pace` seconds, so a higher frequency takes more periods.
        let periods = libm::ceil(hertz * test.pace).max(1.0) as u32;
        for _ in 0..periods {
            if hands.stop_requested() {
                return hands.standstill();
            }
            hands.go(far, SWEEP_RATE, Mode::Feed)?;
            hands.go(*here, SWEEP_RATE, Mode::Feed)?;
        }
        hertz += direction;
    }
    hands.standstill()
}
