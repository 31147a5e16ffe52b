//! The files of a printer.cfg: what it includes, at its place, and the block that SAVE_CONFIG wrote.

use std::path::{Component, Path, PathBuf};

use anyhow::{Context, Result, bail};

use super::reader::{Reader, included};
use super::source::{Place, Source};

/// Beginning of every line that SAVE_CONFIG wrote.
const SAVED: &str = "#*#";
/// Lines that head its block.
const SAVED_HEAD: usize = 3;

/// Reads printer.cfg and all it includes.
pub fn read(path: &Path) -> Result<Source> {
    let mut source = Source::default();
    let text = text_of(path)?;
    let (written, saved) = split(&text);
    let mut open = Vec::new();
    file(&mut source, path, written, &mut open)?;
    if let Some(block) = saved {
        self::saved(&mut source, block, written.lines().count())?;
    }
    if source.sections.is_empty() {
        bail!("{}: there is no [section] in it: is it a printer.cfg?", path.display());
    }
    if let Some(section) = source.section("DEFAULT") {
        let told = source.told(section.place);
        bail!("{told}: Klipper gives the options of [DEFAULT] to every section: write them where they belong");
    }
    Ok(source)
}

/// Reads the text of a file; what is no text is an error.
pub fn text_of(path: &Path) -> Result<String> {
    let bytes = std::fs::read(path).with_context(|| format!("cannot read {}", path.display()))?;
    if bytes.contains(&0) {
        bail!("{} is no text file", path.display());
    }
    let text = String::from_utf8_lossy(&bytes).replace("\r\n", "\n").replace('\r', "\n");
    // Some editors put a byte order mark before the first line.
    Ok(text.trim_start_matches('\u{feff}').to_owned())
}

/// Reads the lines of a file, with the files that it includes at their places.
fn file(source: &mut Source, path: &Path, text: &str, open: &mut Vec<PathBuf>) -> Result<()> {
    let absolute = std::path::absolute(path)?;
    let absolute = simplified(&absolute);
    if open.contains(&absolute) {
        bail!("{} includes itself, over {}", path.display(), told_chain(open));
    }
    open.push(absolute);
    let index = match source.files.iter().position(|known| known == path) {
        Some(index) => index,
        None => {
            source.files.push(path.to_owned());
            source.files.len() - 1
        }
    };
    let lines: Vec<&str> = text.split('\n').collect();
    let mut rest = lines.iter().enumerate().peekable();
    while rest.peek().is_some() {
        let mut reader = Reader::new(source);
        let mut include = None;
        for (number, line) in rest.by_ref() {
            let place = Place { file: index, line: number + 1 };
            match included(line) {
                Some(pattern) => {
                    include = Some((pattern, place));
                    break;
                }
                None => reader.line(line, place)?,
            }
        }
        reader.end();
        if let Some((pattern, place)) = include {
            include_files(source, path, pattern, place, open)?;
        }
    }
    open.pop();
    Ok(())
}

fn include_files(source: &mut Source, from: &Path, pattern: &str, place: Place, open: &mut Vec<PathBuf>) -> Result<()> {
    let folder = from.parent().unwrap_or(Path::new(""));
    let files = matching(&folder.join(pattern));
    if files.is_empty() {
        let told = source.told(place);
        if !has_wildcard(pattern) {
            bail!("{told}: [include {pattern}]: there is no such file");
        }
        source.remarks.push((place, format!("[include {pattern}] finds no file")));
    }
    for path in files {
        let text = text_of(&path).with_context(|| format!("[include {pattern}] in {}", source.told(place)))?;
        file(source, &path, &text, open)?;
    }
    Ok(())
}

/// Adds what SAVE_CONFIG wrote. Where the same option is written above the block, that one counts.
fn saved(source: &mut Source, block: &str, lines_above: usize) -> Result<()> {
    let mut saved = Source { files: source.files.clone(), ..Source::default() };
    let place = |number: usize| Place { file: 0, line: lines_above + number + 1 };
    let is_whole = block.lines().filter(|line| !line.is_empty()).all(|line| line == SAVED || line.starts_with("#*# "));
    if !is_whole {
        let text =
            "the block of SAVE_CONFIG has lines that it did not write: Klipper ignores all of it, and so does this";
        source.remarks.push((place(0), text.to_owned()));
        return Ok(());
    }
    let mut reader = Reader::new(&mut saved);
    for (number, line) in block.lines().enumerate().skip(SAVED_HEAD) {
        reader.line(line.get(SAVED.len() + 1..).unwrap_or(""), place(number))?;
    }
    reader.end();
    for section in saved.sections {
        let Some(known) = source.sections.iter_mut().find(|known| known.name == section.name) else {
            source.sections.push(section);
            continue;
        };
        for entry in section.options {
            match known.options.iter().find(|written| written.name == entry.name) {
                Some(written) if written.value != entry.value => source.remarks.push((
                    entry.place,
                    format!(
                        "[{}] {} = {} of SAVE_CONFIG is not used: the file itself says {}, and Klipper takes that",
                        known.name, entry.name, entry.value, written.value
                    ),
                )),
                Some(_) => {}
                None => known.options.push(entry),
            }
        }
    }
    Ok(())
}

