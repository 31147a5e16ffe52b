//! The machine as far as one kind of work sees it: small traits, so that a function's signature says what it
//! may touch. Features add traits for their own state.
//!
//! [`base::hands::Hands`] is for the sequences of other crates, which know the recipient that asked. These
//! here are for work that knows jobs, program and frames, and the machine itself has them.

use core::fmt::Arguments;

use base::axes::Axes;
use base::failure::{Failure, Outcome};
use base::ports::{MotionPort as _, Wake};
use base::reason::Alarm;
use base::safety::Event;
use base::safety::travel::Travel;
use base::sessions::Recipient;
use base::tuning::Tuning;
use base::wait::Waited;
use base::{Ports, World};
use events::Event as Happened;
use jobs::player::Jobs;
use procedures::probing::ProbeHands;
use program::{Facts, Interpreter, State};
use units::{AxisSet, Micros, PerAxis};

use crate::machine::frames::Frames;
use crate::machine::moments::Featured;

/// The world around the machine, for work that is done at once.
pub(crate) trait WorldHands<'c> {
    /// Type of the world that the machine is in.
    type Ports: Ports;

    /// Returns the world.
    fn world(&mut self) -> &mut World<'c, Self::Ports>;

    /// Says something to one recipient.
    fn say(&mut self, to: Recipient, text: Arguments<'_>) {
        self.world().say(to, text);
    }

    /// Says something to every session.
    fn announce(&mut self, text: Arguments<'_>) {
        self.world().announce(text);
    }

    /// Keeps an event, in the ring that survives a reset.
    fn record(&mut self, event: &Happened) {
        self.world().record(event);
    }
}

/// The machine for work that waits, and changes nothing of it.
pub(crate) trait WaitHands<'c>: WorldHands<'c> {
    /// Makes one turn of a wait: serves everybody, and rests.
    fn wait(&mut self, wake: Wake) -> Waited;
}

/// The machine for work that halts it.
pub(crate) trait HaltHands<'c>: WorldHands<'c> {
    /// Returns the state of the machine.
    fn state(&self) -> State;

    /// Whether the machine is halted.
    fn is_halted(&self) -> bool;

    /// Applies an event to the table of states; true when it meant something.
    fn apply(&mut self, event: Event) -> bool;

    /// Halts the machine and says why.
    fn halt(&mut self, alarm: Alarm, why: Arguments<'_>);
}

/// The machine for work that waits, and knows the program.
pub(crate) trait ProgramHands<'c>: WaitHands<'c> {
    /// Returns the interpreter of codes and modes.
    fn program(&mut self) -> &mut Interpreter;

    /// Returns the interpreter, and the world that its values are kept in.
    fn program_in_world(&mut self) -> (&mut Interpreter, &mut World<'c, Self::Ports>);
}

/// The machine for work that moves it, or has the program follow a move.
pub(crate) trait MoveHands<'c>: ProgramHands<'c> + HaltHands<'c> {
    /// Returns hands for a sequence that this recipient has asked for.
    fn sequence(&mut self, to: Recipient) -> impl ProbeHands<'c, Ports = Self::Ports>;

    /// Returns the axes and motors.
    fn axes(&mut self) -> &mut Axes;

    /// Returns the axes that have a switch to home with.
    fn can_home(&self) -> AxisSet;

    /// Returns the settings that codes have changed.
    fn tuning(&mut self) -> &mut Tuning;

    /// Waits until everything queued has been executed.
    ///
    /// # Errors
    /// [`Failure::HALTED`].
    fn standstill(&mut self) -> Result<(), Failure>;

    /// Waits for a length of time, whatever moves.
    ///
    /// # Errors
    /// [`Failure::HALTED`].
    fn wait_for(&mut self, time: Micros) -> Result<(), Failure>;

    /// Returns the travel that axes may be commanded within.
    fn travel(&mut self) -> &Travel;

    /// Whether a straight move stays within the travel.
    ///
    /// # Errors
    /// Where it does not, with the axis.
    fn stays_within(&mut self, from: &PerAxis<f64>, to: &PerAxis<f64>) -> Result<(), Failure>;

    /// Has the program go on from where the machine is.
    fn resynchronise(&mut self);

    /// Has the program go on from where the machine is, unless it moves.
    fn resynchronise_if_still(&mut self);

    /// Returns the facts about the machine that the program must know.
    fn facts(&self) -> Facts;

    /// Returns the machine position where the last accepted move ends.
    fn position(&mut self) -> PerAxis<f64> {
        self.world().ports.motion(|motion| motion.commanded_position())
    }
}

/// The machine for work on a job: what it waits for, where it goes on, which lines come next.
pub(crate) trait JobHands<'c>: MoveHands<'c> {
    /// Returns the jobs.
    fn jobs(&mut self) -> &mut Jobs;

    /// Returns the jobs, and the world that they read files in.
    fn jobs_in_world(&mut self) -> (&mut Jobs, &mut World<'c, Self::Ports>);

    /// Returns the jobs, and the interpreter that reads their lines.
    fn jobs_and_program(&mut self) -> (&mut Jobs, &mut Interpreter);

    /// Returns the work that lines have started.
    fn frames(&mut self) -> &mut Frames<'c, <Self::Ports as Featured>::Step>;

    /// Has features act before the machine leaves for heights that the file does not say, mm.
    fn leaves_for_heights(&mut self, heights: [f64; 2]);

    /// Has a feature home these axes in its own way. None: none has one for them.
    fn homes(&mut self, named: AxisSet, to: Recipient) -> Option<Outcome>;

    /// Has features know that extruders count from another place, with no filament moved.
    fn extruders_count_anew(&mut self);
}
