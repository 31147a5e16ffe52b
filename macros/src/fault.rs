//! Faults while a template is read or rendered, and the errors that callers see.

use core::fmt;

use heapless::String;

use crate::memory::{Memory, Text};
pub use crate::words::Words;

/// Longest detail of an error, bytes.
const MOST_DETAIL: usize = 64;

/// Result inside the crate: the place is added where the line is known.
pub type Result<T> = core::result::Result<T, Fault>;

/// A fault. Its words and its subject wait in the memory until the error is made: so results stay in
/// registers.
#[derive(Clone, Copy, Debug)]
pub struct Fault(());

/// Subject of a fault.
#[derive(Clone, Copy, Debug)]
pub enum About {
    Nothing,
    Text(Text),
    Word(&'static str),
    Byte(u8),
    Number(usize),
}

impl Fault {
    /// A fault about something that is to be named.
    #[inline(never)]
    pub fn with(memory: &Memory<'_>, words: Words, about: About) -> Self {
        memory.words.set(words);
        memory.about.set(about);
        Self(())
    }

    /// A fault about a text of the template.
    #[inline(never)]
    pub fn about(memory: &Memory<'_>, words: Words, text: Text) -> Self {
        Self::with(memory, words, About::Text(text))
    }

    /// A fault about a type or a function of the language.
    #[inline(never)]
    pub fn of(memory: &Memory<'_>, words: Words, word: &'static str) -> Self {
        Self::with(memory, words, About::Word(word))
    }
}

/// Reason why a template cannot be used or rendered, with its place.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Error {
    /// Line in the template, from 1.
    pub line: u16,
    /// Column in the line, from 1: of the word while reading, of the tag while rendering.
    pub column: u16,
    /// Words that say what is wrong and how to mend it.
    pub words: &'static str,
    /// Name, value or message that the words are about; empty if there is none.
    pub detail: String<MOST_DETAIL>,
}

impl Error {
    pub(crate) fn new((line, column): (u16, u16), memory: &Memory<'_>) -> Self {
        let mut detail = String::new();
        if memory.is_full {
            Fault::with(memory, Words::NoMemory, About::Number(memory.size()));
        }
        match memory.about.get() {
            About::Nothing => {}
            About::Text(text) => memory.text(text).chars().for_each(|char| drop(detail.push(char))),
            About::Word(word) => drop(detail.push_str(word)),
            About::Byte(byte) => drop(detail.push(char::from(byte))),
            About::Number(number) => {
                let mut digits = crate::digits::Integer::new(number as u64, 10);
                digits.text().bytes().for_each(|byte| drop(detail.push(char::from(byte))));
            }
        }
        Self { line, column, words: memory.words.get().text(), detail }
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("line ")?;
        self.line.fmt(f)?;
        f.write_str(" column ")?;
        self.column.fmt(f)?;
        f.write_str(": ")?;
        if !self.detail.is_empty() {
            f.write_str(&self.detail)?;
            f.write_str(": ")?;
        }
        f.write_str(self.words)
    }
}
