//! Line editor: commands of a letter that find, move, insert and delete. The editor knows text alone; files
//! are its caller's.
//!
//! The commands are those of Smoothieware v2's `ed`, an Ecce (H. Dewar, "Edinburgh Compatible Context
//! Editor"). Editing works on a piece of the file: it goes forward through files of any length, and back as
//! far as the piece reaches.

use heapless::{String, Vec};

use super::editor_commands::{Command, What};

/// Bytes of a file to which editing can go back.
pub const PIECE: usize = 2_048;

/// Result of a command.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Step {
    /// The command has been carried out.
    Done,
    /// More of the file is needed: append it, and try again.
    More,
    /// The text to be found is not there.
    Failed,
    /// There is no room for more text: write the beginning, and try again.
    Full,
}

/// Piece of a file that is being edited.
#[derive(Debug, Default)]
pub struct Editor {
    text: Vec<u8, PIECE>,
    /// Place where the next command acts.
    at: usize,
    /// Length of the text there that was found last, bytes.
    found: usize,
    /// Whether the file goes on behind the piece.
    goes_on: bool,
}

impl Editor {
    /// Starts before a file that has not been read.
    #[must_use]
    pub const fn new() -> Self {
        Self { text: Vec::new(), at: 0, found: 0, goes_on: true }
    }

    /// Appends more of the file; nothing is its end. False when there is no room.
    pub fn append(&mut self, bytes: &[u8]) -> bool {
        self.goes_on = !bytes.is_empty();
        self.text.extend_from_slice(bytes).is_ok()
    }

    /// Returns the number of bytes that still fit.
    #[must_use]
    pub fn room(&self) -> usize {
        PIECE - self.text.len()
    }

    /// Returns the beginning that may be written: the lines before the one where commands act. Of a piece
    /// that is one line, or is full behind that line, all but its last line, to go on looking behind it.
    #[must_use]
    pub fn beginning(&self) -> &[u8] {
        let begin = self.line_start(self.at);
        let end = if begin > 0 { begin } else { self.line_start(self.text.len()) };
        self.text.get(..end).unwrap_or(&[])
    }

    /// Forgets so many bytes of the beginning, which are in the new file.
    pub fn forget(&mut self, bytes: usize) {
        let bytes = bytes.min(self.text.len());
        self.text.rotate_left(bytes);
        self.text.truncate(self.text.len() - bytes);
        if bytes > self.at {
            self.found = 0;
        }
        self.at = self.at.saturating_sub(bytes);
    }

    /// Returns the text that is left.
    #[must_use]
    pub fn rest(&self) -> &[u8] {
        &self.text
    }

    /// Returns the line where commands act, in two parts; none at the end of the file.
    #[must_use]
    pub fn line(&self) -> Option<(&[u8], &[u8])> {
        let (begin, end) = (self.line_start(self.at), self.line_end(self.at).unwrap_or(self.text.len()));
        if begin == self.text.len() {
            return None;
        }
        Some((self.text.get(begin..self.at)?, self.text.get(self.at..end)?))
    }

    /// Returns whether the whole line is there.
    #[must_use]
    pub fn has_line(&self) -> bool {
        !self.goes_on || self.line_end(self.at).is_some()
    }

    /// Carries a command out once.
    pub fn run(&mut self, command: &Command<'_>) -> Step {
        if !self.has_line() {
            return Step::More;
        }
        let found = core::mem::take(&mut self.found);
        let text = command.text.as_bytes();
        match command.what {
            What::Next => self.next_line(),
            What::Previous => self.previous_line(),
            What::Right => self.right(),
            What::Left => self.left(),
            What::EraseRight => {
                let from = self.at;
                let step = self.right();
                self.delete(from, self.at);
                step
            }
            What::EraseLeft => {
                let from = self.at;
                let step = self.left();
                self.delete(self.at, from);
                step
            }
            What::Kill => self.kill(),
            What::Print | What::Get => Step::Done,
            What::Insert => self.insert(text),
            What::Break => self.insert(b"\n"),
            What::Join => match self.line_end(self.at) {
                Some(end) if end + 1 < self.text.len() => {
                    self.delete(end, end + 1);
                    self.at = end;
                    Step::Done
                }
                Some(_) if self.goes_on => Step::More,
                _ => Step::Failed,
            },
            What::Substitute if found == 0 => Step::Failed,
            What::Substitute if text.len() > found + self.room() => {
                self.found = found;
                Step::Full
            }
            What::Substitute => {
                self.delete(self.at, self.at + found);
                self.insert(text)
            }
            What::Verify => {
                let is_there = self.text.get(self.at..).is_some_and(|rest| rest.starts_with(text));
                self.found = if is_there { text.len() } else { 0 };
                if is_there { Step::Done } else { Step::Failed }
            }
            What::Find | What::Delete | What::Traverse | What::Uncover => self.search(command, found),
        }
    }

