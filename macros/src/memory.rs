//! Memory that the caller lends: what grows from its start, and a stack that grows from its end.
//!
//! While a template is read, code grows from the start and strings from the end. While it is rendered, values
//! grow behind the code, and the stack before the strings. Nothing is freed one by one: what a statement has
//! made and nobody keeps goes when the next statement begins.

use core::cell::Cell;

use crate::fault::{About, Fault, Result};
use crate::value::{self, Value};

/// Greatest memory: places are 16 bits.
const MOST: usize = 0xffff;

/// A text in memory.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Text {
    /// Place of the first byte.
    pub at: u16,
    /// Length of the text, bytes.
    pub len: u16,
}

impl Text {
    /// The part of the text from one byte up to another.
    pub fn part(self, from: usize, to: usize) -> Self {
        let to = to.min(usize::from(self.len));
        let from = from.min(to);
        Self { at: self.at.saturating_add(from as u16), len: (to - from) as u16 }
    }
}

/// A list, tuple, view, dict or namespace in memory: where its elements are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Block {
    pub data: usize,
    pub len: usize,
    pub room: usize,
}

/// Length of a block's head, bytes.
const HEAD: usize = 6;

/// Use of a place on the stack.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Use {
    /// Operand of an expression.
    Operand,
    /// Variable of the template, by the place of its name.
    Variable,
    /// Argument that is given by its name.
    Keyword,
    /// Argument whose elements are arguments.
    Spread,
    /// Argument whose members are arguments with names.
    SpreadNamed,
}

/// Length of a place on the stack: use, name, value.
const SLOT: usize = 3 + value::SIZE;

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
    /// Subject of the last fault.
    pub about: Cell<About>,
    /// Most bytes that were in use at once.
    pub peak: usize,
}

impl<'a> Memory<'a> {
    /// Memory that is empty.
    pub fn new(bytes: &'a mut [u8]) -> Self {
        let length = bytes.len().min(MOST);
        Self {
            bytes,
            top: 0,
            low: length,
            keep: 0,
            floor: 0,
            pool: length,
            is_sealed: false,
            about: Cell::new(About::Nothing),
            peak: 0,
        }
    }

    #[inline(never)]
    fn check(&mut self) -> Result<()> {
        self.peak = self.peak.max(self.top + self.bytes.len().min(MOST) - self.low.min(self.bytes.len()));
        if self.top > self.low {
            let about = About::Number(self.bytes.len());
            return Err(Fault::with(self, &"bytes of memory are too few for this macro: make it shorter", about));
        }
        Ok(())
    }

    /// The byte at a place; 0 beyond the end.
    pub fn byte(&self, at: usize) -> u8 {
        self.bytes.get(at).copied().unwrap_or(0)
    }

    /// The 16 bits at a place.
    #[inline(never)]
    pub fn word(&self, at: usize) -> u16 {
        u16::from_le_bytes([self.byte(at), self.byte(at + 1)])
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
        for (index, byte) in word.to_le_bytes().into_iter().enumerate() {
            self.set_byte(at + index, byte);
        }
    }

    /// Copies bytes to another place; the places may overlap if the other one comes first.
    fn copy(&mut self, from: usize, to: usize, length: usize) {
        (0..length).for_each(|index| self.set_byte(to + index, self.byte(from + index)));
    }

    /// Appends a byte to what grows from the start.
    #[inline(never)]
    pub fn push_byte(&mut self, byte: u8) -> Result<()> {
        self.top += 1;
        self.check()?;
        self.set_byte(self.top - 1, byte);
        Ok(())
    }

    /// Appends 16 bits, the low byte first.
    #[inline(never)]
    pub fn push_word(&mut self, word: u16) -> Result<()> {
        word.to_le_bytes().into_iter().try_for_each(|byte| self.push_byte(byte))
    }

    /// Appends bytes of the program.
    #[inline(never)]
    pub fn push_bytes(&mut self, bytes: &[u8]) -> Result<()> {
        bytes.iter().try_for_each(|byte| self.push_byte(*byte))
    }

    /// Appends the text of a character.
    #[inline(never)]
    pub fn push_char(&mut self, char: char) -> Result<()> {
        self.push_bytes(char.encode_utf8(&mut [0; 4]).as_bytes())
    }

