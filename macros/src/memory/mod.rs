//! Memory that the caller lends: what grows from its start, and a stack that grows from its end.
//!
//! While a template is read, code grows from the start and strings from the end. While it is rendered, values
//! grow behind the code, and the stack before the strings. Nothing is freed one by one: what a statement has
//! made and nobody keeps goes when the next statement begins.

mod blocks;
mod stack;
mod text;

use core::cell::Cell;

use crate::chars::Sides;
use crate::fault::{About, Fault, Result, Words};
use crate::value::Value;
pub use stack::Use;
pub use text::Text;

/// Greatest memory: places are 16 bits.
const MOST: usize = 0xffff;

/// Place that no memory has: what is written there is lost.
const NOWHERE: usize = MOST;

/// Memory of the caller, with what is used of it.
pub struct Memory<'a> {
    bytes: &'a mut [u8],
    /// First free byte behind what grows from the start.
    pub top: usize,
    /// First used byte of what grows from the end.
    pub low: usize,
    /// End of the values that stay when a statement is over.
    pub keep: usize,
    /// End of the values that stay when a turn of a loop is over.
    pub floor: usize,
    /// First byte of the strings of the template: the stack begins before it.
    pub pool: usize,
    /// Whether the strings of the template are complete, so that new ones are values.
    pub is_sealed: bool,
    /// The last fault.
    pub words: Cell<Words>,
    /// Subject of the last fault.
    pub about: Cell<About>,
    /// Whether something did not fit. What is appended then goes nowhere, and whoever carries out
    /// instructions or reads tags stops before the next one.
    pub is_full: bool,
}

impl<'a> Memory<'a> {
    /// Memory that is empty.
    pub fn new(bytes: &'a mut [u8]) -> Self {
        let length = bytes.len().min(MOST);
        Self {
            bytes: bytes.get_mut(..length).unwrap_or_default(),
            top: 0,
            low: length,
            keep: 0,
            floor: 0,
            pool: length,
            is_sealed: false,
            words: Cell::new(Words::Raised),
            about: Cell::new(About::Nothing),
            is_full: false,
        }
    }

    /// Length of the memory, bytes.
    pub fn size(&self) -> usize {
        self.bytes.len()
    }

    /// A fault that its words describe, in the form that functions return.
    #[inline(always)]
    pub fn fail<T>(&self, words: Words) -> Result<T> {
        Err(self.fault(words))
    }

    /// A fault that its words describe.
    #[inline(never)]
    pub fn fault(&self, words: Words) -> Fault {
        Fault::with(self, words, About::Nothing)
    }

    /// The byte at a place; 0 beyond the end.
    pub fn byte(&self, at: usize) -> u8 {
        self.bytes.get(at).copied().unwrap_or(0)
    }

    /// The 16 bits at a place.
    #[inline(never)]
    pub fn word(&self, at: usize) -> u16 {
        self.bytes.get(at..).and_then(<[u8]>::first_chunk).map_or(0, |bytes| u16::from_le_bytes(*bytes))
    }

    /// The 32 bits at a place.
    #[inline(never)]
    pub fn long_word(&self, at: usize) -> u32 {
        self.bytes.get(at..).and_then(<[u8]>::first_chunk).map_or(0, |bytes| u32::from_le_bytes(*bytes))
    }

    /// Writes a byte at a place.
    pub fn set_byte(&mut self, at: usize, byte: u8) {
        if let Some(place) = self.bytes.get_mut(at) {
            *place = byte;
        }
    }

    /// Writes 16 bits at a place.
    #[inline(never)]
    pub fn set_word(&mut self, at: usize, word: u16) {
        if let Some(place) = self.bytes.get_mut(at..).and_then(<[u8]>::first_chunk_mut) {
            *place = word.to_le_bytes();
        }
    }

    /// Writes 32 bits at a place.
    #[inline(never)]
    pub fn set_long_word(&mut self, at: usize, word: u32) {
        if let Some(place) = self.bytes.get_mut(at..).and_then(<[u8]>::first_chunk_mut) {
            *place = word.to_le_bytes();
        }
    }

    /// The 64 bits at a place.
    #[inline(never)]
    pub fn eight(&self, at: usize) -> u64 {
        u64::from(self.long_word(at)) | u64::from(self.long_word(at + 4)) << 32
    }

