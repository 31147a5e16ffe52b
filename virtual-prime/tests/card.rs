//! Interface of the SD card: its power-up, and cards that come and go while the machine runs.

use crate::common::print::{Carriages, farthest};
use crate::common::velvet::{CONFIG, Plan, SECOND, Velvet};
use crate::common::writes::Written;
use sim::models::sd_card::Traits;
use virtual_prime::sd_image;

/// Addresses of RCC_AHB3RSTR (RM0399 chapter 9) with SDMMC1RST, and of SDMMC1's POWER and CMDR (section
/// 58.10).
const RESET: u64 = 0x5802_447C;
const SDMMC1RST: u64 = 1 << 16;
const POWER: u64 = 0x5200_7000;
const COMMAND: u64 = 0x5200_700C;
/// Values of PWRCTRL: power-cycle, power-off, power-on.
const POWER_STATES: [u64; 3] = [0b10, 0b00, 0b11];
/// Duration of each state but the last, a millisecond; then 74 clocks of 400 kHz, 185 us, until the first
/// command.
const STATE_NS: u64 = 1_000_000;
const FIRST_CLOCKS_NS: u64 = 185_000;

fn watched() -> Plan {
    Plan::new().watching(RESET..RESET + 4).watching(POWER..POWER + 4).watching(COMMAND..COMMAND + 4)
}

/// Asserts for the time up to the card's first command that the block was reset, and went through the states
/// for long enough.
#[track_caller]
fn assert_powered_up(writes: &[Written]) {
    let is_go_idle = |write: &Written| write.address == COMMAND && write.value & 0x3F == 0;
    let go_idle = writes.iter().position(is_go_idle).expect("CMD0, the first that a card hears");
    let (before, command) = (&writes[..go_idle], writes[go_idle]);
    let resets: Vec<u64> =
        before.iter().filter(|write| write.address == RESET).map(|write| write.value & SDMMC1RST).collect();
    assert_eq!(resets, [SDMMC1RST, 0], "one pulse on the reset line: {before:x?}");
    let last_reset = before.iter().rposition(|write| write.address == RESET).expect("a reset");
    let states: Vec<&Written> = before[last_reset..].iter().filter(|write| write.address == POWER).collect();
    assert_eq!(states.iter().map(|write| write.value & 0b11).collect::<Vec<_>>(), POWER_STATES);
    for pair in states.windows(2) {
        assert!(pair[1].at_ns - pair[0].at_ns >= STATE_NS, "{pair:x?}");
    }
    assert!(command.at_ns - states[2].at_ns >= FIRST_CLOCKS_NS, "{states:x?} {command:x?}");
}

fn volume(files: &[(&str, &str)]) -> Vec<u8> {
    let files: Vec<_> = files.iter().map(|(name, text)| ((*name).to_owned(), text.as_bytes().to_vec())).collect();
    sd_image::build(None, &files).expect("a volume")
}

fn insert(velvet: &mut Velvet, files: Option<&[(&str, &str)]>) {
    put(velvet, files.map(volume));
}

/// Puts a card with this content into the slot, or takes the present card out.
fn put(velvet: &mut Velvet, volume: Option<Vec<u8>>) {
    velvet.bench.vm.with(move |stopped| stopped.session.board_mut().insert_card(volume)).expect("the run goes on");
}

/// Sends M21, and returns its answer.
#[track_caller]
fn identify(velvet: &mut Velvet, says: &str) {
    velvet.type_in("M21");
    velvet.hear_until(says, 3 * SECOND);
}

#[test]
fn every_identification_resets_the_controller_and_powers_the_card_anew() {
    let mut velvet = watched().start();
    let writes = velvet.bench.writes.take();
    // The boot stage, which did not look at the card, has reset the controller as well.
    assert_powered_up(&writes[2..]);
    identify(&mut velvet, "SD card ok");
    assert_powered_up(&velvet.bench.writes.take());
}

#[test]
fn a_card_can_be_changed_while_the_machine_runs() {
    let mut velvet = Plan::new().file("first.g", "G4 P1\n").start();
    velvet.assert_card_listed("first.g");
    for (name, text) in [("second.g", "M117 second\n"), ("third.g", "M117 third\n")] {
        insert(&mut velvet, Some(&[("config.ini", CONFIG), (name, text)]));
        identify(&mut velvet, "SD card ok");
        velvet.type_in("ls /sd");
        let listed = velvet.hear_until("File(s)", SECOND);
        assert!(listed.contains(name) && !listed.contains("first.g"), "{listed}");
        velvet.type_in(&format!("cat /sd/{name}"));
        velvet.hear_until(text, SECOND);
    }
    assert_eq!(velvet.bench.vm.complaints(), Vec::<String>::new());
}

