//! A line: is it a console command or G-code, is it the next one, did it arrive whole?

use crate::block::Block;
use crate::error::{Problem, SyntaxError};
use crate::expression;
use crate::extended::{Extended, is_extended};
use crate::flow::{self, FlowLine};
use crate::number;
use crate::scanner::Blocks;
use core::fmt;

/// A line that arrived whole and in turn.
#[derive(Clone, Debug)]
pub enum Line<'a> {
    /// Nothing to do (blank, comment, `%`, deleted block); still answered with ok.
    Blank,
    /// A console command, `ls -1` or `$H`, trimmed.
    Console(&'a str),
    /// A command by name, `SET_PRESSURE_ADVANCE ADVANCE=0.05`.
    Extended(Extended<'a>),
    /// G-code. A bad word shows up in turn, after the commands before it.
    Code(Blocks<'a>),
    /// An O word: a subroutine, a condition, a loop.
    Flow(FlowLine<'a>),
}

/// A line that is not to be executed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Refusal {
    /// Garbled or out of turn: the sender must go back to this line.
    Resend {
        /// The line number that is wanted next.
        expected: i32,
    },
    /// The line number or checksum cannot be read, or a console command is no text.
    Syntax(SyntaxError),
}

/// `rs N12`, as senders understand it, or the syntax error.
impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Resend { expected } => write!(f, "rs N{expected}"),
            Self::Syntax(error) => error.fmt(f),
        }
    }
}

/// Takes line numbers, checksums, block delete and `%` off lines, and counts the numbered ones.
///
/// A number is only held against the count when a checksum vouches for it: the `N` words of an RS-274 program
/// are labels in any order. Lines without a number do not count. Of a sender that vouches for its lines, one
/// whose number or checksum cannot be read, or whose checksum is not there, has been damaged on its way.
#[derive(Clone, Copy, Debug, Default)]
pub struct Decoder {
    /// Skip lines that begin with `/`.
    pub block_delete: bool,
    /// Of two numbers on a line of M110 the one before it counts, not the one behind.
    pub counts_from_before: bool,
    /// A line with a number and its checksum has come.
    vouched: bool,
    last: i32,
}

impl Decoder {
    /// Expects line 1; executes lines that begin with `/`.
    #[must_use]
    pub const fn new() -> Self {
        Self { block_delete: false, counts_from_before: false, vouched: false, last: 0 }
    }

    /// The number the next numbered line must have.
    #[must_use]
    pub const fn expected(&self) -> i32 {
        self.last.wrapping_add(1)
    }

