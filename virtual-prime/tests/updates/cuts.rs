//! The power fails at every operation of every path, in every way, and a board that knows nothing but flash
//! and card is switched on: an image that may run, runs.

use update::{Ended, Entry, Log, Origin, PRIME, Policy, WORD};
use virtual_prime::flash_journal::{FlashContent, SECTOR, Torn};

use super::small::{Before, Came, Small, after, application, card, flash, known, log, state};
use super::{Row, Share, tests};

pub const ROWS: &[Row] = &[
    Row {
        name: "an_install_is_cut",
        what: "at an erase or a word of an install that was asked for",
        does: "the next start finishes it: the new firmware runs",
        run: |share| cut(&install(), share),
    },
    Row {
        name: "an_install_of_two_sectors_is_cut",
        what: "the same, of an image of more than one sector",
        does: "the next start finishes it",
        run: |share| cut(&long_install(), share),
    },
    Row {
        name: "an_install_is_cut_twice",
        what: "and once more while that is finished",
        does: "the start after that finishes it",
        run: |share| cut_twice(&install(), share),
    },
    Row {
        name: "the_file_is_gone_after_a_cut",
        what: "at an erase or a word of an install, and the file is gone then",
        does: "the firmware that ran before does so again, if it was touched, from firmware.previous",
        run: |share| cut(&without_file(), share),
    },
    Row {
        name: "going_back_is_cut",
        what: "at an erase or a word of going back to the previous firmware",
        does: "the next start goes on: the previous firmware runs",
        run: |share| cut(&going_back(), share),
    },
    Row {
        name: "a_rescue_is_cut",
        what: "at an erase or a word of an install from the card into an empty flash",
        does: "the next start begins again",
        run: |share| cut(&rescue(), share),
    },
    Row {
        name: "the_log_is_cut",
        what: "while the full log of updates is made room in",
        does: "the same firmware runs, and a locked board is still locked",
        run: |share| cut(&full_log(), share),
    },
];

tests! {
    an_install_is_cut
    an_install_of_two_sectors_is_cut
    an_install_is_cut_twice
    the_file_is_gone_after_a_cut
    going_back_is_cut
    a_rescue_is_cut
    the_log_is_cut
}

/// Time limit of a start; an image of two sectors takes less, with its erases.
const PATIENCE_MS: u64 = 20_000;
/// Size of the smallest image, which fits into a single sector, bytes.
pub const SHORT: usize = 1152;

const TEARS: [Torn; 3] = [Torn::NotBegun, Torn::Unreadable, Torn::Between];
/// Number of cuts of a row in `make test`.
const QUICK: usize = 4;
/// Number of cuts of a row whose image is long, in each way.
const LONG: usize = 60;

/// A path to an image: flash and card as a start finds them.
struct Path {
    content: FlashContent,
    card: Vec<u8>,
    /// Card as the start after the cut finds it.
    card_then: Vec<u8>,
    /// Image that may run in the end.
    good: &'static [u8],
}

impl Path {
    fn new(content: FlashContent, files: &[(&str, &[u8])], good: &'static [u8]) -> Self {
        let card = card(files);
        Self { content, card_then: card.clone(), card, good }
    }
}

/// Lists the operations to be cut, and the way of each cut.
fn cuts(operations: usize, share: Share) -> Vec<(usize, Torn)> {
    let step = match share {
        // A long image takes its time, so it is cut at two places only.
        Share::Quick if operations > 1000 => operations.div_ceil(2),
        Share::Quick => operations.div_ceil(QUICK),
        Share::Whole => operations.div_ceil(LONG * TEARS.len()).max(1),
    };
    let places = (0..operations).step_by(step);
    match share {
        Share::Quick => places.enumerate().map(|(index, place)| (place, TEARS[(index + 1) % TEARS.len()])).collect(),
        Share::Whole => places.flat_map(|place| TEARS.map(|torn| (place, torn))).collect(),
    }
}

