//! The moments at which features act.
//!
//! A feature is a folder in `features` with its state, the work of its codes, and what it does at moments of
//! the machine: [`Moments`], whose methods do nothing unless a feature has something to do. The core calls
//! the whole list at each moment ([`Features`]) and names no feature. Everything is bound when the firmware
//! is built; a moment that no feature uses costs nothing.

use base::Ports;
use base::failure::{Failure, Outcome};
use base::ports::Running;
use base::sessions::{LineBytes, Listing, Recipient, Reply, SessionId};
use config::MachineConfig;
use gcode::{Code, Line, realtime::Realtime};
use jobs::player::StalledJob;
use program::{BEGINNING_BYTES, Dialect, LightChange, Move, State, Words};
use units::Micros;

use super::Machine;
use super::source::Source;

/// A machine's features, as its core sees them: the list of all, their state, their steps.
pub(crate) trait Featured: Ports + Sized {
    /// All features, as one.
    type List: Moments<Self>;
    /// State of all features.
    type States;
    /// Step of a feature's sequence that waits for the end of a script, or of lines read over.
    type Step: core::fmt::Debug;

    /// Makes the state of all features.
    fn states(config: &MachineConfig) -> Self::States;
    /// Carries out the next step of a feature's sequence.
    ///
    /// # Errors
    /// When the step cannot be done, or the machine halts.
    fn go_on(machine: &mut Machine<'_, Self>, step: Self::Step) -> Result<(), Failure>;
    /// Ends a feature's sequence that cannot go on with this step.
    fn give_up(machine: &mut Machine<'_, Self>, step: Self::Step, why: Failure);
}

/// The executor, as waits and features see it.
pub(crate) trait Served: Ports + Sized {
    /// Serves everybody once: sessions, faults, everything that follows time.
    fn serve(machine: &mut Machine<'_, Self>);
    /// Runs a code that the machine itself has written.
    ///
    /// # Errors
    /// Those of the code.
    fn run_text(machine: &mut Machine<'_, Self>, text: &str, dialect: Dialect, to: Recipient) -> Outcome;
}

/// The list of all features.
pub(crate) type Features<P> = <P as Featured>::List;

/// Place in its file from which a job begins.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum JobBegins {
    /// From its first line.
    Whole,
    /// With lines that are read over, before it is known whether it can go on behind them.
    FurtherOn,
    /// Behind those lines, where the machine goes next.
    Elsewhere,
    /// Once more, as its file is read for the way back to it.
    Again,
}

/// Text of a startup line: as long as a line of GRBL's may be.
pub(crate) type StartupLine = heapless::String<80>;

/// Whether a job begins.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum JobStart {
    /// The job begins now.
    Now,
    /// Not yet: ask again.
    Later,
    /// Not at all; it has been closed.
    Never,
}

/// What a feature does at the moments of the machine.
pub(crate) trait Moments<P: Ports> {
    // --- boot ---

    /// Says at the start how things stand, before the configuration is read.
    fn greet(_running: &Running, _reply: &mut Reply<'_>) {}
    /// Returns the greeting of senders in the dialect of this configuration.
    fn banner(_config: &MachineConfig) -> Option<&'static str> {
        None
    }
    /// Sets up what the configuration has wired, while outputs are still off.
    fn wired(_machine: &mut Machine<'_, P>) {}
    /// Reads the feature's files, before saved settings are replayed.
    fn read_files(_machine: &mut Machine<'_, P>) {}
    /// Acts as the machine begins to listen; `is_usable`: its configuration can be used.
    fn started(_machine: &mut Machine<'_, P>, _is_usable: bool) {}

    // --- time ---

    /// Looks at what must be seen within 250 us.
    fn each_250_us(_machine: &mut Machine<'_, P>, _now: Micros) {}
    /// Looks at what must be seen within 10 ms.
    fn each_10_ms(_machine: &mut Machine<'_, P>, _now: Micros) {}
    /// Looks at what must be seen at every turn of a wait. Every line passes here.
    fn each_turn(_machine: &mut Machine<'_, P>) {}
    /// Does work that waits until nothing else is to be done. True: there was some.
    fn idle(_machine: &mut Machine<'_, P>) -> bool {
        false
    }

    // --- sessions and lines ---

    /// Carries out a byte that acts at once. True: the feature has taken it.
    fn take_request(_machine: &mut Machine<'_, P>, _request: Realtime, _id: SessionId) -> bool {
        false
    }
    /// Whether a console's line is the feature's own.
    fn owns_console_line(_machine: &Machine<'_, P>, _line: &str, _to: Recipient) -> bool {
        false
    }
    /// Runs a console's line of the feature's own.
    fn run_console_line(_machine: &mut Machine<'_, P>, _line: &str, _to: Recipient) -> Option<Outcome> {
        None
    }
    /// Refuses the codes of a session for now. True: that was said.
    fn refuse_codes(_machine: &mut Machine<'_, P>, _to: Recipient) -> bool {
        false
    }
    /// Acts before a line of a session is carried out.
    fn session_line_begins(_machine: &mut Machine<'_, P>) {}
    /// Acts after a line of a session was carried out.
    fn session_line_ends(_machine: &mut Machine<'_, P>) {}
    /// Returns the line that the feature would like to have run, as an input's, without taking it.
    fn line(_machine: &Machine<'_, P>) -> Option<&'static str> {
        None
    }
    /// Takes that line.
    fn take_line(_machine: &mut Machine<'_, P>) -> Option<&'static str> {
        None
    }
    /// Whether lines that move wait, as for room in the look-ahead queue.
    fn hold_moves_back(_machine: &Machine<'_, P>) -> bool {
        false
    }
    /// Acts before a block is interpreted. Every line passes here.
    fn block_begins(_machine: &mut Machine<'_, P>, _source: Source) {}
    /// Whether a move is not made, after the feature's own moves before it.
    ///
    /// # Errors
    /// Where the move is refused, or the machine halts.
    fn leave_move_out(_machine: &mut Machine<'_, P>, _request: &Move) -> Result<bool, Failure> {
        Ok(false)
    }
    /// Refuses a move.
    ///
    /// # Errors
    /// With the reason.
    fn may_move(_machine: &mut Machine<'_, P>, _request: &Move) -> Result<(), Failure> {
        Ok(())
    }
    /// Whether a code that does nothing here is answered with `ok` all the same.
    fn accepts(_code: Code) -> bool {
        false
    }
    /// Says how a startup line has ended.
    fn startup_line_ended(_machine: &mut Machine<'_, P>, _number: u8, _outcome: &Outcome) {}
    /// Returns a startup line.
    fn startup_line(_machine: &Machine<'_, P>, _number: u8) -> Option<StartupLine> {
        None
    }

    /// Takes a line of a session, whatever it says.
    fn take_session_line(_machine: &mut Machine<'_, P>, _id: SessionId, _line: &LineBytes) -> bool {
        false
    }
    /// Answers a line of a file that a session sends, as if it were none of it.
    fn answer_in_upload(_machine: &mut Machine<'_, P>, _line: Line<'_>, _to: Recipient) -> bool {
        false
    }
    /// Gives the next piece of a long answer of the feature's own. True: there is more.
    fn long_answer(
        _machine: &mut Machine<'_, P>,
        _listing: &mut Listing,
        _to: Recipient,
    ) -> Option<Result<bool, Failure>> {
        None
    }

    // --- jobs ---

    /// Whether the job starts now, later, or never.
    fn job_may_start(_machine: &mut Machine<'_, P>) -> JobStart {
        JobStart::Now
    }
    /// Whether the job may begin its first line now.
    fn job_may_begin(_machine: &mut Machine<'_, P>) -> bool {
        true
    }
    /// Acts as a job begins.
    fn job_begins(_machine: &mut Machine<'_, P>, _from: JobBegins) {}
    /// Acts as a job goes on after a power cut, that began with this state.
    fn job_goes_on(_machine: &mut Machine<'_, P>, _beginning: [u8; BEGINNING_BYTES]) {}
    /// Acts when the file of the job cannot be read.
    fn job_is_unreadable(_machine: &mut Machine<'_, P>) {}
    /// Acts when the last line of the job has been carried out.
    fn job_is_read(_machine: &mut Machine<'_, P>) {}
    /// Acts when the job ends, while it is still known; `to` hears of it.
    fn job_ends(_machine: &mut Machine<'_, P>, _is_done: bool, _to: Recipient) {}
    /// Whether the feature stops the job at this line, and says so itself.
    fn explains_stop(_machine: &Machine<'_, P>) -> bool {
        false
    }
    /// Suspends the job for a change of filament (M600).
    fn suspend(
        _machine: &mut Machine<'_, P>,
        _heaters_stay: bool,
        _words: &Words<'_>,
        _to: Recipient,
    ) -> Option<Outcome> {
        None
    }
    /// Refuses to go on with the suspended job.
    ///
    /// # Errors
    /// With the reason.
    fn may_resume(_machine: &mut Machine<'_, P>) -> Result<(), Failure> {
        Ok(())
    }
    /// Acts before the suspended job goes back to its place; heaters are hot.
    ///
    /// # Errors
    /// When the job must stay suspended, or the machine halts.
    fn before_going_back(_machine: &mut Machine<'_, P>) -> Result<(), Failure> {
        Ok(())
    }
    /// Acts as the suspended job goes back to its place.
    fn goes_back(_machine: &mut Machine<'_, P>) {}
    /// Acts at the place where a stall has stopped the job.
    ///
    /// # Errors
    /// When the machine halts.
    fn arrives(_machine: &mut Machine<'_, P>, _stall: &StalledJob) -> Result<(), Failure> {
        Ok(())
    }

    // --- motion ---

    /// Acts before the machine leaves for heights that the file does not say, from least to most, mm.
    fn leaves_for_heights(_machine: &mut Machine<'_, P>, _heights: [f64; 2]) {}
    /// Whether Z's shift for the frame's temperature stays as it is: the job on its way back has its own.
    fn keeps_thermal_z(_machine: &Machine<'_, P>) -> bool {
        false
    }
    /// Acts when extruders count from another place, with no filament moved.
    fn extruders_count_anew(_machine: &mut Machine<'_, P>) {}
    /// Acts when objects are left out, or taken in again, by a person.
    fn objects_change(_machine: &mut Machine<'_, P>) {}
    /// Whether a held machine may go on. False: the reason was said.
    fn may_go_on(_machine: &mut Machine<'_, P>) -> bool {
        true
    }
    /// Acts as the machine goes on from a hold, or from an open door.
    fn goes_on(_machine: &mut Machine<'_, P>, _from: State) {}

    // --- ends ---

    /// Changes the colours of lights where the path has come to.
    ///
    /// # Errors
    /// When the machine halts meanwhile.
    fn change_light(_machine: &mut Machine<'_, P>, _change: &LightChange) -> Result<(), Failure> {
        Ok(())
    }
    /// Arms a rule that switches an output by temperature, or disarms it.
    fn arm(_machine: &mut Machine<'_, P>, _rule: u8, _armed: bool) {}
    /// Notes the change of lights in a file that is read over.
    fn pass_light(_machine: &mut Machine<'_, P>, _change: &LightChange) {}
    /// Drops changes that wait for their place on the path.
    fn drop_effects(_machine: &mut Machine<'_, P>) {}
    /// Acts when all outputs have been stopped.
    fn stops(_machine: &mut Machine<'_, P>) {}
    /// Acts when the machine halts, outputs off already and the reason said.
    fn halts(_machine: &mut Machine<'_, P>) {}
    /// Acts when a halt or a reset drops the job, while it is still known.
    fn job_is_dropped(_machine: &mut Machine<'_, P>) {}
    /// Acts when a halted machine has come to rest.
    fn rests(_machine: &mut Machine<'_, P>) {}
    /// Acts when the work in progress has been ended by `abort` or M410, and motion rests.
    fn work_was_ended(_machine: &mut Machine<'_, P>) {}
}
