//! A bench to run scenarios on: a machine in virtual time with a card, a console and faults to order.

mod outside;
pub mod topics;
mod visitors;

use std::fs;
use std::path::PathBuf;
use std::sync::atomic::{AtomicU32, Ordering};

use base::ports::StepTimes;
use base::sessions::SessionId;
use base::sessions::SessionProfile;
use sim::models::surface::Surface;
use sim::models::tmc26x::Chip;
use sim::runner::{CardState, Runner, Setup};
use sim::world::{TimedFault, World};
use units::Actuator;

/// The sample printer: Cartesian, one hotend, a bed, a part fan, switches at the minimum ends.
pub const CARTESIAN: &str = include_str!("../../config/samples/cartesian.ini");
/// The sample CoreXY printer.
pub const COREXY: &str = include_str!("../../config/samples/corexy.ini");
/// The sample linear delta.
pub const DELTA: &str = include_str!("../../config/samples/delta.ini");

/// The console scenarios talk on.
const CONSOLE: SessionId = SessionId(0);
/// Nanoseconds in a second.
const SECOND: f64 = 1e9;
/// A command that has not answered by then is stuck.
const PATIENCE_S: f64 = 600.0;

/// Starting conditions of a scenario.
#[derive(Clone, Debug)]
pub struct Plan {
    config: String,
    files: Vec<(String, String)>,
    folders: Vec<String>,
    faults: Vec<TimedFault>,
    card_state: CardState,
    built_as: Option<String>,
    visitors: Vec<SessionProfile>,
    chip: Chip,
}

impl Plan {
    /// Returns a plan for a machine of this configuration.
    #[must_use]
    pub fn new(config: &str) -> Self {
        Self {
            config: config.into(),
            files: Vec::new(),
            folders: Vec::new(),
            faults: Vec::new(),
            card_state: CardState::Good,
            built_as: None,
            visitors: Vec::new(),
            chip: Chip::Tmc2590,
        }
    }

    /// Returns whether the machine is on a board with TMC2660.
    #[must_use]
    pub fn is_tmc2660(&self) -> bool {
        self.chip == Chip::Tmc2660
    }

    /// Puts the machine on a board with TMC2660.
    #[must_use]
    pub fn on_tmc2660(mut self) -> Self {
        self.config = self.config.replace("tmc2590", "tmc2660").replace("sense_resistor = 50", "sense_resistor = 100");
        self.chip = Chip::Tmc2660;
        self
    }

    /// Adds a session whose other end is in memory: numbers from 2 on.
    #[must_use]
    pub fn visitor(mut self, profile: SessionProfile) -> Self {
        self.visitors.push(profile);
        self
    }

    /// Changes a piece of the configuration.
    ///
    /// # Panics
    /// When the configuration does not have it: then the scenario tests nothing.
    #[must_use]
    pub fn with(mut self, piece: &str, instead: &str) -> Self {
        assert!(self.config.contains(piece), "the configuration has no `{piece}`");
        self.config = self.config.replace(piece, instead);
        self
    }

    /// Adds a section at the end of the configuration.
    #[must_use]
    pub fn adding(mut self, text: &str) -> Self {
        self.config.push_str(text);
        self
    }

    /// Writes `[section] key = value`; without a value the line goes, and its default counts.
    ///
    /// # Panics
    /// When the text is no such line.
    #[must_use]
    pub fn set(mut self, line: &str) -> Self {
        let parts = line.strip_prefix('[').and_then(|rest| rest.split_once("] "));
        let (section, setting) = parts.unwrap_or_else(|| panic!("no setting: {line}"));
        let (key, value) = setting.split_once('=').map_or((setting, None), |(key, value)| (key, Some(value.trim())));
        self.config = config::edit::apply(&self.config, config::edit::Edit { section, key: key.trim(), value });
        self
    }

    /// Fixes the machine as built so far: later settings change only the configuration.
    #[must_use]
    pub fn built(mut self) -> Self {
        self.built_as = Some(self.config.clone());
        self
    }

