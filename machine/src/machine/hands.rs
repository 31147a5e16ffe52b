//! The machine in the hands of a sequence: what each of [`Hands`]' methods does with it; and in those of
//! other work ([`super::work_hands`]).

use core::fmt::Arguments;

use base::axes::Axes;
use base::bed::Bed;
use base::failure::{Failure, Outcome, Texts};
use base::hands::Hands;
use base::ports::{DriversPort, FileHandle, InputLevels, StorageError, Wake};
use base::reason::Alarm;
use base::safe_file::Draft;
use base::safety::Event;
use base::safety::travel::Travel;
use base::sessions::{Recipient, Reply};
use base::supervisor::Supervisor;
use base::tuning::Tuning;
use base::wait::Waited;
use base::{Ports, World};
use config::MachineConfig;
use jobs::player::Jobs;
use motion::{Latch, Motion};
use procedures::endstop_phase::{EndstopPhases, PhaseHands};
use procedures::probing::{DeltaRecords, Deployment, ProbeHands};
use program::{Dialect, Facts, Interpreter, State};
use thermal::HeatControl;
use units::{Axis, AxisSet, Micros, PerAxis, Volts};

use crate::machine::frames::Frames;
use crate::machine::moments::{Featured, Features, Moments as _};
use crate::machine::work_hands::{HaltHands, JobHands, MoveHands, ProgramHands, WaitHands, WorldHands};
use crate::machine::{Machine, card, probe_script, program_logs};

/// The machine in the hands of a sequence that a recipient asked for.
pub(crate) struct MachineHands<'m, 'c, P: Ports> {
    pub(crate) machine: &'m mut Machine<'c, P>,
    pub(crate) to: Recipient,
}

impl<'m, 'c, P: Ports> MachineHands<'m, 'c, P> {
    /// Makes hands for a sequence that this recipient asked for.
    pub(crate) const fn new(machine: &'m mut Machine<'c, P>, to: Recipient) -> Self {
        Self { machine, to }
    }
}

impl<'c, P: Ports> Hands<'c> for MachineHands<'_, 'c, P> {
    type Ports = P;