    /// Appends a text that is in memory.
    #[inline(never)]
    pub fn push_text(&mut self, text: Text) -> Result<()> {
        (0..usize::from(text.len)).try_for_each(|index| self.push_byte(self.byte(usize::from(text.at) + index)))
    }

    /// Appends a copy of a text.
    #[inline(never)]
    pub fn copy_text(&mut self, text: Text) -> Result<Text> {
        let from = self.top;
        self.push_text(text)?;
        Ok(self.text_since(from))
    }

    /// A text with another behind it; what is made between them goes.
    #[inline(never)]
    pub fn extend(&mut self, text: Text, more: Text) -> Result<Text> {
        let end = usize::from(text.at) + usize::from(text.len);
        let from = usize::from(more.at);
        if from >= end && from < self.pool {
            let moved = self.move_down(more, end);
            self.top = end + usize::from(moved.len);
            return Ok(Text { at: text.at, len: text.len + moved.len });
        }
        self.top = end;
        self.push_text(more)?;
        Ok(Text { at: text.at, len: text.len + more.len })
    }

    /// Moves what was appended since one place down to another.
    pub fn close_gap(&mut self, from: usize, start: usize) {
        let text = self.text_since(start);
        self.move_down(text, from);
        self.top = from + usize::from(text.len);
    }

    /// Puts what was appended since a place into upper case, as far as it is ASCII.
    pub fn make_upper(&mut self, from: usize) {
        self.bytes.get_mut(from..self.top).unwrap_or_default().make_ascii_uppercase();
    }

    /// Makes room for bytes; returns where they are.
    #[inline(never)]
    pub fn reserve(&mut self, count: usize) -> Result<usize> {
        let at = self.top;
        self.top = at.saturating_add(count);
        self.check()?;
        Ok(at)
    }

    /// The text that was appended since the top was at a place.
    #[inline(never)]
    pub fn text_since(&self, from: usize) -> Text {
        Text { at: from as u16, len: self.top.saturating_sub(from) as u16 }
    }

    /// Copies a text of the program into memory.
    #[inline(never)]
    pub fn copy_in(&mut self, text: &str) -> Result<Text> {
        let from = self.top;
        self.push_bytes(text.as_bytes())?;
        Ok(self.text_since(from))
    }

    /// The bytes of a text.
    #[inline(never)]
    pub fn bytes(&self, text: Text) -> &[u8] {
        let from = usize::from(text.at);
        self.bytes.get(from..from + usize::from(text.len)).unwrap_or_default()
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
        let string = self.text(text);
        let start = string.trim_start_matches(crate::chars::is_blank);
        let from = string.len() - start.len();
        text.part(from, from + start.trim_end_matches(crate::chars::is_blank).len())
    }

