//! Random calls against a model of what files are.

use std::collections::BTreeMap;
use std::string::{String, ToString};
use std::vec::Vec;
use std::{format, vec};

use base::ports::{FileHandle, OpenMode, Storage, StorageError};
use card::fat::{is_legal_name, same_name};
use proptest::prelude::*;

use super::card::{Mounted, clean, content, fat16, fat32, mounted, read};
use crate::MAX_FILES;
use crate::ram::RamCard;

#[derive(Clone, Debug)]
enum Call {
    Open(String, u8),
    Write(usize, usize),
    Read(usize, usize),
    Seek(usize, u32),
    Close(usize),
    Remove(String),
    Rename(String, String),
    MakeDirectory(String),
    List(String),
    Mount,
}

fn path() -> impl Strategy<Value = String> {
    let names = [
        "config.ini",
        "config.initial",
        "CONFIG.INIA",
        "Config.Ini",
        "benchy_part_one.gcode",
        "benchy_part_two.gcode",
        "config-override",
        "previous-config-override",
        "größe.g",
        "a b.g",
        "sub",
        "Sub Directory",
        "in:valid",
        "",
    ];
    let directory = proptest::sample::select(vec!["/sd", "/sd", "/SD", "/sd/sub", "/sd/sub directory", "/sd/SUB/sub"]);
    (directory, proptest::sample::select(names.to_vec())).prop_map(|(directory, name)| format!("{directory}/{name}"))
}

fn call() -> impl Strategy<Value = Call> {
    prop_oneof![
        8 => (path(), 0..3_u8).prop_map(|(path, mode)| Call::Open(path, mode)),
        8 => (0..MAX_FILES, 0..3_000_usize).prop_map(|(file, size)| Call::Write(file, size)),
        3 => (0..MAX_FILES, 1..3_000_usize).prop_map(|(file, size)| Call::Read(file, size)),
        2 => (0..MAX_FILES, 0..4_000_u32).prop_map(|(file, at)| Call::Seek(file, at)),
        6 => (0..MAX_FILES).prop_map(Call::Close),
        4 => path().prop_map(Call::Remove),
        4 => (path(), path()).prop_map(|(from, to)| Call::Rename(from, to)),
        2 => path().prop_map(Call::MakeDirectory),
        2 => path().prop_map(Call::List),
        1 => Just(Call::Mount),
    ]
}

/// Paths below the card, without its name and without blanks at the end of a part; directories have no
/// content.
type Tree = BTreeMap<String, Option<Vec<u8>>>;

struct Model {
    tree: Tree,
    /// Handle, path, mode and offset.
    open: Vec<(FileHandle, String, OpenMode, usize)>,
}

fn parts(path: &str) -> (String, String) {
    let (directory, name) = path.rsplit_once('/').unwrap_or(("", path));
    (directory.to_string(), name.to_string())
}

fn join(directory: &str, name: &str) -> String {
    if directory.is_empty() { name.to_string() } else { format!("{directory}/{name}") }
}

impl Model {
    fn resolve(&self, path: &str) -> Result<String, StorageError> {
        let mut found = String::new();
        for part in path.split('/').filter(|part| !part.is_empty()) {
            if self.tree.get(&found).is_some_and(Option::is_some) {
                return Err(StorageError::WrongKind);
            }
            let child = |path: &&String| parts(path).0 == found && same_name(&parts(path).1, part);
            found = self.tree.keys().find(child).ok_or(StorageError::NotFound)?.clone();
        }
        Ok(found)
    }

    fn find(&self, path: &str) -> Result<String, StorageError> {
        if path.is_empty() { Err(StorageError::BadPath) } else { self.resolve(path) }
    }

    fn closed(&self, path: &str) -> Result<String, StorageError> {
        let path = self.find(path)?;
        if self.open.iter().any(|(_, open, _, _)| *open == path) { Err(StorageError::Busy) } else { Ok(path) }
    }

