//! Lines of a .cfg file by Klipper's rules: `#` cuts a line anywhere, `;` at its start or behind a blank;
//! indented lines go on with a value; a later section of the same name adds to the earlier one.

use anyhow::{Result, bail};

use super::source::{Entry, Place, Section, Source};

/// Reads lines into a [`Source`]; one for each run of lines between two includes.
pub struct Reader<'s> {
    source: &'s mut Source,
    section: Option<usize>,
    option: Option<usize>,
    /// Indentation of the option that is open; deeper lines go on with its value.
    indent: usize,
    /// Comment lines since the last blank line or setting.
    above: Vec<String>,
}

/// A line without its comment.
struct Parts<'l> {
    text: &'l str,
    comment: &'l str,
    /// Whether a comment that starts with `;` was cut.
    is_semicolon: bool,
}

impl<'s> Reader<'s> {
    /// Makes a reader that adds to what was read before.
    pub fn new(source: &'s mut Source) -> Self {
        Self { source, section: None, option: None, indent: 0, above: Vec::new() }
    }

    /// Takes the next line.
    pub fn line(&mut self, text: &str, place: Place) -> Result<()> {
        let parts = cut(text);
        let value = parts.text.trim();
        if value.is_empty() {
            return self.blank(&parts);
        }
        let indent = parts.text.chars().take_while(|c| c.is_whitespace()).count();
        if indent > self.indent
            && let Some(entry) = self.open()
        {
            entry.value.push('\n');
            entry.value += value;
            return Ok(());
        }
        self.indent = indent;
        let comment = parts.comment.trim().to_owned();
        if let Some(name) = header(value) {
            self.begin(name, place);
        } else {
            self.option(value, comment, place)?;
        }
        Ok(())
    }

    /// Ends a run of lines: trailing blank lines are no part of a value.
    pub fn end(self) {
        for entry in self.source.sections.iter_mut().flat_map(|section| &mut section.options) {
            entry.value.truncate(entry.value.trim_end().len());
        }
    }

    fn open(&mut self) -> Option<&mut Entry> {
        let section = self.source.sections.get_mut(self.section?)?;
        section.options.get_mut(self.option?)
    }

    /// Takes a line without a setting: blank lines within a value are part of it.
    fn blank(&mut self, parts: &Parts<'_>) -> Result<()> {
        match parts.comment.trim() {
            "" => self.above.clear(),
            comment => self.above.push(comment.to_owned()),
        }
        if !parts.is_semicolon
            && let Some(entry) = self.open()
        {
            entry.value.push('\n');
        }
        Ok(())
    }

    fn begin(&mut self, name: &str, place: Place) {
        let above = std::mem::take(&mut self.above);
        self.option = None;
        let known = self.source.sections.iter().position(|section| section.name == name);
        let index = known.unwrap_or_else(|| {
            let options = Vec::new();
            self.source.sections.push(Section { name: name.to_owned(), place, above: above.clone(), options });
            self.source.sections.len() - 1
        });
        if known.is_some()
            && let Some(section) = self.source.sections.get_mut(index)
        {
            section.above.extend(above);
        }
        self.section = Some(index);
    }

    fn option(&mut self, text: &str, comment: String, place: Place) -> Result<()> {
        let told = self.source.told(place);
        let Some(section) = self.section.and_then(|index| self.source.sections.get_mut(index)) else {
            bail!("{told}: '{}' stands in no [section]: write the section's name above it", shown(text));
        };
        let Some((name, value)) = text.split_once([':', '=']).filter(|(name, _)| !name.trim().is_empty()) else {
            bail!(
                "{told}: '{}' is no setting: write `name: value`, or indent it under the one it belongs to",
                shown(text)
            );
        };
        let (name, value) = (name.trim().to_lowercase(), value.trim().to_owned());
        let above = std::mem::take(&mut self.above);
        let entry = Entry { name, value, place, comment, above, earlier: Vec::new() };
        let at = section.options.iter().position(|known| known.name == entry.name);
        self.option = Some(at.unwrap_or(section.options.len()));
        match at.and_then(|at| section.options.get_mut(at)) {
            Some(known) => {
                let mut earlier = std::mem::take(&mut known.earlier);
                earlier.push((known.place, known.value.trim_end().to_owned()));
                *known = Entry { earlier, ..entry };
            }
            None => section.options.push(entry),
        }
        Ok(())
    }
}

/// Returns the file that a line includes; such a line starts in the first column.
pub fn included(line: &str) -> Option<&str> {
    let line = line.split_once('#').map_or(line, |(before, _)| before);
    header(line)?.strip_prefix("include ").map(str::trim)
}

/// Returns the name in `[name]`; what follows the last bracket is ignored.
fn header(text: &str) -> Option<&str> {
    let (name, _) = text.strip_prefix('[')?.rsplit_once(']')?;
    (!name.is_empty()).then_some(name)
}

