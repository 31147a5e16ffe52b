//! Changes to a volume, and the expected effect of each on its tree.

use std::collections::BTreeMap;
use std::io::Write;
use std::string::{String, ToString};
use std::vec::Vec;
use std::{format, vec};

use fatfs::{FileSystem, FsOptions};
use proptest::prelude::*;

use super::card::{Card, Off};
use super::checker::{Node, capitals, check};
use crate::fat::{Error, Name, Stamp, Volume};

pub type Tree = BTreeMap<String, Node>;

/// 18 May 2021, 18:20.
pub const NOW: Stamp = Stamp { date: 41 << 9 | 5 << 5 | 18, time: 18 << 11 | 20 << 5 };

#[derive(Clone, Debug)]
pub enum Operation {
    Create(String),
    /// Gives a file new content, by the other tool.
    Fill(String, usize),
    Empty(String),
    Remove(String),
    MakeDirectory(String),
    Rename(String, String),
}

/// Makes names that differ late, in case, in blanks, or in nothing; that fill slots exactly; that short names
/// cannot have.
fn name() -> impl Strategy<Value = String> {
    let named = [
        "a",
        "A",
        "config.ini",
        "CONFIG.INI",
        "Config.Ini",
        "config.initial",
        "config.inia",
        "config-override",
        "benchy_part_one.gcode",
        "benchy_part_two.gcode",
        "Benchy_Part_One.gcode",
        "README",
        "ReadMe.md",
        ".hidden",
        "with space.g",
        " with space.g ",
        "trailing.",
        "trailing",
        "a.b.c.gcode",
        "x+y=z;[1],2.g",
        "größe.g",
        "GRÖßE.g",
        "Größe.G",
        "жук.gcode",
        "ЖУК.gcode",
        "print 🖨 me.gcode",
        "thirteen_char",
        "twenty-six characters here",
        "PRINTS",
        "~",
        "semi~colon",
        "under_score",
        "in:valid",
        "quest?ion",
        "",
        "..",
        "tab\tbed",
    ];
    prop_oneof![
        8 => proptest::sample::select(named.to_vec()).prop_map(str::to_string),
        2 => (0..40_usize).prop_map(|number| format!("part {number} of a long print.gcode")),
        1 => (1..=260_usize).prop_map(|length| "n".repeat(length)),
    ]
}

fn path() -> impl Strategy<Value = String> {
    let directory =
        proptest::sample::select(vec!["", "", "", "dir/", "Long Directory/", "DIR/dir/", "dir/Long Directory/"]);
    (directory, name()).prop_map(|(directory, name)| format!("{directory}{name}"))
}

pub fn operation() -> impl Strategy<Value = Operation> {
    let directory =
        proptest::sample::select(vec!["dir", "Long Directory", "dir/Dir", "dir/long directory", "dir/dir/dir"]);
    prop_oneof![
        6 => path().prop_map(Operation::Create),
        3 => (path(), 0..6_000_usize).prop_map(|(path, size)| Operation::Fill(path, size)),
        1 => path().prop_map(Operation::Empty),
        3 => path().prop_map(Operation::Remove),
        1 => path().prop_map(Operation::MakeDirectory),
        3 => directory.clone().prop_map(|path| Operation::MakeDirectory(path.to_string())),
        1 => directory.clone().prop_map(|path| Operation::Remove(path.to_string())),
        4 => (path(), path()).prop_map(|(from, to)| Operation::Rename(from, to)),
        2 => (directory.clone(), path()).prop_map(|(from, to)| Operation::Rename(from.to_string(), to)),
        2 => (directory.clone(), directory).prop_map(|(from, to)| Operation::Rename(from.to_string(), to.to_string())),
    ]
}

/// Applies the operation to the card.
pub fn apply(card: &mut Card, volume: &mut Volume, operation: &Operation) -> Result<(), Error<Off>> {
    match operation {
        Operation::Create(path) => volume.create(card, path, NOW).map(drop),
        Operation::Fill(path, size) => {
            let file = volume.find(card, path)?;
            if file.is_directory() {
                return Err(Error::IsDirectory);
            }
            volume.empty(card, &file, NOW)?;
            fill(card, path, *size);
            Ok(())
        }
        Operation::Empty(path) => {
            let file = volume.find(card, path)?;
            volume.empty(card, &file, NOW)
        }
        Operation::Remove(path) => {
            let entry = volume.find(card, path)?;
            volume.remove(card, &entry)
        }
        Operation::MakeDirectory(path) => volume.make_directory(card, path, NOW).map(drop),
        Operation::Rename(from, to) => {
            let entry = volume.find(card, from)?;
            volume.rename(card, &entry, to)
        }
    }
}

/// Returns content that identifies its file.
pub fn content(seed: u8, size: usize) -> Vec<u8> {
    (0..size).map(|at| seed.wrapping_mul(31).wrapping_add((at * 7 + at / 512) as u8)).collect()
}

/// Writes an empty file's content with the other tool.
pub fn fill(card: &mut Card, path: &str, size: usize) {
    let path = resolve(&check(card).unwrap().tree, path).unwrap();
    let other = FileSystem::new(card.as_file(), FsOptions::new()).unwrap();
    other.root_dir().open_file(&path).unwrap().write_all(&content(path.len() as u8, size)).unwrap();
    other.unmount().unwrap();
}

fn parts(path: &str) -> (String, String) {
    let path = path.trim_end_matches('/');
    path.rsplit_once('/').map_or_else(|| (String::new(), path.to_string()), |(d, n)| (d.to_string(), n.to_string()))
}