    fn new_path(&self, path: &str, moved: Option<&str>) -> Result<String, StorageError> {
        let (directory, name) = parts(path);
        if name.is_empty() {
            return Err(StorageError::BadPath);
        }
        let moved_directory = moved.filter(|moved| self.tree[*moved].is_none());
        // Part by part: what comes first on the way decides.
        for (end, _) in format!("{directory}/").match_indices('/') {
            let parent = self.resolve(&directory[..end])?;
            if self.tree.get(&parent).is_some_and(Option::is_some) {
                return Err(StorageError::WrongKind);
            }
            if !parent.is_empty() && moved_directory == Some(&*parent) {
                return Err(StorageError::BadPath);
            }
        }
        let directory = self.resolve(&directory)?;
        match self.resolve(&join(&directory, &name)) {
            _ if !is_legal_name(&name) => Err(StorageError::BadPath),
            Ok(taken) if Some(&*taken) != moved => Err(StorageError::Exists),
            _ => Ok(join(&directory, &name)),
        }
    }

    fn open(&mut self, path: &str, mode: OpenMode) -> Result<String, StorageError> {
        if self.open.len() == MAX_FILES {
            return Err(StorageError::TooManyOpen);
        }
        let path = match self.closed(path) {
            Err(StorageError::NotFound) if mode != OpenMode::Read => {
                let path = self.new_path(path, None)?;
                self.tree.insert(path.clone(), Some(Vec::new()));
                path
            }
            found => found?,
        };
        let old = self.tree.get_mut(&path).unwrap().as_mut().ok_or(StorageError::WrongKind)?;
        if mode == OpenMode::Write {
            old.clear();
        }
        Ok(path)
    }

    fn content(&mut self, file: usize) -> (&mut Vec<u8>, OpenMode, &mut usize) {
        let (_, path, mode, at) = &mut self.open[file];
        (self.tree.get_mut(path).unwrap().as_mut().unwrap(), *mode, at)
    }
}

fn inside(path: &str) -> &str {
    path.split_at("/sd/".len()).1.trim_end_matches('/')
}

fn step(storage: &mut Mounted, model: &mut Model, call: &Call) {
    let open = model.open.len();
    match call {
        Call::Open(path, mode) => {
            let mode = [OpenMode::Read, OpenMode::Write, OpenMode::Append][usize::from(*mode)];
            let wanted = model.open(inside(path), mode);
            let opened = storage.open(path, mode);
            assert_eq!(opened.map(drop), wanted.clone().map(drop), "{call:?}");
            if let (Ok(file), Ok(path)) = (opened, wanted) {
                let size = model.tree[&path].as_ref().unwrap().len();
                model.open.push((file, path, mode, if mode == OpenMode::Append { size } else { 0 }));
            }
        }
        Call::Write(file, size) if *file < open => {
            let (handle, bytes) = (model.open[*file].0, content(*size, *size));
            let (old, mode, at) = model.content(*file);
            let wanted = if mode == OpenMode::Read && *size > 0 { Err(StorageError::ReadOnly) } else { Ok(()) };
            if wanted.is_ok() {
                old.resize(old.len().max(*at + size), 0);
                old[*at..*at + size].copy_from_slice(&bytes);
                *at += size;
            }
            assert_eq!(storage.write(handle, &bytes), wanted, "{call:?}");
        }
        Call::Read(file, size) if *file < open => {
            let (handle, mut bytes) = (model.open[*file].0, vec![0; *size]);
            let (content, _, at) = model.content(*file);
            let wanted = content[*at..(*at + size).min(content.len())].to_vec();
            *at += wanted.len();
            let count = storage.read(handle, &mut bytes).unwrap();
            assert_eq!(&bytes[..count], wanted, "{call:?}");
        }
        Call::Seek(file, to) if *file < open => {
            let handle = model.open[*file].0;
            let (content, _, at) = model.content(*file);
            let fits = *to as usize <= content.len();
            assert_eq!(storage.size(handle), Ok(content.len() as u32));
            assert_eq!(storage.seek(handle, *to).is_ok(), fits, "{call:?}");
            *at = if fits { *to as usize } else { *at };
        }
        Call::Close(file) if *file < open => {
            let (handle, ..) = model.open.remove(*file);
            storage.close(handle).unwrap();
            assert_eq!(storage.close(handle), Err(StorageError::NotFound));
        }
        Call::Remove(path) => {
            let wanted = model.closed(inside(path)).and_then(|path| {
                let inner = model.tree.keys().any(|other| parts(other).0 == path);
                if inner { Err(StorageError::WrongKind) } else { Ok(path) }
            });
            assert_eq!(storage.remove(path), wanted.clone().map(drop), "{call:?}");
            let _removed = wanted.map(|path| model.tree.remove(&path));
        }
        Call::Rename(from, to) => rename(storage, model, from, to),
        Call::MakeDirectory(path) => {
            let wanted = model.new_path(inside(path), None);
            assert_eq!(storage.make_directory(path), wanted.clone().map(drop), "{call:?}");
            let _made = wanted.map(|path| model.tree.insert(path, None));
        }
        Call::List(path) => {
            let wanted = model.resolve(inside(path)).and_then(|path| {
                let is_file = model.tree.get(&path).is_some_and(Option::is_some);
                if is_file { Err(StorageError::WrongKind) } else { Ok(path) }
            });
            match (names(storage, path), wanted) {
                (Ok(names), Ok(directory)) => {
                    let inner = model.tree.keys().filter(|path| !path.is_empty() && parts(path).0 == directory);
                    assert_eq!(names, inner.map(|path| parts(path).1).collect::<Vec<_>>(), "{call:?}");
                }
                (listed, wanted) => assert_eq!(listed.map(drop), wanted.map(drop), "{call:?}"),
            }
        }
        Call::Mount => {
            storage.mount().unwrap();
            model.open.clear();
        }
        _ => {}
    }
}

