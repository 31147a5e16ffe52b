//! Compares every step edge with the oracle: the ideal trajectory in `f64`, which shares no arithmetic with the step solver.

use machine::motion_config::motion_config;
use motion::oracle::{Ideal, StepError};
use motion::queue::StepEvent;
use motion::trajectory::Piece;
use motion::{Access, Motion, MotionConfig};
use units::{Actuator, PerActuator, StepCount};

/// Pieces that ended this long before the present edge are forgotten.
const MEMORY_NS: f64 = 1e7;
/// Steps between two times of forgetting.
const FORGET_EVERY: u64 = 4_096;

/// Watches one run.
pub struct Verifier {
    config: MotionConfig,
    ideal: Ideal,
    last: Option<Piece>,
    /// Where each motor stands, and which way it turns.
    counts: PerActuator<StepCount>,
    signs: PerActuator<StepCount>,
    /// Nothing has been played since the motors rested.
    resting: bool,
    error: StepError,
    /// Edges without an ideal crossing within a millisecond.
    strays: u64,
}

impl Verifier {
    /// For the machine of this configuration; `None` when it cannot move.
    pub fn new(machine: &config::MachineConfig) -> Option<Self> {
        let config = motion_config(machine).ok()?;
        Some(Self {
            config,
            ideal: Ideal::new(config),
            last: None,
            counts: PerActuator::default(),
            signs: PerActuator([1; units::MAX_ACTUATORS]),
            resting: true,
            error: StepError::default(),
            strays: 0,
        })
    }

    /// Before and after each run of the feed: it may find the motors at rest, and from then on until the next step where
    /// they stand may be declared anew.
    pub fn look(&mut self, motion: &Motion) {
        self.resting |= motion.is_idle();
        if self.resting {
            self.counts = motion.steps();
        }
    }

    /// An event is played at this time.
    pub fn played(&mut self, event: StepEvent, at_ns: u64) {
        let at = at_ns as f64;
        self.resting = false;
        for actuator in Actuator::ALL {
            let bit = actuator.bit();
            if event.turning_forward() & bit != 0 {
                self.signs[actuator] = 1;
            } else if event.turning_backward() & bit != 0 {
                self.signs[actuator] = -1;
            }
            // A slave copies its master's edges: they are the same event.
            let is_master = self.config.actuators[actuator].is_some_and(|motor| motor.slaved_to.is_none());
            if event.stepping() & bit == 0 || !is_master {
                continue;
            }
            self.counts[actuator] += self.signs[actuator];
            match self.ideal.edge_error(actuator, at, self.counts[actuator], self.signs[actuator]) {
                Some(error) => self.error.add(error),
                None => self.strays += 1,
            }
            if self.error.edges.is_multiple_of(FORGET_EVERY) {
                self.ideal.forget_before(at - MEMORY_NS);
            }
        }
    }

    /// Largest and root mean square distance in nanoseconds, and how many edges had no ideal crossing at all.
    pub fn result(&self) -> (f64, f64, u64) {
        (self.error.max, self.error.rms(), self.strays)
    }
}

/// The motion object, watched for new pieces of trajectory.
pub struct Watched<'a> {
    pub motion: &'a mut Motion,
    pub verifier: Option<&'a mut Verifier>,
}

impl Access for Watched<'_> {
    fn with<R>(&mut self, f: impl FnOnce(&mut Motion) -> R) -> R {
        let result = f(self.motion);
        if let (Some(verifier), Some(piece)) = (self.verifier.as_deref_mut(), self.motion.last_piece())
            && verifier.last.as_ref() != Some(piece)
        {
            verifier.ideal.set_filters(self.motion.filters_in_force());
            verifier.ideal.push(piece);
            verifier.last = Some(*piece);
        }
        result
    }
}
