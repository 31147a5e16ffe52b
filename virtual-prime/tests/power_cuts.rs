//! The power goes at every block write of a job with a journal, and a board that knows nothing but the card
//! is switched on: its offer is right or absent, never wrong, and the part is the same.
//!
//! The job is made once, on a card that notes its writes. Runs of a board are repeatable, so the writes
//! before a cut and the places of the carriages then are known without making it again.
//!
//! Quick share in `make test`; every cut with `make faults`, which writes a page to the folder `FAULTS_OUT`.

use std::fmt::Write as _;
use std::sync::OnceLock;

use crate::common::MS;
use crate::common::print::{Carriages, Laid, farthest};
use crate::common::velvet::{Plan, SECOND, Velvet};
use sim::models::sd_card::{BLOCK, BlockWrite};
use sim::trace::StepEdge;
use sim::world::Fault;
use virtual_prime::sd_image;

/// Width of a bead, mm: filament that is laid anew lies within it.
const BEAD: f64 = 0.45;
/// Difference in height below which places are in the same layer, mm.
const SAME_Z: f64 = 0.03;
/// Time after its acknowledgement during which a card may lose a write: the write timeout of high-capacity
/// cards (Physical Layer specification, section 4.6.2.2).
const UNKEPT_NS: u64 = 250 * MS;
/// Time for heating, homing and the rest of the part, ms.
const PATIENCE: u64 = 300 * SECOND;
const OFFER: &str = "a job was interrupted: ";

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Format {
    Fat16,
    Fat32,
}

/// State of a write when the power goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Cut {
    /// The write is kept.
    Kept,
    /// The write's first half is new, the rest is old.
    Torn,
    /// The write was acknowledged, and is lost; the machine has gone on meanwhile.
    Lost,
    /// The write is kept, and the machine has gone on until just before the next write.
    Later,
}

const CUTS: [Cut; 4] = [Cut::Kept, Cut::Torn, Cut::Lost, Cut::Later];

/// Returns two layers of two squares each, near the switches.
fn part() -> String {
    let mut text = String::from("; a part\nM140 S27\nM109 S40\nM190 S27\nG28\nG90\nG21\nM83\n");
    for layer in 1..=2 {
        let _ = writeln!(text, "G1 Z{:.2} F600\nM106 S{}", 0.3 * f64::from(layer), 80 * layer);
        for (x, y) in [(3.0, 3.0), (14.0, 6.0)] {
            let _ = writeln!(text, "G0 X{x} Y{y} F9000");
            for (to_x, to_y) in [(8.0, 0.0), (8.0, 8.0), (0.0, 8.0), (0.0, 0.0)] {
                let _ = writeln!(text, "G1 X{} Y{} E0.4 F1200", x + to_x, y + to_y);
            }
        }
    }
    text + "M107\nM104 S0\nM140 S0\nG1 Z3 F600\n"
}

/// Supply voltage below which the job is noted, volts.
const NOTED_VOLTS: f64 = 20.0;

fn plan() -> Plan {
    let settings = [
        "power_loss = true".to_owned(),
        "power_loss_period = 1".to_owned(),
        "power_loss_lift = 1".to_owned(),
        format!("power_loss_motor_volts = {NOTED_VOLTS}"),
    ];
    settings.iter().fold(Plan::new(), |plan, line| plan.set(&format!("[player] {line}")))
}

/// Start position, not far from the switches, so that homing is short, mm.
const START: [f64; 4] = [4.0, 4.0, 2.0, 0.0];

/// A job that was made without a power cut.
struct Whole {
    card: Vec<u8>,
    writes: Vec<BlockWrite>,
    edges: Vec<StepEdge>,
    laid: Laid,
    /// Start and end of the job, nanoseconds.
    begun: u64,
    ended: u64,
}

fn places(velvet: &mut Velvet) -> Vec<f64> {
    use units::Actuator::{Alpha, Beta, Delta, Gamma};
    velvet.world(|world| [Alpha, Beta, Gamma, Delta].map(|motor| world.carriage_mm(motor).expect("a motor")).to_vec())
}

