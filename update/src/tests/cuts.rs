//! The power fails at every erase and every programmed word of every path: the next start has a working
//! image.

use super::model::{Chip, Cut, Files, SMALL, for_the_whole_flash, image, owner, sign, start, with_trailer};
use crate::flash::Flash as _;
use crate::log::{Entry, Known, Log, Origin};
use crate::verify::{Image, check_flash};
use crate::{Manifest, Next, Policy, Receiving};

fn manifest(bytes: &[u8]) -> Manifest {
    let mut chip = Chip::with(bytes);
    check_flash(&mut chip, &SMALL, &Policy::default()).expect("a good image")
}

fn known(bytes: &[u8]) -> Known {
    Known::of(&manifest(bytes))
}

fn entry(chip: &mut Chip, entry: Entry) {
    Log::read(chip, &SMALL).append(chip, entry).expect("room in the log");
}

/// Cuts the power once, beginning with `chip` and `card`, at every operation in turn, and then once more
/// during the start after that. At the end one of `good` runs, whole.
fn always_runs(chip: &Chip, card: &Files, good: &[&[u8]]) {
    let mut whole = chip.clone();
    whole.operations = 0;
    assert!(matches!(start(&mut whole, &mut card.clone()), Some(Next::Start(_))));
    runs(&mut whole, good);
    let operations = whole.operations;
    assert!(operations > 2, "nothing was done");
    for kind in [Cut::Before, Cut::Within, Cut::After] {
        for first in 1..=operations {
            let mut cut = chip.clone();
            (cut.operations, cut.cut) = (0, Some((first, kind)));
            let mut card = card.clone();
            assert_eq!(start(&mut cut, &mut card), None, "at {first}");
            for second in (1..=operations).step_by(7) {
                let mut again = cut.clone();
                again.operations = 0;
                again.cut = Some((second, kind));
                while start(&mut again, &mut card).is_none() {
                    again.cut = None;
                }
                runs(&mut again, good);
            }
        }
    }
}

fn runs(chip: &mut Chip, good: &[&[u8]]) {
    let found = check_flash(chip, &SMALL, &Policy::default()).expect("an image that may run");
    let bytes = chip.image(found.length as usize);
    assert!(good.contains(&bytes.as_slice()), "another image");
}

#[test]
fn an_install_that_was_asked_for_is_finished() {
    let (old, new) = (image(1, 2048), image(2, 4128));
    let mut chip = Chip::with(&old);
    entry(&mut chip, Entry::Requested(Origin::File, known(&new)));
    let card = Files::with(&[("flashme.bin", &new), ("firmware.previous", &old)]);
    always_runs(&chip, &card, &[&new]);
    let whole = with_trailer(for_the_whole_flash(&new));
    always_runs(&chip, &Files::with(&[("flashme.bin", &whole), ("firmware.previous", &old)]), &[&new]);
}

#[test]
fn an_install_over_a_longer_image_is_finished() {
    let (old, new) = (image(1, 9184), image(2, 1088));
    let mut chip = Chip::with(&old);
    entry(&mut chip, Entry::Requested(Origin::File, known(&new)));
    always_runs(&chip, &Files::with(&[("flashme.bin", &new)]), &[&new]);
}

#[test]
fn going_back_is_finished() {
    let (old, new) = (image(1, 4096), image(2, 2080));
    for name in ["firmware.previous", "firmware.tmp"] {
        let mut chip = Chip::with(&new);
        entry(&mut chip, Entry::Installed(Origin::File, known(&new)));
        (0..3).for_each(|_| entry(&mut chip, Entry::Tried));
        always_runs(&chip, &Files::with(&[("flashme.bin", &new), (name, &old)]), &[&old]);
    }
}

#[test]
fn an_empty_board_takes_an_image_from_the_card() {
    let new = image(3, 4000);
    for name in ["flashme.bin", "velvet.bin", "firmware.previous"] {
        always_runs(&Chip::new(), &Files::with(&[(name, &new)]), &[&new]);
    }
}

