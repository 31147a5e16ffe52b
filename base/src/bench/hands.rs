//! The machine in a sequence's hands, as crate `machine` gives it, around a [`World`].

use core::fmt::Arguments;

use config::{BoardId, MachineConfig};
use motion::{Latch, Motion, Refusal};
use program::State;
use thermal::HeatControl;
use units::{Actuator, Axis, AxisSet, Micros, Volts};

use super::{BenchDrivers, World};
use crate::axes::Axes;
use crate::bed::Bed;
use crate::failure::{Failure, Texts};
use crate::hands::Hands;
use crate::motion_config;
use crate::ports::{Board, Clock, FileHandle, InputLevels, Inputs, MotionPort, Rest, StorageError, Wake};
use crate::reason::Alarm;
use crate::safe_file::Draft;
use crate::safety::travel::Travel;
use crate::safety::{Event, Safety};
use crate::sessions::{Recipient, Reply, SessionId, Sessions};
use crate::supervisor::Supervisor;
use crate::tuning::Tuning;
use crate::wait::Waited;

/// Recipient that asks for every sequence.
const ASKS: Recipient = Recipient::Session(SessionId(0));

/// Deed of an operator, or of chance, in the middle of a sequence.
type Deed<X> = Box<dyn FnOnce(&mut BenchHands<X>)>;

/// Script that moves the probe: its key, its text, and whether it can be carried out.
type ProbeScript = Box<dyn FnMut(&str, &str) -> bool>;

/// The machine of a bench. `X` is what a crate's own sequences need beside it.
pub struct BenchHands<X> {
    /// The world around the machine.
    pub world: World,
    /// State of what the crate's own sequences need.
    pub extra: X,
    /// Watches over the machine, and its state.
    pub safety: Safety,
    /// State of the axes.
    pub motors: Axes,
    /// Settings that codes change.
    pub settings: Tuning,
    /// Where probing starts from.
    pub plate: Bed,
    /// Whether a file is being played.
    pub plays: bool,
    /// Whether the recipient goes by GRBL's numbers.
    pub is_grbl: bool,
    /// Rectangle around the job's objects.
    pub area: Option<[[f64; 2]; 2]>,
    /// Whether the recipient wants the sequence to end.
    pub stops: bool,
    /// What carries out the lines that move the probe; none: they do nothing.
    pub probe_script: Option<ProbeScript>,
    /// Height of a contact and what it reads from now on.
    pub contact: Option<(f64, f64)>,
    /// End of the last search along a line, and whether it found something.
    pub last_probe: Option<([f64; 3], bool)>,
    /// Result of the last wait for an input.
    pub input_result: Option<f64>,
    /// Alarm of the last halt.
    pub alarm: Option<Alarm>,
    /// Whether stalls are watched.
    pub watches_stalls: bool,
    config: &'static MachineConfig,
    texts: &'static Texts,
    sessions: Sessions,
    deeds: Vec<(Micros, Deed<X>)>,
}

impl<X: Default> BenchHands<X> {
    /// Makes a machine from the text of its configuration.
    ///
    /// # Panics
    /// When the text is no sound configuration.
    #[must_use]
    pub fn new(text: &str) -> Self {
        let mut findings = heapless::Vec::<config::Diagnostic, 8>::new();
        let (config, _) = config::parse(text.as_bytes(), BoardId::Prime2590, &mut findings);
        let wrong = findings.iter().find(|finding| finding.severity >= config::Severity::Error);
        assert!(wrong.is_none(), "{wrong:?}");
        Self::of(config)
    }

    /// Makes a machine of a configuration.
    ///
    /// # Panics
    /// When its motion cannot be configured.
    #[must_use]
    pub fn of(config: MachineConfig) -> Self {
        let config: &'static MachineConfig = Box::leak(Box::new(config));
        let mut world = World::new(config);
        let own = motion_config::motion_config(config).expect("an arm solution");
        world.motion(|motion| motion.configure(own)).expect("a sound motion");
        let mut sessions = Sessions::new();
        sessions.configure(&world.line);
        Self {
            extra: X::default(),
            safety: Safety::default(),
            motors: Axes::new(config),
            settings: Tuning::new(config),
            plate: Bed::new(config),
            plays: false,
            is_grbl: false,
            area: None,
            stops: false,
            probe_script: None,
            contact: None,
            last_probe: None,
            input_result: None,
            alarm: None,
            watches_stalls: true,
            texts: Box::leak(Box::new(Texts::new())),
            sessions,
            deeds: Vec::new(),
            config,
            world,
        }
    }
}

