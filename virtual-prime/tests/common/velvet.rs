//! Velvet's own image on a board with a test's configuration, an operator at its console, and access to the
//! machine.

use std::ops::Range;
use std::path::PathBuf;

use config::BoardId;
use rigless::emulator::Host;
use sim::models::sd_card::{BlockWrite, SdCard, Traits};
use sim::models::tmc26x::Chip;
use sim::world::{Fault, TimedFault, World, WorldConfig};
use units::Actuator;
use virtual_prime::board::PrimeBoard;
use virtual_prime::console::Arrived;
use virtual_prime::instruments::Probe;
use virtual_prime::rtt::Probe as Rtt;
use virtual_prime::sd_image;
use virtual_prime::vm::Span;

use super::{Bench, FRAME_NS, MS, boot_watched, stacks};

/// The sample printer: Cartesian, one hot end, a bed, a part fan, switches at the minimum ends.
pub const CONFIG: &str = include_str!("../../../config/samples/cartesian.ini");
/// Milliseconds in a second.
pub const SECOND: u64 = 1_000;
/// End of the greeting: from here on the machine listens.
pub const PROMPT: &str = "Welcome to Smoothie\nok\n";
/// Time within which a healthy machine has greeted.
const BOOT_MS: u64 = 2 * SECOND;
/// Slices of time in which a wait runs the board, milliseconds.
const SLICE_MS: u64 = 5;

/// Returns the path of the image under test.
pub fn image() -> PathBuf {
    let named = std::env::var_os("VELVET_ELF");
    PathBuf::from(named.expect("VELVET_ELF does not name the firmware image: run these tests with `make test`"))
}

/// Content of the card slot.
enum Card {
    Nothing,
    /// A volume with the configuration and the files.
    Volume,
    Raw(Box<dyn Fn(Vec<u8>) -> Vec<u8>>),
}

/// Start conditions of a test.
pub struct Plan {
    config: String,
    files: Vec<(String, Vec<u8>)>,
    faults: Vec<TimedFault>,
    card: Card,
    elf: PathBuf,
    built_as: Option<String>,
    second_core: bool,
    watched: Vec<Range<u64>>,
    chip: Chip,
    traits: Traits,
    keeps_writes: bool,
    carriages: Vec<f64>,
    soaked: Vec<(&'static str, f64)>,
    faults_are_meant: bool,
    leaves_log: bool,
}

impl Plan {
    /// Returns the plan of the sample printer, without faults.
    pub fn new() -> Self {
        let files = Vec::new();
        Self {
            config: CONFIG.into(),
            files,
            faults: Vec::new(),
            card: Card::Volume,
            elf: image(),
            built_as: None,
            second_core: false,
            watched: Vec::new(),
            chip: Chip::Tmc2590,
            traits: Traits::default(),
            keeps_writes: false,
            carriages: Vec::new(),
            soaked: Vec::new(),
            faults_are_meant: false,
            leaves_log: false,
        }
    }

    /// Sets another make of card.
    pub const fn with_traits(mut self, traits: Traits) -> Self {
        self.traits = traits;
        self
    }

    /// Keeps a log of writes to the card, from power-on: [`Velvet::block_writes`].
    pub const fn keeping_writes(mut self) -> Self {
        self.keeps_writes = true;
        self
    }

    /// Places the carriages at power-on, mm, in the order of the motors.
    pub fn carriages(mut self, places: &[f64]) -> Self {
        self.carriages = places.to_vec();
        self
    }

    /// Sets the temperature of a heater at power-on, C.
    pub fn soaked(mut self, heater: &'static str, celsius: f64) -> Self {
        self.soaked.push((heater, celsius));
        self
    }

    /// Sets the board's driver chips.
    pub const fn with_drivers(mut self, chip: Chip) -> Self {
        self.chip = chip;
        self
    }

    /// Keeps a log of the image's writes to these addresses, from power-on.
    pub fn watching(mut self, addresses: Range<u64>) -> Self {
        self.watched.push(addresses);
        self
    }