    /// Inserts a typed line before the one where commands act.
    pub fn insert_line(&mut self, line: &[u8]) -> Step {
        if line.len() + 1 > self.room() {
            return Step::Full;
        }
        let place = self.at - self.line_start(self.at);
        self.at -= place;
        self.insert(line);
        self.insert(b"\n");
        self.at += place;
        Step::Done
    }

    // --- moving ---

    fn line_start(&self, at: usize) -> usize {
        let before = self.text.get(..at).unwrap_or(&[]);
        before.iter().rposition(|byte| *byte == b'\n').map_or(0, |end| end + 1)
    }

    /// Returns the end of the line at this place.
    fn line_end(&self, at: usize) -> Option<usize> {
        self.text.get(at..)?.iter().position(|byte| *byte == b'\n').map(|end| at + end)
    }

    fn next_line(&mut self) -> Step {
        if self.at == self.text.len() {
            return Step::Failed;
        }
        self.at = self.line_end(self.at).map_or(self.text.len(), |end| end + 1);
        Step::Done
    }

    fn previous_line(&mut self) -> Step {
        let begin = self.line_start(self.at);
        if begin == 0 {
            return Step::Failed;
        }
        self.at = self.line_start(begin - 1);
        Step::Done
    }

    /// Moves one letter on, within the line.
    fn right(&mut self) -> Step {
        let end = self.line_end(self.at).unwrap_or(self.text.len());
        if self.at == end {
            return Step::Failed;
        }
        self.at += 1;
        while self.at < end && self.text.get(self.at).is_some_and(|byte| is_inside_letter(*byte)) {
            self.at += 1;
        }
        Step::Done
    }

    fn left(&mut self) -> Step {
        let begin = self.line_start(self.at);
        if self.at == begin {
            return Step::Failed;
        }
        self.at -= 1;
        while self.at > begin && self.text.get(self.at).is_some_and(|byte| is_inside_letter(*byte)) {
            self.at -= 1;
        }
        Step::Done
    }

    // --- changing ---

    fn delete(&mut self, from: usize, to: usize) {
        if let Some(rest) = self.text.get_mut(from..) {
            rest.rotate_left(to - from);
            self.text.truncate(self.text.len() - (to - from));
        }
        self.at = from;
    }

    fn insert(&mut self, text: &[u8]) -> Step {
        if self.text.extend_from_slice(text).is_err() {
            return Step::Full;
        }
        if let Some(rest) = self.text.get_mut(self.at..) {
            rest.rotate_right(text.len());
        }
        self.at += text.len();
        Step::Done
    }

    fn kill(&mut self) -> Step {
        let (begin, end) = (self.line_start(self.at), self.line_end(self.at).map_or(self.text.len(), |end| end + 1));
        if begin == end {
            return Step::Failed;
        }
        self.delete(begin, end);
        Step::Done
    }

    /// Finds the command's text, in so many lines from here on; the text found last is not found again.
    fn search(&mut self, command: &Command<'_>, found: usize) -> Step {
        let text = command.text.as_bytes();
        let from = self.at + if command.what == What::Find { found } else { 0 };
        let end = self.region(command.lines);
        let region = self.text.get(from..end.unwrap_or(self.text.len())).unwrap_or(&[]);
        let Some(place) = region.windows(text.len()).position(|window| window == text).map(|place| from + place) else {
            self.found = found;
            return if end.is_none() && self.goes_on { Step::More } else { Step::Failed };
        };
        match command.what {
            What::Delete => self.delete(place, place + text.len()),
            What::Traverse => self.at = place + text.len(),
            What::Uncover => self.delete(self.at, place),
            _ => (self.at, self.found) = (place, text.len()),
        }
        Step::Done
    }

    /// Returns the end of so many lines from the present one on; none where that is not known yet.
    fn region(&self, lines: u32) -> Option<usize> {
        let mut at = self.at;
        for _ in 0..lines {
            at = self.line_end(at)? + 1;
        }
        (lines > 0).then_some(at)
    }
}

const fn is_inside_letter(byte: u8) -> bool {
    matches!(byte, 0x80..=0xBF)
}

