//! The SD card's interface: how it is powered, and cards that come and go while the machine runs.

mod common;

use common::velvet::{CONFIG, Plan, SECOND, Velvet};
use common::writes::Written;
use virtual_prime::sd_image;

/// RCC_AHB3RSTR (RM0399 chapter 9) with SDMMC1RST; SDMMC1's POWER and CMDR (section 58.10).
const RESET: u64 = 0x5802_447C;
const SDMMC1RST: u64 = 1 << 16;
const POWER: u64 = 0x5200_7000;
const COMMAND: u64 = 0x5200_700C;
/// PWRCTRL: power-cycle, power-off, power-on.
const POWER_STATES: [u64; 3] = [0b10, 0b00, 0b11];
/// Each state but the last lasts a millisecond; then 74 clocks of 400 kHz, 185 us, until the first command.
const STATE_NS: u64 = 1_000_000;
const FIRST_CLOCKS_NS: u64 = 185_000;

fn watched() -> Plan {
    Plan::new().watching(RESET..RESET + 4).watching(POWER..POWER + 4).watching(COMMAND..COMMAND + 4)
}

/// Up to the card's first command: the block was reset, and went through the states for long enough.
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

fn insert(velvet: &mut Velvet, files: Option<&[(&str, &str)]>) {
    let volume = files.map(|files| {
        let files: Vec<_> = files.iter().map(|(name, text)| ((*name).to_owned(), text.as_bytes().to_vec())).collect();
        sd_image::build(None, &files).expect("a volume")
    });
    velvet.bench.vm.with(move |stopped| stopped.session.board_mut().insert_card(volume)).expect("the run goes on");
}

/// M21, and what it says.
#[track_caller]
fn identify(velvet: &mut Velvet, says: &str) {
    velvet.type_in("M21");
    velvet.hear_until(says, 3 * SECOND);
}

#[test]
fn every_identification_resets_the_controller_and_powers_the_card_anew() {
    let mut velvet = watched().start();
    assert_powered_up(&velvet.bench.writes.take());
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
fn a_file_whose_card_goes_away_stops_with_a_reason() {
    let long = "G1 X10 F600\nG1 X11\n".repeat(5_000);
    let mut velvet = Plan::new().file("long.g", &long).start();
    velvet.ask("M23 long.g", SECOND);
    velvet.type_in("M24");
    velvet.hear(2 * SECOND);
    insert(&mut velvet, None);
    velvet.hear_until("reading the file being played failed: the SD card stopped answering", 120 * SECOND);
    velvet.type_in("version");
    velvet.hear_until("Prime", SECOND);
}