    /// Sets the option bytes so that the second core starts.
    pub const fn with_second_core(mut self) -> Self {
        self.second_core = true;
        self
    }

    /// Replaces a piece of the configuration, which must contain it.
    #[track_caller]
    pub fn with(mut self, piece: &str, instead: &str) -> Self {
        assert!(self.config.contains(piece), "the configuration has no `{piece}`");
        self.config = self.config.replace(piece, instead);
        self
    }

    /// Replaces the whole configuration.
    pub fn config(mut self, text: &str) -> Self {
        self.config = text.into();
        self
    }

    /// Writes `[section] key = value`; without a value the line goes.
    #[track_caller]
    pub fn set(mut self, line: &str) -> Self {
        let (section, setting) = line.strip_prefix('[').and_then(|rest| rest.split_once("] ")).expect("[section] key");
        let (key, value) = setting.split_once('=').map_or((setting, None), |(key, value)| (key, Some(value.trim())));
        self.config = config::edit::apply(&self.config, config::edit::Edit { section, key: key.trim(), value });
        self
    }

    /// Builds the simulated machine for the configuration so far, without later changes.
    pub fn built(mut self) -> Self {
        self.built_as = Some(self.config.clone());
        self
    }

    /// Puts another text file on the card.
    pub fn file(mut self, name: &str, text: &str) -> Self {
        self.files.push((name.into(), text.into()));
        self
    }

    /// Puts another file on the card, from bytes.
    pub fn bytes(mut self, name: &str, content: Vec<u8>) -> Self {
        self.files.push((name.into(), content));
        self
    }

    /// Adds a fault, as `virtual-prime run --fault` takes it.
    pub fn fault(mut self, text: &str) -> Self {
        self.faults.push(TimedFault::parse(text).expect("a fault"));
        self
    }

    /// Leaves the card slot empty.
    pub fn without_card(mut self) -> Self {
        self.card = Card::Nothing;
        self
    }

    /// Makes the card's bytes from those of a good card.
    pub fn with_card(mut self, make: impl Fn(Vec<u8>) -> Vec<u8> + 'static) -> Self {
        self.card = Card::Raw(Box::new(make));
        self
    }

    /// Runs another firmware image.
    pub fn image(mut self, elf: PathBuf) -> Self {
        self.elf = elf;
        self
    }

    /// Lets the image meet a hard fault without ending the run.
    pub const fn meaning_faults(mut self) -> Self {
        self.faults_are_meant = true;
        self
    }

    /// Leaves the image's log unread.
    pub const fn leaving_log(mut self) -> Self {
        self.leaves_log = true;
        self
    }

    /// Switches the machine on and waits for its prompt.
    #[track_caller]
    pub fn start(self) -> Velvet {
        let mut velvet = self.held();
        velvet.hear_until(PROMPT, BOOT_MS);
        velvet
    }

