//! Values as text: what `str` and `repr` give in Python.

use super::{Run, wrong};
use crate::digits::{Integer, Shortest};
use crate::environment::Kind;
use crate::fault::{Result, Words};
use crate::memory::{Memory, Text};
use crate::value::{DEEPEST, Map, Seq, Value, View};

impl Run<'_, '_> {
    /// A value as text, as it is written.
    pub fn text_of(&mut self, value: Value) -> Result<Text> {
        if let Some(text) = value.text() {
            return Ok(text);
        }
        let value = self.settle(value, DEEPEST)?;
        let from = self.memory.top;
        if !matches!(value.view(), View::Undefined(_)) {
            self.write_repr(value, DEEPEST)?;
        }
        Ok(self.memory.text_since(from))
    }

    /// A value as Python's source would have it.
    pub fn repr_of(&mut self, value: Value) -> Result<Text> {
        let value = self.settle(value, DEEPEST)?;
        let from = self.memory.top;
        self.write_repr(value, DEEPEST)?;
        Ok(self.memory.text_since(from))
    }

    /// Appends a value, which is all in memory, to what grows.
    pub fn write_repr(&mut self, value: Value, depth: u8) -> Result<()> {
        if depth == 0 {
            return self.memory.fail(Words::TooDeep);
        }
        match value.view() {
            View::Undefined(_) => {
                self.memory.push_bytes(b"Undefined");
                Ok(())
            }
            View::None => {
                self.memory.push_bytes(b"None");
                Ok(())
            }
            View::Number => {
                self.write_number(value);
                Ok(())
            }
            View::Str(text) => {
                self.write_quoted(text);
                Ok(())
            }
            View::Seq(Seq::Once, _) => self.memory.fail(Words::WantsList),
            View::Seq(kind, head) => self.write_seq(kind, head, depth),
            View::Map(kind, head) => self.write_map(kind, head, depth),
            View::Range(at) => {
                self.write_range(at);
                Ok(())
            }
            View::Object(object) if object.kind != Kind::Lookup => self.memory.fail(Words::TooDeep),
            View::Object(_) | View::Function(_) | View::Method | View::Loop(_) => {
                Err(wrong(&self.memory, Words::NoText, value))
            }
        }
    }

    fn write_number(&mut self, value: Value) {
        if let Some(is) = value.as_bool() {
            return self.memory.push_bytes(if is { b"True" } else { b"False" });
        }
        match value.as_float() {
            Some(float) => write_float(&mut self.memory, float),
            None => {
                let int = self.memory.whole(value).unwrap_or(0);
                write_int(&mut self.memory, int)
            }
        }
    }

    fn write_seq(&mut self, kind: Seq, head: u16, depth: u8) -> Result<()> {
        let (begin, end) = match kind {
            Seq::List | Seq::Once => ("[", "]"),
            Seq::Tuple => ("(", ")"),
            Seq::Keys => ("dict_keys([", "])"),
            Seq::Values => ("dict_values([", "])"),
            Seq::Items => ("dict_items([", "])"),
        };
        self.memory.push_bytes(begin.as_bytes());
        let length = self.memory.count(head);
        for index in 0..length {
            if index > 0 {
                self.memory.push_bytes(b", ");
            }
            let element = self.element(Value::seq(kind, head), index)?;
            self.write_repr(element, depth - 1)?;
        }
        if kind == Seq::Tuple && length == 1 {
            self.memory.push_byte(b',');
        }
        self.memory.push_bytes(end.as_bytes());
        Ok(())
    }

    fn write_map(&mut self, kind: Map, head: u16, depth: u8) -> Result<()> {
        if kind == Map::Namespace {
            self.memory.push_bytes(b"<Namespace ");
        }
        self.memory.push_byte(b'{');
        for index in 0..self.memory.count(head) {
            if index > 0 {
                self.memory.push_bytes(b", ");
            }
            let (key, value) = self.entry(Value::map(kind, head), index)?;
            self.write_repr(key, depth - 1)?;
            self.memory.push_bytes(b": ");
            self.write_repr(value, depth - 1)?;
        }
        self.memory.push_byte(b'}');
        if kind == Map::Namespace {
            {
                self.memory.push_byte(b'>');
                Ok(())
            }
        } else {
            Ok(())
        }
    }

