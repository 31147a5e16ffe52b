//! The moments at which features act, and the traits through which this room calls those above it.
//!
//! A feature is a folder in `features` with its state, the work of its codes, and what it does at moments of
//! the machine: [`Moments`], whose methods do nothing unless a feature has something to do. The core calls
//! the whole list at each moment ([`Features`]) and names no feature. Everything is bound when the firmware
//! is built; a moment that no feature uses costs nothing. What a feature touches of the machine is the bound
//! of its `impl`: see [`super::work_hands`].

use base::Ports;
use base::failure::{Failure, Outcome};
use base::ports::Running;
use base::sessions::{LineBytes, Listing, Recipient, Reply, SessionId};
use config::{Command, MachineConfig};
use gcode::{Block, Code, Line, realtime::Realtime};
use jobs::player::StalledJob;
use printer_cfg::Memory;
use program::{BEGINNING_BYTES, Dialect, LightChange, Move, State, Words};
use units::{AxisSet, Micros};

use super::Machine;
use super::source::Source;

/// A machine's features, as its core sees them: the list of all, their state, their steps.
pub(crate) trait Featured: Ports + Sized {
    /// All features, as one.
    type List: for<'c> Moments<Machine<'c, Self>>;
    /// State of all features; some of it lies in memory that is lent for as long as the machine runs.
    type States<'c>;
    /// Step of a feature's sequence that waits for the end of a script, or of lines read over.
    type Step: core::fmt::Debug;

