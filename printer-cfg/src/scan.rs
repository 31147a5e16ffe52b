//! Reads a configuration with all that it includes, once, and notes where its sections are.

use core::fmt;

use base::paths::{self, Path};
use base::ports::{DirectoryEntry, Storage, StorageError};
use heapless::Vec;

use crate::delayed::Delayed;
use crate::index::{Index, MOST_FILES, MOST_RENAMED, MOST_SECTIONS, PATHS_BYTES, Section, Use, hash};
use crate::option::Options;
use crate::store::name_in;

/// Reason for which a part of the configuration cannot be used.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Why {
    Card(StorageError),
    Changed,
    Sections,
    Files,
    Renamed,
    Included,
}

/// Trouble with a file of the configuration.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Trouble {
    why: Why,
    /// Number of the file.
    pub(crate) file: u8,
}

impl Trouble {
    pub(crate) const fn card(why: StorageError, file: u8) -> Self {
        Self { why: Why::Card(why), file }
    }

    pub(crate) const fn changed(file: u8) -> Self {
        Self { why: Why::Changed, file }
    }
}

impl fmt::Display for Trouble {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.why {
            Why::Card(error) => f.write_str(error.text()),
            Why::Changed => f.write_str("the file has changed: macros reload reads it anew"),
            Why::Sections => write!(f, "there is room for {MOST_SECTIONS} sections, in files of a megabyte"),
            Why::Files => write!(f, "there is room for {MOST_FILES} files, with {PATHS_BYTES} bytes of names"),
            Why::Renamed => write!(f, "there is room for {MOST_RENAMED} rename_existing"),
            Why::Included => f.write_str("a file that it includes is not there"),
        }
    }
}

/// Result of reading a configuration.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Loaded {
    /// Number of sections.
    pub sections: u16,
    /// Number of macros among them.
    pub macros: u16,
    /// Whether codes are taken or renamed: some of G0 to G3, and others.
    pub codes: [bool; 2],
    /// The first trouble; what follows it was read all the same.
    pub trouble: Option<Trouble>,
}

/// Places at which reading goes on, the next one last.
type Places = Vec<(u8, u32), { MOST_FILES + 8 }>;

/// Reads the configuration anew.
pub(crate) fn scan<S: Storage>(
    (index, delayed): (&mut Index, &mut Delayed),
    storage: &mut S,
    path: &str,
    now_us: u64,
) -> Loaded {
    index.clear();
    delayed.clear();
    let (mut loaded, mut places) = (Loaded::default(), Places::new());
    match index.add_file(path) {
        // An empty list has room.
        Some(file) => drop(places.push((file, 0))),
        None => loaded.trouble = Some(Trouble { why: Why::Files, file: 0 }),
    }
    while let Some((file, offset)) = places.pop() {
        if let Err(trouble) = scan_file((index, delayed), storage, (file, offset), &mut places, (&mut loaded, now_us)) {
            loaded.trouble = loaded.trouble.or(Some(trouble));
        }
    }
    loaded
}

/// Reads a file from a place up to what it includes.
fn scan_file<S: Storage>(
    (index, delayed): (&mut Index, &mut Delayed),
    storage: &mut S,
    (file, offset): (u8, u32),
    places: &mut Places,
    (loaded, now_us): (&mut Loaded, u64),
) -> Result<(), Trouble> {
    let path = Path::try_from(index.file(file)).unwrap_or_default();
    let pattern = {
        let mut options = Options::scan(storage, &path, offset).map_err(|why| Trouble::card(why, file))?;
        loop {
            let Some(hash) = options.header() else {
                return options.error().map_or(Ok(()), |why| Err(Trouble::card(why, file)));
            };
            let [at, next] = options.offsets();
            if let Some(pattern) = options.name().strip_prefix("include ") {
                // There is room for one more than the files that it may include.
                let _ = places.push((file, next));
                break paths::absolute(path.rsplit_once('/').map_or("", |(folder, _)| folder), pattern);
            }
            let section = index.add(hash, file, at).ok_or(Trouble { why: Why::Sections, file })?;
            loaded.sections += 1;
            let is_macro = options.name().starts_with("gcode_macro ");
            loaded.macros += u16::from(is_macro);
            if is_macro {
                index.mark(section, Use::Macro);
                note_name(loaded, name_in(options.name()));
                note_macro(index, section, &mut options, loaded).map_err(|why| Trouble { why, file })?;
            } else if options.name().starts_with("delayed_gcode ") {
                index.mark(section, Use::Delayed);
                note_delayed(delayed, section, &mut options, now_us);
            } else if options.name() == "homing_override" {
                note_name(loaded, "G28");
            }
        }
    };
    include(index, storage, &pattern, places).map_err(|why| Trouble { why, file })
}

