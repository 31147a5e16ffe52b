//! The ports through which the machine sees the host.

use std::cell::RefMut;
use std::rc::Rc;

use base::ports::{
    Ahead, Board, BoardInfo, Calendar, Clock, DateTime, DriversPort, EventLog, Factors, FilesPort, HeatPort,
    InputLevels, Inputs, KeysRecord, LaserPort, LightPort, MemoryReport, MotionPort, Network, NetworkNews,
    NetworkReport, PasswordRecord, PinPort, PinTaken, Rest, Start, StepTimes, Updates, Usb, Viewers, Wake, Workspace,
};
use base::sessions::{Consoles, SessionProfile};
use base::sessions::{Inbox, SessionId};
use base::snapshot::Snapshot;
use base::supervisor::{Supervisor, SupervisorPort};
use config::{MachineConfig, NetworkConfig, Pin, Pull};
use corosensei::Yielder;
use events::EventRing;
use motion::{Latch, Motion};
use thermal::HeatControl;
use units::{Celsius, Micros, Volts};

use super::bank::{self, Bank};
use super::network::SimulatedNetwork;
use super::sensors::Sensors;
use super::shared::Shared;
use super::storage::Card;
use super::{pins, tasks};

/// Ports that the controller owns.
pub struct HostPorts<'y> {
    shared: Rc<Shared>,
    /// Way out of the executor's stack.
    yielder: &'y Yielder<(), Wake>,
}

impl<'y> HostPorts<'y> {
    /// Makes ports onto the shared state.
    #[must_use]
    pub(super) const fn new(shared: Rc<Shared>, yielder: &'y Yielder<(), Wake>) -> Self {
        Self { shared, yielder }
    }

    fn network(&self) -> RefMut<'_, SimulatedNetwork> {
        self.shared.network.borrow_mut()
    }
}

impl Rest for HostPorts<'_> {
    fn rest(&mut self, wake: Wake) {
        self.yielder.suspend(wake);
    }
}

impl Clock for HostPorts<'_> {
    fn now(&self) -> Micros {
        Micros(self.shared.simulation.now_ns.get() / 1_000)
    }
}

impl EventLog for HostPorts<'_> {
    fn events(&self) -> EventRing<'_> {
        self.shared.events()
    }
}

impl MotionPort for HostPorts<'_> {
    fn motion<R>(&mut self, f: impl FnOnce(&mut Motion) -> R) -> R {
        f(&mut self.shared.motion.borrow_mut())
    }

    fn latch(&self) -> &Latch {
        &self.shared.latch
    }
}

impl Ahead for HostPorts<'_> {
    type Workspace = Box<Workspace>;

    fn workspace(&mut self) -> Option<Box<Workspace>> {
        Some(Box::new(Workspace::new(Motion::new())))
    }
}

impl HeatPort for HostPorts<'_> {
    fn heat<R>(&mut self, f: impl FnOnce(&mut HeatControl) -> R) -> R {
        f(&mut self.shared.heat.borrow_mut())
    }

    /// The executor runs once a period of the heat task, so its next run is soon enough.
    fn run_heat_now(&mut self) {}
}

impl LaserPort for HostPorts<'_> {
    fn lock_laser(&mut self, is_locked: bool) {
        let simulation = &self.shared.simulation;
        simulation.world.borrow_mut().lock_laser(simulation.now_ns.get(), is_locked);
    }

    fn darken_laser(&mut self, is_dark: bool) {
        let simulation = &self.shared.simulation;
        simulation.world.borrow_mut().darken_laser(simulation.now_ns.get(), is_dark);
    }

    fn set_laser(&mut self, duty: u16) {
        let simulation = &self.shared.simulation;
        simulation.world.borrow_mut().set_laser(simulation.now_ns.get(), duty);
    }

    /// Nothing is ever late here, but where a test says so.
    fn look_at_laser(&mut self) -> bool {
        self.shared.simulation.world.borrow_mut().take_lapse()
    }

    fn set_laser_frequency(&mut self, _: u32) {
        self.set_laser(0);
    }
}

impl LightPort for HostPorts<'_> {
    fn send_to_strip(&mut self, strip: usize, bytes: &[u8]) -> bool {
        self.shared.simulation.world.borrow_mut().strip_bytes(strip, bytes);
        true
    }
}