    /// Makes the state of all features.
    fn states<'c>(config: &MachineConfig, macros: Memory<'c>) -> Self::States<'c>;
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
    /// Runs a line that the machine itself has written, and answers it as its source wants it.
    fn run_line(machine: &mut Machine<'_, Self>, line: &[u8], source: Source);
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

/// Declares the moments: what a feature does at each of them unless it says so (nothing), and how a list of
/// features acts, one after the other.
///
/// `all`: each acts. `any`: until one says yes. `every`: until one says no. `first`: until one has an answer.
/// `all_or_fail` and `any_or_fail`: the same, up to the first failure. `start`: until one says other than
/// now.
macro_rules! moments {
    (@nothing all) => { () };
    (@nothing any) => { false };
    (@nothing every) => { true };
    (@nothing first) => { None };
    (@nothing all_or_fail) => { Ok(()) };
    (@nothing any_or_fail) => { Ok(false) };
    (@nothing start) => { JobStart::Now };

    (@both all $one:expr, $other:expr) => {{ $one; $other }};
    (@both any $one:expr, $other:expr) => { $one || $other };
    (@both every $one:expr, $other:expr) => { $one && $other };
    (@both first $one:expr, $other:expr) => { if let Some(answer) = $one { Some(answer) } else { $other } };
    (@both all_or_fail $one:expr, $other:expr) => {{ $one?; $other }};
    (@both any_or_fail $one:expr, $other:expr) => { if $one? { Ok(true) } else { $other } };
    (@both start $one:expr, $other:expr) => { match $one { JobStart::Now => $other, start => start } };

    ($($(#[$doc:meta])* $kind:ident $name:ident($($arg:ident: $type:ty),* $(,)?) $(-> $answer:ty)?;)+) => {
        /// What a feature does at the moments of the machine.
        pub(crate) trait Moments<M> {
            $(
                $(#[$doc])*
                #[expect(unused_variables, reason = "a feature that does nothing looks at nothing")]
                fn $name($($arg: $type),*) $(-> $answer)? {
                    moments!(@nothing $kind)
                }
            )+
        }

        impl<M, A: Moments<M>, B: Moments<M>> Moments<M> for (A, B) {
            $(
                fn $name($($arg: $type),*) $(-> $answer)? {
                    moments!(@both $kind A::$name($($arg),*), B::$name($($arg),*))
                }
            )+
        }
    };
}

moments! {
    // --- boot ---

    /// Says at the start how things stand, before the configuration is read.
    all greet(running: &Running, reply: &mut Reply<'_>);
    /// Returns the greeting of senders in the dialect of this configuration.
    first banner(config: &MachineConfig) -> Option<&'static str>;
    /// Sets up what the configuration has wired, while outputs are still off.
    all wired(machine: &mut M);
    /// Reads the feature's files, before saved settings are replayed.
    all read_files(machine: &mut M);
    /// Acts as the machine begins to listen; `is_usable`: its configuration can be used.
    all started(machine: &mut M, is_usable: bool);

    // --- time ---

    /// Looks at what must be seen within 250 us.
    all each_250_us(machine: &mut M, now: Micros);
    /// Looks at what must be seen within 10 ms.
    all each_10_ms(machine: &mut M, now: Micros);
    /// Looks at what must be seen at every turn of a wait. Every line passes here.
    all each_turn(machine: &mut M);
    /// Does work that waits until nothing else is to be done. True: there was some.
    any idle(machine: &mut M) -> bool;

    // --- sessions and lines ---

    /// Carries out a byte that acts at once. True: the feature has taken it.
    any take_request(machine: &mut M, request: Realtime, id: SessionId) -> bool;
    /// Whether a console's line is the feature's own.
    any owns_console_line(machine: &M, line: &str, to: Recipient) -> bool;
    /// Runs a console's line of the feature's own.
    first run_console_line(machine: &mut M, line: &str, to: Recipient) -> Option<Outcome>;
    /// Refuses the codes of a session while the feature is at work. True: that was said.
    any refuse_codes(machine: &mut M, to: Recipient) -> bool;
    /// Acts before a line of a session is carried out.
    all session_line_begins(machine: &mut M);
    /// Acts after a line of a session was carried out.
    all session_line_ends(machine: &mut M);
    /// Returns the line that the feature would like to have run, as an input's, without taking it.
    first line(machine: &M) -> Option<&str>;
    /// Takes that line.
    first take_line(machine: &mut M) -> Option<Command>;
    /// Whether lines that move wait, as for room in the look-ahead queue.
    any hold_moves_back(machine: &M) -> bool;
    /// Acts before a block is interpreted. Every line passes here.
    all block_begins(machine: &mut M, source: Source);
    /// Whether a move is not made, after the feature's own moves before it.
    ///
    /// # Errors
    /// Where the move is refused, or the machine halts.
    any_or_fail leave_move_out(machine: &mut M, request: &Move) -> Result<bool, Failure>;
    /// Refuses a move.
    ///
    /// # Errors
    /// With the reason.
    all_or_fail may_move(machine: &mut M, request: &Move) -> Result<(), Failure>;
    /// Whether a code that does nothing here is answered with `ok` all the same.
    any accepts(code: Code) -> bool;
    /// Says how a startup line has ended.
    all startup_line_ended(machine: &mut M, number: u8, outcome: &Outcome);
    /// Returns a startup line.
    first startup_line(machine: &M, number: u8) -> Option<StartupLine>;

    /// Carries out a command by name that is the feature's own. None: it is none.
    first run_named(machine: &mut M, line: &str, source: Source) -> Option<Outcome>;
    /// Carries out a code that the feature has taken for its own. None: it has not.
    first run_code(machine: &mut M, block: &Block<'_>, source: Source) -> Option<Outcome>;

    /// Shows a text to the operator (M117).
    all shows(machine: &mut M, text: &str);
    /// Begins what a line of a probe's script names, carried out on the spot; `is_first`: nothing of the
    /// script is under way. Returns the number of what is under way otherwise. None: the line names nothing.
    ///
    /// # Errors
    /// Where nothing can be made of it.
    first begin_template(machine: &mut M, line: &str, is_first: bool) -> Option<Result<usize, Failure>>;
    /// Takes the next line of what has been begun, above so much else. None: that has ended.
    ///
    /// # Errors
    /// When the line is too long.
    first template_line(machine: &mut M, above: usize, line: &mut LineBytes) -> Option<Result<(), Failure>>;
    /// Ends what has been begun, down to so much.
    all end_templates(machine: &mut M, above: usize);
    /// Homes these axes, or all where none is named, in the feature's own way. None: it has none for them.
    first homes(machine: &mut M, named: AxisSet, to: Recipient) -> Option<Outcome>;
    /// Whether the feature has a way of its own to home.
    any has_homing(machine: &M) -> bool;

    /// Takes a line of a session, whatever it says.
    any take_session_line(machine: &mut M, id: SessionId, line: &LineBytes) -> bool;
    /// Answers a line of a file that a session sends, as if it were none of it.
    any answer_in_upload(machine: &mut M, line: &Line<'_>, to: Recipient) -> bool;
    /// Gives the next piece of a long answer of the feature's own. True: there is more.
    first long_answer(
        machine: &mut M,
        listing: &mut Listing,
        to: Recipient,
    ) -> Option<Result<bool, Failure>>;

    // --- jobs ---

    /// Whether the job starts now, later, or never.
    start job_may_start(machine: &mut M) -> JobStart;
    /// Whether the job may begin its first line now.
    every job_may_begin(machine: &mut M) -> bool;
    /// Acts as a job begins.
    all job_begins(machine: &mut M, from: JobBegins);
    /// Acts as a job goes on after a power cut, that began with this state.
    all job_goes_on(machine: &mut M, beginning: [u8; BEGINNING_BYTES]);
    /// Acts when the file of the job cannot be read.
    all job_is_unreadable(machine: &mut M);
    /// Acts when the last line of the job has been carried out.
    all job_is_read(machine: &mut M);
    /// Acts when the job ends, while it is still known; `to` hears of it.
    all job_ends(machine: &mut M, is_done: bool, to: Recipient);
    /// Whether the feature stops the job at this line, and says so itself.
    any explains_stop(machine: &M) -> bool;
    /// Suspends the job for a change of filament (M600).
    first suspend(
        machine: &mut M,
        heaters_stay: bool,
        words: &Words<'_>,
        to: Recipient,
    ) -> Option<Outcome>;
    /// Refuses to go on with the suspended job.
    ///
    /// # Errors
    /// With the reason.
    all_or_fail may_resume(machine: &mut M) -> Result<(), Failure>;
    /// Acts before the suspended job goes back to its place; heaters are hot.
    ///
    /// # Errors
    /// When the job must stay suspended, or the machine halts.
    all_or_fail before_going_back(machine: &mut M) -> Result<(), Failure>;
    /// Acts as the suspended job goes back to its place.
    all goes_back(machine: &mut M);
    /// Acts at the place where a stall has stopped the job.
    ///
    /// # Errors
    /// When the machine halts.
    all_or_fail arrives(machine: &mut M, stall: &StalledJob) -> Result<(), Failure>;

    // --- motion ---

    /// Acts before the machine leaves for heights that the file does not say, from least to most, mm.
    all leaves_for_heights(machine: &mut M, heights: [f64; 2]);
    /// Whether Z's shift for the frame's temperature stays as it is: the job on its way back has its own.
    any keeps_thermal_z(machine: &M) -> bool;
    /// Acts when extruders count from another place, with no filament moved.
    all extruders_count_anew(machine: &mut M);
    /// Acts when objects are left out, or taken in again, by a person.
    all objects_change(machine: &mut M);
    /// Whether a held machine may go on. False: the reason was said.
    every may_go_on(machine: &mut M) -> bool;
    /// Acts as the machine goes on from a hold, or from an open door.
    all goes_on(machine: &mut M, from: State);

    // --- ends ---

    /// Changes the colours of lights where the path has come to.
    ///
    /// # Errors
    /// When the machine halts meanwhile.
    all_or_fail change_light(machine: &mut M, change: &LightChange) -> Result<(), Failure>;
    /// Arms a rule that switches an output by temperature, or disarms it.
    all arm(machine: &mut M, rule: u8, armed: bool);
    /// Notes the change of lights in a file that is read over.
    all pass_light(machine: &mut M, change: &LightChange);
    /// Drops changes that wait for their place on the path.
    all drop_effects(machine: &mut M);
    /// Acts when all outputs have been stopped.
    all stops(machine: &mut M);
    /// Acts when the machine halts, outputs off already and the reason said.
    all halts(machine: &mut M);
    /// Acts when a halt or a reset drops the job, while it is still known.
    all job_is_dropped(machine: &mut M);
    /// Acts when a halted machine has come to rest.
    all rests(machine: &mut M);
    /// Acts as `abort` or M410 ends the work in progress, while motion still comes to rest.
    all work_ends(machine: &mut M);
    /// Acts when the work in progress has been ended by `abort` or M410, and motion rests.
    all work_was_ended(machine: &mut M);
}
