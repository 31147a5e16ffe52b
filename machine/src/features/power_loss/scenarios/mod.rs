//! A job with a journal, the power going at every single block write, and what is made of it afterwards: the
//! same part, by a machine that stands where it was left and knows nothing but its card.

mod goes_on;
mod offers;
mod recovery;

use std::fs;
use std::path::PathBuf;
use std::sync::atomic::{AtomicU32, Ordering};

use sim::runner::{CardState, Runner, Setup};
use units::Actuator;

const CONFIG: &str = include_str!("../../../../../config/samples/cartesian.ini");
const SECOND: u64 = 1_000_000_000;
/// A bead's width, mm: what is made anew lies within it.
const BEAD: f64 = 0.45;
const MOTORS: [Actuator; 4] = [Actuator::Alpha, Actuator::Beta, Actuator::Gamma, Actuator::Delta];

/// A card with a configuration and a job.
struct Card(PathBuf);

impl Card {
    fn new(job: &str) -> Self {
        Self::with_journal(job, true)
    }

    fn with_journal(job: &str, journal: bool) -> Self {
        let journal = if journal { "player.power_loss = true" } else { "player.power_loss = false" };
        Self::of(CONFIG, &[journal], job)
    }

    /// Returns a card for a machine of this configuration, with `section.key = value` settings besides.
    fn of(machine: &str, settings: &[&str], job: &str) -> Self {
        static COUNT: AtomicU32 = AtomicU32::new(0);
        let number = COUNT.fetch_add(1, Ordering::Relaxed);
        let place = std::env::temp_dir().join(format!("velvet-power-loss-{}-{number}", std::process::id()));
        fs::create_dir_all(&place).unwrap();
        let usual = ["player.power_loss = true", "player.power_loss_period = 2", "player.power_loss_lift = 3"];
        let config = usual.iter().chain(settings).fold(machine.to_owned(), |text, line| {
            let (name, value) = line.split_once(" = ").unwrap();
            let (section, key) = name.split_once('.').unwrap();
            config::edit::apply(&text, config::edit::Edit { section, key, value: Some(value) })
        });
        fs::write(place.join("config.ini"), config).unwrap();
        fs::write(place.join("job.g"), job).unwrap();
        Self(place)
    }
}

impl Drop for Card {
    fn drop(&mut self) {
        // A folder left behind harms nobody.
        let _ = fs::remove_dir_all(&self.0);
    }
}

/// Places at which filament was laid: X, Y and Z of the tool, mm.
type Laid = Vec<[f64; 3]>;

/// A machine that is on.
struct Machine {
    runner: Runner,
    said: String,
    laid: Laid,
    filament: f64,
}

impl Machine {
    /// Starts a machine with its carriages where the previous machine left them.
    fn start(card: &Card, carriages: &[f64], writes: Option<u32>) -> Self {
        let mut setup = Setup::new(&card.0);
        (setup.carriages, setup.writes) = (carriages.to_vec(), writes);
        let runner = Runner::new(&setup).unwrap();
        let mut machine = Self { runner, said: String::new(), laid: Laid::new(), filament: f64::INFINITY };
        machine.run(SECOND / 2);
        machine
    }

    fn carriages(&self) -> Vec<f64> {
        MOTORS.map(|motor| self.runner.world(|world| world.carriage_mm(motor)).unwrap()).to_vec()
    }

    /// Runs the machine for a step. Returns false when the power went.
    fn step(&mut self) -> bool {
        self.runner.step();
        let [x, y, z] = self.runner.world(|world| world.tool_mm());
        let filament = self.runner.world(|world| world.carriage_mm(Actuator::Delta)).unwrap();
        let moved =
            self.laid.last().is_none_or(|last| (last[0] - x).hypot(last[1] - y) > 0.05 || (last[2] - z).abs() > 0.02);
        if filament > self.filament && moved {
            self.laid.push([x, y, z]);
        }
        self.filament = filament;
        self.said.push_str(&String::from_utf8_lossy(&self.runner.read_from(base::sessions::SessionId(0))));
        !self.runner.block_writes().1
    }

    fn run(&mut self, time_ns: u64) {
        let end = self.runner.now_ns() + time_ns;
        while self.runner.now_ns() < end && self.step() {}
    }

