//! Strings: joined, split, searched and changed.

use super::Run;
use crate::chars::{self, Case, Sides};
use crate::fault::{Result, Words};
use crate::memory::Text;
use crate::value::{Seq, Value, View};

impl Run<'_, '_> {
    /// Two strings as one. A string at the end of memory is not copied.
    pub fn join_two(&mut self, a: Text, b: Text) -> Value {
        let from = self.memory.top;
        self.memory.push_text(a);
        self.memory.push_text(b);
        Value::str(self.memory.text_since(from))
    }

    /// A string in another case.
    pub fn change(&mut self, text: Text, case: Case) -> Value {
        let from = self.memory.top;
        let mut at = 0;
        let mut before = '\0';
        while let Some(char) = chars::first(self.memory.text(text.rest(at))) {
            let is_upper = case.is_upper(before, char);
            if is_upper && char == 'ß' {
                self.memory.push_bytes(if matches!(case, Case::Upper | Case::Swapped) { b"SS" } else { b"Ss" });
            } else {
                self.memory.push_char(if is_upper { chars::upper(char) } else { chars::lower(char) });
            }
            at += char.len_utf8();
            before = char;
        }
        Value::str(self.memory.text_since(from))
    }

    /// A string without blanks, or without other characters, at its ends.
    pub fn strip(&self, text: Text, set: Option<Text>, sides: Sides) -> Text {
        let set = set.map(|set| self.memory.text(set));
        let (from, to) = chars::strip(self.memory.text(text), set, sides);
        text.part(from, to)
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
                let next = chars::first(self.memory.text(text.rest(found)));
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
        let Some(separator) = separator else { return Ok(self.split_blanks(text, most)) };
        if separator.len() == 0 {
            return self.memory.fail(Words::EmptySeparator);
        }
        let head = self.memory.new_list();
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

    fn split_blanks(&mut self, text: Text, most: i64) -> Value {
        let head = self.memory.new_list();
        let mut left = if most < 0 { i64::MAX } else { most };
        let mut rest = self.strip(text, None, Sides::Left);
        while rest.len() > 0 {
            let mut end = 0;
            while let Some(char) = chars::first(self.memory.text(rest.rest(end)))
                && (left == 0 || !chars::is_blank(char))
            {
                end += char.len_utf8();
            }
            let part = if left == 0 { self.strip(rest, None, Sides::Right) } else { rest.part(0, end) };
            self.append(head, Value::str(part));
            rest = self.strip(rest.rest(end), None, Sides::Left);
            left -= 1;
        }
        Value::seq(Seq::List, head)
    }

    /// Lines of a string.
    pub fn split_lines(&mut self, text: Text) -> Value {
        let head = self.memory.new_list();
        let mut rest = text;
        while rest.len() > 0 {
            let mut end = 0;
            let mut next = 0;
            while let Some(char) = chars::first(self.memory.text(rest.rest(end))) {
                next = end + char.len_utf8();
                if matches!(char, '\n'..='\r' | '\x1c'..='\x1e' | '\u{85}' | '\u{2028}' | '\u{2029}') {
                    let is_pair = self.memory.bytes(rest.rest(end)).starts_with(b"\r\n");
                    next += usize::from(is_pair);
                    break;
                }
                end = next;
            }
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
