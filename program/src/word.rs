//! What a row of the table of codes says of each word.

/// A word that a code takes. There are hundreds, with few different bounds: those are behind a reference.
#[derive(Clone, Copy, Debug)]
pub struct WordInfo {
    letter: u8,
    /// What its number is.
    pub unit: Unit,
    /// What numbers are allowed.
    pub bounds: &'static Bounds,
    /// What it is for.
    pub text: Doc,
}

/// What the number of a word is, as it is written; [`crate::Words`] gives it in mm, s, mm/s and A.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unit {
    /// mm, or inches where the program counts in them.
    Length,
    /// The same, a minute.
    Feed,
    /// Steps for each mm or inch.
    StepsPerLength,
    /// mm, whatever the program counts in.
    Mm,
    /// mm/min.
    MmPerMinute,
    /// mm/s.
    MmPerSecond,
    /// mm/s2.
    MmPerSecond2,
    /// s.
    Seconds,
    /// ms.
    Milliseconds,
    /// The dialect's unit of time.
    Dwell,
    /// Degrees Celsius.
    Celsius,
    /// Percent.
    Percent,
    /// A.
    Amps,
    /// mA.
    Milliamps,
    /// A plain number.
    Number,
    /// The number of a tool or heater.
    Id,
    /// Nothing: that it is there is enough.
    Flag,
}

impl Unit {
    /// As a reader knows it; empty for plain numbers.
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

/// What numbers a word may have, as written.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Bounds {
    /// Any.
    Any,
    /// This or more.
    AtLeast(f64),
    /// More than this.
    Above(f64),
    /// From this to that.
    Within(f64, f64),
    /// Whole, from this to that.
    Whole(f64, f64),
}

/// Text that only documentation needs. The image does not carry it.
#[derive(Clone, Copy, Debug)]
pub struct Doc {
    #[cfg(feature = "docs")]
    text: &'static str,
}

/// Text for the documentation.
#[cfg_attr(not(feature = "docs"), allow(unused_variables, reason = "then nobody reads it"))]
pub(crate) const fn doc(text: &'static str) -> Doc {
    Doc {
        #[cfg(feature = "docs")]
        text,
    }
}

#[cfg(feature = "docs")]
impl Doc {
    /// The text.
    #[must_use]
    pub const fn text(self) -> &'static str {
        self.text
    }
}

/// A word of any value.
///
/// # Panics
/// When its letter is none: as rows are constants, the compiler says it.
pub(crate) const fn word(letter: char, unit: Unit, text: &'static str) -> WordInfo {
    assert!(letter.is_ascii());
    WordInfo { letter: letter as u8, unit, bounds: &Bounds::Any, text: doc(text) }
}

impl WordInfo {
    /// Its letter.
    #[must_use]
    pub const fn letter(&self) -> char {
        self.letter as char
    }

    /// A word of these values alone.
    pub(crate) const fn bounds(mut self, bounds: &'static Bounds) -> Self {
        self.bounds = bounds;
        self
    }
}
