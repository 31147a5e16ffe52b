//! A command with its words.

use core::fmt;

use heapless::Vec;

/// Letter of a command: its kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs, reason = "the letters are the meaning")]
pub enum Letter {
    G,
    M,
    T,
}

/// The number of `T-1`: no tool.
pub const NO_TOOL: u16 = u16::MAX;

/// A command code: `G1`, `G38.2`, `M106.1`, `T0`. Without a written subcode it is 0: `G59.0` equals `G59`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Code {
    /// G, M or T.
    pub letter: Letter,
    /// The number; for T the tool.
    pub number: u16,
    /// The digits after the point.
    pub subcode: u8,
}

impl Code {
    /// Code of the command `Gn`.
    #[must_use]
    pub const fn g(number: u16) -> Self {
        Self { letter: Letter::G, number, subcode: 0 }
    }

    /// Code of the command `Mn`.
    #[must_use]
    pub const fn m(number: u16) -> Self {
        Self { letter: Letter::M, number, subcode: 0 }
    }

    /// Code of the command `Tn`.
    #[must_use]
    pub const fn t(number: u16) -> Self {
        Self { letter: Letter::T, number, subcode: 0 }
    }

    /// Returns the code with a subcode, as in `Code::g(38).sub(2)`.
    #[must_use]
    pub const fn sub(self, subcode: u8) -> Self {
        Self { subcode, ..self }
    }
}

impl fmt::Display for Code {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let letter = match self.letter {
            Letter::G => 'G',
            Letter::M => 'M',
            Letter::T => 'T',
        };
        if self.letter == Letter::T && self.number == NO_TOOL {
            return f.write_str("T-1");
        }
        write!(f, "{letter}{}", self.number)?;
        if self.subcode > 0 {
            write!(f, ".{}", self.subcode)?;
        }
        Ok(())
    }
}

/// Places from `@` to `^`, as ASCII has them: between them are A to Z, and three that no word can have.
const LETTERS: usize = 31;
/// Bit n: the n-th place is that of a letter a word can have.
const ARE_LETTERS: u32 = 0b100_0111_1111_1111_1111_1111_1111_1111;
const POLAR_DISTANCE: u32 = 1 << 0;
const POLAR_ANGLE: u32 = 1 << 30;

/// Every letter a word can have, in the order in which words are given: A to Z, and `@` and `^` of polar
/// coordinates.
pub const WORD_LETTERS: [char; 28] = {
    let mut letters = ['@'; 28];
    let mut place = 0;
    while place < 26 {
        letters[place] = (b'A' + place as u8) as char;
        place += 1;
    }
    letters[27] = '^';
    letters
};

/// The bit of a letter that a word can have, in upper case.
#[must_use]
pub const fn letter_bit(letter: char) -> u32 {
    1 << ((letter as u32).wrapping_sub('@' as u32) & 31)
}

/// A word of a block.
#[derive(Clone, Copy, Debug)]
struct Word {
    /// 0 when it has no number.
    value: f64,
    column: u8,
}

/// Index of the word of each letter in a block. Aligned, so that the array is cleared in whole registers.
#[derive(Clone, Copy, Debug)]
#[repr(align(4))]
struct Places([u8; 32]);

/// A command and its words, or words alone, which go on with the last motion code.
///
/// A letter written twice counts as its last writing. Letters are upper case, however they were written.
#[derive(Clone, Debug)]
pub struct Block<'a> {
    /// The command; none: the modal motion code applies.
    pub code: Option<Code>,
    /// Column of the first word, from 1.
    pub column: u16,
    /// Raw text after a code of `TEXT_M_CODES` (`scanner.rs`), trimmed, without comment and checksum.
    pub text: Option<&'a str>,
    /// Bit n: the n-th letter is written.
    present: u32,
    /// Bit n: the n-th letter has a number.
    valued: u32,
    /// Words in the order in which they are written: few, and an unwritten letter leaves nothing to clear.
    words: Vec<Word, { WORD_LETTERS.len() }>,
    /// Indices of the written letters' words.
    places: Places,
}

impl<'a> Block<'a> {
    /// A block without words.
    #[must_use]
    pub const fn new(code: Option<Code>, column: u16) -> Self {
        Self { code, column, text: None, present: 0, valued: 0, words: Vec::new(), places: Places([0; 32]) }
    }

    /// Makes it a block of this code without words.
    pub(crate) fn begin(&mut self, code: Option<Code>, column: u16) {
        (self.code, self.column, self.text, self.present, self.valued) = (code, column, None, 0, 0);
        self.words.clear();
    }

    /// Adds or replaces a word; for tests and for programs that make blocks. Anything but a letter is left
    /// out.
    #[must_use]
    pub fn with(mut self, letter: char, value: f64) -> Self {
        if let Ok(byte) = u8::try_from(letter) {
            self.set(byte, Some(value), 0);
        }
        self
    }

    /// The number of a word, when the word is there and has one. Letters in either case.
    #[must_use]
    #[inline]
    pub fn get(&self, letter: char) -> Option<f64> {
        let index = index(letter)?;
        if self.valued & (1 << index) == 0 {
            return None;
        }
        self.word(index).map(|word| word.value)
    }

