//! Klipper's files: sections and options with their places, and what is included.

use std::fs;
use std::path::{Path, PathBuf};
use std::rc::Rc;

use anyhow::{Context, Result, bail};

/// Deepest files that include each other.
const DEEPEST: usize = 32;

/// A line of an option's value.
pub struct Line {
    file: Rc<Path>,
    number: usize,
    /// Column of the first character, from 1.
    column: usize,
    text: String,
}

/// An option of a section.
pub struct Entry {
    pub section: String,
    /// Name in lower case.
    pub name: String,
    lines: Vec<Line>,
}

impl Entry {
    /// The value: its lines without blanks at their ends.
    pub fn value(&self) -> String {
        let lines: Vec<&str> = self.lines.iter().map(|line| line.text.as_str()).collect();
        lines.join("\n").trim_end().to_owned()
    }

    /// Place in a file of a line and column of the value, both from 1, as `file:line:column`.
    pub fn place(&self, line: u16, column: u16) -> String {
        let index = usize::from(line).clamp(1, self.lines.len()) - 1;
        let line = &self.lines[index];
        format!("{}:{}:{}", line.file.display(), line.number, line.column + usize::from(column) - 1)
    }
}

/// Reads a file and what it includes. Of an option that comes again the last one counts.
pub fn read(path: &Path) -> Result<Vec<Entry>> {
    let mut reader = Reader::default();
    reader.file(path, 0)?;
    Ok(reader.entries)
}

#[derive(Default)]
struct Reader {
    entries: Vec<Entry>,
    section: Option<String>,
    /// Option whose value may go on, and the columns before its name.
    open: Option<(usize, usize)>,
}

impl Reader {
    fn file(&mut self, path: &Path, depth: usize) -> Result<()> {
        if depth > DEEPEST {
            bail!("{}: files include each other: take an include away", path.display());
        }
        let bytes = fs::read(path).with_context(|| format!("cannot read {}", path.display()))?;
        let text = String::from_utf8(bytes).with_context(|| format!("{} is not UTF-8", path.display()))?;
        let path: Rc<Path> = Rc::from(path);
        (self.section, self.open) = (None, None);
        for (index, line) in text.lines().enumerate() {
            self.line(&path, index + 1, line, depth)?;
        }
        Ok(())
    }

    fn line(&mut self, path: &Rc<Path>, number: usize, line: &str, depth: usize) -> Result<()> {
        let before_hash = line.split('#').next().unwrap_or_default();
        let before = before_comment(before_hash);
        let text = before.trim();
        let column = before.chars().take_while(|char| char.is_whitespace()).count();
        let mut line = Line { file: Rc::clone(path), number, column: column + 1, text: text.to_owned() };
        match self.open {
            // An empty line belongs to the value, one that only had a comment behind `;` does not.
            Some((entry, _)) if text.is_empty() => {
                if before.len() == before_hash.len() {
                    self.entries[entry].lines.push(line);
                }
                return Ok(());
            }
            Some((entry, name_column)) if column > name_column => {
                self.entries[entry].lines.push(line);
                return Ok(());
            }
            _ if text.is_empty() => return Ok(()),
            _ => {}
        }
        if let Some(header) = text.strip_prefix('[').and_then(|rest| rest.rsplit_once(']')).map(|(header, _)| header) {
            self.open = None;
            let Some(pattern) = header.strip_prefix("include ") else {
                self.section = Some(header.to_owned());
                return Ok(());
            };
            for included in included(path, pattern.trim()).with_context(|| format!("{}:{number}", path.display()))? {
                self.file(&included, depth + 1)?;
            }
            (self.section, self.open) = (None, None);
            return Ok(());
        }
        let (Some(section), Some(end)) = (&self.section, text.find([':', '='])) else {
            bail!("{}:{number}: this is no section and no option: put a : behind a name", path.display());
        };
        let (name, value) = (text[..end].trim(), text[end + 1..].trim_start());
        line.column += text.chars().count() - value.chars().count();
        line.text = value.to_owned();
        let (section, name) = (section.clone(), name.to_lowercase());
        self.entries.retain(|entry| (&entry.section, &entry.name) != (&section, &name));
        self.open = Some((self.entries.len(), column));
        self.entries.push(Entry { section, name, lines: vec![line] });
        Ok(())
    }
}

/// A line up to its comment: a `;` at its begin or behind a blank.
fn before_comment(line: &str) -> &str {
    let mut before = ' ';
    for (at, char) in line.char_indices() {
        if char == ';' && before.is_whitespace() {
            return &line[..at];
        }
        before = char;
    }
    line
}

/// Files that an include names, in order. A pattern may name none.
fn included(path: &Path, pattern: &str) -> Result<Vec<PathBuf>> {
    let folder = path.parent().unwrap_or(Path::new("")).to_owned();
    if !pattern.contains(['*', '?']) {
        return Ok(vec![folder.join(pattern)]);
    }
    let mut found = vec![folder];
    for part in pattern.split('/').filter(|part| !part.is_empty()) {
        let mut next = Vec::new();
        for folder in found {
            if !part.contains(['*', '?']) {
                next.push(folder.join(part));
                continue;
            }
            let place = if folder.as_os_str().is_empty() { Path::new(".") } else { &folder };
            for entry in fs::read_dir(place).with_context(|| format!("cannot read {}", place.display()))? {
                let name = entry?.file_name().to_string_lossy().into_owned();
                if !name.starts_with('.') && fits(&name, part) {
                    next.push(folder.join(name));
                }
            }
        }
        found = next.into_iter().filter(|path| path.exists()).collect();
    }
    found.retain(|path| path.is_file());
    found.sort();
    Ok(found)
}

/// Whether a name fits a pattern with `*` and `?`.
fn fits(name: &str, pattern: &str) -> bool {
    let Some(first) = pattern.chars().next() else { return name.is_empty() };
    let rest = &pattern[first.len_utf8()..];
    match (first, name.chars().next()) {
        ('*', _) => {
            let mut places = name.char_indices().map(|(at, _)| at).chain([name.len()]);
            places.any(|at| fits(&name[at..], rest))
        }
        (_, Some(char)) => (first == '?' || first == char) && fits(&name[char.len_utf8()..], rest),
        (_, None) => false,
    }
}

#[cfg(test)]
mod tests {
    use super::{before_comment, fits};

    #[test]
    fn a_comment_begins_behind_a_blank() {
        assert_eq!(before_comment("G1 X1;no"), "G1 X1;no");
        assert_eq!(before_comment("G1 X1 ; yes"), "G1 X1 ");
        assert_eq!(before_comment("; yes"), "");
        assert_eq!(before_comment("a;b ;c"), "a;b ");
    }

    #[test]
    fn patterns_have_stars_and_question_marks() {
        assert!(fits("macros.cfg", "*.cfg") && fits("a.cfg", "?.cfg") && fits("a.b.cfg", "a*.c*"));
        assert!(!fits("macros.cfgs", "*.cfg") && !fits("ab.cfg", "?.cfg") && fits("", "*"));
    }
}
