//! Flaws of firmware files: the running firmware goes on, and where there is none, a good file makes up for
//! it.

use update::{Entry, Origin, PRIME, Policy, Refusal};

use super::cuts::SHORT;
use super::small::{Before, Came, Small, after, application, card, flash, known, linked, log, state};
use super::{Row, Share, tests};

pub const ROWS: &[Row] = &[
    row("wrong_magic", "it is for another board (wrong magic number)", |_| flawed(|_| spoiled(8, 1))),
    row("linked_for_another_address", "it is linked for another address", |_| flawed(|_| spoiled(21, 1))),
    row("no_manifest", "it is no Velvet firmware", |_| flawed(|_| vec![0x55; 5000])),
    row("for_the_beginning", "it takes the flash from its beginning, as Smoothieware does", |_| {
        flawed(|_| beginning())
    }),
    row("wrong_hash", "its SHA-256 is wrong", |_| flawed(|_| spoiled(SHORT - 1, 1))),
    row("wrong_md5", "the trailer's MD5 is wrong", |_| {
        flawed(|new| [new, &[0x03, 0x54, 0x76, 0x98, 0x78, 0x56, 0x34, 0x12], &[b'0'; 32]].concat())
    }),
    row("truncated", "it ends too soon", |_| flawed(|new| new[..SHORT - 100].to_vec())),
    row("too_large", "it says to be larger than flash", |_| flawed(|_| overlong())),
    row("something_behind", "something follows it", |_| flawed(|new| [new, b"hello".as_slice()].concat())),
    row("not_sealed", "it was linked and not sealed", |_| flawed(|_| linked(2, SHORT))),
    Row {
        name: "wrong_signature",
        what: "it is signed with another key than the owner's, or not at all on a locked board",
        does: "it is refused; what runs goes on",
        run: |_| signatures(),
    },
    Row {
        name: "another_file_by_then",
        what: "it is another file than the one that was looked at, or gone",
        does: "it is refused; what runs goes on",
        run: |_| another_by_then(),
    },
];

tests! {
    wrong_magic
    linked_for_another_address
    no_manifest
    for_the_beginning
    wrong_hash
    wrong_md5
    truncated
    too_large
    something_behind
    not_sealed
    wrong_signature
    another_file_by_then
}

const PATIENCE_MS: u64 = 20_000;

const fn row(name: &'static str, what: &'static str, run: fn(Share) -> usize) -> Row {
    let does = "it is refused; what runs goes on, and an empty board waits for another file";
    Row { name, what, does, run }
}

/// Asks for a flawed copy of a good file, on a board with running firmware and on an empty board, and then on
/// an empty board with the good file as well.
#[track_caller]
fn flawed(make: fn(&[u8]) -> Vec<u8>) -> usize {
    let (old, new) = (application(1, SHORT, None), application(2, SHORT, None));
    let file = make(&new);
    refuses(&flash(&old), &new, &[("flashme.bin", &file), ("firmware.previous", &old)], Refusal::Flawed);
    let mut empty = Small::on(&flash(&[]), Some(&card(&[("flashme.bin", &file)])));
    assert_eq!(empty.settle(PATIENCE_MS), Came::Waits);
    assert_eq!(empty.operations(), [], "nothing is written");
    let mut mended = Small::on(&flash(&[]), Some(&card(&[("flashme.bin", &file), ("velvet.bin", &new)])));
    assert_eq!(mended.settle(PATIENCE_MS), Came::Runs(2));
    3
}

/// Asks for the image; asserts that image 1 goes on, and that the log gives the reason.
#[track_caller]
fn refuses(content: &virtual_prime::flash_journal::FlashContent, asked: &[u8], files: &[(&str, &[u8])], why: Refusal) {
    let mut content = content.clone();
    log(&mut content, Entry::Requested(Origin::File, known(asked)));
    let mut board = Small::on(&content, Some(&card(files)));
    assert_eq!(board.settle(PATIENCE_MS), Came::Runs(1), "{}", board.said());
    let operations = board.operations();
    assert_eq!(operations.len(), 1, "the refusal alone is written");
    let then = state(&mut after(&content, &operations));
    assert_eq!((then.refused.map(|(why, _)| why), then.pending), (Some(why), None));
}

/// Changes a byte of a good image. The file is sealed over the bytes behind its manifest alone.
fn spoiled(at: usize, change: u8) -> Vec<u8> {
    let mut image = application(2, SHORT, None);
    image[at] ^= change;
    image
}

fn overlong() -> Vec<u8> {
    let mut image = application(2, SHORT, None);
    image[16..20].copy_from_slice(&(PRIME.image_bytes() + 32).to_le_bytes());
    image
}

/// Builds a file with a vector table first, as every image has that was linked for the flash's beginning.
fn beginning() -> Vec<u8> {
    let mut image = vec![0x55; 0x2_0000 + 5000];
    image[..8].copy_from_slice(&[0x00, 0x00, 0x02, 0x20, 0x91, 0x02, 0x00, 0x08]);
    image
}

fn signatures() -> usize {
    let (owner, stranger) = ([7; 32], [8; 32]);
    let key = Some(update::public_key(&owner));
    let old = application(1, SHORT, Some(&owner));
    let cases = [
        (application(2, SHORT, Some(&stranger)), false, false),
        (application(2, SHORT, Some(&stranger)), true, false),
        (application(2, SHORT, None), true, false),
        (application(2, SHORT, None), false, true),
        (application(2, SHORT, Some(&owner)), true, true),
        (application(2, SHORT, Some(&owner)), false, true),
    ];
    for (file, is_locked, runs) in &cases {
        let mut content = flash(&old);
        let mut before = Before(&mut content);
        let mut log_of_it = update::Log::read(&mut before, &PRIME);
        log_of_it.set_policy(&mut before, &Policy { key, is_locked: *is_locked }).expect("room");
        let files: [(&str, &[u8]); 2] = [("flashme.bin", file), ("firmware.previous", &old)];
        if *runs {
            log(&mut content, Entry::Requested(Origin::File, known(file)));
            let mut board = Small::on(&content, Some(&card(&files)));
            assert_eq!(board.settle(PATIENCE_MS), Came::Runs(2), "{}", board.said());
        } else {
            refuses(&content, file, &files, Refusal::Flawed);
        }
    }
    // The same rule holds for the image in flash: a locked board whose firmware has no signature takes the
    // owner's file.
    let mut content = flash(&application(2, SHORT, None));
    let mut before = Before(&mut content);
    update::Log::read(&mut before, &PRIME).set_policy(&mut before, &Policy { key, is_locked: true }).expect("room");
    let mut board = Small::on(&content, Some(&card(&[("firmware.previous", &old)])));
    assert_eq!(board.settle(PATIENCE_MS), Came::Runs(1), "{}", board.said());
    cases.len() + 1
}

fn another_by_then() -> usize {
    let (old, new, other) = (application(1, SHORT, None), application(2, SHORT, None), application(3, SHORT, None));
    let content = flash(&old);
    refuses(&content, &new, &[("flashme.bin", &other)], Refusal::Flawed);
    refuses(&content, &new, &[("firmware.previous", &old)], Refusal::NoFile);
    2
}
