//! The world around the sequences: the real motion and its feed, motors that go where their steps say, and
//! contacts that look at where the motors are. Time passes half a millisecond a rest.

use std::sync::atomic::AtomicU32;

use config::{MachineConfig, Pin};
use events::{EventRing, Slots};
use motion::queue::{StepEvent, StepQueue};
use motion::{Latch, Motion};
use thermal::HeatControl;
use units::{Actuator, Celsius, Micros, PerActuator, TICK_NANOSECONDS, Ticks, Volts};

use super::{BenchDrivers, Card, Line};
use crate::ports::{
    Ahead, Board, BoardInfo, Calendar, Clock, DateTime, DriversPort, EventLog, FilesPort, HeatPort, Input, InputLevels,
    Inputs, LaserPort, LightPort, MemoryReport, MotionPort, Network, PinPort, PinTaken, Rest, Start, StepTimes,
    Updates, Usb, Viewers, Wake, Workspace,
};
use crate::sessions::{Consoles, Inbox, SessionId, SessionProfile};
use crate::supervisor::{Supervisor, SupervisorPort};
use crate::tasks::{FeedTask, ReachedMark};

/// Time of a rest.
const SLOT: Ticks = Ticks(500_000 / TICK_NANOSECONDS as u64);
/// Machine time after which a test that still waits has failed.
const PATIENCE: Micros = Micros::from_seconds(1_200);

/// Tells from the true places of the motors, mm, whether a contact is operated.
type Contact = Box<dyn FnMut(&PerActuator<f64>) -> bool>;

/// The world as ports.
pub struct World {
    /// The card.
    pub card: Card,
    /// Other ends of the sessions' lines.
    pub line: Line,
    /// The motor drivers.
    pub bank: BenchDrivers,
    /// Watch over drivers and supplies.
    pub watch: Supervisor,
    /// Heat control.
    pub heaters: HeatControl,
    /// True places of the motors, mm.
    pub places: PerActuator<f64>,
    /// Supply of the motors, as measured.
    pub supply: Option<Volts>,
    /// Whether the motors' global enable line is on.
    pub motor_power: bool,
    planner: Motion,
    feed: FeedTask,
    queue: Box<StepQueue>,
    trigger: Latch,
    reached: ReachedMark,
    now: Ticks,
    forward: u8,
    step_mm: PerActuator<f64>,
    contacts: Vec<(Input, Contact)>,
    levels: InputLevels,
    log: (Box<Slots>, AtomicU32),
}

impl World {
    /// Makes the world of a machine whose motors stand at zero.
    #[must_use]
    pub fn new(config: &MachineConfig) -> Self {
        let mut step_mm = PerActuator([0.0; units::MAX_ACTUATORS]);
        config.actuators().for_each(|(motor, settings)| step_mm[motor] = 1.0 / settings.steps_per_mm);
        Self {
            card: Card::default(),
            line: Line::default(),
            bank: BenchDrivers::default(),
            watch: Supervisor::new(),
            heaters: HeatControl::new(),
            places: PerActuator([0.0; units::MAX_ACTUATORS]),
            supply: Some(Volts(24.0)),
            motor_power: false,
            planner: Motion::new(),
            feed: FeedTask::default(),
            queue: Box::new(StepQueue::new()),
            trigger: Latch::new(),
            reached: ReachedMark::new(),
            now: Ticks(0),
            forward: 0,
            step_mm,
            contacts: Vec::new(),
            levels: InputLevels::default(),
            log: (Box::new(Slots::new()), AtomicU32::new(0)),
        }
    }

    /// Wires an input to a contact, which is operated where `is_operated` says so of the motors' true places.
    pub fn wire_input(&mut self, input: Input, is_operated: impl FnMut(&PerActuator<f64>) -> bool + 'static) {
        self.contacts.push((input, Box::new(is_operated)));
        self.look(None);
    }

    /// Puts a motor truly there, mm, whatever its steps say.
    pub fn put(&mut self, motor: Actuator, mm: f64) {
        self.places[motor] = mm;
        self.look(None);
    }

    /// Plays the steps that are due by this time, each at its tick.
    fn play(&mut self, until: Ticks) {
        while let Some(event) = self.queue.front() {
            let ahead = event.at.wrapping_sub(self.now.0 as u32) as i32;
            if self.now.0.saturating_add_signed(i64::from(ahead)) > until.0 {
                break;
            }
            self.queue.advance();
            self.step(event);
            self.look(Some(event.at));
        }
    }

    fn step(&mut self, event: StepEvent) {
        self.forward = (self.forward | event.turning_forward()) & !event.turning_backward();
        for motor in Actuator::of_bits(event.stepping()) {
            let is_forward = self.forward & motor.bit() != 0;
            self.places[motor] += if is_forward { self.step_mm[motor] } else { -self.step_mm[motor] };
        }
    }

    /// Looks at all contacts. With a tick, the inputs that become active then are reported to the latch.
    fn look(&mut self, at: Option<u32>) {
        let mut levels = InputLevels::default();
        for (input, contact) in &mut self.contacts {
            levels = match (contact(&self.places), *input) {
                (true, input) => levels.with(input),
                (false, Input::Probe) => levels.with(Input::ProbeOpen),
                (false, _) => levels,
            };
        }
        let risen = levels.mask() & !self.levels.mask();
        self.levels = levels;
        if let Some(at) = at {
            self.report(risen, at);
        }
    }