    /// A whole number as a value.
    #[inline(never)]
    pub fn int(&mut self, int: i64) -> Value {
        if let Some(value) = Value::short(int) {
            return value;
        }
        let at = self.top;
        self.push_bytes(&int.to_le_bytes());
        Value::long(at)
    }

    /// The whole number that a value is; truth values are 0 and 1.
    #[inline(never)]
    pub fn whole(&self, value: Value) -> Option<i64> {
        if let Some(at) = value.as_long() {
            return Some(self.eight(at) as i64);
        }
        value.as_short().or_else(|| value.as_bool().map(i64::from))
    }

    /// Copies bytes to another place; the places may overlap if the other one comes first.
    fn copy(&mut self, from: usize, to: usize, length: usize) {
        (0..length).for_each(|index| self.set_byte(to + index, self.byte(from + index)));
    }

    /// Appends a byte to what grows from the start.
    #[inline(never)]
    pub fn push_byte(&mut self, byte: u8) {
        let at = self.reserve(1);
        self.set_byte(at, byte);
    }

    /// Appends 16 bits, the low byte first.
    #[inline(never)]
    pub fn push_word(&mut self, word: u16) {
        let at = self.reserve(2);
        self.set_word(at, word);
    }

    /// Appends bytes of the program.
    #[inline(never)]
    pub fn push_bytes(&mut self, bytes: &[u8]) {
        bytes.iter().for_each(|byte| self.push_byte(*byte));
    }

    /// Appends the text of a character.
    #[inline(never)]
    pub fn push_char(&mut self, char: char) {
        self.push_bytes(char.encode_utf8(&mut [0; 4]).as_bytes());
    }

    /// Appends a character so many times.
    #[inline(never)]
    pub fn push_chars(&mut self, char: char, count: usize) {
        for _ in 0..count {
            self.push_char(char);
            if self.is_full {
                return;
            }
        }
    }

    /// Appends a text that is in memory.
    #[inline(never)]
    pub fn push_text(&mut self, text: Text) {
        (0..text.len()).for_each(|index| self.push_byte(self.byte(text.at() + index)));
    }

    /// Appends a copy of a text.
    #[inline(never)]
    pub fn copy_text(&mut self, text: Text) -> Text {
        let from = self.top;
        self.push_text(text);
        self.text_since(from)
    }

    /// A text with another behind it; what is made between them goes.
    #[inline(never)]
    pub fn extend(&mut self, text: Text, more: Text) -> Text {
        let end = text.at() + text.len();
        if more.at() >= end && more.at() < self.pool {
            self.move_down(more, end);
            self.top = end + more.len();
        } else {
            self.top = end;
            self.push_text(more);
        }
        Text::new(text.at(), self.top - text.at())
    }

    /// Moves what was appended since one place down to another.
    pub fn close_gap(&mut self, from: usize, start: usize) {
        let text = self.text_since(start);
        self.move_down(text, from);
        self.top = from + text.len();
    }

    /// Puts what was appended since a place into upper case, as far as it is ASCII.
    pub fn make_upper(&mut self, from: usize) {
        self.bytes.get_mut(from..self.top).unwrap_or_default().make_ascii_uppercase();
    }

    /// Makes room for bytes; returns where they are.
    #[inline(never)]
    pub fn reserve(&mut self, count: usize) -> usize {
        let at = self.top;
        if count > self.low.saturating_sub(at) {
            self.is_full = true;
            return NOWHERE;
        }
        self.top = at + count;
        at
    }

    /// The text that was appended since the top was at a place.
    #[inline(never)]
    pub fn text_since(&self, from: usize) -> Text {
        Text::new(from, self.top.saturating_sub(from))
    }

    /// Copies a text of the program into memory.
    #[inline(never)]
    pub fn copy_in(&mut self, text: &str) -> Text {
        let from = self.top;
        self.push_bytes(text.as_bytes());
        self.text_since(from)
    }

    /// The bytes of a text.
    #[inline(never)]
    pub fn bytes(&self, text: Text) -> &[u8] {
        self.bytes.get(text.at()..text.at() + text.len()).unwrap_or_default()
    }

    /// A text as characters; empty if its bytes are none.
    #[inline(never)]
    pub fn text(&self, text: Text) -> &str {
        core::str::from_utf8(self.bytes(text)).unwrap_or_default()
    }