    fn write_range(&mut self, at: u16) {
        let [start, end, step] = self.range(at);
        self.memory.push_bytes(b"range(");
        write_int(&mut self.memory, start);
        self.memory.push_bytes(b", ");
        write_int(&mut self.memory, end);
        if step != 1 {
            self.memory.push_bytes(b", ");
            write_int(&mut self.memory, step);
        }
        self.memory.push_byte(b')')
    }

    fn write_quoted(&mut self, text: Text) {
        let has = |quote| self.memory.bytes(text).contains(&quote);
        let quote = if has(b'\'') && !has(b'"') { '"' } else { '\'' };
        self.memory.push_char(quote);
        let mut at = 0;
        while let Some(char) = crate::chars::first(self.memory.text(text.rest(at))) {
            at += char.len_utf8();
            match char {
                '\n' => self.memory.push_bytes(b"\\n"),
                '\r' => self.memory.push_bytes(b"\\r"),
                '\t' => self.memory.push_bytes(b"\\t"),
                _ if char == quote || char == '\\' => {
                    self.memory.push_byte(b'\\');
                    self.memory.push_char(char);
                }
                _ if is_printable(char) => self.memory.push_char(char),
                _ => write_escape(&mut self.memory, char),
            }
        }
        self.memory.push_char(quote)
    }
}

/// Whether Python writes a character as it is.
fn is_printable(char: char) -> bool {
    char == ' ' || !(char.is_whitespace() || matches!(char, '\0'..='\x1f' | '\x7f'..='\u{a0}' | '\u{ad}'))
}

fn write_escape(memory: &mut Memory<'_>, char: char) {
    let code = char as u32;
    let (prefix, width) = match code {
        0..0x100 => ("\\x", 2),
        0x100..0x1_0000 => ("\\u", 4),
        _ => ("\\U", 8),
    };
    memory.push_bytes(prefix.as_bytes());
    let mut digits = Integer::new(u64::from(code), 16);
    let text = digits.text();
    memory.push_chars('0', width - text.len());
    memory.push_bytes(text.as_bytes())
}

/// Appends a whole number.
pub fn write_int(memory: &mut Memory<'_>, int: i64) {
    if int < 0 {
        memory.push_byte(b'-');
    }
    memory.push_bytes(Integer::new(int.unsigned_abs(), 10).text().as_bytes())
}

/// Appends a real number with the shortest digits that read back as it.
pub fn write_float(memory: &mut Memory<'_>, float: f64) {
    if float.is_nan() {
        return memory.push_bytes(b"nan");
    }
    if float.is_sign_negative() {
        memory.push_byte(b'-');
    }
    if float.is_infinite() {
        return memory.push_bytes(b"inf");
    }
    let shortest = Shortest::new(float);
    let digits = shortest.digits();
    let power = shortest.power;
    if !(-4..16).contains(&power) {
        let (first, rest) = digits.split_at_checked(1).unwrap_or_default();
        memory.push_bytes(first);
        if !rest.is_empty() {
            memory.push_byte(b'.');
            memory.push_bytes(rest);
        }
        return write_exponent(memory, power);
    }
    let digit = |place: i32| {
        let index = usize::try_from(power - place).ok();
        index.and_then(|index| digits.get(index)).copied().unwrap_or(b'0')
    };
    (0..=power.max(0)).rev().for_each(|place| memory.push_byte(digit(place)));
    memory.push_byte(b'.');
    let last = (power - shortest.count as i32 + 1).min(-1);
    (last..0).rev().for_each(|place| memory.push_byte(digit(place)))
}

/// Appends an exponent of at least two digits.
pub fn write_exponent(memory: &mut Memory<'_>, power: i32) {
    memory.push_bytes(if power < 0 { b"e-" } else { b"e+" });
    let mut digits = Integer::new(u64::from(power.unsigned_abs()), 10);
    if power.unsigned_abs() < 10 {
        memory.push_byte(b'0');
    }
    memory.push_bytes(digits.text().as_bytes())
}