impl<X> BenchHands<X> {
    /// Takes what the recipient was told since the last call.
    pub fn heard(&mut self) -> String {
        let now = self.world.now();
        self.sessions.flush(&mut self.world.line, now);
        self.world.line.heard(0)
    }

    /// Takes what the other session was told since the last call.
    pub fn overheard(&mut self) -> String {
        self.heard();
        self.world.line.heard(1)
    }

    /// Returns the text of a failure.
    #[must_use]
    pub fn text_of(&self, failure: Failure) -> String {
        self.texts.of(failure).to_string()
    }

    /// Has something happen so much later, while the sequence waits.
    pub fn later(&mut self, after: Micros, deed: impl FnOnce(&mut Self) + 'static) {
        let at = self.world.now().plus(after);
        self.deeds.push((at, Box::new(deed)));
    }

    /// Declares the place of a machine whose X, Y and Z have a motor each, which truly stands there, mm.
    ///
    /// # Panics
    /// When it moves.
    pub fn stand_at(&mut self, place: [f64; 3]) {
        let mut position = self.position();
        for ((axis, motor), mm) in Axis::PRIMARY.into_iter().zip(Actuator::ALL).zip(place) {
            position[axis] = mm;
            self.world.put(motor, mm);
        }
        self.set_position(position).expect("standstill");
    }

    /// Has the operator hold the machine.
    pub fn hold(&mut self) {
        self.safety.apply(Event::Hold);
        self.world.motion(Motion::hold);
    }

    /// Has the operator let the machine go on.
    pub fn resume(&mut self) {
        self.safety.apply(Event::Resume);
        self.world.motion(Motion::resume);
    }

    fn tell(&mut self, to: Recipient, text: Arguments<'_>) {
        self.sessions.say(to, text);
        let now = self.world.now();
        self.sessions.flush(&mut self.world.line, now);
    }
}