    fn send(&mut self, line: &str) {
        assert!(self.runner.type_on(base::sessions::SessionId(0), &format!("{line}\n")));
    }

    /// Runs until the words are said. Returns false when the power went before.
    fn until(&mut self, words: &str) -> bool {
        let end = self.runner.now_ns() + 900 * SECOND;
        while !self.said.contains(words) {
            assert!(self.runner.now_ns() < end, "`{words}` was not said, but: {}", self.said);
            if !self.step() {
                return false;
            }
        }
        true
    }

    fn until_any(&mut self, words: &[&str]) {
        let end = self.runner.now_ns() + 10 * SECOND;
        while !words.iter().any(|words| self.said.contains(words)) {
            assert!(self.runner.now_ns() < end, "none of {words:?} was said, but: {}", self.said);
            self.step();
        }
    }

    fn print(&mut self) -> bool {
        self.send("play /sd/job.g -t");
        self.until("Done printing file")
    }
}

/// Three layers of two squares each.
fn part(relative: bool) -> String {
    part_at(0.0, relative)
}

/// Returns the part, shifted to the side by this much, mm.
fn part_at(aside: f64, relative: bool) -> String {
    let mut text = String::from("; a part\nM190 S50\nM109 S180\nG28\nG90\nG21\n");
    text += if relative { "M83\n" } else { "M82\nG92 E0\n" };
    let mut e = 0.0;
    let mut line = |text: &mut String, words: &str, filament: f64| {
        e = if relative { filament } else { e + filament };
        *text += &format!("{words} E{e:.4}\n");
    };
    for layer in 1..=3 {
        text += &format!("G1 Z{:.2} F600\nM106 S{}\n", 0.3 * f64::from(layer), 80 * layer);
        for (x, y) in [(20.0 + aside, 20.0), (60.0 + aside, 30.0)] {
            text += &format!("G0 X{x} Y{y} F9000\n");
            for (to_x, to_y) in [(15.0, 0.0), (15.0, 15.0), (0.0, 15.0), (0.0, 0.0)] {
                line(&mut text, &format!("G1 X{} Y{} F1200", x + to_x, y + to_y), 0.6);
            }
        }
    }
    text + "M107\nM104 S0\nM140 S0\nG1 Z20 F600\n"
}

/// Asserts that every place of the one is near a place of the other.
fn covers(what: &str, one: &Laid, other: &Laid) {
    for [x, y, z] in one {
        let near = other.iter().any(|[a, b, c]| (a - x).hypot(b - y) < BEAD && (c - z).abs() < 0.03);
        assert!(near, "{what}: nothing at X{x:.2} Y{y:.2} Z{z:.2}");
    }
}

fn cut_at_every_write(job: &str, step: u32) {
    let card = Card::new(job);
    let mut whole = Machine::start(&card, &[], None);
    assert!(whole.print());
    let writes = whole.runner.block_writes().0;
    assert!(writes > 20, "{writes}");
    let (mut resumed, mut absent, mut asked) = (0, 0, 0);
    for cut in (0..writes).step_by(step as usize) {
        let card = Card::new(job);
        let mut first = Machine::start(&card, &[], Some(cut));
        if !first.runner.block_writes().1 && first.print() {
            // The last writes are behind the job's end.
            first.run(10 * SECOND);
        }
        let mut second = Machine::start(&card, &first.carriages(), None);
        if !second.said.contains("a job was interrupted") {
            second.send("M1000");
            assert!(second.until("no job was interrupted"), "{}", second.said);
            // Nothing was laid, or all of it.
            assert!(first.laid.len() < whole.laid.len() / 10 || first.laid.len() + 5 > whole.laid.len(), "cut {cut}");
            absent += 1;
            continue;
        }
        second.send("M1000");
        second.until_any(&[" heats to ", "// up to Z", "Z may be anywhere"]);
        if let Some((_, range)) = second.said.split_once("Z may be anywhere from ") {
            // Z was on its way to another height at the cut, so a person enters its place.
            let mut ends = range.split([' ', ':']).filter_map(|word| word.parse::<f64>().ok());
            let (least, most, z) = (ends.next().unwrap(), ends.next().unwrap(), first.carriages()[2]);
            assert!((least - 0.02..=most + 0.02).contains(&z), "cut {cut}: {z} is not from {least} to {most}");
            second.send(&format!("M1000 Z{z:.3}"));
            asked += 1;
        }
        assert!(second.until("the job goes on") && second.until("Done printing file"), "cut {cut}: {}", second.said);
        let all: Laid = first.laid.iter().chain(&second.laid).copied().collect();
        covers(&format!("cut {cut}: missing"), &whole.laid, &all);
        covers(&format!("cut {cut}: too much"), &all, &whole.laid);
        let mut third = Machine::start(&card, &second.carriages(), None);
        assert!(!third.said.contains("interrupted"), "cut {cut}: a finished job leaves no offer");
        third.run(SECOND);
        resumed += 1;
    }
    println!(
        "{writes} writes: gone on with after {resumed} ({asked} with Z told), nothing to go on with after {absent}"
    );
    assert!(resumed > 0 && absent > 0);
}