impl DriversPort for HostPorts<'_> {
    type Drivers = Bank;

    fn drivers<R>(&mut self, f: impl FnOnce(&mut Bank) -> R) -> R {
        f(&mut self.shared.bank.borrow_mut())
    }

    fn set_motor_power(&mut self, on: bool) {
        self.shared.simulation.world.borrow_mut().motors_disable_pin(self.shared.simulation.now_ns.get(), !on);
    }
}

impl SupervisorPort for HostPorts<'_> {
    fn supervisor<R>(&mut self, f: impl FnOnce(&mut Supervisor) -> R) -> R {
        f(&mut self.shared.supervisor.borrow_mut())
    }
}

impl Inputs for HostPorts<'_> {
    fn inputs(&self) -> InputLevels {
        self.shared.levels.get()
    }
}

impl Consoles for HostPorts<'_> {
    fn sessions(&self) -> u8 {
        self.shared.profiles.len() as u8
    }

    fn inbox(&self, session: SessionId) -> &Inbox {
        // The machine asks only for existing sessions, of which there are two at least.
        self.shared.inboxes.get(usize::from(session.0)).unwrap_or(&self.shared.inboxes[0])
    }

    fn have_news(&self) -> bool {
        let news = self.shared.news.get();
        self.shared.news.set(false);
        news
    }

    fn profile(&self, session: SessionId) -> SessionProfile {
        self.shared.profiles.get(usize::from(session.0)).copied().unwrap_or(SessionProfile::SERIAL)
    }

    fn write(&mut self, session: SessionId, bytes: &[u8]) -> usize {
        if !self.inbox(session).is_open() {
            return bytes.len();
        }
        let mut sent = self.shared.sent.borrow_mut();
        sent.get_mut(usize::from(session.0)).map_or(bytes.len(), |sent| sent.take(bytes))
    }
}

impl PinPort for HostPorts<'_> {
    fn borrow_pin(&mut self, pin: Pin, drive: Option<bool>) -> Result<bool, PinTaken> {
        let wired = self.shared.wired.borrow();
        let user = wired.as_ref().and_then(|config| pins::user_of(config, pin));
        if let Some(user) = user {
            let name = Pin { inverted: false, open_drain: false, pull: Pull::Default, ..pin };
            let text = format!("{name} is used by {user}");
            return Err(text.as_str().try_into().unwrap_or_default());
        }
        // Nothing is wired to the pin: an input is as its resistor makes it.
        Ok(drive.unwrap_or((pin.pull != Pull::Down) != pin.inverted))
    }

    fn return_pin(&mut self, _pin: Pin) {
        // Nothing looks at the level.
    }
}

impl Usb for HostPorts<'_> {}

impl Network for HostPorts<'_> {
    fn join_network(&mut self, config: &NetworkConfig) -> Result<(), &'static str> {
        self.network().join(config);
        Ok(())
    }

    fn network_report(&self) -> Option<NetworkReport> {
        self.network().told()
    }

    fn take_network_news(&mut self) -> Option<NetworkNews> {
        self.network().news.pop_front()
    }

    fn set_password_record(&mut self, record: Option<&[u8]>) -> Result<(), &'static str> {
        self.network().set_record(record)
    }

    fn begin_password(&mut self, password: &[u8]) -> bool {
        self.network().begin_password(password)
    }

    fn take_password_record(&mut self) -> Option<PasswordRecord> {
        self.network().take_record()
    }

    fn take_keys_record(&mut self) -> Option<KeysRecord> {
        self.network().changed_keys.take()
    }

    fn set_keys_record(&mut self, record: &[u8]) {
        self.network().keys = Some(record.to_vec());
    }

    fn tell_kept(&mut self, kept: Result<(), &'static str>) {
        self.network().kept.push(kept);
    }
}

