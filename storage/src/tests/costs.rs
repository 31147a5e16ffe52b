//! Costs of calls in blocks read and written. The numbers are those that the present code needs; more would
//! be a step back.

use std::format;

use base::ports::{OpenMode, Storage};

use super::card::{Mounted, content, fat32, mounted};
use super::contents::save;
use crate::ram::{Counts, RamCard};

/// A root directory with this many files of four slots each.
fn filled(files: usize) -> RamCard {
    let card = fat32();
    let mut storage = mounted(&card);
    for number in 0..files {
        save(&mut storage, &format!("/sd/a name that takes four slots {number:03}"), &content(number, 100)).unwrap();
    }
    card
}

fn cost(card: &RamCard, call: impl FnOnce(&mut Mounted)) -> Counts {
    let card = card.powered_for(None);
    let mut storage = mounted(&card);
    let before = card.counts();
    call(&mut storage);
    let after = card.counts();
    Counts { reads: after.reads - before.reads, writes: after.writes - before.writes }
}

#[track_caller]
fn assert_at_most(cost: Counts, reads: u32, writes: u32) {
    assert!(cost.reads <= reads && cost.writes <= writes, "{cost:?}");
}

#[test]
fn calls_read_few_blocks() {
    // 100 files: 401 slots in 26 blocks, and as many in the table between them, as each is a cluster.
    let card = filled(100);
    let mounting = card.powered_for(None);
    let _storage = mounted(&mounting);
    assert_at_most(mounting.counts(), 60, 0);
    let path = "/sd/a name that takes four slots 099";
    let open = |mode| move |storage: &mut Mounted| assert!(storage.open(path, mode).is_ok());
    // The directory is read three times: for its name, for its short name, and to open it.
    assert_at_most(cost(&card, open(OpenMode::Read)), 160, 0);
    assert_at_most(cost(&card, open(OpenMode::Write)), 160, 3);
    let listing = cost(&card, |storage| {
        let (mut entries, mut count) = (heapless::Vec::new(), 0);
        loop {
            storage.list("/sd", count, &mut entries).unwrap();
            count += entries.len();
            if entries.is_empty() {
                break;
            }
        }
        assert_eq!(count, 100);
    });
    // Listing goes on where it was: four entries a call take 16 slots, with their block, the one before or
    // behind, and the table's.
    assert_at_most(listing, 155, 0);
    let one_by_one = cost(&card, |storage| {
        let named = |entry: Option<base::ports::DirectoryEntry>| entry.map(|entry| entry.name);
        let mut count = 0;
        while let Some(name) = named(storage.entry("/sd", count).unwrap()) {
            assert_eq!(named(storage.entry("/sd", count).unwrap()), Some(name), "the same again");
            count += 1;
        }
        assert_eq!(count, 100);
    });
    // Twice each, four slots at a time.
    assert_at_most(one_by_one, 2 * 100 * 3, 0);
    assert_at_most(cost(&card, |storage| storage.rename(path, "/sd/another name for it").unwrap()), 160, 2);
    assert_at_most(cost(&card, |storage| storage.remove(path).unwrap()), 60, 4);
}

/// A file of a megabyte: its table entries go with one write for each block of the table, not for each
/// cluster.
#[test]
fn a_large_file_is_freed_with_few_writes() {
    let card = fat32();
    save(&mut mounted(&card), "/sd/large", &content(1, 1 << 20)).unwrap();
    // 2,048 clusters, 128 to a block of the table, and both tables.
    assert_at_most(cost(&card, |storage| storage.remove("/sd/large").unwrap()), 20, 2 * 17 + 1);
}