#[test]
#[ignore = "long: make faults"]
fn a_part_is_the_same_whichever_block_write_the_power_goes_at() {
    cut_at_every_write(&part(false), 1);
    cut_at_every_write(&part(true), 1);
}

#[test]
fn a_part_is_the_same_after_a_cut_at_some_of_its_writes() {
    cut_at_every_write(&part(false), 3);
    cut_at_every_write(&part(true), 5);
}

/// The power goes while Z goes up to the next layer, or is about to, long after the last entry that was due.
#[test]
fn a_cut_on_the_way_to_another_height_asks_where_z_is() {
    for z in [0.3, 0.35, 0.45, 0.55] {
        let card = Card::new(&part(false));
        let config = fs::read_to_string(card.0.join("config.ini")).unwrap();
        fs::write(card.0.join("config.ini"), config.replace("power_loss_period = 2", "power_loss_period = 600"))
            .unwrap();
        let mut first = Machine::start(&card, &[], None);
        first.send("play /sd/job.g");
        while first.laid.len() < 100 || first.carriages()[2] < z + 0.005 {
            assert!(first.step());
        }
        let mut second = Machine::start(&card, &first.carriages(), None);
        assert!(second.said.contains("a job was interrupted"), "{z}: {}", second.said);
        second.send("M1000");
        assert!(second.until("Z may be anywhere from 0.30 to 0.60: measure it"), "{z}: {}", second.said);
    }
}

/// Prints into the second layer, and loses its power there. Gives the machine that is switched on afterwards.
fn cut_in_the_second_layer(card: &Card, mut first: Machine) -> (Machine, Vec<f64>) {
    first.send("play /sd/job.g");
    while !first.laid.last().is_some_and(|[_, _, z]| (0.59..0.61).contains(z)) {
        first.step();
    }
    first.run(5 * SECOND);
    let carriages = first.carriages();
    drop(first);
    (Machine::start(card, &carriages, None), carriages)
}

fn interrupted(card: &Card) -> (Machine, Vec<f64>) {
    let (second, carriages) = cut_in_the_second_layer(card, Machine::start(card, &[], None));
    assert!(second.said.contains("a job was interrupted: /sd/job.g, line "), "{}", second.said);
    (second, carriages)
}

#[test]
fn m413_begins_and_ends_keeping_a_journal() {
    for configured in [true, false] {
        let card = Card::with_journal(&part(false), configured);
        let mut first = Machine::start(&card, &[], None);
        first.send("M413");
        assert!(first.until(if configured { "power-loss recovery is on" } else { "power-loss recovery is off" }));
        first.send(if configured { "M413 S0" } else { "M413 S1" });
        let (second, _) = cut_in_the_second_layer(&card, first);
        assert_eq!(second.said.contains("a job was interrupted: /sd/job.g"), !configured, "{}", second.said);
    }
}

/// A card may take a quarter of a second for a block, the watchdog waits nearly four seconds for the
/// executor, and making the file takes some sixty.
#[test]
fn a_journal_that_m413_asks_for_is_made_while_everybody_is_served() {
    let card = Card::with_journal(&part(false), false);
    let mut machine = Machine::start(&card, &[], None);
    machine.send("M413 S1");
    let before = machine.runner.block_writes().0;
    machine.send("play /sd/job.g -t");
    assert!(machine.until("// NOTE the journal is made on the card, before the job begins"));
    while machine.laid.is_empty() {
        machine.step();
    }
    let made = machine.runner.block_writes().0 - before;
    assert!(made >= 12, "it was made: {made}");
    // At most 12 of a quarter of a second: three seconds.
    let in_a_row = machine.runner.most_unseen_writes();
    assert!(in_a_row <= 12, "{in_a_row} writes without a word to the watchdog");
    assert!(machine.until("Done printing file"));
}

