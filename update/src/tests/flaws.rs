//! Every flaw that a file can have, and the sentence for it. None of them touches the flash.

use super::model::{Chip, Files, SMALL, for_the_whole_flash, image, linked, owner, sign, start, with_trailer};
use crate::policy::Policy;
use crate::verify::check_file;
use crate::{Card, Flaw, Next};
use ed25519_dalek::SigningKey;

fn found(bytes: &[u8], policy: &Policy) -> Result<(), Flaw> {
    let mut card = Files::with(&[("flashme.bin", bytes)]);
    let mut file = card.open("flashme.bin").expect("a file");
    check_file(&mut file, &SMALL, policy).map(|_| ())
}

fn spoiled(mut bytes: Vec<u8>, at: usize, value: &[u8]) -> Vec<u8> {
    bytes[at..at + value.len()].copy_from_slice(value);
    bytes
}

#[test]
fn each_flaw_has_its_name() {
    let good = image(1, 2048);
    let open = Policy::default();
    let smoothie = with_trailer(for_the_whole_flash(&[0x55; 2048]));
    let whole = for_the_whole_flash(&good);
    let long = (SMALL.image_bytes() + 32).to_le_bytes();
    let mut trailing = good.clone();
    trailing.extend(b"hello");
    let unsealed = linked(1, 2048);
    let cases: [(&str, Vec<u8>, Flaw); 18] = [
        ("empty", Vec::new(), Flaw::NoManifest),
        ("a text", b"G1 X10\n".repeat(100), Flaw::NoManifest),
        ("of Smoothieware", smoothie, Flaw::FromTheBeginning),
        ("a boot stage alone", for_the_whole_flash(&[]), Flaw::FromTheBeginning),
        ("whole, for another board", spoiled(whole.clone(), 2048 + 8, &[1]), Flaw::OtherBoard),
        ("whole, cut off", whole[..4000].to_vec(), Flaw::Truncated { is: 4000, says: 4096 }),
        ("whole, MD5 wrong", spoiled(with_trailer(whole.clone()), 100, &[0]), Flaw::Md5),
        ("for another board", spoiled(good.clone(), 8, &[1]), Flaw::OtherBoard),
        ("for another address", spoiled(good.clone(), 20, &[0, 0, 0, 8]), Flaw::OtherAddress(0x0800_0000)),
        ("too long", spoiled(good.clone(), 16, &long), Flaw::Length(SMALL.image_bytes() + 32)),
        ("too short", spoiled(good.clone(), 16, &[0, 4, 0, 0]), Flaw::Length(1024)),
        ("no whole words", spoiled(good.clone(), 16, &[1, 8, 0, 0]), Flaw::Length(2049)),
        ("cut off", good[..2000].to_vec(), Flaw::Truncated { is: 2000, says: 2048 }),
        ("with something behind it", trailing, Flaw::Trailer),
        ("not sealed", unsealed, Flaw::Unsealed),
        ("a bit wrong", spoiled(good.clone(), 1999, &[!good[1999]]), Flaw::Digest),
        ("its version changed", spoiled(good.clone(), 24, b"9"), Flaw::Digest),
        ("MD5 wrong", spoiled(with_trailer(good.clone()), 2048 + 8, b"zz"), Flaw::Md5),
    ];
    for (name, bytes, flaw) in cases {
        assert_eq!(found(&bytes, &open), Err(flaw), "{name}");
        let old = image(9, 1088);
        let mut chip = Chip::with(&old);
        let next = start(&mut chip, &mut Files::with(&[("flashme.bin", &bytes)]));
        assert!(matches!(next, Some(Next::Start(manifest)) if manifest.digest == old[64..96]), "{name}");
        assert_eq!(chip.operations, 0);
        // The board has nothing else to run, so it waits and says what it found.
        assert_eq!(
            start(&mut Chip::new(), &mut Files::with(&[("flashme.bin", &bytes)])),
            Some(Next::Recover(Flaw::NoManifest))
        );
    }
}

#[test]
fn a_good_file_is_taken_as_it_is_and_with_the_trailer_of_v2() {
    let good = image(1, 2048);
    assert_eq!(found(&good, &Policy::default()), Ok(()));
    assert_eq!(found(&with_trailer(good.clone()), &Policy::default()), Ok(()));
    let whole = for_the_whole_flash(&good);
    assert_eq!(found(&whole, &Policy::default()), Ok(()));
    assert_eq!(found(&with_trailer(whole), &Policy::default()), Ok(()));
    let other = spoiled(with_trailer(good), 2048, &[9]);
    assert_eq!(found(&other, &Policy::default()), Err(Flaw::OtherBoard));
}

#[test]
fn the_owner_says_whose_images_may_run() {
    let good = image(1, 2048);
    let stranger = SigningKey::from_bytes(&[8; 32]);
    let key = Some(owner().verifying_key().to_bytes());
    let open = Policy { key: None, is_locked: false };
    let keyed = Policy { key, is_locked: false };
    let locked = Policy { key, is_locked: true };
    let signed = sign(good.clone(), &owner());
    let foreign = sign(good.clone(), &stranger);
    let table = [
        (&good, open, Ok(())),
        (&good, keyed, Ok(())),
        (&good, locked, Err(Flaw::Unsigned)),
        (&signed, open, Ok(())),
        (&signed, keyed, Ok(())),
        (&signed, locked, Ok(())),
        (&foreign, open, Ok(())),
        (&foreign, keyed, Err(Flaw::Signature)),
        (&foreign, locked, Err(Flaw::Signature)),
    ];
    for (bytes, policy, expected) in table {
        assert_eq!(found(bytes, &policy), expected, "{policy:?}");
    }
}
