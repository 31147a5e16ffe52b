//! The power goes at every block write of whole calls: of what is made of names here and of contents there.

use std::format;
use std::string::{String, ToString};

use base::ports::{Storage, StorageError};
use card::fat::same_name;
use proptest::prelude::*;

use super::card::{Mounted, clean, content, fat16, fat32, mounted, read};
use super::checker::Node;
use super::contents::save;
use crate::ram::RamCard;

#[derive(Clone, Debug)]
enum Change {
    Save(String, usize),
    Remove(String),
    Rename(String, String),
    MakeDirectory(String),
}

fn path() -> impl Strategy<Value = String> {
    let names = ["config.ini", "config.initial", "benchy_part_one.gcode", "benchy_part_two.gcode", "sub"];
    let long = "a name over two blocks ".repeat(9);
    let name = prop_oneof![5 => proptest::sample::select(names.to_vec()).prop_map(str::to_string), 1 => Just(long)];
    (proptest::sample::select(std::vec!["/sd", "/sd", "/sd/sub"]), name)
        .prop_map(|(directory, name)| format!("{directory}/{name}"))
}

fn change() -> impl Strategy<Value = Change> {
    prop_oneof![
        4 => (path(), 0..4_000_usize).prop_map(|(path, size)| Change::Save(path, size)),
        2 => path().prop_map(Change::Remove),
        2 => (path(), path()).prop_map(|(from, to)| Change::Rename(from, to)),
        1 => path().prop_map(Change::MakeDirectory),
        1 => Just(Change::MakeDirectory("/sd/sub".into())),
    ]
}

fn apply(storage: &mut Mounted, change: &Change) -> Result<(), StorageError> {
    match change {
        Change::Save(path, size) => save(storage, path, &content(*size, *size)),
        Change::Remove(path) => storage.remove(path),
        Change::Rename(from, to) => storage.rename(from, to),
        Change::MakeDirectory(path) => storage.make_directory(path),
    }
}

type Tree = std::collections::BTreeMap<String, Node>;

fn same(one: &Tree, other: &Tree) -> bool {
    one.len() == other.len()
        && one.iter().zip(other).all(|(one, other)| one.0 == other.0 && one.1.content == other.1.content)
}

/// Returns the tree after a file was saved, but with that file empty.
fn begun(after: &Tree, change: &Change) -> Option<Tree> {
    let Change::Save(path, _) = change else { return None };
    let mut begun = after.clone();
    let saved = begun.iter_mut().find(|(name, _)| same_name(name, path.trim_start_matches("/sd/")))?.1;
    saved.content = Some(std::vec::Vec::new());
    Some(begun)
}

fn cut_everywhere(card: &RamCard, change: &Change) {
    let before = read(card).tree;
    let whole = card.powered_for(None);
    if apply(&mut mounted(&whole), change).is_err() {
        return;
    }
    let after = clean(&whole).tree;
    let begun = begun(&after, change);
    for writes in 0..whole.counts().writes {
        let what = format!("{change:?} after {writes} of {} writes", whole.counts().writes);
        let cut = card.powered_for(Some(writes));
        let refused = apply(&mut mounted(&cut), change);
        // A file that could not grow gives `Device`: all that is known is that there would have been room.
        assert!(matches!(refused, Err(StorageError::NotResponding | StorageError::Device)), "{what}: {refused:?}");
        let _nothing_crossed = read(&cut);
        // The power comes on again.
        let cut = cut.powered_for(None);
        let mut storage = mounted(&cut);
        let tree = read(&cut).tree;
        let is_begun = begun.as_ref().is_some_and(|begun| same(&tree, begun));
        assert!(same(&tree, &before) || same(&tree, &after) || is_begun, "{what}: {:?}", tree.keys());
        if let Change::Save(..) = change {
            apply(&mut storage, change).unwrap();
            assert!(same(&read(&cut).tree, &after), "{what}");
        }
    }
}

fn run(card: &RamCard, changes: &[Change]) {
    for change in changes {
        cut_everywhere(card, change);
        let _refused = apply(&mut mounted(card), change);
        clean(card);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]
    #[test]
    fn a_cut_harms_no_other_file(changes in proptest::collection::vec(change(), 1..16)) {
        run(&fat16(), &changes);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2))]
    #[test]
    fn a_cut_harms_no_other_file_on_fat32(changes in proptest::collection::vec(change(), 1..12)) {
        run(&fat32(), &changes);
    }
}