    /// Returns the machine before its first instruction.
    pub fn held(self) -> Velvet {
        let built = self.built_as.as_ref().unwrap_or(&self.config);
        let id = if self.chip == Chip::Tmc2660 { BoardId::Prime2660 } else { BoardId::Prime2590 };
        let (machine, _) = config::parse(built.as_bytes(), id, &mut ());
        let mut world = WorldConfig::of(&machine, self.chip);
        for (motor, place) in world.actuators.iter_mut().zip(&self.carriages) {
            motor.start_mm = *place;
        }
        let mut board = PrimeBoard::new(world).expect("the board's tables are right");
        board.mcu.set_second_core(self.second_core);
        let mut on_card = self.files;
        on_card.insert(0, ("config.ini".to_owned(), self.config.into_bytes()));
        let volume = || sd_image::build(None, &on_card).expect("a volume");
        let content = match &self.card {
            Card::Nothing => None,
            Card::Volume => Some(volume()),
            Card::Raw(make) => Some(make(volume())),
        };
        let mut card = content.map(|content| SdCard::new(content).with(self.traits));
        if let Some(card) = card.as_mut().filter(|_| self.keeps_writes) {
            card.keep_writes();
        }
        board.insert(card);
        for (heater, celsius) in self.soaked {
            let mut world = board.world().lock();
            let heater = world.heater_index(heater).expect("a heater of this machine");
            world.soak(heater, celsius);
        }
        for fault in self.faults {
            let mut world = board.world().lock();
            let done = if fault.at_ns == 0 { world.inject(&fault.fault) } else { world.schedule(fault) };
            done.expect("a fault of this machine");
        }
        let probe = Probe { faults_are_meant: self.faults_are_meant, leaves_log: self.leaves_log, ..Probe::default() };
        let is_image = self.elf == image();
        Velvet { bench: boot_watched(&self.elf, board, self.watched, &probe), said: String::new(), is_image }
    }
}

/// A machine that is switched on.
pub struct Velvet {
    pub bench: Bench,
    said: String,
    /// Whether the machine runs the image under test, as it was built.
    is_image: bool,
}

impl Drop for Velvet {
    fn drop(&mut self) {
        if self.is_image && !std::thread::panicking() {
            let left = self.bench.vm.with(|stopped| stacks::left(stopped.host));
            left.flatten().into_iter().for_each(stacks::assert_enough);
        }
    }
}

impl Velvet {
    /// Returns all words from the debug console.
    pub fn said(&self) -> &str {
        &self.said
    }

    /// Returns the virtual time, milliseconds.
    pub const fn now_ms(&self) -> u64 {
        self.bench.vm.now_ns() / MS
    }

    /// Runs the board for so many milliseconds. Returns the words of that time.
    #[track_caller]
    pub fn hear(&mut self, ms: u64) -> String {
        let before = self.said.len();
        self.hear_for(ms * MS);
        self.said[before..].to_owned()
    }

    /// Runs the board for so many nanoseconds. Returns the words of that time, byte by byte.
    #[track_caller]
    pub fn hear_for(&mut self, nanoseconds: u64) -> Vec<Arrived> {
        let end = self.bench.vm.now_ns() + nanoseconds;
        assert_eq!(self.bench.vm.run_until(end), Span::Reached, "after: {}", self.said);
        let heard = self.bench.console.receive_timed();
        let bytes: Vec<u8> = heard.iter().map(|arrived| arrived.byte).collect();
        self.said.push_str(&String::from_utf8_lossy(&bytes));
        heard
    }

    /// Runs the board until its words contain these. Returns all words of that time.
    #[track_caller]
    pub fn hear_until(&mut self, words: &str, patience_ms: u64) -> String {
        let before = self.said.len();
        let end = self.now_ms() + patience_ms;
        while !self.said[before..].contains(words) {
            assert!(self.now_ms() < end, "no {words:?} within {patience_ms} ms; it said: {}", &self.said[before..]);
            self.hear(SLICE_MS);
        }
        self.said[before..].to_owned()
    }

    /// Sends these bytes, and runs the board until the last of them has arrived. Returns the instant of the
    /// arrival.
    #[track_caller]
    pub fn send_through(&mut self, bytes: &[u8]) -> u64 {
        self.bench.console.send(bytes);
        while self.bench.console.unsent() > 0 {
            self.hear_for(FRAME_NS);
        }
        self.bench.console.last_began_ns().expect("a byte went") + FRAME_NS
    }

    /// Types a line at the console.
    pub fn type_in(&mut self, line: &str) {
        self.bench.console.send(format!("{line}\n").as_bytes());
    }

    /// Types a line and waits for the end of the answer. Returns all words of that time.
    #[track_caller]
    pub fn ask(&mut self, line: &str, patience_ms: u64) -> String {
        self.type_in(line);
        let before = self.said.len();
        let end = self.now_ms() + patience_ms;
        // A line is answered by ok, or by an error message.
        let is_answered = |said: &str| said.contains("ok\n") || said.contains("error:") && said.ends_with('\n');
        while !is_answered(&self.said[before..]) {
            assert!(self.now_ms() < end, "no answer within {patience_ms} ms; it said: {}", &self.said[before..]);
            self.hear(SLICE_MS);
        }
        self.said[before..].to_owned()
    }