    fn config(&self) -> &'c MachineConfig {
        self.machine.world.config
    }

    fn texts(&self) -> &'c Texts {
        self.machine.world.texts
    }

    fn tuning(&mut self) -> &mut Tuning {
        &mut self.machine.tuning
    }

    fn bed(&mut self) -> &mut Bed {
        &mut self.machine.bed
    }

    fn drivers<R>(&mut self, f: impl FnOnce(&mut <Self::Ports as DriversPort>::Drivers) -> R) -> R {
        self.machine.world.ports.drivers(f)
    }

    fn axes(&mut self) -> &mut Axes {
        &mut self.machine.axes
    }

    fn now(&self) -> Micros {
        self.machine.world.ports.now()
    }

    fn voltage(&mut self, name: &str) -> Option<Volts> {
        self.machine.world.ports.voltage(name)
    }

    fn motion<R>(&mut self, f: impl FnOnce(&mut Motion) -> R) -> R {
        self.machine.world.ports.motion(f)
    }

    fn heat<R>(&mut self, f: impl FnOnce(&mut HeatControl) -> R) -> R {
        self.machine.world.ports.heat(f)
    }

    fn supervisor<R>(&mut self, f: impl FnOnce(&mut Supervisor) -> R) -> R {
        self.machine.world.ports.supervisor(f)
    }

    fn latch(&self) -> &Latch {
        self.machine.world.ports.latch()
    }

    fn watch_stalls(&mut self, yes: bool) {
        self.machine.polls.ignores_stalls = !yes;
    }

    fn inputs(&self) -> InputLevels {
        self.machine.world.ports.inputs()
    }

    fn storage(&mut self) -> &mut Self::Ports {
        &mut self.machine.world.ports
    }

    fn state(&self) -> State {
        self.machine.safety.state()
    }

    fn speaks_grbl(&self) -> bool {
        self.machine.world.sessions.dialect_of(self.to) == Dialect::Grbl
    }

    fn is_playing(&self) -> bool {
        self.machine.jobs.is_playing()
    }

    fn has_job(&self) -> bool {
        self.machine.jobs.is_open()
    }

    fn objects_area(&self) -> Option<[[f64; 2]; 2]> {
        self.machine.jobs.objects.area()
    }

    fn say(&mut self, text: Arguments<'_>) {
        self.machine.world.sessions.say(self.to, text);
    }

    fn report(&mut self, text: Arguments<'_>) {
        let to = if self.to == Recipient::Nobody { Recipient::All } else { self.to };
        self.machine.world.sessions.say(to, text);
    }

    fn announce(&mut self, text: Arguments<'_>) {
        self.machine.world.sessions.say(Recipient::All, text);
    }

    fn reply(&mut self) -> Reply<'_> {
        Reply::new(self.machine.world.sessions, self.to)
    }

    fn stop_requested(&mut self) -> bool {
        self.machine.world.sessions.take_stop(self.to)
    }

    fn can_be_stopped(&self) -> bool {
        self.to.session().is_some() || self.machine.world.sessions.button_stop.is_some()
    }

    fn wait(&mut self, wake: Wake) -> Waited {
        self.machine.wait(wake)
    }

    fn read_ahead(&mut self, file: FileHandle) {
        if !self.machine.jobs.is_open() {
            self.machine.world.ports.read_ahead(file);
        }
    }

    fn card_at_rest(&mut self) {
        card::at_rest(self.machine);
    }

    fn put_in_place(&mut self, draft: Draft<Self::Ports>) -> Result<(), StorageError> {
        card::finish(self.machine, draft)
    }

    fn card_has_kept(&mut self) -> Result<(), StorageError> {
        card::kept(self.machine)
    }

    fn leaves_wait(&mut self) -> bool {
        self.machine.urgent.leaves_wait()
    }

    fn begin_wait(&mut self) {
        self.machine.urgent.begin_wait();
    }

    fn wait_is_over(&self) -> bool {
        self.machine.urgent.wait_is_over()
    }

    fn is_ended(&self) -> bool {
        self.machine.urgent.ends()
    }

    fn wait_for(&mut self, time: Micros) -> Result<(), Failure> {
        self.machine.wait_for(time)
    }

    fn standstill(&mut self) -> Result<(), Failure> {
        self.machine.standstill()
    }

    fn drain(&mut self) {
        self.machine.drain(self.to);
    }

    fn run_probe_script(&mut self, key: &str, script: &str) -> Result<(), Failure> {
        probe_script::run(self.machine, key, script)
    }

    fn travel(&mut self) -> &Travel {
        self.machine.travel()
    }

    fn submit(&mut self, request: motion::Move) -> Result<(), Failure> {
        let tag = self.machine.tag;
        self.machine.submit(&motion::Move { tag, ..request })
    }

    fn enable_motors(&mut self) -> Result<(), Failure> {
        self.machine.enable_motors()
    }

    fn all_homed(&self) -> bool {
        self.machine.facts().all_homed()
    }

    fn mark_homed(&mut self, axes: AxisSet) {
        self.machine.mark_homed(axes);
    }

    fn apply(&mut self, event: Event) -> bool {
        self.machine.safety.apply(event)
    }

    fn halt(&mut self, alarm: Alarm, why: Arguments<'_>) {
        self.machine.halt(alarm, why);
    }

    fn suspend_limits(&mut self) {
        let now = self.now();
        let Machine { safety, world: World { ports, .. }, .. } = &mut *self.machine;
        safety.limits.suspend(ports.latch(), now);
    }

    fn search_begins(&mut self) {
        self.machine.safety.limits.search_begins();
    }

    fn search_ends(&mut self) {
        let now = self.now();
        let Machine { safety, world: World { ports, .. }, .. } = &mut *self.machine;
        safety.limits.search_ends(ports.latch(), now);
    }

    fn declare_homed(&mut self, axes: AxisSet) {
        self.machine.declare_homed(axes);
    }

    fn end_suspension_without_place(&mut self) {
        let Machine { jobs, axes, safety, world: World { sessions, .. }, .. } = &mut *self.machine;
        let [strayed, comes_back] = axes.strayed();
        if jobs.is_suspended() && !jobs.is_open() && strayed != comes_back {
            safety.apply(Event::Unsuspend);
            jobs.cancel_suspend();
            sessions.say(Recipient::All, format_args!("//Suspend cancelled due to homing cycle\n"));
        }
    }

    fn read_contact(&mut self, machine_z: f64, reads: f64) {
        self.machine.program.read_contact(machine_z, reads);
    }

    fn set_input_result(&mut self, result: f64) {
        self.machine.program.set_input_result(result);
    }

    fn set_last_probe(&mut self, place: [f64; 3], found: bool) {
        self.machine.program.set_last_probe(place, found);
        if found {
            let Machine { logs, program, world, .. } = &mut *self.machine;
            program_logs::contact_found(logs, program, world);
        }
    }

    fn is_let_go(&mut self) -> bool {
        self.stop_requested() || self.machine.world.sessions.has_left(self.to)
    }

    fn may_go_over(&mut self, [x, y]: [f64; 2]) -> Result<(), Failure> {
        let here = self.position();
        let mut there = here;
        (there[Axis::X], there[Axis::Y]) = (x, y);
        self.machine.stays_within(&here, &there)
    }
}