impl<X> Hands<'static> for BenchHands<X> {
    type Ports = World;

    fn config(&self) -> &'static MachineConfig {
        self.config
    }

    fn texts(&self) -> &'static Texts {
        self.texts
    }

    fn tuning(&mut self) -> &mut Tuning {
        &mut self.settings
    }

    fn bed(&mut self) -> &mut Bed {
        &mut self.plate
    }

    fn drivers<R>(&mut self, f: impl FnOnce(&mut BenchDrivers) -> R) -> R {
        f(&mut self.world.bank)
    }

    fn axes(&mut self) -> &mut Axes {
        &mut self.motors
    }

    fn now(&self) -> Micros {
        self.world.now()
    }

    fn voltage(&mut self, name: &str) -> Option<Volts> {
        self.world.voltage(name)
    }

    fn motion<R>(&mut self, f: impl FnOnce(&mut Motion) -> R) -> R {
        self.world.motion(f)
    }

    fn heat<R>(&mut self, f: impl FnOnce(&mut HeatControl) -> R) -> R {
        f(&mut self.world.heaters)
    }

    fn supervisor<R>(&mut self, f: impl FnOnce(&mut Supervisor) -> R) -> R {
        f(&mut self.world.watch)
    }

    fn latch(&self) -> &Latch {
        self.world.latch()
    }

    fn watch_stalls(&mut self, yes: bool) {
        self.watches_stalls = yes;
    }

    fn inputs(&self) -> InputLevels {
        self.world.inputs()
    }

    fn storage(&mut self) -> &mut World {
        &mut self.world
    }

    fn state(&self) -> State {
        self.safety.state()
    }

    fn speaks_grbl(&self) -> bool {
        self.is_grbl
    }

    fn is_playing(&self) -> bool {
        self.plays
    }

    fn has_job(&self) -> bool {
        self.plays
    }

    fn objects_area(&self) -> Option<[[f64; 2]; 2]> {
        self.area
    }

    fn say(&mut self, text: Arguments<'_>) {
        self.tell(ASKS, text);
    }

    fn report(&mut self, text: Arguments<'_>) {
        self.tell(ASKS, text);
    }

    fn announce(&mut self, text: Arguments<'_>) {
        self.tell(Recipient::All, text);
    }

    fn reply(&mut self) -> Reply<'_> {
        Reply::new(&mut self.sessions, ASKS)
    }

    fn stop_requested(&mut self) -> bool {
        core::mem::take(&mut self.stops)
    }

    fn is_let_go(&mut self) -> bool {
        self.stop_requested()
    }

    fn can_be_stopped(&self) -> bool {
        true
    }

    fn wait(&mut self, wake: Wake) -> Waited {
        let now = self.world.now();
        while let Some(due) = self.deeds.iter().position(|(at, _)| *at <= now) {
            let (_, deed) = self.deeds.remove(due);
            deed(self);
        }
        self.world.rest(wake);
        match self.safety.state() {
            _ if self.safety.is_halted() => Waited::Halted,
            State::Hold | State::Door => Waited::Held,
            _ => Waited::Free,
        }
    }

    fn read_ahead(&mut self, _: FileHandle) {}

    fn card_at_rest(&mut self) {}

    fn put_in_place(&mut self, draft: Draft<World>) -> Result<(), StorageError> {
        draft.finish(&mut self.world)
    }

    fn card_has_kept(&mut self) -> Result<(), StorageError> {
        Ok(())
    }

    fn leaves_wait(&mut self) -> bool {
        false
    }

    fn begin_wait(&mut self) {}

    fn wait_is_over(&self) -> bool {
        false
    }

    fn is_ended(&self) -> bool {
        false
    }

    fn wait_for(&mut self, time: Micros) -> Result<(), Failure> {
        let since = self.now();
        while self.now().since(since) < time {
            self.wait(Wake::Time).unless_halted()?;
        }
        Ok(())
    }

    fn standstill(&mut self) -> Result<(), Failure> {
        self.world.motion(Motion::flush);
        while !self.world.motion(|motion| motion.is_idle()) {
            self.wait(Wake::Time).unless_halted()?;
        }
        self.safety.apply(Event::Drained);
        if self.safety.is_halted() { Err(Failure::HALTED) } else { Ok(()) }
    }

    fn drain(&mut self) {}

    fn run_probe_script(&mut self, key: &str, script: &str) -> Result<(), Failure> {
        let done = self.probe_script.as_mut().is_none_or(|carry_out| carry_out(key, script));
        self.wait(Wake::Time).unless_halted()?;
        if done { Ok(()) } else { Err(self.texts.because("the script broke off")) }
    }

    fn travel(&mut self) -> &Travel {
        self.safety.travel.up_to_date(self.config, &self.settings)
    }

    fn may_go_over(&mut self, [x, y]: [f64; 2]) -> Result<(), Failure> {
        let here = self.position();
        let mut there = here;
        (there[Axis::X], there[Axis::Y]) = (x, y);
        let homed = self.motors.homed();
        let checked = self.travel().check(&here, &there, homed);
        checked.map_err(|out| out.failure(self.texts, self.config))
    }

    fn submit(&mut self, request: motion::Move) -> Result<(), Failure> {
        self.enable_motors()?;
        loop {
            match self.world.motion(|motion| motion.submit(&request)) {
                Ok(()) => break,
                Err(Refusal::Full | Refusal::Stopping) => self.wait(Wake::Any).unless_halted()?,
                Err(refusal) => return Err(self.texts.alarm(format_args!("{refusal}"))),
            }
        }
        self.safety.apply(Event::Started);
        Ok(())
    }

    fn enable_motors(&mut self) -> Result<(), Failure> {
        let now = self.world.now();
        self.motors.enable(self.texts, &mut self.world, self.config, &self.settings, now)
    }

    fn all_homed(&self) -> bool {
        let able = Axis::ALL.into_iter().filter(|axis| self.config.homing_endstop(*axis).is_some());
        self.motors.homed().has_all(AxisSet::collect(able))
    }

    fn mark_homed(&mut self, axes: AxisSet) {
        self.motors.mark_homed(axes);
    }

    fn apply(&mut self, event: Event) -> bool {
        self.safety.apply(event)
    }

    fn halt(&mut self, alarm: Alarm, why: Arguments<'_>) {
        let now = self.world.now();
        self.alarm = Some(alarm);
        self.safety.halt(now);
        self.world.motion(Motion::stop);
        self.announce(why);
    }

    fn suspend_limits(&mut self) {
        self.safety.limits.suspend(self.world.latch(), self.world.now());
    }

    fn search_begins(&mut self) {
        self.safety.limits.search_begins();
    }

    fn search_ends(&mut self) {
        self.safety.limits.search_ends(self.world.latch(), self.world.now());
    }

    fn declare_homed(&mut self, axes: AxisSet) {
        self.motors.mark_homed(axes);
        self.motors.stray(axes);
    }

    fn end_suspension_without_place(&mut self) {}

    fn read_contact(&mut self, machine_z: f64, reads: f64) {
        self.contact = Some((machine_z, reads));
    }

    fn set_input_result(&mut self, result: f64) {
        self.input_result = Some(result);
    }

    fn set_last_probe(&mut self, place: [f64; 3], found: bool) {
        self.last_probe = Some((place, found));
    }
}
