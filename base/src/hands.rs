//! The machine as sequences that take time may use it: homing, probing, leveling, tuning, jogging.
//!
//! A sequence is an `fn` over [`Hands`], and reads from top to bottom. Sessions, program and jobs are hidden
//! from it: it moves, waits, looks at inputs, asks owners for what it needs, and reports to the recipient
//! that asked for it.

use core::fmt::Arguments;

use config::MachineConfig;
use motion::{Latch, Mode, Motion, MotionConfig};
use program::State;
use thermal::HeatControl;
use units::{AxisSet, Micros, MmPerSecond, PerAxis, Volts};

use crate::Ports;
use crate::axes::Axes;
use crate::bed::Bed;
use crate::failure::{Failure, Texts};
use crate::ports::{DriversPort, FileHandle, InputLevels, StorageError, Wake};
use crate::reason::Alarm;
use crate::safe_file::Draft;
use crate::safety::Event;
use crate::safety::travel::Travel;
use crate::sessions::Reply;
use crate::supervisor::Supervisor;
use crate::tuning::Tuning;
use crate::wait::Waited;

/// The machine in the hands of one sequence.
pub trait Hands<'c> {
    /// Type of the world that the machine is in.
    type Ports: Ports;

    // --- what there is ---

    /// Returns the configuration of the machine.
    fn config(&self) -> &'c MachineConfig;

    /// Returns the texts of failures.
    fn texts(&self) -> &'c Texts;

    /// Returns the settings that codes have changed.
    fn tuning(&mut self) -> &mut Tuning;

    /// Returns the bed, which probing starts from.
    fn bed(&mut self) -> &mut Bed;

    /// Calls `f` with the motor drivers.
    fn drivers<R>(&mut self, f: impl FnOnce(&mut <Self::Ports as DriversPort>::Drivers) -> R) -> R;

    /// Returns the axes and motors.
    fn axes(&mut self) -> &mut Axes;

    /// Returns the time since boot.
    fn now(&self) -> Micros;

    /// Returns a monitored voltage by name.
    fn voltage(&mut self, name: &str) -> Option<Volts>;

    /// Calls `f` with the motion object.
    fn motion<R>(&mut self, f: impl FnOnce(&mut Motion) -> R) -> R;

    /// Returns the configuration of motion.
    ///
    /// # Errors
    /// When motion is not configured.
    fn motion_config(&mut self) -> Result<MotionConfig, Failure> {
        let config = self.motion(|motion| motion.config().copied());
        config.ok_or_else(|| Failure::refused(&"motion is not configured"))
    }

    /// Calls `f` with heat control.
    fn heat<R>(&mut self, f: impl FnOnce(&mut HeatControl) -> R) -> R;

    /// Calls `f` with the watch over drivers and supplies.
    fn supervisor<R>(&mut self, f: impl FnOnce(&mut Supervisor) -> R) -> R;

    /// Returns the latch through which inputs stop motion.
    fn latch(&self) -> &Latch;

    /// Switches the watch for stalls on or off: while a driver's load is measured its stall output means
    /// nothing.
    fn watch_stalls(&mut self, yes: bool);

    /// Returns the levels of all inputs.
    fn inputs(&self) -> InputLevels;

    /// Returns the storage of the card.
    fn storage(&mut self) -> &mut Self::Ports;

    /// Returns the state of the machine.
    fn state(&self) -> State;

    /// Whether the recipient that asked goes by GRBL's numbers.
    fn speaks_grbl(&self) -> bool;

    /// Whether a file is being played and not paused.
    fn is_playing(&self) -> bool;

    /// Whether a file is open as the job, played or paused.
    fn has_job(&self) -> bool;

    /// Returns the rectangle around the outlines of the job's objects, least and greatest X and Y; objects
    /// that are left out do not count.
    fn objects_area(&self) -> Option<[[f64; 2]; 2]>;

    // --- what it says ---

    /// Says something to the recipient that asked for the sequence.
    fn say(&mut self, text: Arguments<'_>);

    /// Says a result: to the recipient that asked, or to all where a file or a script did.
    fn report(&mut self, text: Arguments<'_>);

    /// Says something to every session.
    fn announce(&mut self, text: Arguments<'_>);

    /// Returns a reply to the recipient that asked for the sequence.
    fn reply(&mut self) -> Reply<'_>;

    /// Takes the recipient's request to end the sequence (Ctrl-Y), once.
    fn stop_requested(&mut self) -> bool;

    /// Whether the recipient wants the sequence to end, or has gone, which ends motion held by hand.
    fn is_let_go(&mut self) -> bool;

    /// Whether a session or a button asked for the sequence, and can stop it.
    fn can_be_stopped(&self) -> bool;

    // --- waiting ---

    /// Makes one turn of a wait: serves everybody, and rests.
    fn wait(&mut self, wake: Wake) -> Waited;

    /// Has a file read ahead, unless one is played.
    fn read_ahead(&mut self, file: FileHandle);

    /// Waits until the card is at rest: no write is on its way. Everybody is served meanwhile.
    fn card_at_rest(&mut self);

    /// Puts a newly written file in the place of the old one, and waits until it is on the card.
    ///
    /// # Errors
    /// Those of the card; the file is the old one then.
    fn put_in_place(&mut self, draft: Draft<Self::Ports>) -> Result<(), StorageError>;

    /// Waits until all that was written is on the card.
    ///
    /// # Errors
    /// When something was not written, with the reason.
    fn card_has_kept(&mut self) -> Result<(), StorageError>;

    /// Whether the wait in work, the job's own line, is left for a pause.
    fn leaves_wait(&mut self) -> bool;

    /// Begins a wait that M108 ends.
    fn begin_wait(&mut self);

    /// Whether M108 has come since the wait began.
    fn wait_is_over(&self) -> bool;

    /// Whether the work in progress is to end, on a machine that is not halted.
    fn is_ended(&self) -> bool;

    /// Waits for a length of time, whatever moves.
    ///
    /// # Errors
    /// [`Failure::HALTED`].
    fn wait_for(&mut self, time: Micros) -> Result<(), Failure>;

    /// Waits until everything queued has been executed.
    ///
    /// # Errors
    /// [`Failure::HALTED`].
    fn standstill(&mut self) -> Result<(), Failure>;

    /// Waits until the recipient has taken most of the output.
    fn drain(&mut self);

    /// Waits while the operator holds the machine, or the door is open.
    ///
    /// # Errors
    /// [`Failure::HALTED`].
    fn wait_while_held(&mut self) -> Result<(), Failure> {
        while matches!(self.state(), State::Hold | State::Door) {
            self.wait(Wake::Time).unless_halted()?;
        }
        Ok(())
    }

    /// Carries out a line of the configuration that moves the probe.
    ///
    /// # Errors
    /// As moves; and where the line holds anything but moves, waits, modes and switches.
    fn run_probe_script(&mut self, key: &str, script: &str) -> Result<(), Failure>;

    // --- moving ---

    /// Returns the machine position where the last accepted move ends.
    fn position(&mut self) -> PerAxis<f64> {
        self.motion(|motion| motion.commanded_position())
    }

    /// Returns the travel that axes may be commanded within.
    fn travel(&mut self) -> &Travel;

    /// Whether the tool may go over this place, X and Y of the machine, from where it is.
    ///
    /// # Errors
    /// When it is out of the travel.
    fn may_go_over(&mut self, place: [f64; 2]) -> Result<(), Failure>;

    /// Submits one straight move, wherever it goes, waiting while the look-ahead queue is full.
    ///
    /// # Errors
    /// When it is refused, or the machine halts.
    fn go(&mut self, target: PerAxis<f64>, rate: MmPerSecond, mode: Mode) -> Result<(), Failure> {
        self.submit(motion::Move { target, feed_rate: rate, mode, ..motion::Move::default() })
    }

    /// Submits one move as [`Self::go`] does.
    ///
    /// # Errors
    /// As [`Self::go`] has them.
    fn submit(&mut self, request: motion::Move) -> Result<(), Failure>;

    /// Moves and waits until the motors stand there.
    ///
    /// # Errors
    /// As [`Self::go`].
    fn go_there(&mut self, target: PerAxis<f64>, rate: MmPerSecond) -> Result<(), Failure> {
        self.go(target, rate, Mode::Rapid)?;
        self.standstill()
    }

    /// Tells motion where the machine is. Only while idle.
    ///
    /// # Errors
    /// When it is not.
    fn set_position(&mut self, position: PerAxis<f64>) -> Result<(), Failure> {
        let set = self.motion(|motion| motion.set_position(position));
        set.map_err(|refusal| self.texts().refused(format_args!("{refusal}")))
    }

    /// Switches the current of every motor on.
    ///
    /// # Errors
    /// Without motor supply, or when a driver does not answer.
    fn enable_motors(&mut self) -> Result<(), Failure>;

    /// Whether every axis that can be homed has been.
    fn all_homed(&self) -> bool;

    /// Marks these axes as homed.
    fn mark_homed(&mut self, axes: AxisSet);

    // --- the machine's state ---

    /// Applies an event to the table of states; true when it meant something.
    fn apply(&mut self, event: Event) -> bool;

    /// Halts the machine and says why.
    fn halt(&mut self, alarm: Alarm, why: Arguments<'_>);

    /// Suspends the limit switches' guard: homing has the latch to itself.
    fn suspend_limits(&mut self);

    /// Gives the latch to a search.
    fn search_begins(&mut self);

    /// Takes the latch back from a search.
    fn search_ends(&mut self);

    /// Takes these axes' places as the machine was told, and counts them as homed.
    fn declare_homed(&mut self, axes: AxisSet);

    /// Ends the suspension of a host's job at a place that nothing leads back to, as in Smoothieware. A file
    /// stays suspended, for M24 would play on from here.
    fn end_suspension_without_place(&mut self);

    /// Has Z of a contact at this height of the machine read as given from now on, both in mm.
    fn read_contact(&mut self, machine_z: f64, reads: f64);

    /// Stores the result of waiting for an input, `#5399`.
    fn set_input_result(&mut self, result: f64);

    /// Stores the end of a search along a line, and whether it found its contact.
    fn set_last_probe(&mut self, place: [f64; 3], found: bool);
}
