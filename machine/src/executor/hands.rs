//! The machine as sequences that take time may use it: homing, probing, leveling, tuning, jogging.
//!
//! A sequence is an `fn` over [`Hands`], and reads from top to bottom. Sessions, program and jobs are hidden
//! from it: it moves, waits, looks at inputs, asks owners for what it needs, and reports to the recipient
//! that asked for it.

use core::fmt::Arguments;

use config::MachineConfig;
use motion::{Latch, Mode, Motion, MotionConfig};
use program::{Dialect, State};
use units::{Axis, AxisSet, Micros, MmPerSecond, PerAxis, Volts};

use super::{Machine, probe_script};
use crate::axes::Axes;
use crate::bed::Bed;
use crate::endstop_phase::EndstopPhases;
use crate::failure::{Failure, Texts};
use crate::files::safe_file::Draft;
use crate::paper::Paper;
use crate::ports::{InputLevels, Ports, StorageError, Wake};
use crate::probing::{DeltaRecords, Deployment};
use crate::reason::Alarm;
use crate::safety::Event;
use crate::safety::travel::Travel;
use crate::sessions::{Recipient, Reply};
use crate::supervisor::Supervisor;
use crate::tuning::Tuning;
use crate::wait::Waited;
use thermal::HeatControl;

/// The machine in the hands of one sequence.
pub struct Hands<'m, 'c, P: Ports> {
    machine: &'m mut Machine<'c, P>,
    to: Recipient,
}

impl<'m, 'c, P: Ports> Hands<'m, 'c, P> {
    /// Makes hands for a sequence that this recipient asked for.
    pub(super) const fn new(machine: &'m mut Machine<'c, P>, to: Recipient) -> Self {
        Self { machine, to }
    }

    // --- what there is ---