/// Asserts that nothing of the machine has changed.
fn stands(machine: &Machine, carriages: &[f64]) {
    assert_eq!(machine.carriages(), carriages);
    assert!(machine.runner.heat(|heat| heat.heaters().all(|(_, heater)| !heater.is_on())));
}

fn refused(change: impl Fn(&Card), words: &str) {
    let card = Card::new(&part(false));
    let (mut second, carriages) = interrupted(&card);
    change(&card);
    second.send("M1000");
    assert!(second.until(words));
    second.run(SECOND);
    stands(&second, &carriages);
    // The offer is as it was, until it is forgotten.
    second.said.clear();
    second.send("M1000 S");
    assert!(second.until("a job was interrupted"));
    second.send("M1000 C");
    assert!(second.until("is not gone on with"));
    second.send("M916");
    assert!(second.until("no job was interrupted"));
}

#[test]
fn another_file_of_this_name_is_refused() {
    refused(|card| fs::write(card.0.join("job.g"), part(true)).unwrap(), "is not the file that was played");
}

#[test]
fn one_digit_of_the_file_is_noticed() {
    let change = |card: &Card| {
        let text = part(false).replacen("X35", "X36", 1);
        fs::write(card.0.join("job.g"), text).unwrap();
    };
    refused(change, "is not the file that was played");
}

#[test]
fn another_configuration_is_refused_and_another_comment_is_none() {
    let change = |card: &Card, text: &str| {
        let before = fs::read_to_string(card.0.join("config.ini")).unwrap();
        fs::write(card.0.join("config.ini"), before + text).unwrap();
    };
    refused(|card| change(card, "\n[actuator]\ngamma.steps_per_mm = 401\n"), "are not those the job was begun with");
    let card = Card::new(&part(false));
    let (mut second, _) = interrupted(&card);
    change(&card, "\n# a comment\n");
    second.send("M1000");
    assert!(second.until(" heats to "));
}

#[test]
fn a_card_without_the_job_has_nothing_to_go_on_with() {
    let card = Card::new(&part(false));
    let (mut second, carriages) = interrupted(&card);
    fs::remove_file(card.0.join("power-loss.journal")).unwrap();
    second.send("M916");
    assert!(second.until("no job was interrupted on this card"));
    stands(&second, &carriages);
    // And without a journal there will be nothing.
    second.send("M413 S0");
    assert!(second.until("power-loss recovery is off"));
    second.send("M413");
    second.said.clear();
    assert!(second.until("power-loss recovery is off"));
}

/// A halt in each step of going on, and the power going then: what is offered is right.
#[test]
fn a_halt_in_any_step_leaves_an_offer_that_is_right() {
    for step in ["the file is read", "bed heats", "hotend heats", "// up to Z", "// homing", "// back to"] {
        for delay_ms in [1, 300] {
            let card = Card::new(&part(false));
            let (mut second, _) = interrupted(&card);
            second.send("M1000");
            assert!(second.until(step));
            second.run(delay_ms * SECOND / 1_000);
            second.send("M112");
            assert!(second.until("Emergency stop"), "{step}");
            second.run(3 * SECOND);
            assert!(second.runner.heat(|heat| heat.heaters().all(|(_, heater)| !heater.is_on())), "{step}");
            assert!(second.runner.motion(|motion| motion.is_idle()), "{step}");
            let z = second.carriages()[2];
            let mut third = Machine::start(&card, &second.carriages(), None);
            assert!(third.said.contains("a job was interrupted"), "{step}: {}", third.said);
            third.send("M1000");
            third.until_any(&[" heats to ", "Z may be anywhere"]);
            if third.said.contains("Z may be anywhere") {
                third.send(&format!("M1000 Z{z:.3}"));
            }
            assert!(third.until("the job goes on") && third.until("Done printing file"), "{step}: {}", third.said);
            let heights: std::collections::BTreeSet<i64> =
                third.laid.iter().map(|[_, _, z]| (z * 100.0).round() as i64).collect();
            assert_eq!(heights, [60, 90].into(), "{step} after {delay_ms} ms: {}", third.said);
        }
    }
}