impl<'c, P: Ports> PhaseHands<'c> for MachineHands<'_, 'c, P> {
    fn phases(&mut self) -> &mut EndstopPhases {
        &mut self.machine.phases
    }

    fn homes_by_template(&self) -> bool {
        Features::<P>::has_homing(self.machine)
    }
}

impl<'c, P: Ports> ProbeHands<'c> for MachineHands<'_, 'c, P> {
    fn delta_records(&mut self) -> &mut DeltaRecords {
        &mut self.machine.delta
    }

    fn deployment(&mut self) -> &mut Deployment {
        &mut self.machine.deployment
    }
}

impl<'c, P: Ports> WorldHands<'c> for Machine<'c, P> {
    type Ports = P;

    fn world(&mut self) -> &mut World<'c, P> {
        &mut self.world
    }
}

impl<'c, P: Ports> WaitHands<'c> for Machine<'c, P> {
    fn wait(&mut self, wake: Wake) -> Waited {
        self.wait(wake)
    }
}

impl<'c, P: Ports> HaltHands<'c> for Machine<'c, P> {
    fn state(&self) -> State {
        self.safety.state()
    }

    fn is_halted(&self) -> bool {
        self.safety.is_halted()
    }

    fn apply(&mut self, event: Event) -> bool {
        self.safety.apply(event)
    }

    fn halt(&mut self, alarm: Alarm, why: Arguments<'_>) {
        self.halt(alarm, why);
    }
}

impl<'c, P: Ports> ProgramHands<'c> for Machine<'c, P> {
    fn program(&mut self) -> &mut Interpreter {
        &mut self.program
    }

    fn program_in_world(&mut self) -> (&mut Interpreter, &mut World<'c, P>) {
        (&mut self.program, &mut self.world)
    }
}

impl<'c, P: Ports> MoveHands<'c> for Machine<'c, P> {
    fn sequence(&mut self, to: Recipient) -> impl ProbeHands<'c, Ports = P> {
        MachineHands::new(self, to)
    }

    fn axes(&mut self) -> &mut Axes {
        &mut self.axes
    }

    fn can_home(&self) -> AxisSet {
        self.can_home
    }

    fn facts(&self) -> Facts {
        self.facts()
    }

    fn tuning(&mut self) -> &mut Tuning {
        &mut self.tuning
    }

    fn standstill(&mut self) -> Result<(), Failure> {
        self.standstill()
    }

    fn wait_for(&mut self, time: Micros) -> Result<(), Failure> {
        self.wait_for(time)
    }

    fn travel(&mut self) -> &Travel {
        self.travel()
    }

    fn stays_within(&mut self, from: &PerAxis<f64>, to: &PerAxis<f64>) -> Result<(), Failure> {
        self.stays_within(from, to)
    }

    fn resynchronise(&mut self) {
        self.resynchronise();
    }

    fn resynchronise_if_still(&mut self) {
        self.resynchronise_if_still();
    }
}

impl<'c, P: Ports> JobHands<'c> for Machine<'c, P> {
    fn jobs(&mut self) -> &mut Jobs {
        &mut self.jobs
    }

    fn jobs_in_world(&mut self) -> (&mut Jobs, &mut World<'c, P>) {
        (&mut self.jobs, &mut self.world)
    }

    fn jobs_and_program(&mut self) -> (&mut Jobs, &mut Interpreter) {
        (&mut self.jobs, &mut self.program)
    }

    fn frames(&mut self) -> &mut Frames<'c, <P as Featured>::Step> {
        &mut self.frames
    }

    fn leaves_for_heights(&mut self, heights: [f64; 2]) {
        Features::<P>::leaves_for_heights(self, heights);
    }

    fn homes(&mut self, named: AxisSet, to: Recipient) -> Option<Outcome> {
        Features::<P>::homes(self, named, to)
    }

    fn extruders_count_anew(&mut self) {
        Features::<P>::extruders_count_anew(self);
    }
}