/// Returns a line as printed, with `^` where commands act.
pub fn shown(line: Option<(&[u8], &[u8])>) -> String<300> {
    let mut text = String::new();
    let Some((before, behind)) = line else { return String::try_from("**END**").unwrap_or_default() };
    for (part, mark) in [(before, "^"), (behind, "")] {
        for letter in core::str::from_utf8(part).unwrap_or("(not text)").chars() {
            // Letters that do not fit are cut.
            let _cut = text.push(letter);
        }
        let _cut = text.push_str(mark);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::super::editor_commands::parse;
    use super::*;
    use proptest::prelude::*;
    use std::string::String as Text;

    fn editor(text: &str) -> Editor {
        let mut editor = Editor::new();
        assert!(editor.append(text.as_bytes()) && editor.append(b""));
        editor
    }

    /// Runs a line of commands; returns the text with `^` in its place, and whether a command failed.
    fn edited(editor: &mut Editor, mut line: &str) -> (Text, bool) {
        let mut failed = false;
        while !line.is_empty() && !failed {
            let (command, rest) = parse(line).expect("a command");
            line = rest;
            for _ in 0..command.times.max(1) {
                failed = editor.run(&command) != Step::Done;
            }
        }
        let (before, behind) = editor.rest().split_at(editor.at);
        (format!("{}^{}", Text::from_utf8_lossy(before), Text::from_utf8_lossy(behind)), failed)
    }

    #[test]
    fn a_typed_line_fits_with_its_end_or_is_refused_whole() {
        let mut full = editor(&"x".repeat(PIECE - 4));
        for line in [&b"1234"[..], b"12345678"] {
            assert_eq!(full.insert_line(line), Step::Full);
            assert_eq!(full.room(), 4, "nothing of it is there");
        }
        assert_eq!(full.insert_line(b"123"), Step::Done);
        assert_eq!(full.room(), 0);
        assert!(full.rest().starts_with(b"123\nxx"));
    }

    #[test]
    fn each_command_does_what_the_help_says() {
        for (line, after) in [
            ("m", "one\n^two\nthree\n"),
            ("m2", "one\ntwo\n^three\n"),
            ("m3", "one\ntwo\nthree\n^"),
            ("m2m-", "one\n^two\nthree\n"),
            ("r2", "on^e\ntwo\nthree\n"),
            ("r2l", "o^ne\ntwo\nthree\n"),
            ("e2", "^e\ntwo\nthree\n"),
            ("r3e-", "on^\ntwo\nthree\n"),
            ("k2", "^three\n"),
            ("i/zero /", "zero ^one\ntwo\nthree\n"),
            ("rb", "o\n^ne\ntwo\nthree\n"),
            ("j", "one^two\nthree\n"),
            ("f/th/", "one\ntwo\n^three\n"),
            ("f/o/f/o/", "one\ntw^o\nthree\n"),
            ("f/two/s/2/", "one\n2^\nthree\n"),
            ("d/n/", "o^e\ntwo\nthree\n"),
            ("d0/two/", "one\n^\nthree\n"),
            ("t/n/", "on^e\ntwo\nthree\n"),
            ("u/e/", "^e\ntwo\nthree\n"),
            ("u0/three/", "^three\n"),
            ("v/one/s/1/", "1^\ntwo\nthree\n"),
        ] {
            assert_eq!(edited(&mut editor("one\ntwo\nthree\n"), line), (after.into(), false), "{line}");
        }
    }

    #[test]
    fn what_cannot_be_done_fails_and_changes_nothing() {
        for line in
            ["m-", "l", "e-", "f/four/", "d/two/", "t/two/", "u/two/", "s/x/", "v/two/", "m3m", "m3k", "f/e/e s/x/"]
        {
            let (text, failed) = edited(&mut editor("one\ntwo\nthree\n"), line);
            assert!(failed, "{line}");
            assert!(line.contains('e') || text.replace('^', "") == "one\ntwo\nthree\n", "{line}: {text}");
        }
    }

    #[test]
    fn a_line_that_is_typed_stands_before_the_one_here() {
        let mut editor = editor("one\ntwo\n");
        edited(&mut editor, "mr2");
        assert_eq!(editor.insert_line(b"new"), Step::Done);
        assert_eq!(edited(&mut editor, ""), ("one\nnew\ntw^o\n".into(), false));
        assert_eq!(shown(editor.line()), "tw^o");
    }

    #[test]
    fn more_of_a_file_is_asked_for_where_it_is_needed() {
        let mut editor = Editor::new();
        let (find, _) = parse("f/end/").unwrap();
        assert_eq!(editor.run(&find), Step::More);
        editor.append(b"a\nb");
        assert_eq!(editor.run(&find), Step::More);
        assert_eq!(editor.beginning(), b"a\n", "looking for more than a piece");
        editor.append(b"\nend");
        assert_eq!(editor.run(&find), Step::Done);
        assert_eq!(editor.beginning(), b"a\nb\n");
        editor.forget(4);
        assert_eq!((editor.rest(), editor.at, editor.found), (&b"end"[..], 0, 3));
    }

    proptest! {
        /// Any typed commands: no panic, and the place stays in the text.
        #[test]
        fn any_commands_keep_the_place(text in "[ab\u{e4}\n]{0,40}", lines in proptest::collection::vec("[mrlekpibjfsdtuv]-?[0-3]?(/[ab]/)?[0-3]?", 0..20)) {
            let mut editor = editor(&text);
            for line in &lines {
                if let Ok((command, _)) = parse(line) {
                    let before = editor.rest().to_vec();
                    let step = editor.run(&command);
                    prop_assert!(editor.at <= editor.rest().len() && editor.at + editor.found <= editor.rest().len());
                    prop_assert!(step == Step::Done || editor.rest() == before);
                    prop_assert!(core::str::from_utf8(editor.rest()).is_ok());
                }
            }
        }
    }
}