    /// Puts a file on the card.
    #[must_use]
    pub fn file(mut self, name: &str, text: &str) -> Self {
        self.files.push((name.into(), text.into()));
        self
    }

    /// Puts an empty folder on the card.
    #[must_use]
    pub fn folder(mut self, name: &str) -> Self {
        self.folders.push(name.into());
        self
    }

    /// Orders a fault, `thermistor-open:hotend@30`.
    ///
    /// # Panics
    /// When the fault is misspelled.
    #[must_use]
    pub fn fault(mut self, text: &str) -> Self {
        self.faults.push(TimedFault::parse(text).unwrap_or_else(|reason| panic!("{reason}")));
        self
    }

    /// Sets a fault of the card.
    #[must_use]
    pub const fn card(mut self, state: CardState) -> Self {
        self.card_state = state;
        self
    }

    /// Starts the machine, checks that nothing is reported, and homes all axes.
    ///
    /// # Panics
    /// When it complains.
    #[must_use]
    pub fn start_homed(self) -> Bench {
        let mut bench = self.start();
        let greeting = bench.greeting();
        assert!(!["ERROR", "Error", "error", "WARNING"].iter().any(|word| greeting.contains(word)), "{greeting}");
        bench.run(&["G28"]);
        bench
    }

    /// Switches the machine on and lets it boot.
    ///
    /// # Panics
    /// When the card's folder cannot be made.
    #[must_use]
    pub fn start(self) -> Bench {
        static COUNT: AtomicU32 = AtomicU32::new(0);
        let number = COUNT.fetch_add(1, Ordering::Relaxed);
        let card = std::env::temp_dir().join(format!("velvet-scenario-{}-{number}", std::process::id()));
        fs::create_dir_all(&card).expect("a temporary folder");
        fs::write(card.join("config.ini"), &self.config).expect("a file in it");
        for (name, text) in &self.files {
            fs::write(card.join(name), text).expect("a file in it");
        }
        for name in &self.folders {
            fs::create_dir_all(card.join(name)).expect("a folder in it");
        }
        let Self { faults, card_state, built_as, visitors, chip, .. } = self;
        let setup = Setup { faults, card_state, built_as, visitors, chip, ..Setup::new(&card) };
        let runner = Runner::new(&setup).expect("faults of this machine");
        let mut bench = Bench { runner, card, greeting: String::new() };
        bench.greeting = bench.hear(0.2);
        bench
    }
}

/// A machine that is switched on.
#[derive(Debug)]
pub struct Bench {
    runner: Runner,
    card: PathBuf,
    greeting: String,
}

impl Drop for Bench {
    fn drop(&mut self) {
        // A folder left behind harms nobody.
        let _ = fs::remove_dir_all(&self.card);
    }
}

impl Bench {
    /// Returns the text said at boot.
    #[must_use]
    pub fn greeting(&self) -> &str {
        &self.greeting
    }

    /// Sends a line and returns the whole answer.
    ///
    /// # Panics
    /// When there is none.
    pub fn say(&mut self, line: &str) -> String {
        let answer = self.runner.command(line, (PATIENCE_S * SECOND) as u64);
        assert!(!answer.is_empty(), "no answer to {line}");
        answer
    }

    /// Sends a line on another console and returns the whole answer.
    ///
    /// # Panics
    /// When there is none.
    pub fn say_on(&mut self, console: SessionId, line: &str) -> String {
        // Text that came on the console before the line is no part of the answer.
        let _before = self.runner.read_from(console);
        let answer = self.runner.command_on(console, line, (PATIENCE_S * SECOND) as u64);
        assert!(!answer.is_empty(), "no answer to {line}");
        answer
    }

    /// Sends a line whose answer has no ok, and returns what is said within a tenth of a second.
    pub fn ask(&mut self, line: &str) -> String {
        self.type_in(line);
        self.type_in("\n");
        self.hear(0.1)
    }

    /// Sends lines that must all be answered by a plain ok.
    ///
    /// # Panics
    /// When one is not.
    pub fn run(&mut self, lines: &[&str]) {
        for line in lines {
            assert_eq!(self.say(line), "ok\n", "{line}");
        }
    }

