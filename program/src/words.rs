//! The words of a code as its row of the table reads them: in mm, seconds and amperes, within their bounds.

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
    /// How they are read.
    known: &'static [WordInfo],
    code: Code,
    lengths: Lengths,
}

/// How the program writes lengths.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Lengths {
    /// Lengths are in inches (G20).
    pub inches: bool,
    /// Those along X are diameters (G7).
    pub diameters: bool,
}

impl Lengths {
    /// mm, and radii.
    const PLAIN: Self = Self { inches: false, diameters: false };

    fn mm(self, letter: char, value: f64) -> f64 {
        let value = if self.diameters && letter.eq_ignore_ascii_case(&'X') { value / 2.0 } else { value };
        if self.inches { value * MM_PER_INCH } else { value }
    }
}

impl<'b> Words<'b> {
    /// The words of a block as the row of this code reads them.
    pub(crate) const fn new(block: &'b Block<'b>, code: Code, known: &'static [WordInfo], lengths: Lengths) -> Self {
        Self { block, known, code, lengths }
    }

    /// No words of a code, where a dialect says the same by another one.
    pub(crate) const fn bare(code: Code) -> Self {
        static BARE: Block<'static> = Block::new(None, 1);
        Self { block: &BARE, known: &[], code, lengths: Lengths::PLAIN }
    }

    /// The same words, read in other units.
    pub(crate) const fn read_as(self, known: &'static [WordInfo]) -> Self {
        Self { known, ..self }
    }

    /// The code they belong to.
    #[must_use]
    pub const fn code(&self) -> Code {
        match self.block.code {
            Some(code) => code,
            None => self.code,
        }
    }

    /// Whether a code is written, not only words for the one in force.
    #[must_use]
    pub(crate) const fn has_code(&self) -> bool {
        self.block.code.is_some()
    }

    /// The number of a word, in the internal unit of what it means; as it is written where the row does not
    /// know it.
    #[must_use]
    pub fn get(&self, letter: char) -> Option<f64> {
        let value = self.block.get(letter)?;
        let unit = self.known(letter).map_or(Unit::Number, |word| word.unit);
        Some(self.converted(letter, value, unit))
    }

    /// A length in mm, where the row says that it is one: without a look at the row, for every line of a
    /// program has some.
    #[must_use]
    #[inline]
    pub(crate) fn length(&self, letter: char) -> Option<f64> {
        debug_assert!(self.known(letter).is_none_or(|word| word.unit == Unit::Length), "{letter}");
        let value = self.block.get(letter)?;
        Some(if self.lengths == Lengths::PLAIN { value } else { self.lengths.mm(letter, value) })
    }

    /// A plain number, where the row says that it is one.
    #[must_use]
    pub(crate) fn number(&self, letter: char) -> Option<f64> {
        debug_assert!(self.known(letter).is_none_or(|word| word.unit == Unit::Number), "{letter}");
        self.block.get(letter)
    }

    /// A feed rate in mm/s, where the row says that it is one.
    #[must_use]
    pub(crate) fn feed(&self, letter: char) -> Option<f64> {
        debug_assert!(self.known(letter).is_none_or(|word| word.unit == Unit::Feed), "{letter}");
        let value = self.block.get(letter)?;
        Some(self.converted(letter, value, Unit::Feed))
    }

    /// The number as it is written, whatever it is.
    #[must_use]
    pub(crate) fn as_written(&self, letter: char) -> Option<f64> {
        self.block.get(letter)
    }

    /// How a letter is read here.
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

    /// A word as a length in mm, where a row reads it as a number because it is a length in some cases only.
    #[must_use]
    pub fn as_length(&self, letter: char) -> Option<f64> {
        self.block.get(letter).map(|value| self.converted(letter, value, Unit::Length))
    }

    /// Whether a word is there, with or without a number.
    #[must_use]
    pub fn has(&self, letter: char) -> bool {
        self.block.has(letter)
    }

    /// See [`Block::has_rare_coordinate`].
    #[inline]
    pub(crate) const fn has_rare_coordinate(&self) -> bool {
        self.block.has_rare_coordinate()
    }

    /// Whether there is no word beside the code.
    #[must_use]
    pub const fn is_bare(&self) -> bool {
        self.block.is_bare()
    }

    /// Whether nothing is written but rates, which need no move: the code is the one in force.
    pub(crate) fn are_rates_alone(&self) -> bool {
        self.block.code.is_none() && !self.is_bare() && self.other_than("FS").is_none()
    }

    /// How many words there are.
    #[must_use]
    pub fn count(&self) -> usize {
        self.block.words().count()
    }

    /// The text after a code that takes text.
    #[must_use]
    pub const fn text(&self) -> Option<&'b str> {
        self.block.text
    }

    /// The axes that are named.
    #[must_use]
    pub fn axes(&self) -> AxisSet {
        AxisSet::collect(Axis::ALL.into_iter().filter(|axis| self.has(axis.letter())))
    }

    /// The value of an axis' word.
    #[must_use]
    pub fn axis(&self, axis: Axis) -> Option<f64> {
        self.get(axis.letter())
    }

    /// A letter that is written and not among these.
    #[must_use]
    pub fn other_than(&self, letters: &str) -> Option<char> {
        self.block.words().map(|(letter, _)| letter).find(|letter| !letters.contains(*letter))
    }

    /// Letters that are written and none of these: [`gcode::letter_bit`] each.
    pub(crate) fn strange(&self, known: u32) -> impl Iterator<Item = char> + 'b {
        let is_strange = move |letter: &char| gcode::letter_bit(*letter) & known == 0;
        self.block.words().map(|(letter, _)| letter).filter(is_strange)
    }

    /// Whether one is, in no time.
    #[inline]
    pub(crate) const fn has_strange(&self, known: u32) -> bool {
        self.block.has_beside(known)
    }

    /// A letter that is written and that the row does not take.
    pub(crate) fn not_taken(&self) -> Option<char> {
        self.block.words().map(|(letter, _)| letter).find(|letter| !self.takes(*letter))
    }

    /// Whether the row takes a letter, written or not.
    #[must_use]
    pub fn takes(&self, letter: char) -> bool {
        self.known(letter).is_some()
    }

    /// Column of a word, from 1; the code's own when the word is not there.
    #[must_use]
    pub fn column_of(&self, letter: char) -> u16 {
        self.block.column_of(letter)
    }

    /// Column of the code.
    #[must_use]
    pub const fn column(&self) -> u16 {
        self.block.column
    }

    /// Holds every word against the bounds that its row gives it.
    ///
    /// # Errors
    /// The first word that is out of them.
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

/// The words in internal units, each after a blank.
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
