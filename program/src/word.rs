//! Words in a row of the table of codes.

/// Word that a code takes. Rows have hundreds of words with few distinct bounds, so bounds are references.
#[derive(Clone, Copy, Debug)]
pub struct WordInfo {
    letter: u8,
    /// Unit of the word's number.
    pub unit: Unit,
    /// Permitted numbers of the word.
    pub bounds: &'static Bounds,
    /// Meaning of the word, for documentation.
    pub text: Doc,
}

/// Unit of a word's number as written; [`crate::Words`] converts to mm, s, mm/s and A.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unit {
    /// Length in mm, or in inches if the program uses inches.
    Length,
    /// Length per minute, in mm or inches.
    Feed,
    /// Steps for each mm or inch.
    StepsPerLength,
    /// Length in mm, whatever the program's unit.
    Mm,
    /// Speed in mm/min, never inches.
    MmPerMinute,
    /// Speed in mm/s, never inches.
    MmPerSecond,
    /// Acceleration in mm/s2, never inches.
    MmPerSecond2,
    /// Time in seconds, s.
    Seconds,
    /// Time in milliseconds, ms.
    Milliseconds,
    /// The dialect's unit of time.
    Dwell,
    /// Temperature in degrees Celsius.
    Celsius,
    /// Percent, converted to a factor.
    Percent,
    /// Current in amperes, A.
    Amps,
    /// Current in milliamperes, mA.
    Milliamps,
    /// Plain number without unit.
    Number,
    /// The number of a tool or heater.
    Id,
    /// Presence of the letter alone, without a number.
    Flag,
}

impl Unit {
    /// Returns the unit's name for readers; empty for plain numbers.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Length => "length",
            Self::Feed => "length/min",
            Self::StepsPerLength => "steps/length",
            Self::Mm => "mm",
            Self::MmPerMinute => "mm/min",
            Self::MmPerSecond => "mm/s",
            Self::MmPerSecond2 => "mm/s2",
            Self::Seconds => "s",
            Self::Milliseconds => "ms",
            Self::Dwell => "ms, in GRBL's dialect s",
            Self::Celsius => "C",
            Self::Percent => "%",
            Self::Amps => "A",
            Self::Milliamps => "mA",
            Self::Number | Self::Id | Self::Flag => "",
        }
    }
}

/// Range of a word's number, as written.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Bounds {
    /// Any number is permitted.
    Any,
    /// At least this number.
    AtLeast(f64),
    /// Greater than this number.
    Above(f64),
    /// From the first number to the second.
    Within(f64, f64),
    /// Whole numbers from the first to the second.
    Whole(f64, f64),
}

/// Text for documentation only, which the firmware image leaves out.
#[derive(Clone, Copy, Debug)]
pub struct Doc {
    #[cfg(feature = "docs")]
    text: &'static str,
}

/// Creates text for the documentation.
#[cfg_attr(not(feature = "docs"), allow(unused_variables, reason = "then nobody reads it"))]
pub(crate) const fn doc(text: &'static str) -> Doc {
    Doc {
        #[cfg(feature = "docs")]
        text,
    }
}

#[cfg(feature = "docs")]
impl Doc {
    /// Returns the documentation text.
    #[must_use]
    pub const fn text(self) -> &'static str {
        self.text
    }
}

/// Creates a word without bounds.
///
/// # Panics
/// When the letter is not ASCII; rows are constants, so the compiler reports this.
pub(crate) const fn word(letter: char, unit: Unit, text: &'static str) -> WordInfo {
    assert!(letter.is_ascii());
    WordInfo { letter: letter as u8, unit, bounds: &Bounds::Any, text: doc(text) }
}

impl WordInfo {
    /// Returns the word's letter.
    #[must_use]
    pub const fn letter(&self) -> char {
        self.letter as char
    }

    /// Returns the word with bounds.
    pub(crate) const fn bounds(mut self, bounds: &'static Bounds) -> Self {
        self.bounds = bounds;
        self
    }
}