impl Whole {
    fn make(format: Format) -> Self {
        let card = move |files: Vec<u8>| match format {
            Format::Fat32 => files,
            Format::Fat16 => {
                let files =
                    ["config.ini", "job.g"].map(|name| (name.into(), sd_image::read(&files, name).expect(name)));
                sd_image::build_fat16(&files).expect("a volume")
            }
        };
        let mut held = plan().file("job.g", &part()).with_card(card).keeping_writes().carriages(&START).held();
        let card = held.card(|card| card.content().to_vec());
        held.hear_until(crate::common::velvet::PROMPT, 2 * SECOND);
        let begun = held.bench.vm.now_ns();
        held.type_in("play /sd/job.g -t");
        hear_any(&mut held, &["Done printing file"]);
        let ended = held.bench.vm.now_ns();
        // The last writes come after the job's end.
        held.hear(SECOND);
        let mut whole = Self { card, writes: held.block_writes(), edges: Vec::new(), laid: Laid::new(), begun, ended };
        whole.edges = held.world(|world| world.trace_mut().take());
        let end = whole.until(u64::MAX);
        let really = places(&mut held);
        assert!(end.places().iter().zip(&really).all(|(a, b)| (a - b).abs() < 1e-6), "{:?} {really:?}", end.places());
        whole.laid = end.laid().clone();
        whole
    }

    /// Returns the carriages at this time.
    fn until(&self, time_ns: u64) -> Carriages {
        let mut carriages = Carriages::new(&START);
        self.edges.iter().take_while(|edge| edge.time_ns <= time_ns).for_each(|edge| carriages.step(edge));
        carriages
    }

    /// Returns the card after a cut at this write, and the instant of the cut.
    fn cut(&self, number: usize, cut: Cut) -> (Vec<u8>, u64) {
        let (mut card, write) = (self.card.clone(), &self.writes[number]);
        for write in &self.writes[..number] {
            put(&mut card, write, BLOCK);
        }
        put(
            &mut card,
            write,
            match cut {
                Cut::Kept | Cut::Later => BLOCK,
                Cut::Torn => BLOCK / 2,
                Cut::Lost => 0,
            },
        );
        let next = self.writes.get(number + 1).map_or(write.at_ns + UNKEPT_NS, |next| next.at_ns - 1);
        (
            card,
            match cut {
                Cut::Kept | Cut::Torn => write.at_ns,
                Cut::Lost => next.min(write.at_ns + UNKEPT_NS),
                Cut::Later => next,
            },
        )
    }
}

fn put(card: &mut [u8], write: &BlockWrite, bytes: usize) {
    let at = write.block as usize * BLOCK;
    card[at..at + bytes].copy_from_slice(&write.bytes[..bytes]);
}

/// Result of a cut.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Outcome {
    /// Nothing was offered, and nothing had to be.
    Absent,
    /// The job was resumed; `told`: a person had to say the height of Z. `seam`: length of filament laid
    /// twice, mm. `off`: greatest difference of the two parts, mm.
    Resumed { told: bool, seam: f64, off: f64 },
}