    /// Returns the configuration of the machine.
    pub const fn config(&self) -> &'c MachineConfig {
        self.machine.config
    }

    /// Returns the texts of failures.
    pub const fn texts(&self) -> &'c Texts {
        self.machine.texts
    }

    /// Returns the settings that codes have changed.
    pub const fn tuning(&mut self) -> &mut Tuning {
        &mut self.machine.tuning
    }

    /// Returns the bed, which probing starts from.
    pub const fn bed(&mut self) -> &mut Bed {
        &mut self.machine.bed
    }

    /// Returns the measurements made of a delta.
    pub const fn delta_records(&mut self) -> &mut DeltaRecords {
        &mut self.machine.delta
    }

    /// Returns the phases that motors have at their switches.
    pub(crate) const fn phases(&mut self) -> &mut EndstopPhases {
        &mut self.machine.phases
    }

    /// Calls `f` with the motor drivers.
    pub fn drivers<R>(&mut self, f: impl FnOnce(&mut P::Drivers) -> R) -> R {
        self.machine.ports.drivers(f)
    }

    /// Returns the axes and motors.
    pub const fn axes(&mut self) -> &mut Axes {
        &mut self.machine.axes
    }

    /// Returns the time since boot.
    pub fn now(&self) -> Micros {
        self.machine.ports.now()
    }

    /// Returns a monitored voltage by name.
    pub fn voltage(&mut self, name: &str) -> Option<Volts> {
        self.machine.ports.voltage(name)
    }

    /// Calls `f` with the motion object.
    pub fn motion<R>(&mut self, f: impl FnOnce(&mut Motion) -> R) -> R {
        self.machine.ports.motion(f)
    }

    /// Returns the configuration of motion.
    ///
    /// # Errors
    /// When motion is not configured.
    pub fn motion_config(&mut self) -> Result<MotionConfig, Failure> {
        let config = self.motion(|motion| motion.config().copied());
        config.ok_or_else(|| Failure::refused(&"motion is not configured"))
    }

    /// Calls `f` with heat control.
    pub fn heat<R>(&mut self, f: impl FnOnce(&mut HeatControl) -> R) -> R {
        self.machine.ports.heat(f)
    }

    /// Calls `f` with the watch over drivers and supplies.
    pub fn supervisor<R>(&mut self, f: impl FnOnce(&mut Supervisor) -> R) -> R {
        self.machine.ports.supervisor(f)
    }

    /// Returns the latch through which inputs stop motion.
    pub fn latch(&self) -> &Latch {
        self.machine.ports.latch()
    }

    /// Switches the watch for stalls on or off: while a driver's load is measured its stall output means
    /// nothing.
    pub const fn watch_stalls(&mut self, yes: bool) {
        self.machine.polls.ignores_stalls = !yes;
    }

    /// Returns the levels of all inputs.
    pub fn inputs(&self) -> InputLevels {
        self.machine.ports.inputs()
    }

    /// Returns the storage of the card.
    pub const fn storage(&mut self) -> &mut P {
        &mut self.machine.ports
    }

    /// Returns the state of the machine.
    pub const fn state(&self) -> State {
        self.machine.safety.state()
    }

    /// Whether the recipient that asked goes by GRBL's numbers.
    pub fn speaks_grbl(&self) -> bool {
        self.machine.sessions.dialect_of(self.to) == Dialect::Grbl
    }

    /// Whether a file is being played and not paused.
    pub fn is_playing(&self) -> bool {
        self.machine.jobs.is_playing()
    }

    /// Returns the rectangle around the outlines of the job's objects, least and greatest X and Y; objects
    /// that are left out do not count.
    pub fn objects_area(&self) -> Option<[[f64; 2]; 2]> {
        self.machine.jobs.objects.area()
    }

    // --- what it says ---

    /// Says something to the recipient that asked for the sequence.
    pub fn say(&mut self, text: Arguments<'_>) {
        self.machine.sessions.say(self.to, text);
    }

    /// Says a result: to the recipient that asked, or to all where a file or a script did.
    pub fn report(&mut self, text: Arguments<'_>) {
        let to = if self.to == Recipient::Nobody { Recipient::All } else { self.to };
        self.machine.sessions.say(to, text);
    }

    /// Says something to every session.
    pub fn announce(&mut self, text: Arguments<'_>) {
        self.machine.sessions.say(Recipient::All, text);
    }

    /// Returns a reply to the recipient that asked for the sequence.
    pub const fn reply(&mut self) -> Reply<'_> {
        Reply::new(self.machine.sessions, self.to)
    }

    /// Takes the recipient's request to end the sequence (Ctrl-Y), once.
    pub fn stop_requested(&mut self) -> bool {
        self.machine.sessions.take_stop(self.to)
    }

    /// Whether the recipient wants the sequence to end, or has gone, which ends motion held by hand.
    pub fn is_let_go(&mut self) -> bool {
        self.stop_requested() || self.machine.sessions.has_left(self.to)
    }

    /// Whether a session or a button asked for the sequence, and can stop it.
    pub const fn can_be_stopped(&self) -> bool {
        self.to.session().is_some() || self.machine.sessions.button_stop.is_some()
    }

    // --- waiting ---

    /// Makes one turn of a wait: serves everybody, and rests.
    pub fn wait(&mut self, wake: Wake) -> Waited {
        self.machine.wait(wake)
    }

    /// Has a file read ahead, unless one is played.
    pub fn read_ahead(&mut self, file: crate::ports::FileHandle) {
        if !self.machine.jobs.is_open() {
            self.machine.ports.read_ahead(file);
        }
    }

    /// Waits until the card is at rest: see [`super::card`].
    pub fn card_at_rest(&mut self) {
        super::card::at_rest(self.machine);
    }

    /// Puts a newly written file in the place of the old one, and waits until it is on the card.
    ///
    /// # Errors
    /// Those of the card; the file is the old one then.
    pub fn put_in_place(&mut self, draft: Draft<P>) -> Result<(), StorageError> {
        super::card::finish(self.machine, draft)
    }

    /// Waits until all that was written is on the card.
    ///
    /// # Errors
    /// When something was not written, with the reason.
    pub fn card_has_kept(&mut self) -> Result<(), StorageError> {
        super::card::kept(self.machine)
    }

    /// Whether the wait in work, the job's own line, is left for a pause.
    pub fn leaves_wait(&mut self) -> bool {
        self.machine.urgent.leaves_wait()
    }

    /// Begins a wait that M108 ends.
    pub const fn begin_wait(&mut self) {
        self.machine.urgent.begin_wait();
    }

    /// Whether M108 has come since the wait began.
    pub const fn wait_is_over(&self) -> bool {
        self.machine.urgent.wait_is_over()
    }

    /// Whether the work in progress is to end, on a machine that is not halted.
    pub const fn is_ended(&self) -> bool {
        self.machine.urgent.ends()
    }

    /// Waits for a length of time, whatever moves.
    ///
    /// # Errors
    /// [`Failure::HALTED`].
    pub fn wait_for(&mut self, time: Micros) -> Result<(), Failure> {
        self.machine.wait_for(time)
    }

    /// Waits until everything queued has been executed.
    ///
    /// # Errors
    /// [`Failure::HALTED`].
    pub fn standstill(&mut self) -> Result<(), Failure> {
        self.machine.standstill()
    }

    /// Waits until the recipient has taken most of the output.
    pub fn drain(&mut self) {
        self.machine.drain(self.to);
    }

    /// Waits while the operator holds the machine, or the door is open.
    ///
    /// # Errors
    /// [`Failure::HALTED`].
    pub fn wait_while_held(&mut self) -> Result<(), Failure> {
        while matches!(self.state(), State::Hold | State::Door) {
            self.wait(Wake::Time).unless_halted()?;
        }
        Ok(())
    }

    // --- the probe ---

    /// Returns the paper test that is under way.
    pub const fn paper(&mut self) -> &mut Paper {
        &mut self.machine.paper
    }

    /// Returns the probe's state, out or stowed.
    pub const fn deployment(&mut self) -> &mut Deployment {
        &mut self.machine.deployment
    }

    /// Carries out a line of the configuration that moves the probe.
    ///
    /// # Errors
    /// As moves; and where the line holds anything but moves, waits, modes and switches.
    pub fn run_probe_script(&mut self, key: &str, script: &str) -> Result<(), Failure> {
        probe_script::run(self.machine, key, script)
    }

    // --- moving ---

    /// Returns the machine position where the last accepted move ends.
    pub fn position(&mut self) -> PerAxis<f64> {
        self.motion(|motion| motion.commanded_position())
    }

    /// Returns the travel that axes may be commanded within.
    pub fn travel(&mut self) -> &Travel {
        self.machine.travel()
    }

    /// Whether the tool may go over this place, X and Y of the machine, from where it is.
    ///
    /// # Errors
    /// When it is out of the travel.
    pub fn may_go_over(&mut self, [x, y]: [f64; 2]) -> Result<(), Failure> {
        let here = self.position();
        let mut there = here;
        (there[Axis::X], there[Axis::Y]) = (x, y);
        self.machine.stays_within(&here, &there)
    }

    /// Submits one straight move, wherever it goes, waiting while the look-ahead queue is full.
    ///
    /// # Errors
    /// When it is refused, or the machine halts.
    pub fn go(&mut self, target: PerAxis<f64>, rate: MmPerSecond, mode: Mode) -> Result<(), Failure> {
        let tag = self.machine.tag;
        let request = motion::Move { target, feed_rate: rate, mode, tag, ..motion::Move::default() };
        self.machine.submit(&request)
    }

    /// Moves and waits until the motors stand there.
    ///
    /// # Errors
    /// As [`Self::go`].
    pub fn go_there(&mut self, target: PerAxis<f64>, rate: MmPerSecond) -> Result<(), Failure> {
        self.go(target, rate, Mode::Rapid)?;
        self.standstill()
    }

    /// Tells motion where the machine is. Only while idle.
    ///
    /// # Errors
    /// When it is not.
    pub fn set_position(&mut self, position: PerAxis<f64>) -> Result<(), Failure> {
        let set = self.motion(|motion| motion.set_position(position));
        set.map_err(|refusal| self.texts().refused(format_args!("{refusal}")))
    }

    /// Switches the current of every motor on.
    ///
    /// # Errors
    /// Without motor supply, or when a driver does not answer.
    pub fn enable_motors(&mut self) -> Result<(), Failure> {
        self.machine.enable_motors()
    }

    /// Whether every axis that can be homed has been.
    pub fn all_homed(&self) -> bool {
        self.machine.facts().all_homed()
    }

    /// Marks these axes as homed.
    pub fn mark_homed(&mut self, axes: AxisSet) {
        self.machine.mark_homed(axes);
    }

    // --- the machine's state ---

    /// Applies an event to the table of states; true when it meant something.
    pub const fn apply(&mut self, event: Event) -> bool {
        self.machine.safety.apply(event)
    }

    /// Halts the machine and says why.
    pub fn halt(&mut self, alarm: Alarm, why: Arguments<'_>) {
        self.machine.halt(alarm, why);
    }

    /// Suspends the limit switches' guard: homing has the latch to itself.
    pub fn suspend_limits(&mut self) {
        let now = self.now();
        let Machine { safety, ports, .. } = &mut *self.machine;
        safety.limits.suspend(ports.latch(), now);
    }

    /// Gives the latch to a search.
    pub const fn search_begins(&mut self) {
        self.machine.safety.limits.search_begins();
    }

    /// Takes the latch back from a search.
    pub fn search_ends(&mut self) {
        let now = self.now();
        let Machine { safety, ports, .. } = &mut *self.machine;
        safety.limits.search_ends(ports.latch(), now);
    }

    /// Takes these axes' places as the machine was told, and counts them as homed.
    pub fn declare_homed(&mut self, axes: AxisSet) {
        self.machine.declare_homed(axes);
    }

    /// Ends the suspension of a host's job at a place that nothing leads back to, as in Smoothieware. A file
    /// stays suspended, for M24 would play on from here.
    pub fn end_suspension_without_place(&mut self) {
        let Machine { jobs, axes, safety, sessions, .. } = &mut *self.machine;
        let [strayed, comes_back] = axes.strayed();
        if jobs.is_suspended() && !jobs.is_open() && strayed != comes_back {
            safety.apply(Event::Unsuspend);
            jobs.cancel_suspend();
            sessions.say(Recipient::All, format_args!("//Suspend cancelled due to homing cycle\n"));
        }
    }

    /// Has Z of a contact at this height of the machine read as given from now on, both in mm.
    pub fn read_contact(&mut self, machine_z: f64, reads: f64) {
        self.machine.program.read_contact(machine_z, reads);
    }

    /// Stores the end of a search along a line, and whether it found its contact.
    pub fn set_last_probe(&mut self, place: [f64; 3], found: bool) {
        self.machine.program.set_last_probe(place, found);
        if found {
            super::log::contact_found(self.machine);
        }
    }
}