    /// Reads one line, without its end.
    pub fn decode<'a>(&mut self, line: &'a [u8]) -> Result<Line<'a>, Refusal> {
        // Nearly all lines of a program: a G-code with neither number nor checksum.
        if matches!(line, [b'G', b'0'..=b'9', ..]) && memchr::memchr(b'*', line).is_none() {
            return Ok(Line::Code(Blocks::new(line)));
        }
        self.decode_any(line)
    }

    fn decode_any<'a>(&mut self, line: &'a [u8]) -> Result<Line<'a>, Refusal> {
        let mut at = skip_blanks(line, byte_order_mark(line));
        match line.get(at) {
            None | Some(b'%' | b';') => return Ok(Line::Blank),
            Some(b'/') if self.block_delete => return Ok(Line::Blank),
            Some(b'/') => at = skip_blanks(line, at + 1),
            Some(_) => {}
        }
        let number = line_number(line, at).map_err(|error| self.damaged(line, error))?;
        if let Some((_, end)) = number {
            at = skip_blanks(line, end);
        }
        let console = is_console(line.get(at..).unwrap_or(&[]));
        let checksum = match checksum(line, number.is_some(), at) {
            _ if console && number.is_none() => None,
            Err(error) if is_text(line, at) => return Err(self.damaged(&[], error)),
            checksum => checksum.map_err(|error| self.damaged(line, error))?,
        };
        let end = checksum.map_or(line.len(), |(star, _)| star);
        let body = line.get(..end).unwrap_or(line);
        if let Some((star, sum)) = checksum
            && line.iter().take(star).fold(0, |xor, byte| xor ^ byte) != sum
        {
            // A sender that numbers no lines cannot be asked to send one again.
            return Err(if number.is_some() || self.last != 0 {
                Refusal::Resend { expected: self.expected() }
            } else {
                Refusal::Syntax(SyntaxError::at(star, Problem::BadChecksum))
            });
        }
        let blocks = Blocks::starting_at(body, at);
        if is_set_line_number(body.get(at..).unwrap_or(&[])) {
            self.vouched |= number.is_some() && checksum.is_some();
            self.set_line_number(blocks.clone(), number.map(|(n, _)| n));
        } else if let Some((number, _)) = number {
            self.count(number, checksum.is_some())?;
        }
        if matches!(line.get(at), Some(b'O' | b'o')) && flow::begins(body.get(at..).unwrap_or(&[])) {
            return FlowLine::read(body, at).map(Line::Flow).map_err(Refusal::Syntax);
        }
        if console {
            return Ok(Line::Console(text_of(body, at)?));
        }
        // Nearly every line is told apart by its second character.
        if body.get(at + 1).is_some_and(|byte| *byte >= b'A') && is_extended(body.get(at..).unwrap_or(&[])) {
            return Ok(Line::Extended(Extended::new(text_of(body, at)?)));
        }
        Ok(Line::Code(blocks))
    }

    /// Takes a line of this number, whose checksum holds if it has one. Without one the number is a label,
    /// unless the sender vouches for its lines and this one would be the next.
    fn count(&mut self, number: i32, has_checksum: bool) -> Result<(), Refusal> {
        self.vouched |= has_checksum;
        let expected = self.expected();
        match (has_checksum, number == expected) {
            (true, true) => self.last = number,
            (false, false) => {}
            (false, true) if !self.vouched => {}
            _ => return Err(Refusal::Resend { expected }),
        }
        Ok(())
    }

    /// Whether the sender numbers its lines and vouches for them: what has become of one can be asked for.
    #[must_use]
    pub const fn can_resend(&self) -> bool {
        self.vouched
    }

    /// Refuses a line whose number or checksum cannot be read: only senders that vouch for lines write a `*`.
    #[cold]
    fn damaged(&self, line: &[u8], error: SyntaxError) -> Refusal {
        match self.vouched || line.contains(&b'*') {
            true => Refusal::Resend { expected: self.expected() },
            false => Refusal::Syntax(error),
        }
    }

    /// `N5 M110` and `M110 N5`: the line just read counts as line 5.
    fn set_line_number(&mut self, mut blocks: Blocks<'_>, prefix: Option<i32>) {
        let word = blocks.next().and_then(Result::ok).and_then(|block| block.get('N'));
        // The cast saturates; a number that is no whole number is cut.
        let word = word.map(|n| n as i32);
        if let Some(number) = if self.counts_from_before { prefix.or(word) } else { word.or(prefix) } {
            self.last = number;
        }
    }
}

/// Length of the mark some editors put before a file's first line.
fn byte_order_mark(line: &[u8]) -> usize {
    const UTF8_MARK: &[u8] = &[0xEF, 0xBB, 0xBF];
    if line.starts_with(UTF8_MARK) { UTF8_MARK.len() } else { 0 }
}

fn skip_blanks(line: &[u8], mut at: usize) -> usize {
    while matches!(line.get(at), Some(b' ' | b'\t')) {
        at += 1;
    }
    at
}

/// A leading `N` word: its number and where it ends. A lower-case `n` only with the number right behind it.
fn line_number(line: &[u8], at: usize) -> Result<Option<(i32, usize)>, SyntaxError> {
    let digits = match line.get(at) {
        // A command by name may begin with an N too.
        Some(b'N') if line.get(at + 1).is_some_and(|byte| byte.is_ascii_alphabetic() || *byte == b'_') => {
            return Ok(None);
        }
        Some(b'N') => skip_blanks(line, at + 1),
        Some(b'n') if line.get(at + 1).is_some_and(|&byte| number::starts(byte)) => at + 1,
        _ => return Ok(None),
    };
    match number::parse_integer(line.get(digits..).unwrap_or(&[])) {
        Some((number, length)) => {
            let end = digits + length;
            // RS-274 has fractions of lines; they do not count.
            let point = usize::from(line.get(end) == Some(&b'.'));
            let fraction = line.get(end + point..).unwrap_or(&[]).iter().take_while(|byte| byte.is_ascii_digit());
            Ok(Some((number, end + point + if point > 0 { fraction.count() } else { 0 })))
        }
        None => Err(SyntaxError::at(at, Problem::BadLineNumber)),
    }
}

