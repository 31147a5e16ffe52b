//! A line: is it a console command or G-code, is it the next one, did it arrive whole?

use crate::block::Block;
use crate::error::{Problem, SyntaxError};
use crate::expression;
use crate::extended::{Extended, is_extended};
use crate::flow::{self, FlowLine};
use crate::number;
use crate::scanner::{Blocks, column};
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
/// are labels in any order. Lines without a number do not count.
#[derive(Clone, Copy, Debug, Default)]
pub struct Decoder {
    /// Skip lines that begin with `/`.
    pub block_delete: bool,
    /// Of two numbers on a line of M110 the one before it counts, not the one behind.
    pub counts_from_before: bool,
    last: i32,
}

impl Decoder {
    /// Expects line 1; executes lines that begin with `/`.
    #[must_use]
    pub const fn new() -> Self {
        Self { block_delete: false, counts_from_before: false, last: 0 }
    }

    /// The number the next numbered line must have.
    #[must_use]
    pub const fn expected(&self) -> i32 {
        self.last.wrapping_add(1)
    }

    /// Reads one line, without its end.
    pub fn decode<'a>(&mut self, line: &'a [u8]) -> Result<Line<'a>, Refusal> {
        let mut at = skip_blanks(line, byte_order_mark(line));
        match line.get(at) {
            None | Some(b'%' | b';') => return Ok(Line::Blank),
            Some(b'/') if self.block_delete => return Ok(Line::Blank),
            Some(b'/') => at = skip_blanks(line, at + 1),
            Some(_) => {}
        }
        let number = line_number(line, at).map_err(Refusal::Syntax)?;
        if let Some((_, end)) = number {
            at = skip_blanks(line, end);
        }
        let console = is_console(line.get(at..).unwrap_or(&[]));
        let checksum = if console && number.is_none() { None } else { checksum(line, number.is_some(), at)? };
        let end = checksum.map_or(line.len(), |(star, _)| star);
        let body = line.get(..end).unwrap_or(line);
        if let Some((star, sum)) = checksum
            && line.iter().take(star).fold(0, |xor, byte| xor ^ byte) != sum
        {
            // Whoever numbers no lines cannot be asked for one.
            return Err(if number.is_some() || self.last != 0 {
                Refusal::Resend { expected: self.expected() }
            } else {
                Refusal::Syntax(SyntaxError { column: column(star), problem: Problem::BadChecksum })
            });
        }
        let blocks = Blocks::starting_at(body, at);
        if is_set_line_number(body.get(at..).unwrap_or(&[])) {
            self.set_line_number(blocks.clone(), number.map(|(n, _)| n));
        } else if let (Some((number, _)), Some(_)) = (number, checksum) {
            if number != self.expected() {
                return Err(Refusal::Resend { expected: self.expected() });
            }
            self.last = number;
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
        None => Err(SyntaxError { column: column(at), problem: Problem::BadLineNumber }),
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
        Err(error) => {
            Err(Refusal::Syntax(SyntaxError { column: column(at + error.valid_up_to()), problem: Problem::NotText }))
        }
    }
}