#[track_caller]
fn cut(path: &Path, share: Share) -> usize {
    let mut whole = Small::on(&path.content, Some(&path.card));
    whole.settle(PATIENCE_MS);
    let operations = whole.operations();
    assert!(operations.len() > 2, "nothing was done: {}", whole.said());
    let policy = state(&mut path.content.clone()).policy;
    let cuts = cuts(operations.len(), share);
    for (place, torn) in &cuts {
        let mut content = after(&path.content, &operations[..*place]);
        content.tear(&operations[*place], *torn);
        assert_eq!(state(&mut content).policy, policy, "{torn:?} at {place} of {}", operations.len());
        let mut board = Small::on(&content, Some(&path.card_then));
        let came = board.settle(PATIENCE_MS);
        let runs = matches!(came, Came::Runs(number) if path.good.contains(&number));
        assert!(runs, "{torn:?} at {place} of {}: {came:?}: {}", operations.len(), board.said());
        assert_eq!(state(&mut after(&content, &board.operations())).policy, policy, "after that: {torn:?} at {place}");
    }
    cuts.len()
}

#[track_caller]
fn cut_twice(path: &Path, share: Share) -> usize {
    let mut whole = Small::on(&path.content, Some(&path.card));
    whole.settle(PATIENCE_MS);
    let operations = whole.operations();
    let mut tried = 0;
    for (place, torn) in cuts(operations.len(), share).into_iter().step_by(if share == Share::Quick { 2 } else { 5 }) {
        let mut content = after(&path.content, &operations[..place]);
        content.tear(&operations[place], torn);
        let next = Path { content, card: path.card.clone(), card_then: path.card.clone(), good: path.good };
        let mut second = Small::on(&next.content, Some(&next.card));
        second.settle(PATIENCE_MS);
        let again = second.operations();
        for place in (0..again.len()).step_by(again.len().div_ceil(if share == Share::Quick { 2 } else { 8 }).max(1)) {
            let mut content = after(&next.content, &again[..place]);
            content.tear(&again[place], torn);
            let mut board = Small::on(&content, Some(&next.card));
            let came = board.settle(PATIENCE_MS);
            assert!(matches!(came, Came::Runs(number) if path.good.contains(&number)), "{came:?}: {}", board.said());
            tried += 1;
        }
    }
    tried
}

fn install() -> Path {
    let (old, new) = (application(1, SHORT, None), application(2, SHORT, None));
    let mut content = flash(&old);
    log(&mut content, Entry::Requested(Origin::File, known(&new)));
    Path::new(content, &[("flashme.bin", &new), ("firmware.previous", &old)], &[2])
}

fn long_install() -> Path {
    let (old, new) = (application(1, 3 * SHORT, None), application(2, SECTOR + SHORT, None));
    let mut content = flash(&old);
    log(&mut content, Entry::Requested(Origin::File, known(&new)));
    Path::new(content, &[("flashme.bin", &new), ("firmware.previous", &old)], &[2])
}

/// Returns an install whose file is gone after the cut: before the first operation the old image is still
/// there, after the last the new image is.
fn without_file() -> Path {
    let (old, new) = (application(1, SHORT, None), application(2, SHORT, None));
    let path = install();
    Path {
        card_then: card(&[("firmware.previous", &old)]),
        good: &[1, 2],
        ..Path::new(path.content, &[("flashme.bin", &new), ("firmware.previous", &old)], &[])
    }
}

fn going_back() -> Path {
    let (old, new) = (application(1, SHORT, None), application(2, SHORT, None));
    let mut content = flash(&new);
    log(&mut content, Entry::Installed(Origin::File, known(&new)));
    (0..update::TRIALS).for_each(|_| log(&mut content, Entry::Tried));
    Path::new(content, &[("flashme.bin", &new), ("firmware.previous", &old)], &[1])
}

fn rescue() -> Path {
    let new = application(2, SHORT, None);
    Path::new(flash(&[]), &[("velvet.bin", &new)], &[2])
}

fn full_log() -> Path {
    let owner = [7; 32];
    let old = application(1, SHORT, Some(&owner));
    let mut content = flash(&old);
    let locked = Policy { key: Some(update::public_key(&owner)), is_locked: true };
    let mut before = Before(&mut content);
    Log::read(&mut before, &PRIME).set_policy(&mut before, &locked).expect("room");
    log(&mut content, Entry::Failed(Ended::Watchdog, known(&application(2, SHORT, None))));
    log(&mut content, Entry::Installed(Origin::Previous, known(&old)));
    let entries = PRIME.sector_bytes as usize / WORD;
    (0..entries - 12).for_each(|_| log(&mut content, Entry::Confirmed(known(&old))));
    Path::new(content, &[], &[1])
}