fn rename(storage: &mut Mounted, model: &mut Model, from: &str, to: &str) {
    let wanted = model.closed(inside(from)).and_then(|from| Ok((model.new_path(inside(to), Some(&from))?, from)));
    assert_eq!(storage.rename(from, to), wanted.clone().map(drop), "rename {from} {to}");
    let Ok((to, from)) = wanted else { return };
    let moved = |path: &str| match path.strip_prefix(&from) {
        Some(rest) if rest.is_empty() || rest.starts_with('/') => format!("{to}{rest}"),
        _ => path.to_string(),
    };
    model.tree = model.tree.iter().map(|(path, content)| (moved(path), content.clone())).collect();
    model.open.iter_mut().for_each(|(_, path, _, _)| *path = moved(path));
}

fn names(storage: &mut Mounted, path: &str) -> Result<Vec<String>, StorageError> {
    let (mut names, mut entries) = (Vec::new(), heapless::Vec::new());
    loop {
        storage.list(path, names.len(), &mut entries)?;
        if entries.is_empty() {
            names.sort();
            return Ok(names);
        }
        names.extend(entries.iter().map(|entry| entry.name.to_string()));
    }
}

fn run(card: &RamCard, calls: &[Call]) {
    let mut storage = mounted(card);
    let mut model = Model { tree: Tree::new(), open: Vec::new() };
    for call in calls {
        step(&mut storage, &mut model, call);
        if model.open.is_empty() {
            clean(card);
        }
    }
    for (file, ..) in std::mem::take(&mut model.open) {
        storage.close(file).unwrap();
    }
    clean(card);
    let content = |node: super::checker::Node| node.content;
    let tree: Tree = read(card).tree.into_iter().map(|(path, node)| (path, content(node))).collect();
    assert_eq!(tree, model.tree);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(96))]
    #[test]
    fn files_are_what_was_written(calls in proptest::collection::vec(call(), 1..80)) {
        run(&fat16(), &calls);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]
    #[test]
    fn files_are_what_was_written_on_fat32(calls in proptest::collection::vec(call(), 1..80)) {
        run(&fat32(), &calls);
    }
}