#[test]
fn a_card_that_goes_away_is_told_and_nothing_hangs() {
    let long = "G4 P1\n".repeat(20_000);
    let mut velvet = Plan::new().file("long.g", &long).start();
    insert(&mut velvet, None);
    velvet.type_in("cat /sd/long.g");
    velvet.hear_until("the SD card stopped answering", 5 * SECOND);
    identify(&mut velvet, "no SD card found");
    velvet.type_in("version");
    velvet.hear_until("Prime", SECOND);
    insert(&mut velvet, Some(&[("config.ini", CONFIG), ("back.g", "G4 P1\n")]));
    identify(&mut velvet, "SD card ok");
    velvet.assert_card_listed("back.g");
}

#[test]
fn a_file_whose_card_goes_away_waits_with_a_reason() {
    let long = "G1 X10 F600\nG1 X11\n".repeat(5_000);
    let mut velvet = Plan::new().file("long.g", &long).start();
    velvet.ask("M23 long.g", SECOND);
    velvet.type_in("M24");
    velvet.hear(2 * SECOND);
    insert(&mut velvet, None);
    velvet.hear_until("paused, reading the file being played failed: the SD card stopped answering", 120 * SECOND);
    velvet.type_in("version");
    velvet.hear_until("Prime", SECOND);
}

/// Returns lines of 10 mm to and fro, each with filament, and words between them: more than the look-ahead
/// and the board's memory of the card hold.
fn long_part() -> String {
    let words = "; so many words that the card is read while the part is made\n".repeat(8);
    let lines: String = (1..=60)
        .map(|n| format!("G1 X{} Y{:.1} E0.2 F3000\n{words}", 4 + n % 2 * 10, 4.0 + f64::from(n) / 5.0))
        .collect();
    format!("G28.3 X4 Y4 Z2\nG1 Z0.3 F600\nM83\n{lines}G1 Z2 F600\n")
}

/// Returns the places of filament, and of the carriages.
fn made(velvet: &mut Velvet) -> Carriages {
    let mut made = Carriages::new(&START);
    velvet.world(|world| world.trace().edges().to_vec()).iter().for_each(|edge| made.step(edge));
    made
}

const START: [f64; 4] = [4.0, 4.0, 2.0, 0.0];
const PULLED: &str = "paused, reading the file being played failed: the SD card stopped answering";

