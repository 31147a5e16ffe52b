//! The machine as GRBL's dialect sees it.

use base::failure::{Failure, Outcome};
use base::ports::MotionPort;
use base::safety::{Mode, Safety};
use base::sessions::{Recipient, Sessions};
use base::tuning::Tuning;
use base::{Ports, World};
use jobs::player::Jobs;
use parts::outputs::Outputs;
use program::{Dialect, Interpreter, State};
use units::AxisSet;

use crate::features::grbl::startup;
use crate::features::grbl::state::Grbl;
use crate::features::state::States;
use crate::machine::Machine;
use crate::machine::feed_hold::FeedHoldHands;
use crate::machine::halt::ReleaseHands;
use crate::machine::moments::Served as _;
use crate::machine::program_io::OverrideHands;
use crate::machine::settings_file::SettingsHands;
use crate::machine::work_hands::{JobHands, MoveHands as _};

/// The machine as GRBL's dialect reports it and sets it up.
pub(crate) struct Spoken<'m, 'c, P> {
    pub world: &'m mut World<'c, P>,
    pub program: &'m mut Interpreter,
    pub safety: &'m mut Safety,
    pub tuning: &'m Tuning,
    pub outputs: &'m mut Outputs,
    pub jobs: &'m Jobs,
    pub grbl: &'m mut Grbl,
    /// Axes that are homed, and those that can be.
    pub homed: [AxisSet; 2],
    /// Operator's factor of feed rates, while the program does not let it count.
    pub feed_waits: &'m mut Option<f64>,
}

/// The machine for GRBL's commands.
pub(crate) trait GrblHands<'c>:
    FeedHoldHands<'c> + OverrideHands<'c> + ReleaseHands<'c> + SettingsHands<'c> + JobHands<'c>
{
    /// Returns the machine as the dialect reports it.
    fn spoken(&mut self) -> Spoken<'_, 'c, Self::Ports>;

    /// Returns the state that only the dialect has.
    fn grbl(&self) -> &Grbl;

    /// Returns the sessions, one of which may speak the dialect.
    fn sessions(&self) -> &Sessions;

    /// Tells the jobs which of their moves the motors make.
    fn follow_job(&mut self);

    /// Releases a halted machine, unless its configuration cannot be used or the machine sleeps.
    fn unlock(&mut self, to: Recipient);

    /// Switches check mode.
    ///
    /// # Errors
    /// When the machine is at work.
    fn check_mode(&mut self, to: Recipient) -> Outcome;

    /// Switches everything off until a reset.
    ///
    /// # Errors
    /// When the machine is at work.
    fn sleep(&mut self) -> Result<(), Failure>;

    /// Runs a code that sets a setting.
    ///
    /// # Errors
    /// Those of the code.
    fn run_text(&mut self, text: &str) -> Outcome;

    /// Stops what a reset stops. Motors and place are kept where they can be.
    fn stop(&mut self);

    /// Has the startup lines run next, where the machine is ready.
    fn begin_startup(&mut self);
}

impl<'c, P: Ports> GrblHands<'c> for Machine<'c, P> {
    fn spoken(&mut self) -> Spoken<'_, 'c, P> {
        let homed = [self.axes.homed(), self.can_home()];
        let Self { world, program, safety, tuning, outputs, jobs, features: States { grbl, .. }, feed_waits, .. } =
            self;
        Spoken { world, program, safety, tuning, outputs, jobs, grbl, homed, feed_waits }
    }

    fn grbl(&self) -> &Grbl {
        &self.features.grbl
    }

    fn sessions(&self) -> &Sessions {
        self.world.sessions
    }

    fn follow_job(&mut self) {
        self.follow_job();
    }

    fn unlock(&mut self, to: Recipient) {
        self.unlock(to);
    }

    fn check_mode(&mut self, to: Recipient) -> Outcome {
        self.check_mode(to)
    }

    fn sleep(&mut self) -> Result<(), Failure> {
        self.sleep()
    }

    fn run_text(&mut self, text: &str) -> Outcome {
        P::run_text(self, text, Dialect::Grbl, Recipient::Nobody)
    }

    fn stop(&mut self) {
        let stands = matches!(self.safety.state(), State::Idle | State::Alarm | State::Invalid);
        if stands && self.frames.is_empty() && !self.jobs.is_playing() && !self.world.sessions.are_busy() {
            self.stop_outputs();
        } else if rests_in_hold(self.safety.mode(), &mut self.world.ports) {
            self.drop_held();
        } else {
            self.abort();
        }
    }

    fn begin_startup(&mut self) {
        startup::begin(&self.features.grbl.own, self.safety.state(), &mut self.frames);
    }
}

/// Whether a held program stands at a known place. (A search for a switch or the bed does not.)
fn rests_in_hold(mode: Mode, ports: &mut impl MotionPort) -> bool {
    mode.state() == State::Hold
        && matches!(mode.interrupted(), State::Run | State::Jog)
        && ports.motion(|motion| motion.state() == motion::State::Held || motion.is_idle())
}
