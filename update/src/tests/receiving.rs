//! Files that come piece after piece.

use super::model::{Chip, Files, SMALL, for_the_whole_flash, image, owner, sign, start, with_trailer};
use crate::log::{Arrival, Entry, Known, Log, Origin};
use crate::{Flaw, Next, NotInstalled, Policy, Receiving, TRIALS, check_flash};
use ed25519_dalek::SigningKey;

/// Sends a file to a board whose card holds firmware to come back to.
fn send(chip: &mut Chip, file: &[u8], piece: usize) -> Result<Known, NotInstalled> {
    let previous = sign(image(1, 2048), &owner());
    send_with(chip, &mut Files::with(&[("firmware.previous", &previous)]), file, piece)
}

fn send_with(chip: &mut Chip, card: &mut Files, file: &[u8], piece: usize) -> Result<Known, NotInstalled> {
    let mut receiving = Receiving::new(&SMALL);
    for piece in file.chunks(piece) {
        receiving.take(chip, card, piece)?;
    }
    receiving.finish(chip).map(|manifest| Known::of(&manifest))
}

/// Every kind of file that `make firmware` makes comes in pieces of any size.
#[test]
fn every_kind_of_file_is_received() {
    let (old, new) = (image(1, 2048), image(2, 4128));
    let files =
        [new.clone(), with_trailer(new.clone()), for_the_whole_flash(&new), with_trailer(for_the_whole_flash(&new))];
    for file in files {
        for piece in [1, 7, 32, 100, 256, 300, 4096, 100_000] {
            let mut chip = Chip::with(&old);
            let known = send(&mut chip, &file, piece).expect("a good file");
            assert_eq!(chip.image(new.len()), new, "in pieces of {piece}");
            let state = Log::read(&mut chip, &SMALL).state;
            assert_eq!((state.arrival(known), state.pending), (Arrival::Trial(Origin::Usb, 0), None));
        }
    }
}

/// An image for another board, or not by the owner, is refused before the flash is touched.
#[test]
fn what_may_not_run_costs_nothing() {
    let (old, new) = (image(1, 2048), image(2, 4128));
    let mut other_board = new.clone();
    other_board[8] ^= 1;
    let locked = Policy { key: Some(owner().verifying_key().to_bytes()), is_locked: true };
    let stranger = sign(new.clone(), &SigningKey::from_bytes(&[8; 32]));
    let cases = [
        (other_board, Policy::default(), Flaw::OtherBoard),
        (vec![0x55; 5000], Policy::default(), Flaw::NoManifest),
        (for_the_whole_flash(&[0x55; 2048]), Policy::default(), Flaw::FromTheBeginning),
        (new.clone(), locked, Flaw::Unsigned),
        (stranger, locked, Flaw::Signature),
    ];
    for (file, policy, flaw) in cases {
        let mut chip = Chip::with(&old);
        Log::read(&mut chip, &SMALL).set_policy(&mut chip, &policy).expect("room");
        let operations = chip.operations;
        assert_eq!(send(&mut chip, &file, 256), Err(NotInstalled::Flawed(flaw)));
        assert_eq!(chip.operations, operations, "{flaw:?}");
    }
    let mut chip = Chip::with(&old);
    Log::read(&mut chip, &SMALL).set_policy(&mut chip, &locked).expect("room");
    send(&mut chip, &sign(new, &owner()), 256).expect("it is the owner's");
}

/// An image that may run is not given up without another that may.
#[test]
fn what_runs_is_replaced_only_with_something_to_come_back_to() {
    let (old, new) = (image(1, 2048), image(2, 4128));
    let mut spoiled = old.clone();
    spoiled[2000] ^= 1;
    for files in [&[][..], &[("firmware.previous", &spoiled)], &[("other.bin", &old)]] {
        let files: Vec<(&str, &[u8])> = files.iter().map(|(name, bytes)| (*name, bytes.as_slice())).collect();
        let mut chip = Chip::with(&old);
        let operations = chip.operations;
        let sent = send_with(&mut chip, &mut Files::with(&files), &new, 256);
        assert_eq!((sent, chip.operations), (Err(NotInstalled::NoCopy), operations), "nothing is touched");
        let mut failed = Chip::with(&old);
        let is_old = Known::of(&check_flash(&mut failed, &SMALL, &Policy::default()).expect("a good image"));
        let mut log = Log::read(&mut failed, &SMALL);
        log.append(&mut failed, Entry::Installed(Origin::Usb, is_old)).expect("room");
        (0..TRIALS).for_each(|_| log.append(&mut failed, Entry::Tried).expect("room"));
        send_with(&mut failed, &mut Files::with(&files), &new, 256).expect("its trial has failed");
        // An image that may not run is nothing to lose either.
        let mut broken = Chip::with(&spoiled);
        send_with(&mut broken, &mut Files::with(&files), &new, 256).expect("a good file");
    }
    for name in ["firmware.previous", "firmware.tmp", "flashme.bin", "velvet.bin"] {
        let mut chip = Chip::with(&old);
        send_with(&mut chip, &mut Files::with(&[(name, &old)]), &new, 256).expect("a good file");
    }
}

/// A file whose flaw shows at its end alone is not started, and the previous image comes back from the card.
#[test]
fn what_is_flawed_at_its_end_is_not_started() {
    let (old, new) = (image(1, 2048), image(2, 4128));
    let mut spoiled = new.clone();
    spoiled[4100] ^= 1;
    let cases = [
        (new[..4000].to_vec(), Flaw::Truncated { is: 4000, says: 4128 }),
        (spoiled, Flaw::Digest),
        ([new.as_slice(), b"hello"].concat(), Flaw::Trailer),
    ];
    for (file, flaw) in cases {
        let mut chip = Chip::with(&old);
        assert_eq!(send(&mut chip, &file, 256), Err(NotInstalled::Flawed(flaw)));
        assert!(matches!(start(&mut chip.clone(), &mut Files::default()), Some(Next::Recover(_))));
        let again = send_with(&mut chip.clone(), &mut Files::default(), &new, 256);
        assert!(again.is_ok(), "it is sent again");
        start(&mut chip, &mut Files::with(&[("firmware.previous", &old)]));
        assert!(check_flash(&mut chip, &SMALL, &Policy::default()).is_ok_and(|found| found.digest == old[64..96]));
    }
}

#[test]
fn a_request_that_waits_does_not_outlive_a_download() {
    let (old, new) = (image(1, 2048), image(2, 4128));
    let mut chip = Chip::with(&old);
    let asked = Known { length: 4000, digest: [7; 16] };
    Log::read(&mut chip, &SMALL).append(&mut chip, Entry::Requested(Origin::File, asked)).expect("room");
    send(&mut chip, &new, 256).expect("a good file");
    assert_eq!(Log::read(&mut chip, &SMALL).state.pending, None);
}