fn stripped(name: &str) -> String {
    name.trim_start_matches(' ').trim_end_matches([' ', '.']).to_string()
}

fn join(directory: &str, name: &str) -> String {
    if directory.is_empty() { name.to_string() } else { format!("{directory}/{name}") }
}

/// Finds the path of a node in the tree.
pub fn resolve(tree: &Tree, path: &str) -> Result<String, Error<Off>> {
    let mut found = String::new();
    for part in path.split('/').filter(|part| !part.is_empty()) {
        if !found.is_empty() && tree[&found].content.is_some() {
            return Err(Error::IsFile);
        }
        let wanted = capitals(&stripped(part));
        let child = |(path, node): &(&String, &Node)| {
            let (directory, name) = parts(path);
            directory == found && (capitals(&name) == wanted || node.short_name == wanted)
        };
        found = tree.iter().find(child).filter(|_| !wanted.is_empty()).ok_or(Error::NotFound)?.0.clone();
    }
    Ok(found)
}

fn directory_of(tree: &Tree, path: &str) -> Result<String, Error<Off>> {
    let directory = resolve(tree, path)?;
    if !directory.is_empty() && tree[&directory].content.is_some() { Err(Error::IsFile) } else { Ok(directory) }
}

/// Returns directory and name of a new entry; `moved` does not count as taken.
fn new_path(tree: &Tree, path: &str, moved: Option<&str>) -> Result<String, Error<Off>> {
    let (directory, name) = parts(path);
    if name.is_empty() {
        return Err(Error::BadName);
    }
    let moved_directory = moved.filter(|moved| tree[*moved].content.is_none());
    // The path is checked part by part, as the first error on the way decides.
    for (end, _) in format!("{directory}/").match_indices('/') {
        if Some(&*directory_of(tree, &directory[..end])?) == moved_directory {
            return Err(Error::IntoItself);
        }
    }
    let directory = directory_of(tree, &directory)?;
    let name = stripped(&name);
    let illegal = |letter: char| (letter as u32) < 32 || "\"*/:<>?\\|\u{7F}".contains(letter);
    if name.is_empty() || name.encode_utf16().count() > 255 || name.chars().any(illegal) {
        return Err(Error::BadName);
    }
    match resolve(tree, &join(&directory, &name)) {
        Ok(taken) if Some(&*taken) != moved => Err(Error::Exists),
        _ => Ok(join(&directory, &name)),
    }
}

/// Returns the tree after an operation, but for short names, which only the code itself chooses.
pub fn expected(tree: &Tree, operation: &Operation) -> Result<Tree, Error<Off>> {
    let mut after = tree.clone();
    let find = |path: &str| if parts(path).1.is_empty() { Err(Error::BadName) } else { resolve(tree, path) };
    let mut add = |path: &str, directory: bool| {
        let path = new_path(tree, path, None)?;
        let (content, attributes) = if directory { (None, 0x10) } else { (Some(Vec::new()), 0x20) };
        after.insert(path, Node { short_name: String::new(), content, attributes });
        Ok(())
    };
    match operation {
        Operation::Create(path) => add(path, false)?,
        Operation::MakeDirectory(path) => add(path, true)?,
        Operation::Fill(path, _) | Operation::Empty(path) => {
            let path = find(path)?;
            let node = after.get_mut(&path).unwrap();
            let old = node.content.as_mut().ok_or(Error::IsDirectory)?;
            let size = if let Operation::Fill(_, size) = operation { *size } else { 0 };
            *old = content(path.len() as u8, size);
        }
        Operation::Remove(path) => {
            let path = find(path)?;
            if tree.keys().any(|other| parts(other).0 == path) {
                return Err(Error::NotEmpty);
            }
            after.remove(&path);
        }
        Operation::Rename(from, to) => {
            let from = find(from)?;
            let to = new_path(tree, to, Some(&from))?;
            after = tree.iter().map(|(path, node)| (moved(path, &from, &to), node.clone())).collect();
        }
    }
    Ok(after)
}

fn moved(path: &str, from: &str, to: &str) -> String {
    match path.strip_prefix(from) {
        Some(rest) if rest.is_empty() || rest.starts_with('/') => format!("{to}{rest}"),
        _ => path.to_string(),
    }
}

/// Returns a tree without its short names.
pub fn names_and_content(tree: &Tree) -> BTreeMap<&str, (&Option<Vec<u8>>, u8)> {
    tree.iter().map(|(path, node)| (path.as_str(), (&node.content, node.attributes))).collect()
}

/// Collects the entries that the code under test lists, by path; every entry is found under its name and its
/// short name.
pub fn listed(card: &mut Card, volume: &mut Volume, directory: &str, found: &mut Vec<(String, bool, u32)>) {
    let (mut listing, mut name) = (volume.list(card, directory).unwrap(), Name::new());
    while let Some(entry) = listing.next(volume, card, &mut name).unwrap() {
        let path = join(directory, &name.chars().collect::<String>());
        assert_eq!(volume.find(card, &path).unwrap().place(), entry.place(), "{path}");
        let short = entry.short_name().map(char::from).iter().collect::<String>();
        let (stem, extension) = short.split_at(8);
        let short = format!("{}.{}", stem.trim_end(), extension.trim_end()).to_lowercase();
        let by_short = join(directory, short.trim_end_matches('.'));
        assert_eq!(volume.find(card, &by_short).unwrap().place(), entry.place(), "{by_short}");
        found.push((path.clone(), entry.is_directory(), entry.size_bytes()));
        if entry.is_directory() {
            listed(card, volume, &path, found);
        }
    }
}