    /// Whether a text is this word.
    pub fn is(&self, text: Text, word: &str) -> bool {
        self.bytes(text) == word.as_bytes()
    }

    /// A text without the blanks at its ends.
    pub fn trim(&self, text: Text) -> Text {
        let (from, to) = crate::chars::strip(self.text(text), None, Sides::Both);
        text.part(from, to)
    }

    /// Moves bytes down to a place before them.
    #[inline(never)]
    pub fn move_down(&mut self, text: Text, to: usize) -> Text {
        self.copy(text.at(), to, text.len());
        Text::new(to, text.len())
    }

    /// Moves the first bytes of a part behind the others.
    pub fn rotate(&mut self, from: usize, to: usize, count: usize) {
        if let Some(part) = self.bytes.get_mut(from..to)
            && count <= part.len()
        {
            part.rotate_left(count);
        }
    }

    /// Puts the bytes since a place, which are at the top, among the strings of the template, if they are not
    /// there yet; returns where they are.
    #[inline(never)]
    pub fn intern(&mut self, from: usize) -> Text {
        let new = self.text_since(from);
        if self.is_sealed {
            return new;
        }
        let end = self.bytes.len();
        let mut at = self.low;
        while at < end {
            let known = Text::new(at + 2, usize::from(self.word(at)));
            if self.bytes(known) == self.bytes(new) {
                self.top = from;
                return known;
            }
            at += 2 + known.len();
        }
        let length = new.len();
        if length + 2 > self.low.saturating_sub(self.top) {
            self.is_full = true;
            return Text::default();
        }
        self.low -= length + 2;
        self.copy(from, self.low + 2, length);
        self.set_word(self.low, length as u16);
        self.top = from;
        self.pool = self.low;
        Text::new(self.low + 2, length)
    }

    /// The string of the template that begins at a place.
    #[inline(never)]
    pub fn interned(&self, at: u16) -> Text {
        Text::new(usize::from(at), usize::from(self.word(usize::from(at).saturating_sub(2))))
    }

    /// Reads a value at a place.
    #[inline(never)]
    pub fn value(&self, at: usize) -> Value {
        Value::from_words(self.long_word(at), self.long_word(at + 4))
    }

    /// Writes a value at a place.
    #[inline(never)]
    pub fn set_value(&mut self, at: usize, value: Value) {
        let [low, high] = value.words();
        self.set_long_word(at, low);
        self.set_long_word(at + 4, high);
    }
}

#[cfg(test)]
mod tests {
    use super::{Memory, Text};
    use crate::value::{SIZE, Value};

    #[test]
    fn what_does_not_fit_goes_nowhere_and_is_noted() {
        let mut bytes = [0; 20];
        let mut memory = Memory::new(&mut bytes);
        let head = memory.new_block(1, SIZE);
        let at = memory.grow(head, SIZE);
        memory.set_value(at, Value::small(7));
        assert!(!memory.is_full);
        let beyond = memory.grow(head, SIZE);
        memory.set_value(beyond, Value::small(8));
        assert!(memory.is_full);
        assert_eq!((memory.count(head), memory.element(head, 0).as_short()), (1, Some(7)));
        memory.push_chars('x', usize::MAX);
        assert_eq!(memory.size(), 20);
    }

    #[test]
    fn whole_numbers_of_any_length_are_kept() {
        let mut bytes = [0; 64];
        let mut memory = Memory::new(&mut bytes);
        for int in [0, -5, 1 << 47, i64::MAX, i64::MIN] {
            let value = memory.int(int);
            assert_eq!(memory.whole(value), Some(int));
        }
        assert_eq!((memory.whole(Value::bool(true)), memory.whole(Value::NONE)), (Some(1), None));
    }

    #[test]
    fn a_text_that_follows_is_not_copied() {
        let mut bytes = [0; 64];
        let mut memory = Memory::new(&mut bytes);
        let (a, b) = (memory.copy_in("ab"), memory.copy_in("cd"));
        let joined = memory.extend(a, b);
        assert_eq!((memory.text(joined), memory.top), ("abcd", 4));
        assert_eq!(memory.text(joined.part(1, 3)), "bc");
        assert_eq!(memory.text(memory.trim(Text::new(0, 0))), "");
    }
}