/// The card is pulled out in the middle, another card put in, then one with another file of that name, one
/// with the file edited on a desk, and at last its own: nothing of the part is missing and nothing is made
/// twice.
#[test]
fn a_job_whose_card_was_out_goes_on_when_its_own_is_back() {
    let part = long_part();
    let files = [("config.ini", CONFIG), ("part.g", part.as_str())];
    let whole = {
        let mut velvet = Plan::new().file("part.g", &part).carriages(&START).start();
        velvet.type_in("play /sd/part.g -t");
        velvet.hear_until("Done printing file", 120 * SECOND);
        made(&mut velvet)
    };
    let mut velvet = Plan::new().file("part.g", &part).carriages(&START).start();
    velvet.ask("M104 S60", SECOND);
    velvet.type_in("play /sd/part.g -t");
    velvet.hear(3 * SECOND);
    insert(&mut velvet, None);
    velvet.hear_until(PULLED, 60 * SECOND);
    velvet.hear(5 * SECOND);
    assert!(made(&mut velvet).laid().len() < whole.laid().len() * 3 / 4, "it has ended already");
    let hot_end = velvet.world(|world| world.heater_index("hotend")).expect("the sample has one");
    assert!(velvet.world(|world| world.heater_mean_duty(hot_end)) > 0.01, "it stays hot");
    velvet.type_in("M24");
    velvet.hear_until("no SD card found", 3 * SECOND);
    insert(&mut velvet, Some(&[("config.ini", CONFIG)]));
    velvet.type_in("M24");
    velvet.hear_until("no such file", 3 * SECOND);
    let other = part.replace("G1 X", "G0 X");
    insert(&mut velvet, Some(&[("config.ini", CONFIG), ("part.g", &other)]));
    velvet.type_in("M24");
    velvet.hear_until("is not the file that was played", 3 * SECOND);
    // The edited file differs only in its last line, and in the date of its directory entry.
    let edited = part.replace("G1 Z2 F600", "G1 Z9 F600");
    let mut card = volume(&[("config.ini", CONFIG), ("part.g", &edited)]);
    let entry = card.chunks(32).position(|entry| entry.starts_with(b"PART    G  ")).expect("a directory entry") * 32;
    // Time and date of the last write are at 22 and 24: 2026-05-01.
    card[entry + 24..entry + 26].copy_from_slice(&((46 << 9 | 5 << 5 | 1) as u16).to_le_bytes());
    put(&mut velvet, Some(card));
    velvet.type_in("M24");
    let said = velvet.hear(3 * SECOND);
    assert!(said.contains("is not the file that was played"), "{said}");
    assert!(!velvet.said().contains("Done printing"));
    insert(&mut velvet, Some(&files));
    velvet.type_in("M24");
    velvet.hear_until("Done printing file", 120 * SECOND);
    let made = made(&mut velvet);
    let near = |a: &[f64; 4], b: &[f64; 4]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 0.01);
    assert!(near(made.places(), whole.places()), "{:?}, not {:?}", made.places(), whole.places());
    assert_eq!(farthest(made.laid(), whole.laid(), 0.03).max(farthest(whole.laid(), made.laid(), 0.03)).max(0.1), 0.1);
    assert_eq!(velvet.bench.vm.complaints(), Vec::<String>::new());
}

/// A job with a journal on a card that takes no writes: the fault is told once, and the part is made.
#[test]
fn a_protected_card_has_no_journal_and_the_job_is_played() {
    let traits = Traits { is_protected: true, ..Traits::default() };
    let plan = Plan::new().set("[player] power_loss = true").file("part.g", "G28.3 X4 Y4 Z2\nM83\nG1 X14 E1 F3000\n");
    let mut velvet = plan.with_traits(traits).carriages(&START).start();
    velvet.hear(SECOND);
    assert!(velvet.said().contains("WARNING there will be no journal of jobs: "), "{}", velvet.said());
    velvet.type_in("play /sd/part.g -t");
    let said = velvet.hear_until("Done printing file", 20 * SECOND);
    assert!(said.contains("WARNING no journal of this job: "), "{said}");
    assert!((made(&mut velvet).places()[0] - 14.0).abs() < 0.01);
    velvet.type_in("M500");
    let said = velvet.hear(2 * SECOND);
    assert!(said.contains("rror"), "{said}");
}

/// A card that takes the longest that it may to write, 250 ms, at each entry: the part is the same, step by
/// step where it moves.
#[test]
fn a_slow_card_delays_no_step() {
    let run = |programming_ns: u64| {
        let traits = Traits { programming_ns, ..Traits::default() };
        let plan = Plan::new().set("[player] power_loss = true").set("[player] power_loss_period = 1");
        let mut velvet =
            plan.file("part.g", &long_part()).with_traits(traits).carriages(&START).keeping_writes().held();
        // The journal's file is made at this first boot, a block at a time.
        velvet.hear_until(crate::common::velvet::PROMPT, 60 * SECOND);
        velvet.type_in("play /sd/part.g -t");
        velvet.hear_until("Done printing file", 120 * SECOND);
        let entries = velvet.block_writes().iter().filter(|write| write.bytes.starts_with(b"VPLJ")).count();
        let edges = velvet.world(|world| world.trace_mut().take());
        let began = edges.first().expect("it moves").time_ns;
        (entries, edges.iter().map(|edge| (edge.time_ns - began, edge.actuator, edge.direction)).collect::<Vec<_>>())
    };
    let ((fast, quick), (slow, late)) = (run(300_000), run(250_000_000));
    assert!(fast > 8 && slow > 8, "{fast} and {slow} entries");
    assert_eq!(quick.len(), late.len());
    let worst = quick.iter().zip(&late).map(|(a, b)| a.0.abs_diff(b.0)).max();
    println!("{fast} and {slow} entries, the farthest edge {worst:?} ns away");
    assert!(worst.is_some_and(|ns| ns < 1_000), "{worst:?}");
}