/// Splits a text at the block of SAVE_CONFIG.
fn split(text: &str) -> (&str, Option<&str>) {
    let mut place = 0;
    for line in text.split_inclusive('\n') {
        if line.starts_with("#*# <---") && line.contains("SAVE_CONFIG") {
            let (written, block) = text.split_at(place);
            return (written, Some(block));
        }
        place += line.len();
    }
    (text, None)
}

fn told_chain(open: &[PathBuf]) -> String {
    let names = open.iter().filter_map(|path| path.file_name());
    names.map(|name| name.to_string_lossy().into_owned()).collect::<Vec<_>>().join(", ")
}

/// Takes `.` and `x/..` out of a path.
pub fn simplified(path: &Path) -> PathBuf {
    let mut out = PathBuf::new();
    for part in path.components() {
        match part {
            Component::CurDir => {}
            Component::ParentDir if out.file_name().is_some() => {
                out.pop();
            }
            part => out.push(part),
        }
    }
    out
}

fn has_wildcard(pattern: &str) -> bool {
    pattern.contains(['*', '?', '['])
}

/// Returns the files that a pattern with `*`, `?` and `[..]` names, sorted.
fn matching(pattern: &Path) -> Vec<PathBuf> {
    let mut found = vec![PathBuf::new()];
    for part in pattern.components() {
        let text = part.as_os_str().to_string_lossy().into_owned();
        if !has_wildcard(&text) {
            found.iter_mut().for_each(|path| path.push(part));
            continue;
        }
        found = found.iter().flat_map(|folder| children(folder, &text)).collect();
    }
    found.retain(|path| path.is_file());
    found.sort();
    found
}

fn children(folder: &Path, pattern: &str) -> Vec<PathBuf> {
    let listed = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let Ok(entries) = std::fs::read_dir(listed) else { return Vec::new() };
    let pattern: Vec<char> = pattern.chars().collect();
    let names = entries.flatten().map(|entry| entry.file_name().to_string_lossy().into_owned());
    // A name that starts with a dot is hidden from a pattern that does not.
    let shown = names.filter(|name| !name.starts_with('.') || pattern.first() == Some(&'.'));
    shown.filter(|name| fits(&pattern, &name.chars().collect::<Vec<_>>())).map(|name| folder.join(name)).collect()
}

/// Returns whether a name fits a pattern of `*`, `?` and `[..]`.
fn fits(pattern: &[char], name: &[char]) -> bool {
    // For each length of the name's beginning, whether the pattern so far fits it.
    let mut reached = vec![false; name.len() + 1];
    reached[0] = true;
    let mut rest = pattern;
    while let Some((&first, after)) = rest.split_first() {
        let (takes, after): (Box<dyn Fn(char) -> bool>, &[char]) = match first {
            '*' => {
                let from = reached.iter().position(|fits| *fits).unwrap_or(reached.len());
                reached.iter_mut().skip(from).for_each(|fits| *fits = true);
                rest = after;
                continue;
            }
            '?' => (Box::new(|_| true), after),
            '[' => match set(after) {
                Some((members, is_not, after)) => (Box::new(move |c| holds(&members, c) != is_not), after),
                None => (Box::new(|c| c == '['), after),
            },
            plain => (Box::new(move |c| c == plain), after),
        };
        let before = reached.clone();
        reached.fill(false);
        for (place, c) in name.iter().enumerate() {
            reached[place + 1] = before[place] && takes(*c);
        }
        rest = after;
    }
    reached.last().copied().unwrap_or(false)
}

/// Splits the set off a pattern that stands behind `[`: its members, whether it is `[!..]`, what follows.
fn set(pattern: &[char]) -> Option<(Vec<char>, bool, &[char])> {
    let is_not = pattern.first() == Some(&'!');
    let start = usize::from(is_not);
    let end = pattern.iter().skip(start + 1).position(|c| *c == ']')? + start + 1;
    Some((pattern.get(start..end)?.to_vec(), is_not, pattern.get(end + 1..)?))
}

fn holds(members: &[char], c: char) -> bool {
    let ranges = members.windows(3).any(|range| matches!(range, [low, '-', high] if (*low..=*high).contains(&c)));
    ranges || members.contains(&c)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn patterns_fit_as_in_a_shell() {
        let chars = |text: &str| text.chars().collect::<Vec<_>>();
        for (pattern, name, fit) in [
            ("*.cfg", "a.cfg", true),
            ("*.cfg", ".cfg", true),
            ("*.cfg", "a.cfg.bak", false),
            ("a?c", "abc", true),
            ("a?c", "ac", false),
            ("*a*b*", "xxaxxbxx", true),
            ("*a*b*", "xxbxxaxx", false),
            ("[ab]x", "bx", true),
            ("[!ab]x", "bx", false),
            ("[0-9]x", "7x", true),
            ("[0-9]x", "ax", false),
            ("[x", "[x", true),
            ("", "", true),
            ("", "a", false),
        ] {
            assert_eq!(fits(&chars(pattern), &chars(name)), fit, "{pattern} {name}");
        }
    }
}