/// Notes what a macro's options say beside its G-code.
fn note_macro<S: Storage>(
    index: &mut Index,
    section: Section,
    options: &mut Options<'_, S>,
    loaded: &mut Loaded,
) -> Result<(), Why> {
    while options.go_on() {
        if options.key().starts_with("variable_") {
            index.mark(section, Use::Variables);
        } else if options.key() == "rename_existing" {
            let mut name = heapless::String::<96>::new();
            // A longer name is none that anybody calls.
            options.value().for_each(|byte| drop(name.push(char::from(byte))));
            note_name(loaded, &name);
            if !index.rename(hash(name.bytes()), section) {
                return Err(Why::Renamed);
            }
        }
    }
    Ok(())
}

/// Notes whether a name is that of a code.
fn note_name(loaded: &mut Loaded, name: &str) {
    let is_code =
        matches!(name.as_bytes(), [letter, digit, ..] if letter.is_ascii_alphabetic() && digit.is_ascii_digit());
    let is_move = ["G0", "G1", "G2", "G3"].iter().any(|code| code.eq_ignore_ascii_case(name));
    let [moves, others] = &mut loaded.codes;
    *moves |= is_move;
    *others |= is_code && !is_move;
}

/// Notes when G-code is due for the first time.
fn note_delayed<S: Storage>(delayed: &mut Delayed, section: Section, options: &mut Options<'_, S>, now_us: u64) {
    while options.go_on() {
        if options.key() == "initial_duration" {
            let mut text = heapless::String::<24>::new();
            options.value().for_each(|byte| drop(text.push(char::from(byte))));
            let seconds = gcode::read_f64(&text).filter(|seconds| *seconds > 0.0);
            // More of them than there is room for are refused when they are asked for.
            let _ = delayed.set(section, seconds.map(|seconds| now_us + (seconds * 1e6) as u64));
        }
    }
}

/// Puts the files that a pattern includes in front of everything else, sorted by name.
fn include<S: Storage>(index: &mut Index, storage: &mut S, pattern: &str, places: &mut Places) -> Result<(), Why> {
    let (folder, name) = pattern.rsplit_once('/').ok_or(Why::Included)?;
    let is_glob = name.contains(['*', '?']);
    let (mut first, mut last) = (None, heapless::String::<64>::new());
    loop {
        let path = if is_glob { following(storage, folder, name, &last)? } else { Path::try_from(pattern).ok() };
        let Some(path) = path else { break };
        last.clear();
        // A longer name was left out.
        let _ = last.push_str(path.rsplit_once('/').map_or("", |(_, name)| name));
        if index.files().all(|known| known != path.as_str()) {
            if !is_glob && storage.facts(&path) == Err(StorageError::NotFound) {
                return Err(Why::Included);
            }
            let file = index.add_file(&path).ok_or(Why::Files)?;
            first = first.or(Some(places.len()));
            places.push((file, 0)).map_err(|_| Why::Files)?;
        }
        if !is_glob {
            break;
        }
    }
    if let Some(included) = first.and_then(|first| places.get_mut(first..)) {
        included.reverse();
    }
    Ok(())
}

/// Returns the file of a folder that fits a pattern and follows a name in the order of names.
fn following<S: Storage>(storage: &mut S, folder: &str, pattern: &str, last: &str) -> Result<Option<Path>, Why> {
    let (mut found, mut skip) = (heapless::String::<64>::new(), 0);
    while let Some(DirectoryEntry { name, is_directory, .. }) = storage.entry(folder, skip).map_err(Why::Card)? {
        skip += 1;
        let is_first = name.as_str() > last && (found.is_empty() || name.as_str() < found.as_str());
        if is_first && !is_directory && fits(name.as_bytes(), pattern.as_bytes()) && name.len() <= found.capacity() {
            found.clear();
            // There is room, as was looked.
            let _ = found.push_str(&name);
        }
    }
    if found.is_empty() {
        return Ok(None);
    }
    let mut path = Path::new();
    let whole = path.push_str(folder).and_then(|()| path.push('/')).and_then(|()| path.push_str(&found));
    whole.map(|()| Some(path)).map_err(|_| Why::Files)
}

/// Whether a name fits a pattern with `*` and `?`.
fn fits(name: &[u8], pattern: &[u8]) -> bool {
    let (mut at, mut next, mut star) = (0, 0, None);
    while let Some(byte) = name.get(at) {
        match pattern.get(next) {
            Some(b'*') => {
                star = Some((next + 1, at));
                next += 1;
            }
            Some(wanted) if *wanted == b'?' || wanted == byte => (at, next) = (at + 1, next + 1),
            _ => {
                let Some((behind, from)) = star else { return false };
                star = Some((behind, from + 1));
                (at, next) = (from + 1, behind);
            }
        }
    }
    pattern.get(next..).is_some_and(|rest| rest.iter().all(|byte| *byte == b'*'))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_fit_patterns() {
        for (name, pattern, is) in [
            ("a.cfg", "*.cfg", true),
            ("a.cfg", "?.cfg", true),
            ("ab.cfg", "?.cfg", false),
            ("a.cfg.bak", "*.cfg", false),
            ("kamp_line.cfg", "k*_*.cfg", true),
            ("aab", "*ab", true),
            ("", "*", true),
        ] {
            assert_eq!(fits(name.as_bytes(), pattern.as_bytes()), is, "{name} {pattern}");
        }
    }
}