#[test]
fn a_card_that_is_pulled_pauses_the_job_which_goes_on_when_it_is_back() {
    // Long enough for the card to be read meanwhile.
    let job = part(false).replace("M107", &format!("{}M107", "; so many words\n".repeat(200)));
    let card = Card::new(&job);
    let mut whole = Machine::start(&card, &[], None);
    assert!(whole.print());
    for cut_s in [1, 40, 105] {
        let card = Card::new(&job);
        let mut machine = Machine::start(&card, &[], None);
        machine.send("play /sd/job.g -t");
        machine.run(cut_s * SECOND);
        machine.runner.set_card_state(CardState::Missing);
        assert!(machine.until("error:paused, reading the file being played failed"));
        machine.run(20 * SECOND);
        machine.send("M24");
        assert!(machine.until("no SD card found"), "{}", machine.said);
        // Another card; then another file; then its own.
        machine.runner.set_card_state(CardState::Good);
        fs::rename(card.0.join("job.g"), card.0.join("other.g")).unwrap();
        machine.send("M24");
        assert!(machine.until("no such file"), "{}", machine.said);
        fs::write(card.0.join("job.g"), job.replace("G1", "G0")).unwrap();
        machine.send("M24");
        assert!(machine.until("is not the file that was played"), "{}", machine.said);
        fs::rename(card.0.join("other.g"), card.0.join("job.g")).unwrap();
        machine.send("M24");
        assert!(machine.until("Done printing file"), "{}", machine.said);
        let (count, all) = (machine.laid.len() as f64, whole.laid.len() as f64);
        assert!((count / all - 1.0).abs() < 0.01, "pulled after {cut_s} s: {count} of {all} pieces, some twice or not");
        covers("missing", &whole.laid, &machine.laid);
        covers("too much", &machine.laid, &whole.laid);
    }
}

/// The part with its squares as objects; the first one is excluded while it is made in the second layer, and
/// the power goes so long afterwards.
fn cut_behind_an_exclusion(relative: bool, seconds: f64) {
    let mut layer = 0;
    let job: String = part(relative)
        .lines()
        .map(|line| match line {
            "G0 X20 Y20 F9000" => {
                layer += 1;
                format!("M486 S0\n{line}\n")
            }
            "G0 X60 Y30 F9000" => format!("M486 S1\n{line}\n"),
            line if line.starts_with("G1 Z") => format!("M486 S-1\n{line}\n"),
            _ => format!("{line}\n"),
        })
        .collect();
    assert_eq!(layer, 3);
    let card = Card::new(&job);
    let mut whole = Machine::start(&card, &[], None);
    assert!(whole.print());
    let mut first = Machine::start(&card, &[], None);
    first.send("play /sd/job.g");
    while !first.laid.last().is_some_and(|[x, y, z]| (0.59..0.61).contains(z) && *x > 34.0 && (25.0..40.0).contains(y))
    {
        assert!(first.step());
    }
    first.send("M486 C");
    first.run((seconds * SECOND as f64) as u64);
    let (laid, carriages) = (first.laid.clone(), first.carriages());
    drop(first);
    let mut second = Machine::start(&card, &carriages, None);
    second.send("M1000");
    second.until_any(&[" heats to ", "// up to Z", "Z may be anywhere"]);
    if second.said.contains("Z may be anywhere") {
        second.send(&format!("M1000 Z{:.3}", carriages[2]));
    }
    assert!(second.until("the job goes on") && second.until("Done printing file"), "{}", second.said);
    let is_excluded = |[x, _, z]: &&[f64; 3]| *x < 50.0 && *z > 0.5;
    let what = format!("relative {relative}, {seconds} s");
    assert_eq!(second.laid.iter().filter(is_excluded).count(), 0, "{what}: nothing of it is made any more");
    let kept: Laid = whole.laid.iter().filter(|place| !is_excluded(place)).copied().collect();
    let all: Laid = laid.iter().chain(&second.laid).copied().collect();
    covers(&format!("{what}: missing"), &kept, &all);
    covers(&format!("{what}: too much"), &all, &whole.laid);
}

#[test]
fn an_object_that_was_excluded_stays_so_after_a_cut() {
    cut_behind_an_exclusion(false, 0.2);
    cut_behind_an_exclusion(true, 6.0);
}