    /// Runs `work` on the simulated machine, to look at it or change it.
    pub fn world<R>(&mut self, work: impl FnOnce(&mut World) -> R) -> R {
        let world = self.bench.world();
        let mut world = world.lock();
        work(&mut world)
    }

    /// Runs `work` as the debug probe at the image's RTT.
    pub fn probe<R: Send + 'static>(&mut self, work: impl FnOnce(Rtt, &mut dyn Host) -> R + Send + 'static) -> R {
        let probe = Rtt::of(&image()).expect("an ELF file").expect("an image with RTT");
        self.bench.vm.with(move |stopped| work(probe, stopped.host)).expect("the run goes on")
    }

    /// Returns the level of a pin, by its name.
    pub fn level(&mut self, pin: &'static str) -> bool {
        let pin = virtual_prime::pins::pin(pin);
        self.bench.vm.with(move |stopped| stopped.session.board().level(pin)).expect("the run goes on")
    }

    /// Returns the result of a look at the card in the slot.
    pub fn card<R: Send + 'static>(&mut self, look: impl FnOnce(&SdCard) -> R + Send + 'static) -> R {
        let looked = self.bench.vm.with(|stopped| stopped.session.board().mcu.sdmmc.card().map(look));
        looked.flatten().expect("a card in the slot")
    }

    /// Returns the log of writes to the card, where it is kept.
    pub fn block_writes(&mut self) -> Vec<BlockWrite> {
        self.card(|card| card.writes().to_vec())
    }

    /// Injects a fault at this instant.
    #[track_caller]
    pub fn inject(&mut self, fault: &Fault) {
        self.world(|world| world.inject(fault)).expect("a fault of this machine");
    }

    /// Asserts that the words were said exactly once since power-on, and no other error or warning was.
    #[track_caller]
    pub fn assert_told_once(&self, words: &str) {
        let words = words.trim_end();
        assert_eq!(self.said.matches(words).count(), 1, "{words:?} in: {}", self.said);
        let trouble = |line: &&str| {
            let line = line.to_ascii_lowercase();
            ["error", "warning", "alarm"].iter().any(|word| line.contains(word)) && !line.starts_with('<')
        };
        let others: Vec<_> = self.said.lines().filter(|line| !line.contains(words)).filter(trouble).collect();
        assert!(others.is_empty(), "besides {words:?}: {others:?}");
    }

    /// Asserts that nothing heats, nothing moves, no motor has current, and the console answers.
    #[track_caller]
    pub fn assert_safe(&mut self) {
        // A halt takes the current off as soon as motion rests; the mean duty falls to zero within seconds.
        self.hear(500);
        let edges = self.world(|world| world.trace().total());
        for _ in 0..12 {
            self.hear(500);
            if self.duties().iter().all(|duty| *duty < 0.01) {
                break;
            }
        }
        assert!(self.duties().iter().all(|duty| *duty < 0.01), "heaters are driven: {:?}", self.duties());
        assert_eq!(self.world(|world| world.vfet_v()), 0.0, "the heaters' supply is on");
        assert_eq!(self.world(|world| world.trace().total()), edges, "something still moves");
        for motor in [Actuator::Alpha, Actuator::Beta, Actuator::Gamma, Actuator::Delta] {
            assert!(!self.world(|world| world.driver(motor as usize).drives()), "{} has current", motor.name());
        }
        self.type_in("version");
        self.hear_until("Prime", SECOND);
    }

    /// Asserts that the card can be read over the console.
    #[track_caller]
    pub fn assert_card_listed(&mut self, name: &str) {
        self.type_in("ls /sd");
        self.hear_until(name, SECOND);
    }

    fn duties(&mut self) -> [f64; 2] {
        self.world(|world| {
            ["hotend", "bed"].map(|name| world.heater_index(name).map_or(0.0, |index| world.heater_mean_duty(index)))
        })
    }
}