/// `$...`, or a lower-case letter that no number follows: `g1`, `x#3` and `o<pocket>` are G-code, `get` is
/// not.
fn is_console(body: &[u8]) -> bool {
    let starts_value = |byte: u8| number::starts(byte) || expression::starts(byte);
    match body.first() {
        Some(b'$') => true,
        Some(b'o') if flow::begins(body) => false,
        Some(b'a'..=b'z') => !body.get(1).is_some_and(|&byte| starts_value(byte)),
        _ => false,
    }
}

fn is_set_line_number(body: &[u8]) -> bool {
    const M110: &[u8] = b"M110";
    body.get(..M110.len()).is_some_and(|start| start.eq_ignore_ascii_case(M110))
        && !body.get(M110.len()).is_some_and(|&byte| byte.is_ascii_digit() || byte == b'.')
}

/// The line from here on, which is to be text.
fn text_of(body: &[u8], at: usize) -> Result<&str, Refusal> {
    match core::str::from_utf8(body.get(at..).unwrap_or(&[])) {
        Ok(text) => Ok(text.trim_matches([' ', '\t'])),
        Err(error) => Err(Refusal::Syntax(SyntaxError::at(at + error.valid_up_to(), Problem::NotText))),
    }
}

/// Finds the checksum's `*`, and its number.
///
/// A sender sums the whole line, comments included, so on a numbered line the last `*` counts when only
/// digits follow. Elsewhere a `*` inside a comment is part of the comment, and in brackets it multiplies.
fn checksum(line: &[u8], numbered: bool, at: usize) -> Result<Option<(usize, u8)>, SyntaxError> {
    let Some(last) = memchr::memrchr(b'*', line) else { return Ok(None) };
    if !numbered && is_text(line, at) {
        return Ok(None);
    }
    if numbered
        && let Some((sum, end)) = checksum_number(line, last)
        && end == line.len()
    {
        return Ok(Some((last, sum)));
    }
    let Some(first) = star_outside_comments(line) else { return Ok(None) };
    match checksum_number(line, first) {
        Some((sum, end)) if matches!(line.get(end), None | Some(b';' | b'(')) => Ok(Some((first, sum))),
        // Unnumbered, the line may be text (`M117 2*x`); the scanner objects when it is not.
        _ if !numbered => Ok(None),
        _ => Err(SyntaxError::at(first, Problem::BadChecksum)),
    }
}

/// Whether a `*` in a line without a number may be part of a text: of a command by name or of a code that
/// takes one.
#[cold]
fn is_text(line: &[u8], at: usize) -> bool {
    let takes_text = |block: Block<'_>| block.text.is_some();
    is_extended(line.get(at..).unwrap_or(&[])) || Blocks::starting_at(line, at).flatten().any(takes_text)
}

/// The number after a `*`, and the first place after it that is not blank.
fn checksum_number(line: &[u8], star: usize) -> Option<(u8, usize)> {
    let (sum, length) = number::parse_digits(line.get(star + 1..)?)?;
    Some((u8::try_from(sum).ok()?, skip_blanks(line, star + 1 + length)))
}

fn star_outside_comments(line: &[u8]) -> Option<usize> {
    let mut in_parentheses = false;
    let mut brackets = 0_u32;
    for (at, byte) in line.iter().enumerate() {
        match byte {
            b'(' => in_parentheses = true,
            b')' => in_parentheses = false,
            _ if in_parentheses => {}
            b'[' => brackets += 1,
            b']' => brackets = brackets.saturating_sub(1),
            b';' => return None,
            b'*' if brackets == 0 => return Some(at),
            _ => {}
        }
    }
    None
}

/// The checksum a sender puts after the `*`: the XOR of all bytes before it.
#[must_use]
pub fn checksum_of(bytes: &[u8]) -> u8 {
    bytes.iter().fold(0, |xor, byte| xor ^ byte)
}

#[cfg(test)]
mod tests;
