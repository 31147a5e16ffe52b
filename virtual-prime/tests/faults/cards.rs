//! Faults of the card, its files, and the configuration.

use super::scene::{Seen, State, enter, printer};
use super::{Case, Class};
use crate::common::velvet::{CONFIG, PROMPT, Plan, SECOND, Velvet};

/// Message of a machine that cannot be set up, after its reason, and its answer to any move.
const LOCKED: &str = "error:the configuration has errors: mend config.ini and reset";

/// Asserts that a machine without a usable configuration tells this reason, once, that nothing moves or
/// heats, and that the console works.
#[track_caller]
fn stays_off(plan: Plan, reason: &str) -> Velvet {
    stays_off_from(plan.held(), reason)
}

/// Like [`stays_off`], for a machine before its first instruction.
#[track_caller]
fn stays_off_from(mut velvet: Velvet, reason: &str) -> Velvet {
    velvet.hear_until(PROMPT, 5 * SECOND);
    velvet.hear(2 * SECOND);
    velvet.assert_safe();
    assert_eq!(velvet.said().matches(reason).count(), 1, "{reason:?} in: {}", velvet.said());
    assert_eq!(velvet.said().matches("There was a fatal error in the config.ini").count(), 1, "{}", velvet.said());
    let answer = velvet.ask("G28", SECOND);
    assert!(answer.contains(LOCKED), "{answer}");
    assert_eq!(velvet.world(|world| world.trace().total()), 0);
    velvet
}

fn missing(_: &Case) -> Seen {
    let reason = "ERROR: cannot read /sd/config.ini: no SD card found: insert a card and reset\n";
    stays_off(Plan::new().without_card(), reason);
    Seen::default()
}

fn unformatted(_: &Case) -> Seen {
    let blank = |mut card: Vec<u8>| {
        card.fill(0);
        card
    };
    let reason = "ERROR: cannot read /sd/config.ini: the SD card has no FAT file system: format it as FAT32\n";
    stays_off(Plan::new().with_card(blank), reason);
    Seen::default()
}

fn without_configuration(_: &Case) -> Seen {
    let other = |_| virtual_prime::sd_image::build(None, &[("part.g".into(), b"G28\n".to_vec())]).expect("a volume");
    let mut velvet = stays_off(Plan::new().with_card(other), "ERROR: cannot read /sd/config.ini: no such file\n");
    velvet.assert_card_listed("part.g");
    Seen::default()
}

/// Makes the directory entry of config.ini begin at this cluster.
fn misplace_config(card: &mut [u8], cluster: u32) {
    let entry = card.chunks(32).position(|entry| entry.starts_with(b"CONFIG  INI")).expect("a directory entry") * 32;
    let [a, b, c, d] = cluster.to_le_bytes();
    // The first cluster's number: high half at 20, low half at 26.
    card[entry + 20..entry + 22].copy_from_slice(&[c, d]);
    card[entry + 26..entry + 28].copy_from_slice(&[a, b]);
}

fn damaged(_: &Case) -> Seen {
    let misplaced = |mut card: Vec<u8>| {
        // The volume has no such cluster.
        misplace_config(&mut card, 0x00F0_0000);
        card
    };
    let reason =
        "ERROR: cannot read /sd/config.ini: the SD card's file system is damaged: check the card on a computer\n";
    stays_off(Plan::new().with_card(misplaced), reason).assert_card_listed("config.ini");
    Seen::default()
}

/// Makes the block unreadable at which config.ini begins.
fn unreadable(_: &Case) -> Seen {
    let mut velvet = Plan::new().held();
    let beginning = CONFIG.as_bytes()[..64].to_vec();
    velvet.bench.vm.with(move |stopped| {
        let card = stopped.session.board_mut().mcu.sdmmc.card_mut().expect("a card in the slot");
        let block = card.content().chunks(512).position(|block| block.starts_with(&beginning)).expect("config.ini");
        card.trouble().unreadable = vec![block as u32];
    });
    let reason = "ERROR: cannot read /sd/config.ini: \
                  the SD card cannot read a part of itself any more: save its files and replace it\n";
    stays_off_from(velvet, reason);
    Seen::default()
}

fn unknown_key(_: &Case) -> Seen {
    let plan = Plan::new().with("alpha.max_rate = 18000", "alpha.max_rat = 18000");
    let line = 1 + CONFIG.lines().position(|line| line.starts_with("alpha.max_rate")).expect("the sample has it");
    let told = format!("config.ini: line {line}, column 1: fatal: alpha.max_rat: [actuator] has no setting 'max_rat'");
    stays_off(plan, &told).assert_card_listed("config.ini");
    Seen::default()
}

