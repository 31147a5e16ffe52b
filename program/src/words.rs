//! Words of a code, converted as its row of the table says: in mm, seconds and amperes, within their bounds.

use core::fmt;

use gcode::{Block, Code};
use units::{Axis, AxisSet};

use crate::fault::{Fault, Problem};
use crate::word::{Bounds, Unit, WordInfo};

/// Millimetres in an inch (exact since 1959).
pub(crate) const MM_PER_INCH: f64 = 25.4;

/// The words of one code.
#[derive(Clone, Copy, Debug)]
pub struct Words<'b> {
    block: &'b Block<'b>,
    /// Descriptions of the words in the code's row.
    known: &'static [WordInfo],
    code: Code,
    lengths: Lengths,
}

/// Units of lengths in the program.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Lengths {
    /// Whether lengths are in inches (G20).
    pub inches: bool,
    /// Whether lengths along X are diameters (G7).
    pub diameters: bool,
}

impl Lengths {
    /// Millimetres and radii, the default.
    const PLAIN: Self = Self { inches: false, diameters: false };

    fn mm(self, letter: char, value: f64) -> f64 {
        let value = if self.diameters && letter.eq_ignore_ascii_case(&'X') { value / 2.0 } else { value };
        if self.inches { value * MM_PER_INCH } else { value }
    }
}

impl<'b> Words<'b> {
    /// Creates the words of a block for the row of this code.
    pub(crate) const fn new(block: &'b Block<'b>, code: Code, known: &'static [WordInfo], lengths: Lengths) -> Self {
        Self { block, known, code, lengths }
    }

    /// Creates an empty list of words, where a dialect's code equals a code without words.
    pub(crate) const fn bare(code: Code) -> Self {
        static BARE: Block<'static> = Block::new(None, 1);
        Self { block: &BARE, known: &[], code, lengths: Lengths::PLAIN }
    }

    /// Returns the same words, read in other units.
    pub(crate) const fn read_as(self, known: &'static [WordInfo]) -> Self {
        Self { known, ..self }
    }

    /// Returns the code that the words belong to.
    #[must_use]
    pub const fn code(&self) -> Code {
        match self.block.code {
            Some(code) => code,
            None => self.code,
        }
    }

    /// Whether the block has a code, rather than words for the motion code in force.
    #[must_use]
    pub(crate) const fn has_code(&self) -> bool {
        self.block.code.is_some()
    }

    /// Returns the number of a word in the internal unit; as written if the row does not list the word.
    #[must_use]
    pub fn get(&self, letter: char) -> Option<f64> {
        let value = self.block.get(letter)?;
        let unit = self.known(letter).map_or(Unit::Number, |word| word.unit);
        Some(self.converted(letter, value, unit))
    }

    /// Returns a length in mm, for words that the row reads as lengths. Skips looking at the row for speed,
    /// because every line of a program has lengths.
    #[must_use]
    #[inline]
    pub(crate) fn length(&self, letter: char) -> Option<f64> {
        debug_assert!(self.known(letter).is_none_or(|word| word.unit == Unit::Length), "{letter}");
        let value = self.block.get(letter)?;
        Some(if self.lengths == Lengths::PLAIN { value } else { self.lengths.mm(letter, value) })
    }

    /// Returns the same in place, of X, Y and Z: every move has some of them.
    #[inline(always)]
    pub(crate) fn coordinate(&self, letter: char) -> Option<f64> {
        debug_assert!(self.known(letter).is_none_or(|word| word.unit == Unit::Length), "{letter}");
        let value = self.block.coordinate(letter)?;
        Some(if self.lengths == Lengths::PLAIN { value } else { self.lengths.mm(letter, value) })
    }

    /// Returns a plain number, for words that the row reads as numbers.
    #[must_use]
    pub(crate) fn number(&self, letter: char) -> Option<f64> {
        debug_assert!(self.known(letter).is_none_or(|word| word.unit == Unit::Number), "{letter}");
        self.block.get(letter)
    }

    /// Returns a feed rate in mm/s, for words that the row reads as feed rates.
    #[must_use]
    pub(crate) fn feed(&self, letter: char) -> Option<f64> {
        debug_assert!(self.known(letter).is_none_or(|word| word.unit == Unit::Feed), "{letter}");
        let value = self.block.get(letter)?;
        Some(self.converted(letter, value, Unit::Feed))
    }

    /// Returns the number as written, in any unit.
    #[must_use]
    pub(crate) fn as_written(&self, letter: char) -> Option<f64> {
        self.block.get(letter)
    }

