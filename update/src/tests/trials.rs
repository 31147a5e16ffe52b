//! Trials, confirmation and requests, without power failures.

use super::model::{Chip, Files, SMALL, image, start};
use crate::log::{Entry, Known, Log, Origin, Refusal, State};
use crate::verify::check_flash;
use crate::{Next, Policy};

fn known(chip: &mut Chip) -> Known {
    Known::of(&check_flash(chip, &SMALL, &Policy::default()).expect("a good image"))
}

fn state(chip: &mut Chip) -> State {
    Log::read(chip, &SMALL).state
}

fn append(chip: &mut Chip, entry: Entry) {
    Log::read(chip, &SMALL).append(chip, entry).expect("room in the log");
}

fn digest_of(next: Option<Next>) -> [u8; 32] {
    match next {
        Some(Next::Start(manifest)) => manifest.digest,
        other => panic!("it does not start: {other:?}"),
    }
}

#[test]
fn an_image_that_never_confirms_itself_is_replaced_at_the_fourth_start() {
    let (old, new) = (image(1, 2048), image(2, 2048));
    let mut chip = Chip::with(&old);
    let asked = known(&mut Chip::with(&new));
    append(&mut chip, Entry::Requested(Origin::File, asked));
    let mut card = Files::with(&[("flashme.bin", &new), ("firmware.previous", &old)]);
    for starts in 1..=3 {
        assert_eq!(digest_of(start(&mut chip, &mut card)), new[64..96]);
        assert_eq!(state(&mut chip).trial, Some(starts));
    }
    assert_eq!(digest_of(start(&mut chip, &mut card)), old[64..96]);
    let after = state(&mut chip);
    assert!(after.fell_back && after.trial.is_none(), "{after:?}");
    // And it stays.
    assert_eq!(digest_of(start(&mut chip, &mut card)), old[64..96]);
}

#[test]
fn a_confirmed_image_stays() {
    let (old, new) = (image(1, 2048), image(2, 2048));
    let mut chip = Chip::with(&old);
    let asked = known(&mut Chip::with(&new));
    append(&mut chip, Entry::Requested(Origin::File, asked));
    let mut card = Files::with(&[("flashme.bin", &new), ("firmware.previous", &old)]);
    start(&mut chip, &mut card);
    append(&mut chip, Entry::Confirmed(asked));
    for _ in 0..8 {
        assert_eq!(digest_of(start(&mut chip, &mut card)), new[64..96]);
    }
    assert_eq!(state(&mut chip).trial, None);
}

/// There is nothing better than the image that does not confirm itself.
#[test]
fn without_a_previous_image_the_trial_goes_on() {
    let new = image(2, 2048);
    for card in [Files::default(), Files::with(&[("firmware.previous", &new)])] {
        let mut chip = Chip::with(&new);
        let this = known(&mut chip);
        append(&mut chip, Entry::Installed(Origin::File, this));
        for _ in 0..8 {
            assert_eq!(digest_of(start(&mut chip, &mut card.clone())), new[64..96]);
        }
        append(&mut chip, Entry::Confirmed(this));
        assert_eq!(state(&mut chip).trial, None);
    }
}

#[test]
fn what_cannot_be_installed_is_refused_and_changes_nothing() {
    let (old, new) = (image(1, 2048), image(2, 2048));
    let asked = known(&mut Chip::with(&new));
    let mut spoiled = new.clone();
    spoiled[1000] ^= 4;
    for (file, why) in [(None, Refusal::NoFile), (Some(&spoiled), Refusal::Flawed), (Some(&old), Refusal::Flawed)] {
        let mut chip = Chip::with(&old);
        append(&mut chip, Entry::Requested(Origin::File, asked));
        let mut card = Files::default();
        card.files.extend(file.map(|bytes| ("flashme.bin".to_string(), bytes.clone())));
        assert_eq!(digest_of(start(&mut chip, &mut card)), old[64..96]);
        assert_eq!(state(&mut chip).refused, Some(why));
        assert_eq!(state(&mut chip).pending, None);
        assert_eq!(chip.operations, 2, "the request and its refusal");
    }
}

#[test]
fn the_policy_of_the_owner_is_kept_in_the_log() {
    let mut chip = Chip::new();
    for policy in [
        Policy { key: Some([0x5a; 32]), is_locked: true },
        Policy { key: Some([0x5a; 32]), is_locked: false },
        Policy::default(),
    ] {
        Log::read(&mut chip, &SMALL).set_policy(&mut chip, &policy).expect("room");
        assert_eq!(state(&mut chip).policy, policy);
        let operations = chip.operations;
        Log::read(&mut chip, &SMALL).set_policy(&mut chip, &policy).expect("room");
        assert_eq!(chip.operations, operations, "the same again writes nothing");
    }
}