/// Switches on a board with this card, its carriages as they were left.
fn after(whole: &Whole, what: &str, left: &Carriages, card: Vec<u8>, leaves_no_offer: bool) -> Outcome {
    let mut velvet = plan().with_card(move |_| card.clone()).carriages(left.places()).start();
    velvet.hear(100);
    assert_eq!(velvet.world(|world| world.trace().total()), 0, "{what}: it moves by itself");
    if !velvet.said().contains(OFFER) {
        velvet.type_in("M1000");
        velvet.hear_until("no job was interrupted", SECOND);
        let (laid, all) = (left.laid().len(), whole.laid.len());
        assert!(laid < all / 10 || laid + 5 > all, "{what}: {laid} of {all} pieces were laid, and nothing is offered");
        return Outcome::Absent;
    }
    velvet.type_in("M1000");
    let said = hear_any(&mut velvet, &[" heats to ", "// up to Z", "Z may be anywhere"]);
    let told = said.split_once("Z may be anywhere from ").map(|(_, range)| range.to_owned());
    if let Some(range) = &told {
        // The cut came on the way to another height: a person tells the height of Z.
        let mut ends = range.split([' ', ':']).filter_map(|word| word.parse::<f64>().ok());
        let (least, most) = ends.next().zip(ends.next()).expect("a range");
        let z = left.places()[2];
        assert!((least - 0.02..=most + 0.02).contains(&z), "{what}: Z {z} is not from {least} to {most}");
        velvet.type_in(&format!("M1000 Z{z:.3}"));
    }
    let said = hear_any(&mut velvet, &["Done printing file"]);
    assert!(said.contains("the job goes on"), "{what}: {said}");
    velvet.hear(SECOND);
    let edges = velvet.world(|world| world.trace_mut().take());
    let mut second = Carriages::new(left.places());
    edges.iter().for_each(|edge| second.step(edge));
    let all: Laid = left.laid().iter().chain(second.laid()).copied().collect();
    let (missing, surplus) = (farthest(&whole.laid, &all, SAME_Z), farthest(&all, &whole.laid, SAME_Z));
    assert!(
        missing < BEAD && surplus < BEAD,
        "{what}: {missing} mm are missing, {surplus} mm too much: {}",
        velvet.said()
    );
    assert!(
        (second.places()[2] - whole.until(u64::MAX).places()[2]).abs() < SAME_Z,
        "{what}: it ends at another height"
    );
    assert_eq!(velvet.bench.vm.complaints(), Vec::<String>::new());
    let filament = left.laid().len() + second.laid().len() - whole.laid.len();
    let seam = filament as f64 * crate::common::print::GRAIN_MM;
    let outcome = Outcome::Resumed { told: told.is_some(), seam, off: missing.max(surplus) };
    if !leaves_no_offer {
        return outcome;
    }
    let card = velvet.card(|card| card.content().to_vec());
    let third = plan().with_card(move |_| card.clone()).carriages(second.places()).start();
    assert!(!third.said().contains(OFFER), "{what}: a finished job leaves an offer");
    outcome
}

/// Runs the board until one of these is said. Returns all words of that time.
fn hear_any(velvet: &mut Velvet, words: &[&str]) -> String {
    let mut said = String::new();
    let end = velvet.now_ms() + PATIENCE;
    while !words.iter().any(|words| said.contains(words)) {
        assert!(velvet.now_ms() < end, "none of {words:?} was said, but: {said}");
        said += &velvet.hear(100);
    }
    said
}

/// Returns the purpose of a write.
fn purpose(write: &BlockWrite) -> &'static str {
    // The first bytes are the journal's mark, its version, and the kind of block.
    match (write.bytes.get(..4), write.bytes.get(5)) {
        (Some(b"VPLJ"), Some(1)) => "journal: file",
        (Some(b"VPLJ"), Some(2)) => "journal: beginning",
        (Some(b"VPLJ"), Some(3)) => "journal: entry",
        (Some(b"VPLJ"), Some(4)) => "journal: entry, at rest",
        (Some(b"VPLJ"), Some(_)) => "journal: nothing to go on with",
        _ => "another file, a directory or a table",
    }
}

/// Cuts of a job, with statistics of their results.
struct Trial<'a> {
    whole: &'a Whole,
    format: Format,
    page: String,
    absent: u32,
    resumed: u32,
    asked: u32,
    seam: f64,
    off: f64,
}

impl<'a> Trial<'a> {
    fn new(whole: &'a Whole, format: Format) -> Self {
        let in_job = whole.writes.iter().filter(|write| (whole.begun..whole.ended).contains(&write.at_ns)).count();
        let page = format!(
            "## {format:?}: {} block writes, {in_job} of them while the job is played\n\n\
             | write | for | power goes at | and it is | what comes of it |\n|--:|---|--:|---|---|\n",
            whole.writes.len()
        );
        Self { whole, format, page, absent: 0, resumed: 0, asked: 0, seam: 0.0, off: 0.0 }
    }

