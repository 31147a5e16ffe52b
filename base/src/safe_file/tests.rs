//! Power cuts on a card that loses everything after its n-th write.

use super::*;
use crate::bench::Card;
use std::string::ToString;
use std::vec::Vec as List;

const FILE: &str = "/sd/settings of a machine.ini";
const DRAFT_FILE: &str = "/sd/draft-settings of a machine.ini";
const NEW_FILE: &str = "/sd/new-settings of a machine.ini";
const PREVIOUS_FILE: &str = "/sd/previous-settings of a machine.ini";

fn save(card: &mut Card, content: &[u8]) -> Result<(), StorageError> {
    let mut draft = Draft::begin(card, FILE)?;
    for piece in content.chunks(100) {
        if let Err(error) = draft.write(card, piece) {
            draft.give_up(card);
            return Err(error);
        }
    }
    draft.finish(card)
}

fn content(seed: u8, length: usize) -> List<u8> {
    (0..length).map(|i| seed.wrapping_mul(31).wrapping_add(i as u8)).collect()
}

/// Makes a card with these files.
fn card<const N: usize>(files: [(&str, &[u8]); N]) -> Card {
    Card { files: files.map(|(name, content)| (name.to_string(), content.to_vec())).into(), ..Card::default() }
}

#[test]
fn a_power_cut_at_any_write_leaves_the_old_file_or_the_new() {
    for (old, new) in [(700, 1_500), (1_500, 40), (0, 600), (512, 512)] {
        let (older, old, new) = (content(0, 30), content(1, old), content(2, new));
        let before = card([(FILE, &old), (PREVIOUS_FILE, &older)]);
        let mut whole = before.clone();
        save(&mut whole, &new).unwrap();
        assert_eq!(whole.files, card([(FILE, &new), (PREVIOUS_FILE, &old)]).files, "nothing else stays");
        let (mut olds, mut news) = (0, 0);
        for writes in 0..whole.writes {
            let mut card = Card { writes_left: Some(writes), ..before.clone() };
            assert!(save(&mut card, &new).is_err());
            let mut card = card.rebooted();
            settle(&mut card, FILE).unwrap();
            let found = &card.files[FILE];
            assert!(*found == old || *found == new, "after {writes} writes: {} bytes", found.len());
            if *found == new {
                assert_eq!(card.files.get(PREVIOUS_FILE), Some(&old), "after {writes} writes");
                news += 1;
            } else {
                olds += 1;
            }
            assert!(!card.files.contains_key(NEW_FILE));
        }
        assert!(olds > 2 && news > 1, "{olds} {news}");
    }
}

/// The power may go again while the change is put in place at boot.
#[test]
fn a_second_power_cut_while_recovering_changes_nothing_about_it() {
    let (old, new) = (content(3, 900), content(4, 1_300));
    let before = card([(FILE, &old)]);
    for first in 0..40 {
        let mut card = Card { writes_left: Some(first), ..before.clone() };
        let done = save(&mut card, &new).is_ok();
        for second in 0..20 {
            let mut again = Card { writes_left: Some(second), ..card.rebooted() };
            let _ = settle(&mut again, FILE);
            let mut last = again.rebooted();
            settle(&mut last, FILE).unwrap();
            let found = &last.files[FILE];
            assert!(*found == new || (!done && *found == old), "after {first} and {second} writes");
        }
    }
}

#[test]
fn the_first_save_needs_no_file() {
    let mut fresh = Card::default();
    save(&mut fresh, &content(1, 600)).unwrap();
    assert_eq!(fresh.files, card([(FILE, &content(1, 600))]).files);
}

/// A draft that a power cut has left is no file, whatever it holds.
#[test]
fn a_draft_counts_for_nothing() {
    let mut card = card([(FILE, &content(1, 10)), (DRAFT_FILE, &content(9, 700))]);
    settle(&mut card, FILE).unwrap();
    assert_eq!(card.files[FILE], content(1, 10));
    save(&mut card, &content(2, 600)).unwrap();
    assert!(!card.files.contains_key(DRAFT_FILE));
}

#[test]
fn who_is_refused_has_changed_nothing() {
    let before = card([(FILE, &content(1, 10)), (PREVIOUS_FILE, &content(2, 10))]);
    for (no_room_for, read_only, error) in [
        (Some(NEW_FILE), None, StorageError::Full),
        (Some(PREVIOUS_FILE), None, StorageError::Full),
        (None, Some(FILE), StorageError::ReadOnly),
    ] {
        let mut card = Card { no_room_for, read_only, ..before.clone() };
        assert_eq!(save(&mut card, &content(3, 600)), Err(error));
        let mut card = card.rebooted();
        settle(&mut card, FILE).unwrap();
        assert_eq!(card.files[FILE], content(1, 10), "{no_room_for:?} {read_only:?}");
        assert!(!card.files.contains_key(DRAFT_FILE));
        assert!(!card.files.contains_key(NEW_FILE));
    }
}

#[test]
fn a_removed_file_does_not_come_back() {
    let mut card = card([(FILE, &content(1, 10)), (NEW_FILE, &content(2, 10))]);
    remove(&mut card, FILE).unwrap();
    settle(&mut card, FILE).unwrap();
    assert!(!card.files.contains_key(FILE));
    assert_eq!(card.files[PREVIOUS_FILE], content(1, 10));
    assert_eq!(remove(&mut card, FILE), Ok(()), "there need not be one");
}