fn impossible_value(_: &Case) -> Seen {
    let plan = Plan::new().with("alpha.steps_per_mm = 80 ", "alpha.steps_per_mm = eighty ");
    let mut velvet = stays_off(plan, "config.ini: line ");
    assert!(velvet.said().contains("alpha.steps_per_mm"), "{}", velvet.said());
    velvet.assert_card_listed("config.ini");
    Seen::default()
}

fn pull(velvet: &mut Velvet) {
    velvet.bench.vm.with(|stopped| stopped.session.board_mut().insert_card(None)).expect("the run goes on");
}

/// Pulls the card of an idle machine with heaters on: they go on heating under control, and the next access
/// is told.
fn pulled_hot(case: &Case) -> Seen {
    let mut velvet = enter(printer(), case.state);
    pull(&mut velvet);
    velvet.type_in("cat /sd/job.g");
    let from = velvet.now_ms();
    velvet.hear_until("the SD card stopped answering", case.within_ms as u64);
    let told_ms = Some((velvet.now_ms() - from) as f64);
    velvet.hear(2 * SECOND);
    let hot_end = velvet.world(|world| world.heater_index("hotend")).expect("the sample has one");
    assert!((velvet.world(|world| world.heater_c(hot_end)) - 200.0).abs() < 5.0, "it is not held");
    super::scene::answers(&mut velvet, "M105", "/200.0");
    Seen { told_ms, ..Seen::default() }
}

/// Pulls the card during a job: the file pauses where it cannot be read on; heaters keep their targets.
fn pulled_playing(case: &Case) -> Seen {
    let mut velvet = enter(printer(), case.state);
    pull(&mut velvet);
    let from = velvet.now_ms();
    velvet.hear_until("paused, reading the file being played failed", case.within_ms as u64);
    let told_ms = Some((velvet.now_ms() - from) as f64);
    super::scene::answers(&mut velvet, "M105", "/200.0");
    Seen { told_ms, ..Seen::default() }
}

pub const CLASSES: &[Class] = &[
    Class {
        name: "a_card_that_is_missing",
        what: "card missing",
        does: "told; nothing is wired, moves or heats; consoles work",
        cases: &[Case { state: State::PowerOn, within_ms: 0.0, run: missing }],
    },
    Class {
        name: "a_card_without_a_file_system",
        what: "card without a file system",
        does: "the same, with what to do",
        cases: &[Case { state: State::PowerOn, within_ms: 0.0, run: unformatted }],
    },
    Class {
        name: "a_card_without_configuration",
        what: "card without config.ini",
        does: "the same; the card can be read and written",
        cases: &[Case { state: State::PowerOn, within_ms: 0.0, run: without_configuration }],
    },
    Class {
        name: "a_card_that_is_damaged",
        what: "file system damaged",
        does: "the same",
        cases: &[Case { state: State::PowerOn, within_ms: 0.0, run: damaged }],
    },
    Class {
        name: "a_card_that_cannot_be_read",
        what: "card reports a read error",
        does: "the same",
        cases: &[Case { state: State::PowerOn, within_ms: 0.0, run: unreadable }],
    },
    Class {
        name: "a_key_that_is_unknown",
        what: "configuration with a key that nobody knows",
        does: "told with line and column; nothing is wired, moves or heats, so that it can be mended",
        cases: &[Case { state: State::PowerOn, within_ms: 0.0, run: unknown_key }],
    },
    Class {
        name: "a_value_that_is_impossible",
        what: "configuration with an impossible value where motion depends on it",
        does: "the same",
        cases: &[Case { state: State::PowerOn, within_ms: 0.0, run: impossible_value }],
    },
    Class {
        name: "a_card_that_is_pulled_while_hot",
        what: "card pulled out while heaters are on",
        does: "heaters stay under control; told with the next access",
        cases: &[Case { state: State::Holding, within_ms: 3_000.0, run: pulled_hot }],
    },
    Class {
        name: "a_card_that_is_pulled_in_a_job",
        what: "card pulled out while its file is played",
        does: "the file pauses where it could not be read on, hot and in place; M24 goes on when its card is back",
        cases: &[Case { state: State::Printing, within_ms: 90_000.0, run: pulled_playing }],
    },
];

super::tests! {
    a_card_that_is_missing
    a_card_without_a_file_system
    a_card_without_configuration
    a_card_that_is_damaged
    a_card_that_cannot_be_read
    a_key_that_is_unknown
    a_value_that_is_impossible
    a_card_that_is_pulled_while_hot
    a_card_that_is_pulled_in_a_job
}