/// The file is exchanged or deleted, or the card comes out, when the new image is half in flash: the previous
/// one is put back.
#[test]
fn a_file_that_is_gone_half_way_costs_nothing_but_the_new_image() {
    let (old, new, other) = (image(1, 2048), image(2, 6144), image(4, 2048));
    for present in [None, Some(other.clone()), Some(new[..1000].to_vec())] {
        let mut chip = Chip::with(&old);
        entry(&mut chip, Entry::Requested(Origin::File, known(&new)));
        let mut card = Files::with(&[("flashme.bin", &new), ("firmware.previous", &old)]);
        chip.cut = Some((chip.operations + 60, Cut::Within));
        assert_eq!(start(&mut chip, &mut card), None);
        card.files.remove("flashme.bin");
        let is_other = present.as_ref() == Some(&other);
        card.files.extend(present.map(|bytes| ("flashme.bin".to_string(), bytes)));
        chip.cut = None;
        assert!(matches!(start(&mut chip, &mut card), Some(Next::Start(_))));
        // A whole image by the same name is as good as the one that was there.
        runs(&mut chip, &[if is_other { &other } else { &old }]);
    }
}

#[test]
fn a_card_that_comes_back_is_gone_on_with() {
    let new = image(2, 6144);
    let mut chip = Chip::new();
    let mut card = Files::with(&[("velvet.bin", &new)]);
    card.ends_at = Some(3000);
    assert!(matches!(start(&mut chip, &mut card), Some(Next::Recover(_))));
    card.ends_at = None;
    assert!(matches!(start(&mut chip, &mut card), Some(Next::Start(_))));
    runs(&mut chip, &[&new]);
}

/// A download by USB, with a card that has the previous image: without one it is not begun.
#[test]
fn a_download_that_is_cut_off_leaves_the_previous_image() {
    let (old, new) = (image(1, 2048), image(2, 4128));
    let mut is_whole = false;
    for operations in 1..140 {
        let mut chip = Chip::with(&old);
        let mut card = Files::with(&[("firmware.previous", &old)]);
        chip.cut = Some((operations, Cut::Within));
        let cut = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| {
            let mut receiving = Receiving::new(&SMALL);
            new.chunks(100).for_each(|piece| receiving.take(&mut chip, &mut card, piece).expect("room"));
            receiving.finish(&mut chip).expect("good");
        }));
        chip.cut = None;
        is_whole = cut.is_ok();
        assert!(matches!(start(&mut chip, &mut card), Some(Next::Start(_))), "at {operations}");
        let may_run = [new.as_slice(), &old];
        runs(&mut chip, if is_whole { &may_run[..1] } else { &may_run });
    }
    assert!(is_whole, "every operation was cut");
}

#[test]
fn making_room_in_the_log_may_be_cut_off() {
    let new = image(2, 2048);
    let mut chip = Chip::with(&new);
    entry(&mut chip, Entry::Installed(Origin::File, known(&new)));
    (0..40).for_each(|_| entry(&mut chip, Entry::Confirmed(known(&new))));
    let mut tidied = chip.clone();
    start(&mut tidied, &mut Files::default());
    assert!(tidied.operations > 2, "room was made");
    let state = Log::read(&mut tidied, &SMALL).state;
    assert_eq!(state.installed, Some((Origin::File, known(&new))));
    assert_eq!(state.trial, None);
    always_runs(&chip, &Files::default(), &[&new]);
}