    /// Types without waiting; realtime characters act at once.
    ///
    /// # Panics
    /// When the machine holds its senders back.
    pub fn type_in(&mut self, text: &str) {
        assert!(self.try_type(text), "the inbox is full");
    }

    /// Sends bytes that are no text on the debug console.
    ///
    /// # Panics
    /// When its inbox is full.
    pub fn send(&mut self, bytes: &[u8]) {
        assert!(self.runner.send_on(CONSOLE, bytes), "the inbox is full");
    }

    /// Sends bytes on any session.
    ///
    /// # Panics
    /// When its inbox is full.
    pub fn send_on(&mut self, session: SessionId, bytes: &[u8]) {
        assert!(self.runner.send_on(session, bytes), "the inbox is full");
    }

    /// As [`Self::type_in`], but text that does not fit is lost. Returns false when some was lost.
    pub fn try_type(&mut self, text: &str) -> bool {
        self.runner.type_on(CONSOLE, text)
    }

    /// Lets this much time pass and returns what was said.
    pub fn hear(&mut self, seconds: f64) -> String {
        let until = self.runner.now_ns() + (seconds * SECOND) as u64;
        self.runner.run_until(until);
        String::from_utf8_lossy(&self.runner.read_from(CONSOLE)).into_owned()
    }

    /// Lets this much time pass and returns the text said on any session.
    pub fn hear_on(&mut self, session: SessionId, seconds: f64) -> String {
        let until = self.runner.now_ns() + (seconds * SECOND) as u64;
        self.runner.run_until(until);
        String::from_utf8_lossy(&self.runner.read_from(session)).into_owned()
    }

    /// Lets time pass until something that was said contains this; returns all that was said.
    ///
    /// # Panics
    /// When it is not said in time.
    pub fn hear_until(&mut self, words: &str, patience_s: f64) -> String {
        let mut heard = String::new();
        let end = self.now_s() + patience_s;
        while !heard.contains(words) {
            assert!(self.now_s() < end, "`{words}` was not said, but: {heard}");
            heard.push_str(&self.hear(0.01));
        }
        heard
    }

    /// Returns the answer to `?`.
    pub fn status(&mut self) -> String {
        self.type_in("?");
        self.hear_until(">\n", 1.0)
    }

    /// Returns the virtual time, seconds.
    #[must_use]
    pub fn now_s(&self) -> f64 {
        self.runner.now_ns() as f64 / SECOND
    }

    /// Cuts the power and restores it: the card and the carriages are as they were left.
    ///
    /// # Panics
    /// When the machine does not start.
    pub fn cycle_power(&mut self) {
        self.start_again(World::carriage_mm);
    }

    /// Cycles the power; then the rotors go where the drivers' counters, which begin at zero, hold them.
    ///
    /// # Panics
    /// When the machine does not start.
    pub fn cycle_power_and_snap(&mut self) {
        self.start_again(World::carriage_after_power_up_mm);
    }

    fn start_again(&mut self, place: fn(&World, Actuator) -> Option<f64>) {
        let motors = [Actuator::Alpha, Actuator::Beta, Actuator::Gamma, Actuator::Delta];
        let carriages = motors.iter().map_while(|motor| self.world(|world| place(world, *motor))).collect();
        self.runner = Runner::new(&Setup { carriages, ..Setup::new(&self.card) }).expect("a machine");
        self.greeting = self.hear(0.5);
    }

    /// Returns the moves that the look-ahead queue holds, and those there is room for.
    pub fn queue_level(&mut self) -> (usize, usize) {
        self.runner.motion(|motion| motion.queue_level())
    }

    /// Returns the most block writes that a card would have made between two times that the machine said it
    /// was alive.
    #[must_use]
    pub fn most_unseen_writes(&self) -> u32 {
        self.runner.most_unseen_writes()
    }

    /// Sets the state of the card, faulty or good, from now on.
    pub fn set_card(&self, state: CardState) {
        self.runner.set_card_state(state);
    }

    /// Looks at the simulated machine, or changes it.
    pub fn world<R>(&self, f: impl FnOnce(&mut World) -> R) -> R {
        self.runner.world(f)
    }