    fn cut(&mut self, number: usize, cut: Cut) {
        let (card, at_ns) = self.whole.cut(number, cut);
        let (purpose, time) = (purpose(&self.whole.writes[number]), at_ns as f64 / 1e9);
        let what = format!("{:?}, write {number} ({purpose}) at {time:.3} s, {cut:?}", self.format);
        let words = match after(self.whole, &what, &self.whole.until(at_ns), card, cut == Cut::Kept) {
            Outcome::Absent => {
                self.absent += 1;
                "nothing to go on with".to_owned()
            }
            Outcome::Resumed { told, seam, off } => {
                (self.resumed, self.asked) = (self.resumed + 1, self.asked + u32::from(told));
                (self.seam, self.off) = (self.seam.max(seam), self.off.max(off));
                let told = if told { ", Z was asked for" } else { "" };
                format!("gone on with{told}; {seam:.1} mm twice, {off:.2} mm off")
            }
        };
        println!("{what}: {words}");
        let _ = writeln!(self.page, "| {number} | {purpose} | {time:.3} s | {cut:?} | {words} |");
    }

    /// Returns the page with the results.
    fn end(mut self) -> String {
        let _ = writeln!(
            self.page,
            "\n{} cuts: nothing to go on with after {}, gone on with after {}, of which {} asked where Z is. At most {:.1} mm were \
             laid twice, and no place of the one part is farther than {:.2} mm from the other.\n",
            self.absent + self.resumed,
            self.absent,
            self.resumed,
            self.asked,
            self.seam,
            self.off
        );
        assert!(self.resumed > 0, "{}", self.page);
        self.page
    }
}

/// Returns the job on a small card, which is made once for both tests.
fn on_a_small_card() -> &'static Whole {
    static WHOLE: OnceLock<Whole> = OnceLock::new();
    WHOLE.get_or_init(|| Whole::make(Format::Fat16))
}

/// Tries only one of the worst kinds of cut, in the middle of the job; `make faults` has every one.
#[test]
fn a_part_is_the_same_after_a_write_that_was_lost() {
    let mut trial = Trial::new(on_a_small_card(), Format::Fat16);
    let entries: Vec<usize> = (0..trial.whole.writes.len())
        .filter(|number| purpose(&trial.whole.writes[*number]) == "journal: entry")
        .collect();
    trial.cut(entries[entries.len() * 5 / 8], Cut::Lost);
    println!("{}", trial.end());
}

/// Writes the result of each cut to the folder `FAULTS_OUT`, and returns the sum of them.
fn every_cut(format: Format, cuts: &[Cut]) -> String {
    let whole = Whole::make(format);
    let mut trial = Trial::new(&whole, format);
    let first = std::env::var("FAULTS_FROM").map_or(0, |number| number.parse().expect("a number"));
    for number in first..trial.whole.writes.len() {
        // Before anything is laid, a card that loses a write is the same as a cut before the write.
        let is_entry = purpose(&trial.whole.writes[number]).starts_with("journal: entry");
        for cut in cuts.iter().filter(|cut| is_entry || matches!(cut, Cut::Kept | Cut::Torn)) {
            trial.cut(number, *cut);
        }
    }
    let page = trial.end();
    if let Some(folder) = std::env::var_os("FAULTS_OUT") {
        let name = format!("power-cuts-{format:?}.md").to_lowercase();
        std::fs::write(std::path::Path::new(&folder).join(name), &page).expect("the page");
    }
    page.trim_end().rsplit("\n\n").next().unwrap_or_default().to_owned()
}

/// Cuts every write of a large card, in every way.
pub fn of_a_large_card() -> String {
    every_cut(Format::Fat32, &CUTS)
}

/// Cuts every write of a small card, kept and torn.
pub fn of_a_small_card() -> String {
    every_cut(Format::Fat16, &[Cut::Kept, Cut::Torn])
}

