//! Strings: joined, split, searched and changed.

use super::Run;
use crate::chars;
use crate::fault::{Result, Words};
use crate::memory::Text;
use crate::value::{SIZE, Seq, Value, View};

impl Run<'_, '_> {
    /// Two strings as one. A string at the end of memory is not copied.
    pub fn join_two(&mut self, a: Text, b: Text) -> Value {
        let from = self.memory.top;
        self.memory.push_text(a);
        self.memory.push_text(b);
        Value::str(self.memory.text_since(from))
    }

    /// A string with each of its characters changed, which is told its place.
    pub fn change(&mut self, text: Text, change: impl Fn(usize, char, char) -> char) -> Value {
        let from = self.memory.top;
        let mut at = 0;
        let mut before = ' ';
        while let Some(char) = self.memory.text(text.rest(at)).chars().next() {
            self.memory.push_char(change(at, before, char));
            at += char.len_utf8();
            before = char;
        }
        Value::str(self.memory.text_since(from))
    }

    /// A string in upper case.
    pub fn upper(&mut self, text: Text) -> Value {
        if chars::find(self.memory.text(text), "ß", 0).is_some() {
            let (sharp, double) = (self.memory.copy_in("ß"), self.memory.copy_in("SS"));
            if let Some(text) = self.replace(text, sharp, double, -1).text() {
                return self.change(text, |_, _, char| chars::upper(char));
            }
        }
        self.change(text, |_, _, char| chars::upper(char))
    }

    /// A string in lower case.
    pub fn lower(&mut self, text: Text) -> Value {
        self.change(text, |_, _, char| chars::lower(char))
    }

    /// A string with its first character in upper case and the others in lower case.
    pub fn capitalize(&mut self, text: Text) -> Value {
        self.change(text, |at, _, char| if at == 0 { chars::upper(char) } else { chars::lower(char) })
    }

    /// A string without blanks, or without other characters, at its ends.
    pub fn strip(&self, text: Text, set: Option<Text>, sides: (bool, bool)) -> Text {
        let string = self.memory.text(text);
        let goes = |char: char| {
            set.map_or_else(|| chars::is_blank(char), |set| self.memory.text(set).chars().any(|known| known == char))
        };
        let from = if sides.0 { string.len() - string.trim_start_matches(goes).len() } else { 0 };
        let to = if sides.1 { string.trim_end_matches(goes).len() } else { string.len() };
        text.part(from, to.max(from))
    }

    /// Place of a string in another from a place on, in bytes.
    pub fn position(&self, text: Text, part: Text, from: usize) -> Option<usize> {
        chars::find(self.memory.text(text), self.memory.text(part), from)
    }

    /// A string with parts replaced, at most so many.
    pub fn replace(&mut self, text: Text, old: Text, new: Text, most: i64) -> Value {
        let from = self.memory.top;
        let length = text.len();
        let mut left = if most < 0 { i64::MAX } else { most };
        let mut at = 0;
        while left > 0
            && at <= length
            && let Some(found) = self.position(text, old, at)
        {
            self.memory.push_text(text.part(at, found));
            self.memory.push_text(new);
            at = found + old.len();
            left -= 1;
            if old.len() == 0 {
                let next = self.memory.text(text.part(found, length)).chars().next();
                let Some(char) = next else {
                    at = length + 1;
                    break;
                };
                self.memory.push_char(char);
                at = found + char.len_utf8();
            }
        }
        self.memory.push_text(text.part(at.min(length), length));
        Value::str(self.memory.text_since(from))
    }

    /// Parts of a string between separators, at most so many and the rest.
    pub fn split(&mut self, text: Text, separator: Option<Text>, most: i64) -> Result<Value> {
        let Some(separator) = separator else { return self.split_blanks(text, most) };
        if separator.len() == 0 {
            return self.memory.fail(Words::EmptySeparator);
        }
        let head = self.memory.new_block(0, SIZE);
        let mut left = if most < 0 { i64::MAX } else { most };
        let mut at = 0;
        while left > 0
            && let Some(found) = self.position(text, separator, at)
        {
            self.append(head, Value::str(text.part(at, found)));
            at = found + separator.len();
            left -= 1;
        }
        self.append(head, Value::str(text.rest(at)));
        Ok(Value::seq(Seq::List, head))
    }

    fn split_blanks(&mut self, text: Text, most: i64) -> Result<Value> {
        let head = self.memory.new_block(0, SIZE);
        let mut left = if most < 0 { i64::MAX } else { most };
        let mut rest = self.strip(text, None, (true, false));
        while rest.len() > 0 {
            let string = self.memory.text(rest);
            let end = if left > 0 { string.find(chars::is_blank).unwrap_or(string.len()) } else { string.len() };
            let part = if left > 0 { rest.part(0, end) } else { self.strip(rest, None, (false, true)) };
            self.append(head, Value::str(part));
            rest = self.strip(rest.rest(end), None, (true, false));
            left -= 1;
        }
        Ok(Value::seq(Seq::List, head))
    }

    /// Lines of a string.
    pub fn split_lines(&mut self, text: Text) -> Value {
        let head = self.memory.new_block(0, SIZE);
        let mut rest = text;
        while rest.len() > 0 {
            let string = self.memory.text(rest);
            let end =
                string.find(['\n', '\r', '\x0b', '\x0c', '\x1c', '\x1d', '\x1e', '\u{85}', '\u{2028}', '\u{2029}']);
            let (end, next) = match end {
                None => (string.len(), string.len()),
                Some(end) => {
                    let tail = string.get(end..).unwrap_or_default();
                    let width =
                        if tail.starts_with("\r\n") { 2 } else { tail.chars().next().map_or(1, char::len_utf8) };
                    (end, end + width)
                }
            };
            self.append(head, Value::str(rest.part(0, end)));
            rest = rest.rest(next);
        }
        Value::seq(Seq::List, head)
    }

    /// A string with blanks or other characters on its sides until it is so wide.
    pub fn pad(&mut self, text: Text, (left, right): (usize, usize), fill: char) -> Value {
        let from = self.memory.top;
        self.memory.push_chars(fill, left);
        self.memory.push_text(text);
        self.memory.push_chars(fill, right);
        Value::str(self.memory.text_since(from))
    }

    /// Texts of the elements of a value with another text between them.
    pub fn join(&mut self, values: Value, between: Text, is_strict: bool) -> Result<Value> {
        let length = self.iterate(values)?;
        let mut joined = Text::default();
        for index in 0..length {
            if index > 0 {
                joined = self.memory.extend(joined, between);
            }
            let element = self.element(values, index)?;
            if is_strict && !matches!(element.view(), View::Str(_)) {
                return Err(super::wrong(&self.memory, Words::TextsToJoin, element));
            }
            let text = self.text_of(element)?;
            joined = if index == 0 { self.memory.copy_text(text) } else { self.memory.extend(joined, text) };
        }
        self.use_up(values);
        Ok(Value::str(joined))
    }
}