    /// Returns the row's description of a letter.
    fn known(&self, letter: char) -> Option<&'static WordInfo> {
        self.known.iter().find(|word| word.letter() == letter.to_ascii_uppercase())
    }

    fn converted(&self, letter: char, value: f64, unit: Unit) -> f64 {
        let length = |value: f64| self.lengths.mm(letter, value);
        match unit {
            Unit::Length => length(value),
            Unit::Feed => length(value) / 60.0,
            Unit::StepsPerLength if self.lengths.inches => value / MM_PER_INCH,
            Unit::MmPerMinute => value / 60.0,
            Unit::Milliseconds | Unit::Milliamps => value / 1_000.0,
            Unit::Percent => value / 100.0,
            _ => value,
        }
    }

    /// Returns a word as a length in mm, for rows that read it as a number because only some uses are
    /// lengths.
    #[must_use]
    pub fn as_length(&self, letter: char) -> Option<f64> {
        self.block.get(letter).map(|value| self.converted(letter, value, Unit::Length))
    }

    /// Whether a word is present, with or without a number.
    #[must_use]
    pub fn has(&self, letter: char) -> bool {
        self.block.has(letter)
    }

    /// Whether a word is A, B, C or polar, see [`Block::has_rare_coordinate`].
    #[inline]
    pub(crate) const fn has_rare_coordinate(&self) -> bool {
        self.block.has_rare_coordinate()
    }

    /// Whether the code has no words.
    #[must_use]
    pub const fn is_bare(&self) -> bool {
        self.block.is_bare()
    }

    /// Whether the block has only rates, which need no move, and no code.
    pub(crate) fn are_rates_alone(&self) -> bool {
        self.block.code.is_none() && !self.is_bare() && self.other_than("FS").is_none()
    }

    /// Returns the number of words.
    #[must_use]
    pub fn count(&self) -> usize {
        self.block.words().count()
    }

    /// Returns the text after a code that takes text.
    #[must_use]
    pub const fn text(&self) -> Option<&'b str> {
        self.block.text
    }

    /// Returns the axes that are named.
    #[must_use]
    pub fn axes(&self) -> AxisSet {
        AxisSet::collect(Axis::ALL.into_iter().filter(|axis| self.has(axis.letter())))
    }

    /// Returns the value of an axis' word.
    #[must_use]
    pub fn axis(&self, axis: Axis) -> Option<f64> {
        self.get(axis.letter())
    }

    /// Returns a written letter that is not among these.
    #[must_use]
    pub fn other_than(&self, letters: &str) -> Option<char> {
        self.block.words().map(|(letter, _)| letter).find(|letter| !letters.contains(*letter))
    }

    /// Returns the written letters outside this set, [`gcode::letter_bit`] each.
    pub(crate) fn strange(&self, known: u32) -> impl Iterator<Item = char> + 'b {
        let is_strange = move |letter: &char| gcode::letter_bit(*letter) & known == 0;
        self.block.words().map(|(letter, _)| letter).filter(is_strange)
    }

    /// Whether a written letter is outside this set; faster than [`Self::strange`].
    #[inline]
    pub(crate) const fn has_strange(&self, known: u32) -> bool {
        self.block.has_beside(known)
    }

    /// Returns a written letter that the row does not take.
    pub(crate) fn not_taken(&self) -> Option<char> {
        self.block.words().map(|(letter, _)| letter).find(|letter| !self.takes(*letter))
    }

    /// Whether the row takes a letter, written or not.
    #[must_use]
    pub fn takes(&self, letter: char) -> bool {
        self.known(letter).is_some()
    }

    /// Returns the column of a word, from 1; the code's column if the word is missing.
    #[must_use]
    pub fn column_of(&self, letter: char) -> u16 {
        self.block.column_of(letter)
    }

    /// Returns the column of the code.
    #[must_use]
    pub const fn column(&self) -> u16 {
        self.block.column
    }

    /// Checks every word against the bounds in its row.
    ///
    /// # Errors
    /// When a word is out of bounds, the first such word.
    pub(crate) fn check(&self) -> Result<(), Fault> {
        for word in self.known {
            if let Some(value) = self.block.get(word.letter()).filter(|_| *word.bounds != Bounds::Any) {
                self.check_word(word, value)?;
            }
        }
        Ok(())
    }

    fn check_word(&self, word: &WordInfo, value: f64) -> Result<(), Fault> {
        let (code, letter) = (self.code(), word.letter());
        let problem = match *word.bounds {
            Bounds::AtLeast(least) if value < least => Problem::TooLittle(code, letter, least),
            Bounds::Above(bound) if value <= bound => Problem::MustExceed(code, letter, bound),
            Bounds::Within(least, _) if value < least => Problem::TooLittle(code, letter, least),
            Bounds::Within(_, most) if value > most => Problem::TooMuch(code, letter, most),
            Bounds::Whole(least, _) if value < least => Problem::TooLittle(code, letter, least),
            Bounds::Whole(_, most) if value > most => Problem::TooMuch(code, letter, most),
            Bounds::Whole(..) if libm::floor(value) != value => Problem::NotWhole(code, letter),
            _ => return Ok(()),
        };
        Err(problem.refused(self.column_of(letter)))
    }
}

/// Formats the words in internal units, each after a blank.
impl fmt::Display for Words<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(text) = self.text() {
            write!(f, " {text}")?;
        }
        for (letter, value) in self.block.words() {
            write!(f, " {letter}")?;
            if value.is_some() {
                write!(f, "{}", self.get(letter).unwrap_or_default())?;
            }
        }
        Ok(())
    }
}