    fn report(&self, inputs: u32, at: u32) {
        for number in (0..u32::BITS).filter(|number| inputs & 1 << number != 0) {
            self.trigger.report(number as u8, at, &self.queue);
        }
    }
}

impl Rest for World {
    fn rest(&mut self, _: Wake) {
        assert!(self.now() < PATIENCE, "a sequence waits for ever");
        self.look(Some(self.now.0 as u32));
        // The feed reads armed inputs: who was operated before arming gives no edge.
        self.report(self.levels.mask(), self.now.0 as u32);
        self.feed.run(self.now, &mut self.planner, &self.queue, &self.trigger, &self.reached);
        let until = Ticks(self.now.0 + SLOT.0);
        self.play(until);
        self.now = until;
    }
}

impl Clock for World {
    fn now(&self) -> Micros {
        Micros(self.now.nanoseconds() / 1_000)
    }
}

impl MotionPort for World {
    fn motion<R>(&mut self, f: impl FnOnce(&mut Motion) -> R) -> R {
        f(&mut self.planner)
    }

    fn latch(&self) -> &Latch {
        &self.trigger
    }
}

impl Ahead for World {
    type Workspace = Box<Workspace>;

    fn workspace(&mut self) -> Option<Box<Workspace>> {
        None
    }
}

impl HeatPort for World {
    fn heat<R>(&mut self, f: impl FnOnce(&mut HeatControl) -> R) -> R {
        f(&mut self.heaters)
    }

    fn run_heat_now(&mut self) {}
}

impl LaserPort for World {
    fn lock_laser(&mut self, _: bool) {}

    fn darken_laser(&mut self, _: bool) {}

    fn set_laser(&mut self, _: u16) {}

    fn look_at_laser(&mut self) -> bool {
        false
    }

    fn set_laser_frequency(&mut self, _: u32) {}
}

impl LightPort for World {
    fn send_to_strip(&mut self, _: usize, _: &[u8]) -> bool {
        true
    }
}

impl DriversPort for World {
    type Drivers = BenchDrivers;

    fn drivers<R>(&mut self, f: impl FnOnce(&mut BenchDrivers) -> R) -> R {
        f(&mut self.bank)
    }

    fn set_motor_power(&mut self, on: bool) {
        self.motor_power = on;
    }
}

impl SupervisorPort for World {
    fn supervisor<R>(&mut self, f: impl FnOnce(&mut Supervisor) -> R) -> R {
        f(&mut self.watch)
    }
}

impl Inputs for World {
    fn inputs(&self) -> InputLevels {
        self.levels
    }
}

impl PinPort for World {
    fn borrow_pin(&mut self, _: Pin, drive: Option<bool>) -> Result<bool, PinTaken> {
        Ok(drive.unwrap_or(false))
    }

    fn return_pin(&mut self, _: Pin) {}
}

impl Consoles for World {
    fn sessions(&self) -> u8 {
        self.line.sessions()
    }

    fn inbox(&self, session: SessionId) -> &Inbox {
        self.line.inbox(session)
    }

    fn profile(&self, session: SessionId) -> SessionProfile {
        self.line.profile(session)
    }

    fn write(&mut self, session: SessionId, bytes: &[u8]) -> usize {
        Consoles::write(&mut self.line, session, bytes)
    }
}

impl Board for World {
    fn wire(&mut self, _: &MachineConfig, _: &mut dyn FnMut(&str)) -> bool {
        true
    }

    fn voltage(&mut self, _: &str) -> Option<Volts> {
        self.supply
    }

    fn chip_celsius(&mut self) -> Option<Celsius> {
        None
    }

    fn set_led(&mut self, _: u8, _: bool) {}

    fn board(&self) -> BoardInfo {
        BoardInfo {
            mcu: "bench",
            board_id: 0,
            core_mhz: 400,
            version: "0",
            build_date: "-",
            start: Start::Asked,
            second_core_starts: false,
        }
    }

    fn memory(&self) -> MemoryReport {
        MemoryReport::default()
    }

    fn step_times(&self) -> StepTimes {
        StepTimes::default()
    }

    fn report_alive(&mut self) {}

    fn stop_for_debugger(&mut self) -> bool {
        false
    }

    fn request_reset(&mut self) {}
}

impl Usb for World {}

impl Network for World {}

impl Viewers for World {}

impl Updates for World {}

impl Calendar for World {
    fn date(&self) -> DateTime {
        DateTime::UNSET
    }

    fn set_date(&mut self, _: DateTime) -> bool {
        false
    }
}

impl EventLog for World {
    fn events(&self) -> EventRing<'_> {
        EventRing::new(&self.log.0, &self.log.1)
    }
}

impl FilesPort for World {
    type Files = Card;

    fn files<R>(&mut self, action: impl FnOnce(&mut Card) -> R) -> R {
        action(&mut self.card)
    }
}
