//! Trials, confirmation and requests, without power failures.

use super::model::{Chip, Files, SMALL, image, start};
use crate::log::{Arrival, Ended, Entry, Known, Log, Origin, Refusal, State};
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
    // The next start chooses the previous image again.
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

/// The power failed between the last word of the image and the word in the log that says so.
#[test]
fn an_image_that_is_all_there_is_on_trial_though_the_log_does_not_say_so() {
    let (old, new) = (image(1, 2048), image(2, 2048));
    for origin in [Origin::Usb, Origin::File] {
        let mut chip = Chip::with(&new);
        let this = known(&mut chip);
        append(&mut chip, Entry::Installed(Origin::File, known(&mut Chip::with(&old))));
        append(&mut chip, Entry::Began(origin, this));
        let mut card = Files::with(&[("firmware.previous", &old)]);
        for starts in 1..=3 {
            assert_eq!(digest_of(start(&mut chip, &mut card)), new[64..96]);
            assert_eq!(state(&mut chip).trial, Some(starts));
        }
        assert_eq!(digest_of(start(&mut chip, &mut card)), old[64..96]);
    }
}

#[test]
fn what_has_failed_is_known_until_it_is_installed_again() {
    let [failed, other] = [2, 3].map(|seed| known(&mut Chip::with(&image(seed, 2048))));
    let mut chip = Chip::new();
    append(&mut chip, Entry::Failed(Ended::Watchdog, failed));
    for origin in [Origin::Previous, Origin::Usb, Origin::Probe, Origin::File] {
        append(&mut chip, Entry::Installed(origin, other));
        assert_eq!(state(&mut chip).failed, Some((Ended::Watchdog, failed)));
    }
    append(&mut chip, Entry::Installed(Origin::File, failed));
    assert_eq!(state(&mut chip).failed, None);
}

/// The image that does not confirm itself goes on, as nothing better is there.
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
        assert_eq!(state(&mut chip).refused.map(|(why, _)| why), Some(why));
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

/// A debug probe has put another image into the place of the one on trial: it has nothing to confirm, and its
/// starts count for nobody.
#[test]
fn what_a_probe_puts_there_is_on_no_trial() {
    let (old, new, flashed) = (image(1, 2048), image(2, 2048), image(3, 2048));
    let mut chip = Chip::with(&new);
    let tried = known(&mut chip);
    append(&mut chip, Entry::Installed(Origin::File, tried));
    (0..3).for_each(|_| append(&mut chip, Entry::Tried));
    chip.flash(&flashed);
    let card = Files::with(&[("flashme.bin", &new), ("firmware.previous", &old)]);
    for _ in 0..8 {
        assert_eq!(digest_of(start(&mut chip, &mut card.clone())), flashed[64..96]);
    }
    let running = known(&mut chip);
    assert_eq!(state(&mut chip).arrival(running), Arrival::Probe);
    Log::read(&mut chip, &SMALL).confirm(&mut chip, running).expect("room");
    assert_eq!(state(&mut chip).arrival(running), Arrival::Known);
}

#[test]
fn how_an_image_came_to_run_is_told_from_request_to_confirmation() {
    let (old, new) = (image(1, 2048), image(2, 2048));
    let mut chip = Chip::with(&old);
    let (before, after) = (known(&mut chip), known(&mut Chip::with(&new)));
    let confirm = |chip: &mut Chip, image| Log::read(chip, &SMALL).confirm(chip, image).expect("room");
    confirm(&mut chip, before);
    append(&mut chip, Entry::Requested(Origin::File, after));
    let mut card = Files::with(&[("flashme.bin", &new), ("firmware.previous", &old)]);
    for starts in 1..=3 {
        start(&mut chip, &mut card);
        assert_eq!(state(&mut chip).arrival(after), Arrival::Trial(Origin::File, starts));
    }
    start(&mut chip, &mut card);
    assert_eq!(state(&mut chip).arrival(before), Arrival::FellBack(Ended::Watchdog));
    assert_eq!(state(&mut chip).failed, Some((Ended::Watchdog, after)));
    confirm(&mut chip, before);
    assert_eq!(state(&mut chip).arrival(before), Arrival::Known);
    assert_eq!(state(&mut chip).failed, Some((Ended::Watchdog, after)), "it is known still what failed");
    let operations = chip.operations;
    confirm(&mut chip, before);
    assert_eq!(chip.operations, operations, "what is known is not written again");
}

/// An image that has failed its trial is better than none where nothing in flash may run, and worse than any
/// other.
#[test]
fn an_image_that_failed_is_the_last_one_to_be_put_back() {
    let (old, new) = (image(1, 2048), image(2, 2048));
    for (files, expected) in
        [(vec![("flashme.bin", &new), ("firmware.previous", &old)], &old), (vec![("flashme.bin", &new)], &new)]
    {
        let mut chip = Chip::new();
        let failed = known(&mut Chip::with(&new));
        append(&mut chip, Entry::Failed(Ended::Itself, failed));
        let files: Vec<(&str, &[u8])> = files.into_iter().map(|(name, bytes)| (name, bytes.as_slice())).collect();
        assert_eq!(digest_of(start(&mut chip, &mut Files::with(&files))), expected[64..96]);
    }
}

/// A board that is switched on and off four thousand times within the first seconds.
#[test]
fn a_log_that_is_full_of_starts_is_made_room_in() {
    let new = image(2, 2048);
    let mut chip = Chip::with(&new);
    let this = known(&mut chip);
    append(&mut chip, Entry::Installed(Origin::Usb, this));
    for _ in 0..200 {
        start(&mut chip, &mut Files::default());
        assert!(matches!(state(&mut chip).arrival(this), Arrival::Trial(Origin::Usb, 1..)));
    }
    Log::read(&mut chip, &SMALL).confirm(&mut chip, this).expect("room");
    assert_eq!(state(&mut chip).arrival(this), Arrival::Known);
}