/// Pins of the sample printer that a falling supply is to switch off: the heaters, and the switch of their
/// supply.
const HEATERS: [&str; 3] = ["PE0", "PE3", "PD7"];
/// Slope of the falling supply: 4 A out of 10 mF. A quarter of that is in the board's and a supply's own
/// capacitors.
const FALL_V_PER_MS: f64 = 0.4;
/// Voltage below which the board's regulators end, and the drivers lock themselves out (TMC2590 data sheet: 8
/// V at most).
const GONE_VOLTS: f64 = 8.0;

/// Lets both supplies fall while a job prints: heaters off, motors braked, the job noted, in this order and
/// before the voltage is gone; and the next board goes on from there.
#[test]
fn a_supply_that_falls_is_noted_before_it_is_gone() {
    let mut velvet = plan().file("job.g", &part()).keeping_writes().carriages(&START).start();
    velvet.type_in("play /sd/job.g");
    // The supply falls in the second layer, in the middle of a line: a layer takes 3.2 mm of filament.
    while velvet.world(|world| world.carriage_mm(units::Actuator::Delta)).is_none_or(|filament| filament < 3.9) {
        velvet.hear(20);
    }
    // The hot end is full on, so that its pin shows an edge.
    velvet.type_in("M104 S200");
    velvet.hear(100);
    crate::common::machine::watch(&mut velvet, &HEATERS);
    crate::common::machine::changes(&mut velvet);
    let (begins_ns, mut volts, mut crossed_ns) = (velvet.bench.vm.now_ns(), 24.0, 0);
    let writes_before = velvet.block_writes().len();
    while volts > GONE_VOLTS {
        volts -= FALL_V_PER_MS;
        velvet.inject(&Fault::MotorSupply(volts));
        velvet.inject(&Fault::FetSupply(volts));
        if volts < NOTED_VOLTS && crossed_ns == 0 {
            crossed_ns = velvet.bench.vm.now_ns();
        }
        velvet.hear(1);
    }
    let gone_ns = velvet.bench.vm.now_ns();
    let ms = |at_ns: u64| at_ns.saturating_sub(crossed_ns) as f64 / 1e6;
    let changes = crate::common::machine::changes(&mut velvet);
    let off_ns = HEATERS.map(|name| {
        let pin = crate::common::machine::pin(name);
        let last = changes.iter().filter(|change| change.pin == pin).last();
        assert!(!velvet.level(name), "{name} is on");
        last.map_or(0, |change| change.at_ns)
    });
    let edges = velvet.world(|world| world.trace_mut().take());
    let mut left = Carriages::new(&START);
    edges.iter().for_each(|edge| left.step(edge));
    let last_step_ns = edges.last().expect("it printed").time_ns;
    let notes: Vec<_> = velvet.block_writes()[writes_before..].to_vec();
    println!(
        "from {NOTED_VOLTS} V on, falling by {FALL_V_PER_MS} V/ms: heaters off after {:.2} ms, motors at rest after {:.2} ms, \
         entries after {:?} ms, {GONE_VOLTS} V after {:.2} ms",
        off_ns.map(ms).into_iter().fold(0.0, f64::max),
        ms(last_step_ns),
        notes.iter().map(|write| ms(write.at_ns)).collect::<Vec<_>>(),
        ms(gone_ns)
    );
    let heaters_off = off_ns.into_iter().max().unwrap_or(0);
    assert!(begins_ns < heaters_off && heaters_off < last_step_ns && ms(heaters_off) < 12.0);
    assert!(edges.iter().all(|edge| edge.time_ns < gone_ns - 2 * MS), "the motors still turn");
    // The journal's file is closed after these, which writes its directory entry.
    assert_eq!(notes[..2].iter().map(purpose).collect::<Vec<_>>(), ["journal: entry", "journal: entry, at rest"]);
    assert!(notes.iter().all(|write| heaters_off < write.at_ns && write.at_ns < gone_ns - MS));
    let card = velvet.card(|card| card.content().to_vec());
    let outcome = after(on_a_small_card(), "the supply has fallen", &left, card, true);
    println!("{outcome:?}");
    assert!(matches!(outcome, Outcome::Resumed { told: false, .. }), "{outcome:?}");
}
