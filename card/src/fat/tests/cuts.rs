//! Tests that cut the power at every single block write of random changes.

use proptest::prelude::*;

use super::card::{Card, Format, Off};
use super::checker::{Found, check};
use super::operations::{NOW, Operation, Tree, apply, names_and_content, operation, resolve};
use crate::fat::Error;

/// Reads a volume after a cut and checks that it has only harmless faults.
fn read(card: &Card, what: &str) -> Found {
    let found = check(card).unwrap_or_else(|fault| panic!("{what}: {fault}"));
    assert_eq!(found.behind_end, 0, "{what}");
    found
}

fn same(one: &Tree, other: &Tree) -> bool {
    names_and_content(one) == names_and_content(other)
}

/// Removes the moved entry: a reader without notes may see neither of its names.
fn without(tree: &Tree, moved: Option<&str>) -> Tree {
    let stays = |path: &str| moved.is_none_or(|moved| path != moved && !path.starts_with(&std::format!("{moved}/")));
    tree.iter().filter(|(path, _)| stays(path)).map(|(path, node)| (path.clone(), node.clone())).collect()
}

/// Counts of what was seen after cuts.
#[derive(Default)]
struct Seen {
    before: u32,
    after: u32,
    under_way: u32,
}

fn cut_everywhere(card: &Card, operation: &Operation, seen: &mut Seen) {
    let before = read(card, "before").tree;
    let mut whole = card.powered_for(None);
    let mut volume = whole.mount();
    if apply(&mut whole, &mut volume, operation).is_err() {
        return;
    }
    let after = read(&whole, "after").tree;
    let moved = if let Operation::Rename(from, _) = operation { resolve(&before, from).ok() } else { None };
    for writes in 0..whole.writes {
        let what = std::format!("{operation:?} after {writes} of {} writes", whole.writes);
        let mut cut = card.powered_for(Some(writes));
        let mut volume = cut.mount();
        assert_eq!(apply(&mut cut, &mut volume, operation), Err(Error::Device(Off)), "{what}");
        let cut = cut.powered_for(None);
        let mut raw = read(&cut, &what).tree;
        raw.remove("~MOVING.TMP");
        let under_way = moved.is_some() && same(&raw, &without(&before, moved.as_deref()));
        assert!(same(&raw, &before) || same(&raw, &after) || under_way, "{what}: {raw:?}");
        seen.under_way += u32::from(under_way);
        let mut settled = cut.clone();
        settled.mount().settle(&mut settled).unwrap();
        let tree = read(&settled, &what).tree;
        seen.before += u32::from(same(&tree, &before));
        seen.after += u32::from(same(&tree, &after));
        assert!(same(&tree, &before) || same(&tree, &after), "{what}, settled: {tree:?}");
        // Settling may be cut as well, and is completed the next time.
        for writes in 0..settled.writes {
            let mut again = cut.powered_for(Some(writes));
            assert!(again.mount().settle(&mut again).is_err(), "{what}");
            let mut again = again.powered_for(None);
            again.mount().settle(&mut again).unwrap();
            assert!(same(&read(&again, &what).tree, &tree), "{what}, settled twice");
        }
        // After settling, the card can be used as if no cut had happened.
        let mut volume = settled.mount();
        let entry = volume.create(&mut settled, "a name behind the pieces.txt", NOW).unwrap();
        assert_eq!(read(&settled, &what).tree.len(), tree.len() + 1, "{what}");
        volume.remove(&mut settled, &entry).unwrap();
        assert!(same(&read(&settled, &what).tree, &tree), "{what}");
    }
}

fn run(format: Format, operations: &[Operation], seen: &mut Seen) {
    let mut card = Card::new(format);
    let mut volume = card.mount();
    for operation in operations {
        if !matches!(operation, Operation::Fill(..)) {
            cut_everywhere(&card, operation, seen);
        }
        let _refused = apply(&mut card, &mut volume, operation);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]
    #[test]
    fn a_cut_leaves_what_was_or_what_should_be(operations in proptest::collection::vec(operation(), 1..25)) {
        run(Format::FAT16, &operations, &mut Seen::default());
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(4))]
    #[test]
    fn a_cut_leaves_what_was_or_what_should_be_on_fat32(operations in proptest::collection::vec(operation(), 1..20)) {
        run(Format::FAT32, &operations, &mut Seen::default());
    }
}

/// Moves files and directories between directories, with long names over several blocks, back and forth.
#[test]
fn a_cut_move_is_taken_back_or_completed() {
    let long = |letter: &str| letter.repeat(230);
    let mut operations = std::vec![
        Operation::MakeDirectory("one".into()),
        Operation::MakeDirectory("another directory".into()),
        Operation::MakeDirectory("one/inner".into()),
        Operation::Create("one/inner/file".into()),
        Operation::Create("one/config-override".into()),
        Operation::Fill("one/config-override".into(), 3_000),
    ];
    let moves = [
        ("one/config-override", std::format!("another directory/{}", long("x"))),
        (&std::format!("another directory/{}", long("x")), std::format!("{}.g", long("y"))),
        (&std::format!("{}.g", long("y")), "one/config-override".into()),
        ("one/config-override", "another directory/config-override".into()),
        ("another directory/config-override", "one/config-override".into()),
        ("one/inner", "another directory/INNER".into()),
        ("another directory/inner", std::format!("one/{}", long("z"))),
        ("one", "another directory/one".into()),
    ];
    operations.extend(moves.map(|(from, to)| Operation::Rename(from.into(), to)));
    let mut seen = Seen::default();
    run(Format::FAT16, &operations, &mut seen);
    assert!(
        seen.before > 20 && seen.after > 10 && seen.under_way >= 8,
        "{} {} {}",
        seen.before,
        seen.after,
        seen.under_way
    );
}
