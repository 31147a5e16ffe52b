//! What is wrong with a line, and where.

use core::fmt;

/// Why a line cannot be read. The texts begin with the words Smoothieware uses.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Problem {
    /// A character that can begin no word.
    NotALetter(u8),
    /// A letter without a number, where the code needs one.
    MissingNumber(char),
    /// A sign or a point without a digit.
    NoDigits(char),
    /// A second point.
    SecondPoint(char),
    /// G, M or T without a whole number that fits.
    BadCode(char),
    /// A subcode beyond 255, or a digit string that is no subcode.
    BadSubcode(char),
    /// A `(` without its `)`.
    UnclosedComment,
    /// `#` parameters, `[ ]` expressions, assignments and `O` words of RS-274.
    NotSupported(u8),
    /// A console command or a text argument that is not UTF-8.
    NotText,
    /// Something other than a comment after a checksum, or a `*` without a number up to 255.
    BadChecksum,
    /// An `N` without a whole number of 31 bits.
    BadLineNumber,
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
            Self::NotSupported(byte) => write!(
                f,
                "Illegal word: '{}' (parameters, expressions and O words) is not supported",
                byte.escape_ascii()
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
    /// What is wrong there.
    pub problem: Problem,
}

/// `Illegal word: '@' where a letter should be, column 5`
impl fmt::Display for SyntaxError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}, column {}", self.problem, self.column)
    }
}