impl Viewers for HostPorts<'_> {
    fn wants_snapshot(&self) -> bool {
        self.network().is_viewed
    }

    fn show(&mut self, snapshot: &Snapshot) {
        self.network().shown = Some(snapshot.clone());
    }

    fn follows_path(&mut self) -> Option<bool> {
        let mut network = self.network();
        let draws = network.draws;
        network.draws = draws.filter(|draws| *draws);
        draws
    }

    fn add_to_path(&mut self, at: [f32; 3], lays: bool) {
        self.network().path.push((at, lays));
    }

    fn take_factors(&mut self) -> Option<Factors> {
        self.network().factors.take()
    }

    fn wants_heights(&self, number: u32) -> bool {
        self.network().heights.0 != number
    }

    fn show_heights(&mut self, number: u32, row: usize, heights: &[f32]) {
        let shown = &mut self.network().heights;
        if row == 0 {
            *shown = (number, Vec::new());
        }
        shown.1.push(heights.to_vec());
    }

    fn wants_macro(&mut self) -> Option<u16> {
        let network = self.network();
        network.wants_macros.then_some(network.macros.len() as u16)
    }

    fn show_macro(&mut self, number: u16, shown: Option<(&str, &str)>) {
        let mut network = self.network();
        assert_eq!(usize::from(number), network.macros.len(), "the macro that was asked for");
        match shown {
            Some((name, about)) => network.macros.push((name.to_owned(), about.to_owned())),
            None => network.wants_macros = false,
        }
    }

    fn begin_path(&mut self) {
        self.network().path.clear();
    }
}

impl Updates for HostPorts<'_> {}

impl Board for HostPorts<'_> {
    fn wire(&mut self, config: &MachineConfig, report: &mut dyn FnMut(&str)) -> bool {
        *self.shared.wired.borrow_mut() = Some(config.clone());
        let (bank, clean) = bank::configure(&self.shared.simulation, config, report);
        *self.shared.bank.borrow_mut() = bank;
        let sensors = Sensors::of(&self.shared.simulation, config);
        *self.shared.sensors.borrow_mut() = sensors;
        clean
    }

    fn voltage(&mut self, name: &str) -> Option<Volts> {
        tasks::voltage(&self.shared, name)
    }

    fn chip_celsius(&mut self) -> Option<Celsius> {
        Some(Celsius(tasks::CHIP_C))
    }

    fn set_led(&mut self, _index: u8, _on: bool) {
        // Nobody looks at a lamp here.
    }

    fn board(&self) -> BoardInfo {
        BoardInfo {
            mcu: "host",
            board_id: self.shared.board_id,
            core_mhz: 400,
            version: env!("CARGO_PKG_VERSION"),
            build_date: "-",
            start: Start::Asked,
            second_core_starts: false,
        }
    }

    fn memory(&self) -> MemoryReport {
        MemoryReport::default()
    }

    fn step_times(&self) -> StepTimes {
        self.shared.step_times.get()
    }

    fn report_alive(&mut self) {
        // The host has no watchdog: a machine that hangs here hangs the test. Writes of the time in which a
        // watchdog would hear nothing are counted.
        self.shared.card.borrow_mut().seen();
    }

    fn stop_for_debugger(&mut self) -> bool {
        // A debugger of this process stops it without being asked.
        false
    }

    fn request_reset(&mut self) {
        self.shared.reset_requested.set(true);
    }
}

impl Calendar for HostPorts<'_> {
    fn date(&self) -> DateTime {
        // Runs are repeatable: the clock starts with the machine, and counts from its last setting.
        let (set, since_ns) = self.shared.date.get();
        later(set, self.shared.simulation.now_ns.get().saturating_sub(since_ns) / 1_000_000_000)
    }

    fn set_date(&mut self, date: DateTime) -> bool {
        self.shared.date.set((date, self.shared.simulation.now_ns.get()));
        true
    }
}

/// Returns the date so many seconds later; a machine in a test does not see the end of a month.
fn later(date: DateTime, seconds: u64) -> DateTime {
    let total = u64::from(date.hour) * 3_600 + u64::from(date.minute) * 60 + u64::from(date.second) + seconds;
    let day = date.day + (total / 86_400) as u8;
    DateTime {
        day,
        hour: (total / 3_600 % 24) as u8,
        minute: (total / 60 % 60) as u8,
        second: (total % 60) as u8,
        ..date
    }
}

impl FilesPort for HostPorts<'_> {
    type Files = Card;

    fn files<R>(&mut self, action: impl FnOnce(&mut Card) -> R) -> R {
        action(&mut self.shared.card.borrow_mut())
    }
}
