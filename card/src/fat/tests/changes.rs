//! Random sequences of changes, each compared with its expected result.

use std::io::Read;
use std::string::{String, ToString};
use std::vec::Vec;

use fatfs::{Dir, FileSystem, FsOptions, ReadWriteSeek};
use proptest::prelude::*;

use super::card::{Card, Format};
use super::checker::check;
use super::operations::{Operation, Tree, apply, expected, listed, names_and_content, operation};

/// Reads paths and contents with the other tool.
fn read_back<T: ReadWriteSeek>(directory: &Dir<'_, T>, path: &str, found: &mut Vec<(String, Option<Vec<u8>>)>) {
    for entry in directory.iter().map(Result::unwrap) {
        let name = entry.file_name();
        if name == "." || name == ".." {
            continue;
        }
        let path = if path.is_empty() { name } else { std::format!("{path}/{name}") };
        if entry.is_dir() {
            found.push((path.clone(), None));
            read_back(&entry.to_dir(), &path, found);
        } else {
            let mut content = Vec::new();
            entry.to_file().read_to_end(&mut content).unwrap();
            found.push((path, Some(content)));
        }
    }
}

fn judge(card: &mut Card, tree: &Tree) {
    let mut read = Vec::new();
    let other = FileSystem::new(card.as_file(), FsOptions::new()).unwrap();
    read_back(&other.root_dir(), "", &mut read);
    other.unmount().unwrap();
    read.sort();
    let ours: Vec<_> = tree.iter().map(|(path, node)| (path.to_string(), node.content.clone())).collect();
    assert_eq!(read, ours, "what the other tool reads");
    let (mut list, mut volume) = (Vec::new(), card.mount());
    listed(card, &mut volume, "", &mut list);
    list.sort();
    let size = |content: &Option<Vec<u8>>| content.as_ref().map_or(0, Vec::len) as u32;
    let ours: Vec<_> = ours.iter().map(|(path, content)| (path.clone(), content.is_none(), size(content))).collect();
    assert_eq!(list, ours, "what is listed");
}

fn run(format: Format, operations: &[Operation]) {
    let mut card = Card::new(format);
    let mut volume = card.mount();
    let mut tree = Tree::new();
    for operation in operations {
        let wanted = expected(&tree, operation);
        let done = apply(&mut card, &mut volume, operation);
        assert_eq!(done, wanted.as_ref().map(drop).map_err(|error| *error), "{operation:?}");
        let found = check(&card).unwrap_or_else(|fault| panic!("{operation:?}: {fault}"));
        assert!(found.is_clean(), "{operation:?}: {found:?}");
        assert_eq!(
            names_and_content(&found.tree),
            names_and_content(wanted.as_ref().unwrap_or(&tree)),
            "{operation:?}"
        );
        tree = found.tree;
    }
    judge(&mut card, &tree);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(128))]
    #[test]
    fn every_change_does_what_it_says_on_fat16(operations in proptest::collection::vec(operation(), 1..60)) {
        run(Format::FAT16, &operations);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]
    #[test]
    fn every_change_does_what_it_says_on_fat32(operations in proptest::collection::vec(operation(), 1..60)) {
        run(Format::FAT32, &operations);
        run(Format { tables: 1, blocks_per_cluster: 4, ..Format::FAT32 }, &operations);
    }
}