/// Cuts the comment off a line.
fn cut(line: &str) -> Parts<'_> {
    let (text, comment) = line.split_once('#').unwrap_or((line, ""));
    let mut before = ' ';
    for (place, c) in text.char_indices() {
        if c == ';' && before.is_whitespace() {
            let (text, comment) = text.split_at(place);
            return Parts { text, comment: comment.trim_start_matches(';'), is_semicolon: true };
        }
        before = c;
    }
    Parts { text, comment: comment.trim_start_matches('#'), is_semicolon: false }
}

/// Returns the beginning of a text that may be long.
fn shown(text: &str) -> String {
    let mut short: String = text.chars().take(60).collect();
    if short.len() < text.len() {
        short += "...";
    }
    short
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<Source> {
        let mut source = Source { files: vec!["printer.cfg".into()], ..Source::default() };
        let mut reader = Reader::new(&mut source);
        for (number, line) in text.split('\n').enumerate() {
            reader.line(line, Place { file: 0, line: number + 1 })?;
        }
        reader.end();
        Ok(source)
    }

    fn value(text: &str, option: &str) -> Option<String> {
        read(text).ok()?.sections.first()?.get(option).map(str::to_owned)
    }

    #[test]
    fn comments_end_where_klipper_ends_them() {
        assert_eq!(value("[a]\nb: 1 # two", "b").as_deref(), Some("1"));
        assert_eq!(value("[a]\nb: 1#2", "b").as_deref(), Some("1"), "# cuts anywhere");
        assert_eq!(value("[a]\nb: 1;2", "b").as_deref(), Some("1;2"), "; only behind a blank");
        assert_eq!(value("[a]\nb: 1 ;2", "b").as_deref(), Some("1"));
        assert_eq!(value("[a]\n;b: 1\n c: 2", "c").as_deref(), Some("2"));
        assert_eq!(value("[a]\nb: \"#x\" ; y", "b").as_deref(), Some("\""), "no quotes help");
    }

    #[test]
    fn deeper_lines_go_on_with_a_value() {
        let text = "[a]\nb:\n  one\n\n    two # x\n ; y\n  three\nc = 1\n";
        assert_eq!(value(text, "b").as_deref(), Some("\none\n\ntwo\nthree"));
        assert_eq!(value(text, "c").as_deref(), Some("1"));
        assert_eq!(value("[a]\n  b: 1\n  c: 2", "c").as_deref(), Some("2"), "as far in is an option of its own");
        assert_eq!(value("[a]\nb: 1\n [c]\nd: 2", "b").as_deref(), Some("1\n[c]"), "an indented header is text");
    }

    #[test]
    fn names_and_separators() {
        assert_eq!(value("[a]\nPID_Kp = 1:2", "pid_kp").as_deref(), Some("1:2"));
        assert_eq!(value("[a]\nx:=3", "x").as_deref(), Some("=3"));
        let source = read("[Mixed Case]\nb: 1\n[mixed case]\nb: 2").unwrap_or_default();
        assert_eq!(source.sections.len(), 2, "sections mind case");
    }

    #[test]
    fn a_later_section_adds_to_the_first_and_a_later_value_counts() {
        let source = read("[a]\nb: 1\nc: 2\n[x]\n[a]\nb: 3 # new\nd: 4\n").unwrap_or_default();
        let names: Vec<&str> = source.sections[0].options.iter().map(|option| option.name.as_str()).collect();
        assert_eq!(names, ["b", "c", "d"]);
        let entry = &source.sections[0].options[0];
        assert_eq!((entry.value.as_str(), entry.comment.as_str(), entry.place.line), ("3", "new", 6));
        assert_eq!(entry.earlier, [(Place { file: 0, line: 2 }, "1".to_owned())]);
    }

    #[test]
    fn lines_that_klipper_cannot_read_are_errors_with_their_place() {
        for (text, says) in [
            ("b: 1", "printer.cfg:1: 'b: 1' stands in no [section]"),
            ("[a]\nb", "printer.cfg:2: 'b' is no setting"),
            ("[a]\n: 1", "printer.cfg:2"),
        ] {
            let error = read(text).err().map(|error| error.to_string()).unwrap_or_default();
            assert!(error.contains(says), "{text}: {error}");
        }
    }

    #[test]
    fn comments_above_belong_to_what_follows() {
        let text = "# head\n\n# of a\n[a]\n# one\n# two\nb: 1\n\n# lost\n\nc: 2";
        let source = read(text).unwrap_or_default();
        assert_eq!(source.sections[0].above, ["of a"]);
        assert_eq!(source.sections[0].options[0].above, ["one", "two"]);
        assert_eq!(source.sections[0].options[1].above, Vec::<String>::new());
    }

    #[test]
    fn includes_stand_in_the_first_column() {
        assert_eq!(included("[include a/*.cfg] # x"), Some("a/*.cfg"));
        assert_eq!(included(" [include a.cfg]"), None);
        assert_eq!(included("#[include a.cfg]"), None);
        assert_eq!(included("[included a.cfg]"), None);
    }
}