    /// Moves bytes down to a place before them.
    #[inline(never)]
    pub fn move_down(&mut self, text: Text, to: usize) -> Text {
        let from = usize::from(text.at);
        self.copy(from, to, usize::from(text.len));
        Text { at: to as u16, len: text.len }
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
    pub fn intern(&mut self, from: usize) -> Result<Text> {
        let new = self.text_since(from);
        if self.is_sealed {
            return Ok(new);
        }
        let end = self.bytes.len().min(MOST);
        let mut at = self.low;
        while at < end {
            let known = Text { at: (at + 2) as u16, len: self.word(at) };
            if self.bytes(known) == self.bytes(new) {
                self.top = from;
                return Ok(known);
            }
            at += 2 + usize::from(known.len);
        }
        let length = usize::from(new.len);
        self.low = self.low.saturating_sub(length + 2);
        self.check()?;
        self.copy(from, self.low + 2, length);
        self.set_word(self.low, new.len);
        self.top = from;
        self.pool = self.low;
        Ok(Text { at: (self.low + 2) as u16, len: new.len })
    }

    /// The string of the template that begins at a place.
    #[inline(never)]
    pub fn interned(&self, at: u16) -> Text {
        Text { at, len: self.word(usize::from(at).saturating_sub(2)) }
    }

    /// Reads a value at a place.
    #[inline(never)]
    pub fn value(&self, at: usize) -> Value {
        let mut payload = [0; 8];
        for (index, byte) in payload.iter_mut().enumerate() {
            *byte = self.byte(at + 1 + index);
        }
        Value::decode(self.byte(at), payload)
    }

    /// Writes a value at a place.
    #[inline(never)]
    pub fn set_value(&mut self, at: usize, value: Value) {
        let (tag, payload) = value.encode();
        self.set_byte(at, tag);
        for (index, byte) in payload.into_iter().enumerate() {
            self.set_byte(at + 1 + index, byte);
        }
    }

    /// Makes an empty block with room for elements of a size.
    #[inline(never)]
    pub fn new_block(&mut self, room: usize, size: usize) -> Result<u16> {
        let head = self.reserve(HEAD)?;
        let data = self.reserve(room.saturating_mul(size))?;
        self.set_block(head as u16, Block { data, len: 0, room });
        Ok(head as u16)
    }

    /// The block with its head at a place.
    #[inline(never)]
    pub fn block(&self, head: u16) -> Block {
        let head = usize::from(head);
        let [data, len, room] = [0, 2, 4].map(|offset| usize::from(self.word(head + offset)));
        Block { data, len, room }
    }

    /// Writes the head of a block.
    #[inline(never)]
    pub fn set_block(&mut self, head: u16, block: Block) {
        for (index, word) in [block.data, block.len, block.room].into_iter().enumerate() {
            self.set_word(usize::from(head) + 2 * index, word as u16);
        }
    }

    /// Makes room for one more element of a size; returns its place.
    #[inline(never)]
    pub fn grow(&mut self, head: u16, size: usize) -> Result<usize> {
        let mut block = self.block(head);
        if block.len == block.room {
            let more = block.room.max(2);
            if block.data + block.room * size == self.top {
                self.reserve(more * size)?;
            } else {
                let data = self.reserve((block.room + more) * size)?;
                self.copy(block.data, data, block.len * size);
                block.data = data;
            }
            block.room += more;
        }
        let at = block.data + block.len * size;
        block.len += 1;
        self.set_block(head, block);
        Ok(at)
    }

    /// Number of places on the stack.
    pub fn depth(&self) -> usize {
        self.pool.saturating_sub(self.low) / SLOT
    }

    fn slot(&self, index: usize) -> usize {
        self.pool.saturating_sub((index + 1) * SLOT)
    }

    /// Puts a value on the stack.
    #[inline(never)]
    pub fn push(&mut self, value: Value) -> Result<()> {
        self.push_named(Use::Operand, 0, value)
    }

    /// Puts a variable or an argument with its name on the stack.
    #[inline(never)]
    pub fn push_named(&mut self, kind: Use, name: u16, value: Value) -> Result<()> {
        let Some(low) = self.low.checked_sub(SLOT) else {
            return Err(Fault::new(&"the memory is too small for this macro"));
        };
        self.low = low;
        self.check()?;
        self.set_byte(low, kind as u8);
        self.set_word(low + 1, name);
        self.set_value(low + 3, value);
        Ok(())
    }

    /// Takes the last value from the stack.
    #[inline(never)]
    pub fn pop(&mut self) -> Value {
        let value = self.value(self.low + 3);
        self.low = (self.low + SLOT).min(self.pool);
        value
    }

    /// Takes values from the stack until it has so many.
    #[inline(never)]
    pub fn cut(&mut self, depth: usize) {
        self.low = self.pool.saturating_sub(depth * SLOT);
    }

    /// A value on the stack, counted from its start.
    #[inline(never)]
    pub fn at(&self, index: usize) -> Value {
        self.value(self.slot(index) + 3)
    }

    /// Writes a value on the stack.
    #[inline(never)]
    pub fn set_at(&mut self, index: usize, value: Value) {
        self.set_value(self.slot(index) + 3, value);
    }

    /// Use of a place on the stack.
    pub fn use_at(&self, index: usize) -> Use {
        const USES: [Use; 5] = [Use::Operand, Use::Variable, Use::Keyword, Use::Spread, Use::SpreadNamed];
        USES.get(usize::from(self.byte(self.slot(index)))).copied().unwrap_or(Use::Operand)
    }

    /// The name of a place on the stack, if it is used so.
    #[inline(never)]
    pub fn name_at(&self, index: usize, kind: Use) -> Option<u16> {
        let slot = self.slot(index);
        (self.byte(slot) == kind as u8).then(|| self.word(slot + 1))
    }

    /// Makes an argument of the last value.
    pub fn name_last(&mut self, kind: Use, name: u16) {
        self.set_byte(self.low, kind as u8);
        self.set_word(self.low + 1, name);
    }
}
