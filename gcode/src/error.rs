//! Syntax errors in a line, with their column.

use core::fmt;

/// Reason for which a line cannot be read. The texts begin with the words Smoothieware uses.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Problem {
    /// A character that can begin no word.
    NotALetter(u8),
    /// A letter without a number, where the code needs one.
    MissingNumber(char),
    /// A sign or a point without a digit.
    NoDigits(char),
    /// A second point in a number.
    SecondPoint(char),
    /// G, M or T without a whole number that fits.
    BadCode(char),
    /// A subcode beyond 255, or a digit string that is no subcode.
    BadSubcode(char),
    /// A `(` without its `)`.
    UnclosedComment,
    /// A character that should stand here and does not.
    Expected(u8),
    /// A value should stand here: a number, a parameter, an expression.
    NoValue,
    /// A number with two points in an expression.
    TwoPoints,
    /// Brackets within brackets without end.
    NestedTooDeep,
    /// A result that is no number, such as the root of a negative one.
    NotFinite,
    /// A division by zero.
    DivisionByZero,
    /// A parameter that does not exist, or has no value.
    NoParameter,
    /// A parameter that cannot be written.
    ReadOnly,
    /// More parameters than there is room for.
    TooManyParameters,
    /// More codes than a line can have.
    TooManyCodes,
    /// A name that is empty or too long.
    BadName,
    /// The label of an O word is worked out, and is no whole number.
    BadLabel,
    /// An O word without a word that is known.
    BadFlowWord,
    /// A console command or a text argument that is not UTF-8.
    NotText,
    /// Something other than a comment after a checksum, or a `*` without a number up to 255.
    BadChecksum,
    /// An `N` without a whole number of 31 bits.
    BadLineNumber,
}

impl Problem {
    /// Bytes that no text has, or a checksum that no sender writes: not a slip.
    #[must_use]
    pub const fn is_damage(self) -> bool {
        match self {
            Self::NotText | Self::BadChecksum => true,
            Self::NotALetter(byte) => !byte.is_ascii() || byte.is_ascii_control(),
            _ => false,
        }
    }
}

impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::NotALetter(byte) => {
                write!(f, "Illegal word: '{}' where a letter should be", byte.escape_ascii())
            }
            Self::MissingNumber(letter) => write!(f, "Illegal parameter word: {letter} needs a number"),
            Self::NoDigits(letter) => write!(f, "Illegal parameter word: {letter} has a number without digits"),
            Self::SecondPoint(letter) => write!(f, "Illegal parameter word: {letter} has a number with two points"),
            Self::BadCode(letter) => write!(f, "Illegal command word: {letter} needs a whole number up to 65535"),
            Self::BadSubcode(letter) => write!(f, "Illegal command word: {letter} has a subcode that is not 0 to 255"),
            Self::UnclosedComment => f.write_str("Illegal word: a comment is not closed with )"),
            Self::Expected(byte) => write!(f, "Illegal word: '{}' is missing", byte.escape_ascii()),
            Self::NoValue => f.write_str("Illegal word: a number, a parameter or an expression is missing"),
            Self::TwoPoints => f.write_str("Illegal word: a number with two points"),
            Self::NestedTooDeep => f.write_str("Illegal word: more than 10 brackets within each other"),
            Self::NotFinite => f.write_str("the result is not a number"),
            Self::DivisionByZero => f.write_str("a division by zero"),
            Self::NoParameter => f.write_str("there is no such parameter, or it was never set"),
            Self::ReadOnly => f.write_str("this parameter can only be read"),
            Self::TooManyParameters => f.write_str("there is no room for another parameter"),
            Self::TooManyCodes => write!(f, "Illegal command word: more than {} codes", crate::MOST_CODES),
            Self::BadName => f.write_str("Illegal word: a name has 1 to 32 letters between < and >"),
            Self::BadLabel => f.write_str("Illegal word: the label of an O word is a whole number"),
            Self::BadFlowWord => f.write_str(
                "Illegal word: after O and its number there is sub, call, return, if, while, do, repeat, or none",
            ),
            Self::NotText => f.write_str("Illegal word: text that is not UTF-8"),
            Self::BadChecksum => f.write_str("Illegal word: * must end the line with a number up to 255"),
            Self::BadLineNumber => f.write_str("Illegal word: N needs a whole number"),
        }
    }
}

/// A [`Problem`] and the column of its word.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SyntaxError {
    /// Byte position in the line, from 1.
    pub column: u16,
    /// Problem found in that column.
    pub problem: Problem,
}

impl SyntaxError {
    /// Creates the error of the word at this offset in the line.
    pub(crate) fn at(offset: usize, problem: Problem) -> Self {
        Self { column: column(offset), problem }
    }
}

/// Returns the column of an offset in the line, from 1.
pub(crate) fn column(offset: usize) -> u16 {
    u16::try_from(offset).map_or(u16::MAX, |offset| offset.saturating_add(1))
}

/// `Illegal word: '@' where a letter should be, column 5`
impl fmt::Display for SyntaxError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}, column {}", self.problem, self.column)
    }
}