/// Nor does an install afterwards that erases the copy.
#[test]
fn the_policy_outlives_making_room_in_the_log_wherever_that_is_cut_off() {
    let [old, new] = [image(1, 2048), image(2, 9184)].map(|image| sign(image, &owner()));
    let locked = Policy { key: Some(owner().verifying_key().to_bytes()), is_locked: true };
    let mut full = Chip::with(&old);
    Log::read(&mut full, &SMALL).set_policy(&mut full, &locked).expect("room");
    (0..40).for_each(|_| entry(&mut full, Entry::Confirmed(known(&old))));
    full.operations = 0;
    let policy = |chip: &mut Chip| Log::read(chip, &SMALL).state.policy;
    let mut operations = 1;
    let mut was_only_the_copy = 0;
    loop {
        let mut is_whole = false;
        for kind in [Cut::Before, Cut::Within, Cut::After] {
            let mut chip = full.clone();
            chip.cut = Some((operations, kind));
            is_whole = start(&mut chip, &mut Files::default()).is_some();
            chip.cut = None;
            assert_eq!(policy(&mut chip), locked, "{kind:?} at {operations}");
            was_only_the_copy += usize::from(!Log::read(&mut chip, &SMALL).state.says_policy());
            start(&mut chip, &mut Files::default()).expect("power");
            entry(&mut chip, Entry::Requested(Origin::File, known(&new)));
            start(&mut chip, &mut Files::with(&[("flashme.bin", &new)])).expect("power");
            assert_eq!(policy(&mut chip), locked, "after an install, {kind:?} at {operations}");
            assert!(chip.image(new.len()) == new, "it is installed, {kind:?} at {operations}");
        }
        if is_whole {
            break;
        }
        operations += 1;
    }
    assert!(was_only_the_copy > 3, "the copy was all there was");
}

/// The copy left behind is of the policy before, which is no longer in force.
#[test]
fn a_policy_that_was_given_up_does_not_come_back_by_its_copy() {
    let new = image(2, 2048);
    let mut chip = Chip::with(&new);
    for policy in [Policy { key: Some([0x5a; 32]), is_locked: false }, Policy::default()] {
        Log::read(&mut chip, &SMALL).set_policy(&mut chip, &policy).expect("room");
        (0..40).for_each(|_| entry(&mut chip, Entry::Confirmed(known(&new))));
        start(&mut chip, &mut Files::default()).expect("power");
        assert_eq!(Log::read(&mut chip, &SMALL).state.policy, policy);
        chip.erase(SMALL.log).expect("an erase");
        assert_eq!(Log::read(&mut chip, &SMALL).state.policy, policy, "by the copy");
    }
}

/// A log that fills up in a trial without end is emptied all the same.
#[test]
fn making_room_waits_for_the_end_of_a_trial() {
    let [old, new] = [image(1, 2048), image(2, 2048)];
    let mut chip = Chip::with(&new);
    (0..31).for_each(|_| entry(&mut chip, Entry::Confirmed(known(&old))));
    entry(&mut chip, Entry::Installed(Origin::File, known(&new)));
    chip.operations = 0;
    let mut card = Files::with(&[("firmware.previous", &old)]);
    (1..=3).for_each(|starts| {
        start(&mut chip, &mut card).expect("power");
        assert_eq!(Log::read(&mut chip, &SMALL).state.trial, Some(starts));
        assert_eq!(chip.operations, usize::from(starts), "no erase");
    });
    let mut lonely = chip.clone();
    for _ in 0..100 {
        start(&mut lonely, &mut Files::default()).expect("power");
    }
    entry(&mut lonely, Entry::Confirmed(known(&new)));
    start(&mut chip, &mut card).expect("power");
    runs(&mut chip, &[&old]);
}

#[test]
fn a_flash_word_that_takes_nothing_never_makes_a_wrong_image_run() {
    let (old, new) = (image(1, 2048), image(2, 4128));
    let mut chip = Chip::with(&old);
    entry(&mut chip, Entry::Requested(Origin::File, known(&new)));
    chip.bad = vec![SMALL.image() + 2560];
    let mut card = Files::with(&[("flashme.bin", &new), ("firmware.previous", &old)]);
    assert!(matches!(start(&mut chip, &mut card), Some(Next::Start(_))));
    runs(&mut chip, &[&old]);
}

#[test]
fn bytes_of_flash_are_read_from_any_place() {
    let bytes = image(5, 2048);
    let mut chip = Chip::with(&bytes);
    for (at, length) in [(0, 1), (31, 2), (33, 100), (2000, 48)] {
        let mut read = vec![0; length];
        crate::Bytes::read(&mut Image::new(&mut chip, &SMALL), at, &mut read).expect("readable");
        assert_eq!(read, bytes[at as usize..][..length]);
    }
    assert!(chip.read(0).is_ok());
}
