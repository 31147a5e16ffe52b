//! A line as one block: all its codes, and all its words together, as RS-274/NGC reads lines.

use heapless::Vec;

use crate::block::{Block, Code, Letter};
use crate::error::{Problem, SyntaxError, column};
use crate::expression::Parameters;
use crate::scanner::Blocks;
use crate::text_value::powers;

/// Codes of a line at most.
pub const MOST_CODES: usize = 16;

/// A line whose codes share its words.
#[derive(Clone, Debug)]
pub struct WholeLine<'a> {
    pub(crate) all: Block<'a>,
    /// Column at which the line begins, from 1.
    column: u16,
    codes: Vec<Code, MOST_CODES>,
    /// Column of each code, from 1.
    columns: Vec<u16, MOST_CODES>,
    /// A letter that stands twice.
    pub(crate) twice: Option<char>,
    part: Block<'a>,
}

impl<'a> Default for WholeLine<'a> {
    fn default() -> Self {
        Self {
            all: Block::new(None, 1),
            column: 1,
            codes: Vec::new(),
            columns: Vec::new(),
            twice: None,
            part: Block::new(None, 1),
        }
    }
}

impl<'a> WholeLine<'a> {
    /// The codes, as they are written.
    #[must_use]
    pub fn codes(&self) -> &[Code] {
        &self.codes
    }

    /// A letter that stands twice; its last word counts.
    #[must_use]
    pub const fn twice(&self) -> Option<char> {
        self.twice
    }

    /// Returns all words of the line.
    #[must_use]
    pub const fn words(&self) -> &Block<'a> {
        &self.all
    }

    /// A code, or the one in force, with those of the line's words whose letters are wanted:
    /// [`letter_bit`](crate::letter_bit) each.
    pub fn part(&mut self, code: Option<Code>, wanted: u32) -> &Block<'a> {
        let place = self.codes.iter().position(|other| Some(*other) == code);
        let column = place.and_then(|place| self.columns.get(place)).copied().unwrap_or(self.column);
        // Most lines have one code, which takes all their words.
        if !self.all.has_beside(wanted) {
            (self.all.code, self.all.column) = (code, column);
            return &self.all;
        }
        self.part.begin(code, column);
        self.part.take(&self.all, wanted);
        &self.part
    }
}

impl<'a> Blocks<'a> {
    /// Reads the rest of the line as one block: codes and words in any order.
    ///
    /// # Errors
    /// The first thing that is wrong.
    pub fn read_whole(
        &mut self,
        whole: &mut WholeLine<'a>,
        parameters: &mut dyn Parameters,
    ) -> Result<(), SyntaxError> {
        whole.codes.clear();
        whole.columns.clear();
        whole.twice = None;
        whole.column = column(self.at);
        whole.all.begin(None, whole.column);
        while let Some(letter) = self.next_word(parameters)? {
            let begin = self.at;
            let code = match letter {
                b'G' => self.code(Letter::G, 'G', parameters)?,
                b'M' => self.code(Letter::M, 'M', parameters)?,
                b'T' => self.code(Letter::T, 'T', parameters)?,
                // A run of pixels behind S, which only single commands have.
                b'@' if powers(self.line, begin, &whole.all).is_some() => {
                    return Err(self.error(begin, Problem::NotALetter(b'@')));
                }
                letter => {
                    if whole.all.has(char::from(letter)) {
                        whole.twice = Some(char::from(letter));
                    }
                    let value = self.value(letter, false, parameters)?;
                    whole.all.set(letter, value, begin.saturating_add(1).min(usize::from(u8::MAX)) as u8);
                    continue;
                }
            };
            whole.codes.push(code).map_err(|_| self.error(begin, Problem::TooManyCodes))?;
            // Columns and codes have equal room.
            let _ = whole.columns.push(column(begin));
        }
        Ok(())
    }
}