    /// Lays a bed of this surface, from now on, also for the probe's contacts.
    pub fn lay(&self, surface: Surface) {
        let at_ns = (self.now_s() * SECOND) as u64;
        self.world(|world| world.lay(at_ns, surface));
    }

    /// Returns the true place of a motor's carriage, mm.
    ///
    /// # Panics
    /// When there is no such motor.
    #[must_use]
    pub fn carriage(&self, actuator: Actuator) -> f64 {
        self.world(|world| world.carriage_mm(actuator)).expect("a motor of this machine")
    }

    /// Returns the real temperature of a heater, degrees Celsius.
    ///
    /// # Panics
    /// When there is no such heater.
    #[must_use]
    pub fn celsius(&self, heater: &str) -> f64 {
        self.world(|world| world.heater_index(heater).map(|index| world.heater_c(index)))
            .expect("a heater of this machine")
    }

    /// Returns the mean duty of a heater's output over the last moments, 0 to 1.
    ///
    /// # Panics
    /// When there is no such heater.
    #[must_use]
    pub fn duty(&self, heater: &str) -> f64 {
        self.world(|world| world.heater_index(heater).map(|index| world.heater_mean_duty(index)))
            .expect("a heater of this machine")
    }

    /// Returns whether a heater is on, or is to be.
    #[must_use]
    pub fn heats(&self) -> bool {
        self.runner.heat(|heat| heat.heaters().any(|(_, heater)| heater.is_on() || heater.duty().0 > 0))
    }

    /// Returns whether moves are queued or under way.
    #[must_use]
    pub fn moves(&self) -> bool {
        self.runner.motion(|motion| !motion.is_idle())
    }

    /// Limits the machine's work to this many turns in half a millisecond, from now on.
    pub const fn set_turns(&mut self, turns: u32) {
        self.runner.set_turns(turns);
    }

    /// Returns whether a motor has current.
    #[must_use]
    pub fn is_energised(&self, actuator: Actuator) -> bool {
        self.world(|world| world.driver(actuator as usize).drives())
    }

    /// Stops or resumes the reading of the sensors' chips.
    pub fn hold_sensors(&mut self, stand: bool) {
        self.runner.hold_sensors(stand);
    }

    /// Keeps the step feed from its next runs, as many as given.
    pub fn block_feed(&mut self, runs: u32) {
        self.runner.block_feed(runs);
    }

    /// Makes the board report these step times from now on.
    pub fn pretend_step_times(&mut self, times: StepTimes) {
        self.runner.pretend_step_times(times);
    }

    /// Returns the content of a file on the card.
    #[must_use]
    pub fn read_card(&self, name: &str) -> Option<String> {
        fs::read_to_string(self.card.join(name)).ok()
    }

    /// Returns the bytes of a file on the card.
    #[must_use]
    pub fn read_card_bytes(&self, name: &str) -> Option<Vec<u8>> {
        fs::read(self.card.join(name)).ok()
    }

    /// Puts a file on the card, as another computer would.
    ///
    /// # Panics
    /// When the card's folder cannot be written.
    pub fn write_card(&self, name: &str, bytes: &[u8]) {
        fs::write(self.card.join(name), bytes).expect("the card's folder");
    }

    /// Asserts that nothing moves, nothing heats, no motor has current, and a command is refused.
    ///
    /// # Panics
    /// When one of these is not so.
    pub fn assert_safe(&mut self) {
        // The mean duty decays within a few seconds.
        self.hear(6.0);
        let edges = self.world(|world| world.trace().total());
        self.hear(1.0);
        assert_eq!(self.world(|world| world.trace().total()), edges, "something still moves");
        for heater in ["hotend", "bed"] {
            assert!(self.duty(heater) < 0.01, "{heater} still heats");
        }
        for actuator in [Actuator::Alpha, Actuator::Beta, Actuator::Gamma, Actuator::Delta] {
            assert!(!self.is_energised(actuator), "{} still has current", actuator.name());
        }
        assert_eq!(self.say("G1 X10 F600"), "!!\n");
    }
}