/// Where the checksum's `*` stands, and its number.
///
/// A sender sums the whole line, comments included, so on a numbered line the last `*` counts when only
/// digits follow. Elsewhere a `*` inside a comment is part of the comment, and in brackets it multiplies.
fn checksum(line: &[u8], numbered: bool, at: usize) -> Result<Option<(usize, u8)>, Refusal> {
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
        // Without a number it may be text (`M117 2*x`); the scanner objects when it is not.
        _ if !numbered => Ok(None),
        _ => Err(Refusal::Syntax(SyntaxError { column: column(first), problem: Problem::BadChecksum })),
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
mod tests {
    use super::*;
    use crate::{Block, Code};
    use proptest::prelude::*;

    fn numbered(number: i32, text: &str) -> String {
        let line = format!("N{number} {text}");
        let sum = checksum_of(line.as_bytes());
        format!("{line}*{sum}")
    }

    fn decode<'a>(decoder: &mut Decoder, line: &'a str) -> Result<Line<'a>, Refusal> {
        decoder.decode(line.as_bytes())
    }

    fn blocks(line: Line<'_>) -> Vec<Block<'_>> {
        match line {
            Line::Code(blocks) => blocks.map(Result::unwrap).collect(),
            other => panic!("not G-code: {other:?}"),
        }
    }

    fn is_code(line: &str) -> bool {
        matches!(decode(&mut Decoder::new(), line), Ok(Line::Code(_)))
    }

    fn console(line: &str) -> Option<&str> {
        match decode(&mut Decoder::new(), line) {
            Ok(Line::Console(text)) => Some(text),
            _ => None,
        }
    }

    #[test]
    fn commands_by_name_are_neither_code_nor_console() {
        let name = |line: &str| match decode(&mut Decoder::new(), line) {
            Ok(Line::Extended(command)) => Some(command.name().to_owned()),
            _ => None,
        };
        let numbered = numbered(1, "PAUSE");
        for (line, expected) in
            [("PRINT_START BED=60", "PRINT_START"), ("  NEXT_PART", "NEXT_PART"), (&numbered, "PAUSE")]
        {
            assert_eq!(name(line).as_deref(), Some(expected), "{line}");
        }
        for line in ["set_velocity_limit", "G1 X1", "N5 G28", "T1", "M117 PAUSE", "pause"] {
            assert_eq!(name(line), None, "{line}");
        }
    }

    #[test]
    fn numbered_lines_in_turn_are_executed() {
        let mut decoder = Decoder::new();
        for number in 1..5 {
            let line = numbered(number, "G1 X5");
            assert_eq!(blocks(decode(&mut decoder, &line).unwrap()), [Block::new(Some(Code::g(1)), 4).with('X', 5.0)]);
        }
        assert_eq!(decoder.expected(), 5);
    }

    #[test]
    fn a_lost_or_repeated_line_asks_for_the_next_one_and_changes_nothing() {
        let mut decoder = Decoder::new();
        decode(&mut decoder, &numbered(1, "G28")).unwrap();
        for wrong in [0, 1, 3, -7] {
            let refusal = decode(&mut decoder, &numbered(wrong, "G28")).unwrap_err();
            assert_eq!(refusal, Refusal::Resend { expected: 2 });
            assert_eq!(refusal.to_string(), "rs N2");
        }
        decode(&mut decoder, &numbered(2, "G28")).unwrap();
    }

    #[test]
    fn m110_sets_the_count_in_both_forms() {
        let mut decoder = Decoder::new();
        decode(&mut decoder, &numbered(100, "M110")).unwrap();
        assert_eq!(decoder.expected(), 101);
        decode(&mut decoder, "M110 N7").unwrap();
        assert_eq!(decoder.expected(), 8);
        decode(&mut decoder, &numbered(0, "m110 N5")).unwrap();
        assert_eq!(decoder.expected(), 6);
        decoder.counts_from_before = true;
        decode(&mut decoder, &numbered(0, "M110 N5")).unwrap();
        assert_eq!(decoder.expected(), 1);
        decode(&mut decoder, "M110 N7").unwrap();
        assert_eq!(decoder.expected(), 8);
        decode(&mut decoder, "N-1 M110*15").unwrap();
        assert_eq!(decoder.expected(), 0);
        decode(&mut decoder, "M1100").unwrap();
        assert_eq!(decoder.expected(), 0);
    }

    #[test]
    fn a_star_in_brackets_multiplies_on_a_numbered_line_too() {
        let mut decoder = Decoder::new();
        for line in
            ["N5 G1 X[2*3]", "N5 #1=[2 * [1 ** 2]]", "N5 G1 X[2*3] (4*5)", "N5 G1 X[2*3] ; 4*", "N5 G1 Y1 X[2*3]F7"]
        {
            assert!(decode(&mut decoder, line).is_ok(), "{line}");
        }
        assert!(decode(&mut decoder, &numbered(1, "G1 X[2*3]")).is_ok());
        for line in ["N5 G1 X[2*3]*1", "N5 G1 X[2]*3 Y1", "N5 G1 X1*"] {
            assert!(decode(&mut decoder, line).is_err(), "{line}");
        }
    }

    #[test]
    fn numbers_without_a_checksum_are_labels() {
        let mut decoder = Decoder::new();
        for line in ["N100 G1 X1", "N20 G1 X1", "n30g1x1", "N 40 G1 X1", "/N50 G1 X1", "G1 X1"] {
            assert_eq!(blocks(decode(&mut decoder, line).unwrap()).len(), 1, "{line}");
        }
        assert_eq!(decoder.expected(), 1);
    }

    #[test]
    fn a_checksum_holds_without_a_number_and_before_a_comment() {
        let sum = checksum_of(b"G1 X5");
        assert!(is_code(&format!("G1 X5*{sum}")));
        assert!(is_code(&format!("G1 X5*{sum} ; fast*1")));
        let with_comment = numbered(1, "G1 X5 ; two*3 ");
        assert!(is_code(&with_comment), "{with_comment}");
        assert!(is_code("G1 X5 ; a comment with *99"));
        let wrong = format!("G1 X5*{}", sum ^ 1);
        let bad = Refusal::Syntax(SyntaxError { column: 6, problem: Problem::BadChecksum });
        assert_eq!(decode(&mut Decoder::new(), &wrong).unwrap_err(), bad, "it has no number to be asked for");
        let mut numbering = Decoder::new();
        decode(&mut numbering, &numbered(1, "G28")).unwrap();
        assert_eq!(decode(&mut numbering, &wrong).unwrap_err(), Refusal::Resend { expected: 2 });
    }

    #[test]
    fn a_star_in_a_text_is_no_checksum() {
        let mut numbering = Decoder::new();
        decode(&mut numbering, &numbered(1, "G28")).unwrap();
        for mut decoder in [Decoder::new(), numbering] {
            for line in [
                "M117 Pass 3*4",
                "M118 5*3",
                "M117 *** Test ****15",
                "M486 Abox 2*2",
                "M23 a*1.g",
                "M0 Turn 2*3",
                "M16 Box*2",
                "G1 X1 M117 3*4",
                "echo 5*3",
                "RESPOND MSG=3*4",
                "M30 part*7",
            ] {
                assert!(decode(&mut decoder, line).is_ok(), "{line}");
            }
        }
        let texts = blocks(decode(&mut Decoder::new(), "M117 Pass 3*4").unwrap());
        assert_eq!(texts[0].text, Some("Pass 3*4"));
    }

    #[test]
    fn an_unreadable_number_or_checksum_is_a_syntax_error() {
        let refused = |line| decode(&mut Decoder::new(), line).unwrap_err();
        let syntax = |column, problem| Refusal::Syntax(SyntaxError { column, problem });
        assert_eq!(refused("N1 G28*x"), syntax(7, Problem::BadChecksum));
        assert_eq!(refused("N1 G28*300"), syntax(7, Problem::BadChecksum));
        assert_eq!(refused(" N-X G28"), syntax(2, Problem::BadLineNumber));
        assert_eq!(refused("N9999999999 G28"), syntax(1, Problem::BadLineNumber));
    }

    #[test]
    fn lower_case_gcode_is_gcode_and_words_are_console_commands() {
        for line in ["g1 x10", "m105", "t1", "x10 y5", "x-5", "f+100", "y.5", "n5 g1x1", "G28", "M105"] {
            assert!(is_code(line), "{line}");
        }
        for line in ["ls -1 /sd", "$H", "$X", "get pos", "mem", "m", "go *.g", "echo 5*3", "version", "net -n", "n"] {
            assert_eq!(console(line), Some(line));
        }
        assert_eq!(console("  help\t"), Some("help"));
        assert_eq!(console(&numbered(1, "play /sd/a.g")), Some("play /sd/a.g"));
        let refusal = Decoder::new().decode(b"cat \xff").unwrap_err();
        assert_eq!(refusal, Refusal::Syntax(SyntaxError { column: 5, problem: Problem::NotText }));
    }

    #[test]
    fn lines_without_a_command_are_blank() {
        for line in ["", "   ", "; comment", "%", "% program 5", "\t"] {
            assert!(matches!(decode(&mut Decoder::new(), line), Ok(Line::Blank)), "{line}");
        }
        assert!(matches!(Decoder::new().decode(b"\xEF\xBB\xBF; first line"), Ok(Line::Blank)));
        assert!(blocks(decode(&mut Decoder::new(), "(only a comment)").unwrap()).is_empty());
    }

    #[test]
    fn deleted_blocks_are_skipped_only_when_the_switch_is_on() {
        let mut decoder = Decoder::new();
        assert_eq!(blocks(decode(&mut decoder, "/G1 X1").unwrap()).len(), 1);
        decoder.block_delete = true;
        assert!(matches!(decode(&mut decoder, "/G1 X1"), Ok(Line::Blank)));
    }

    #[test]
    fn text_codes_lose_only_their_checksum() {
        let line = numbered(1, "M117 2*3 is six");
        let mut decoder = Decoder::new();
        assert_eq!(blocks(decode(&mut decoder, &line).unwrap())[0].text, Some("2*3 is six"));
    }

    proptest! {
        #[test]
        fn any_changed_byte_of_a_checksummed_line_is_noticed(
            words in "G1( [XYZ]-?[0-9]{1,3}(\\.[0-9]{1,3})?){1,4}", at in any::<prop::sample::Index>(), bit in 0_u8..7,
        ) {
            let line = numbered(1, &words);
            let star = line.rfind('*').unwrap();
            let mut bytes = line.clone().into_bytes();
            let at = at.index(star);
            bytes[at] ^= 1 << bit;
            // A changed N, or a byte turned into one that ends the line, makes another kind of line; none may
            // be executed as if nothing had happened.
            let mut decoder = Decoder::new();
            let executed = matches!(decoder.decode(&bytes), Ok(Line::Code(blocks)) if blocks.clone().all(|b| b.is_ok()));
            prop_assert!(!executed, "{:?}", String::from_utf8_lossy(&bytes));
        }

        #[test]
        fn no_bytes_make_it_panic(lines in proptest::collection::vec(proptest::collection::vec(any::<u8>(), 0..80), 1..20)) {
            let mut decoder = Decoder::new();
            for line in &lines {
                if let Ok(Line::Code(blocks)) = decoder.decode(line) {
                    prop_assert!(blocks.count() <= line.len());
                }
            }
        }

        #[test]
        fn no_plausible_line_makes_it_panic(line in "[/%]?[ N0-9-]{0,8}[GMTX0-9 .*;()a-z$-]{0,40}") {
            if let Ok(Line::Code(blocks)) = Decoder::new().decode(line.as_bytes()) {
                let _ = blocks.count();
            }
        }
    }
}