    /// The number of a word by its letter in upper case, read in place: every move has some of these.
    #[must_use]
    #[inline(always)]
    pub fn coordinate(&self, letter: char) -> Option<f64> {
        if self.valued & letter_bit(letter) == 0 {
            return None;
        }
        let index = (letter as usize).wrapping_sub('@' as usize);
        self.words.get(usize::from(*self.places.0.get(index)?)).map(|word| word.value)
    }

    /// The word of a letter that is written.
    #[inline]
    fn word(&self, index: usize) -> Option<&Word> {
        self.words.get(usize::from(*self.places.0.get(index)?))
    }

    /// Whether a word is there, with or without a number.
    #[must_use]
    pub fn has(&self, letter: char) -> bool {
        index(letter).is_some_and(|index| self.present & (1 << index) != 0)
    }

    /// Whether one of the words A, B, C, `@` and `^` is there: those of a move that few moves have.
    #[must_use]
    #[inline]
    pub const fn has_rare_coordinate(&self) -> bool {
        const RARE: u32 = 0b1110 | POLAR_DISTANCE | POLAR_ANGLE;
        self.present & RARE != 0
    }

    /// Whether a word is there that is none of these: [`letter_bit`] each.
    #[must_use]
    #[inline]
    pub const fn has_beside(&self, letters: u32) -> bool {
        self.present & !letters != 0
    }

    /// The letters of all words that are there: [`letter_bit`] each.
    #[must_use]
    #[inline]
    pub const fn letters(&self) -> u32 {
        self.present
    }

    /// Whether there is no word (nor text) beside the code.
    #[must_use]
    pub const fn is_bare(&self) -> bool {
        self.present == 0 && self.text.is_none()
    }

    /// Column of a word, from 1; the block's own when the word is not there.
    #[must_use]
    pub fn column_of(&self, letter: char) -> u16 {
        let word = index(letter).filter(|_| self.has(letter)).and_then(|index| self.word(index));
        word.map_or(self.column, |word| u16::from(word.column))
    }

    /// The words in order of the alphabet: letter and number.
    pub fn words(&self) -> impl Iterator<Item = (char, Option<f64>)> + '_ {
        WORD_LETTERS.into_iter().filter(|&letter| self.has(letter)).map(|letter| (letter, self.get(letter)))
    }

    /// Whether the code is this one, subcode included.
    #[must_use]
    pub fn is(&self, code: Code) -> bool {
        self.code == Some(code)
    }

    pub(crate) fn set(&mut self, letter: u8, value: Option<f64>, column: u8) {
        let Some(index) = index(char::from(letter)) else { return };
        match value {
            Some(value) => self.put(index, Word { value, column }),
            None => {
                self.put(index, Word { value: 0.0, column });
                self.valued &= !(1 << index);
            }
        }
    }

    /// Adds the words of another block whose letters are among these: [`letter_bit`] each.
    pub(crate) fn take(&mut self, other: &Self, letters: u32) {
        let mut left = other.present & letters;
        while left != 0 {
            let index = left.trailing_zeros() as usize;
            left &= left - 1;
            if let Some(word) = other.word(index) {
                self.put(index, *word);
            }
        }
        self.valued &= !(other.present & letters & !other.valued);
    }

    /// Adds or replaces a word that has a number, by its letter in upper case.
    #[inline(always)]
    pub(crate) fn set_plain(&mut self, letter: u8, value: f64, column: u8) {
        self.put(usize::from(letter.wrapping_sub(b'@') & 31), Word { value, column });
    }

    #[inline(always)]
    fn put(&mut self, index: usize, word: Word) {
        let bit = 1 << index;
        self.valued |= bit;
        let Some(place) = self.places.0.get_mut(index) else { return };
        if self.present & bit == 0 {
            self.present |= bit;
            *place = self.words.len() as u8;
            // The list has room for one word of each letter.
            let _ = self.words.push(word);
        } else if let Some(known) = self.words.get_mut(usize::from(*place)) {
            *known = word;
        }
    }
}

/// Equal in meaning: columns do not count.
impl PartialEq for Block<'_> {
    fn eq(&self, other: &Self) -> bool {
        self.code == other.code && self.text == other.text && self.words().eq(other.words())
    }
}

/// Prints a block that reads back as the same block.
impl fmt::Display for Block<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut blank = "";
        if let Some(code) = self.code {
            write!(f, "{code}")?;
            blank = " ";
        }
        if let Some(text) = self.text {
            write!(f, " {text}")?;
        }
        // In first place N, O and T would be a line number, a subroutine or a tool, so those words come last.
        let is_late = |word: &(char, Option<f64>)| matches!(word.0, 'N' | 'O' | 'T');
        for (letter, value) in self.words().filter(|word| !is_late(word)).chain(self.words().filter(is_late)) {
            write!(f, "{blank}{letter}")?;
            if let Some(value) = value {
                write!(f, "{value}")?;
            }
            blank = " ";
        }
        Ok(())
    }
}

/// The place of a letter, in either case.
#[inline]
fn index(letter: char) -> Option<usize> {
    let place = u32::from(letter.to_ascii_uppercase()).wrapping_sub(u32::from('@'));
    (place < LETTERS as u32 && ARE_LETTERS & (1 << place) != 0).then_some(place as usize)
}
