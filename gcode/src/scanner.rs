//! Words to blocks, one pass, lazily: blocks before a bad word are given before the error.

use crate::block::{Block, Code, Letter};
use crate::error::{Problem, SyntaxError, column};
use crate::expression::{self, NoParameters, Parameters, Reader};
use crate::number::{self, Flaw};
use crate::plain_words::read_plain_words;
use crate::text_value::{comment, powers, string_or_list};

/// M-codes whose argument is text, kept as it stands.
///
/// M115 is followed by the version that a file wants (`M115 U3.13.2`), M486 by names of objects.
pub(crate) const TEXT_M_CODES: [u16; 12] = [16, 23, 28, 30, 32, 33, 115, 117, 118, 486, 501, 504];
/// G-codes whose words are coordinates and rates. A letter without a number there is a slip, not a flag.
const NUMBERED_G_CODES: [u16; 22] = [0, 1, 2, 3, 4, 5, 10, 33, 38, 43, 53, 73, 81, 82, 83, 85, 89, 92, 93, 94, 98, 99];

/// The commands of a line, in order. Ends after the first error.
#[derive(Clone, Debug)]
pub struct Blocks<'a> {
    pub(crate) line: &'a [u8],
    pub(crate) at: usize,
    /// A comment that says something, `(MSG, hello)`.
    remark: Option<&'a [u8]>,
    /// Text after M0 and M1 is for the operator, whatever the text looks like.
    pub(crate) stops_say: bool,
}

impl<'a> Blocks<'a> {
    /// The commands of a line that has neither number nor checksum. [`crate::Decoder`] takes those off.
    #[must_use]
    pub const fn new(line: &'a [u8]) -> Self {
        Self::starting_at(line, 0)
    }

    /// Reads the commands from a place of the line on: see [`Self::place`].
    #[must_use]
    pub const fn starting_at(line: &'a [u8], at: usize) -> Self {
        Self { line, at, remark: None, stops_say: false }
    }

    /// Sets whether text after M0 and M1 is said to the operator, whatever it looks like. Otherwise `M0 M9`
    /// has two codes, and `M0 Insert M3 nuts` one: see `crate::stop`.
    pub const fn set_stops_say(&mut self, stops_say: bool) {
        self.stops_say = stops_say;
    }

    /// The line, and where in it the next command is looked for: enough to go on later.
    #[must_use]
    pub const fn place(&self) -> (&'a [u8], usize) {
        (self.line, self.at)
    }

    pub(crate) fn peek(&self) -> Option<u8> {
        self.line.get(self.at).copied()
    }

    pub(crate) fn rest(&self) -> &'a [u8] {
        self.line.get(self.at..).unwrap_or(&[])
    }

    pub(crate) fn error(&self, at: usize, problem: Problem) -> SyntaxError {
        SyntaxError::at(at, problem)
    }

    pub(crate) fn skip_blanks(&mut self) {
        while matches!(self.peek(), Some(b' ' | b'\t')) {
            self.at += 1;
        }
    }

    /// The comment that says something, `(MSG, hello)`, when there was one since the last call: its text
    /// between the brackets.
    pub const fn take_remark(&mut self) -> Option<&'a [u8]> {
        self.remark.take()
    }

    /// Passes a comment over, and keeps one that says something.
    #[cold]
    fn pass_comment(&mut self) -> Result<(), SyntaxError> {
        let Some(length) = self.rest().iter().position(|&byte| byte == b')') else {
            return Err(self.error(self.at, Problem::UnclosedComment));
        };
        let text = self.line.get(self.at + 1..self.at + length).unwrap_or(&[]);
        if is_remark(text) {
            self.remark = Some(text);
        }
        self.at += length + 1;
        Ok(())
    }

    /// `#5 = [1 + 2]`, the `#` being at hand.
    #[cold]
    fn assign(&mut self, parameters: &mut dyn Parameters) -> Result<(), SyntaxError> {
        let begin = self.at;
        let mut reader = Reader::new(self.line, begin, parameters);
        let parameter = reader.parameter()?;
        if reader.peek() != Some(b'=') {
            return Err(self.error(reader.at, Problem::Expected(b'=')));
        }
        reader.at += 1;
        let value = reader.value()?;
        self.at = reader.at;
        parameters.set(parameter, value).map_err(|problem| self.error(begin, problem))
    }

    /// Goes to the next word; none at the end of the line. In place in both loops over words: a move has six.
    #[inline(always)]
    pub(crate) fn next_word(&mut self, parameters: &mut dyn Parameters) -> Result<Option<u8>, SyntaxError> {
        loop {
            match self.peek() {
                Some(b' ' | b'\t') => self.at += 1,
                None | Some(b';') => {
                    self.at = self.line.len();
                    return Ok(None);
                }
                Some(b'(') => self.pass_comment()?,
                Some(byte) if byte.is_ascii_alphabetic() => return Ok(Some(byte.to_ascii_uppercase())),
                Some(b'#') => self.assign(parameters)?,
                // Polar coordinates: distance and angle.
                Some(byte @ (b'@' | b'^')) => return Ok(Some(byte)),
                Some(b'*') => return Err(self.error(self.at, Problem::BadChecksum)),
                Some(byte) => return Err(self.error(self.at, Problem::NotALetter(byte))),
            }
        }
    }

    /// Reads the next command into a block; false at the end of the line. Values may come from parameters,
    /// and what the line assigns is set there.
    ///
    /// # Errors
    /// The first thing that is wrong with the command; the line has ended then.
    pub fn read(&mut self, block: &mut Block<'a>, parameters: &mut dyn Parameters) -> Result<bool, SyntaxError> {
        let read = self.read_next(block, parameters);
        if read.is_err() {
            self.at = self.line.len();
        }
        read
    }

    fn read_next(&mut self, block: &mut Block<'a>, parameters: &mut dyn Parameters) -> Result<bool, SyntaxError> {
        let Some(first) = self.next_word(parameters)? else { return Ok(false) };
        let begin = self.at;
        let code = match first {
            b'G' => Some(self.code(Letter::G, 'G', parameters)?),
            b'M' => Some(self.code(Letter::M, 'M', parameters)?),
            b'T' => Some(self.code(Letter::T, 'T', parameters)?),
            _ => None,
        };
        block.begin(code, column(begin));
        if code.is_some_and(takes_text) {
            block.text = self.text()?.filter(|text| !is_end_of_program(code, text));
            return Ok(true);
        }
        if code.is_some_and(crate::stop::is_stop) && self.stop(block)? {
            return Ok(true);
        }
        let flags_allowed = code.is_some_and(allows_flags);
        loop {
            self.at = read_plain_words(self.line, self.at, block);
            let letter = match self.next_word(parameters) {
                // A run of pixels, where the value of S goes on with it.
                Ok(Some(b'@')) if self.skips_string_or_list(block) => continue,
                Ok(Some(letter)) => letter,
                Ok(None) => break,
                Err(_) if self.skips_string_or_list(block) => continue,
                Err(error) => return Err(error),
            };
            if matches!(letter, b'G' | b'M') {
                break;
            }
            let begin = self.at;
            let value = self.value(letter, flags_allowed, parameters)?;
            block.set(letter, value, begin.saturating_add(1).min(usize::from(u8::MAX)) as u8);
        }
        Ok(true)
    }

    /// Passes over what goes on with the value of a code, or takes it: see [`string_or_list`] and [`powers`].
    fn skips_string_or_list(&mut self, block: &mut Block<'a>) -> bool {
        if let Some(list) = powers(self.line, self.at, block) {
            (block.text, self.at) = (Some(list), self.at + list.len());
            return true;
        }
        // RepRapFirmware's G29 S1 P"name" as well.
        let may_have = block.code.is_some_and(|code| code.letter == Letter::M || code == Code::g(29));
        let Some((length, text)) = string_or_list(self.rest()).filter(|_| may_have) else { return false };
        block.text = block.text.or(text);
        self.at += length;
        true
    }

    /// The number of a word, the letter being at hand; none for a flag.
    #[inline(always)]
    pub(crate) fn value(
        &mut self,
        letter: u8,
        flags_allowed: bool,
        parameters: &dyn Parameters,
    ) -> Result<Option<f64>, SyntaxError> {
        let begin = self.at;
        let letter = char::from(letter);
        self.at += 1;
        if !self.peek().is_some_and(number::starts) {
            self.skip_blanks();
        }
        if !self.peek().is_some_and(number::starts) {
            return self.worked_out(begin, letter, flags_allowed, parameters);
        }
        match number::parse(self.rest()) {
            Ok((value, length)) => {
                self.at += length;
                Ok(Some(value))
            }
            Err(Flaw::NoDigits) if self.rest().get(1).is_some_and(|&byte| expression::starts(byte)) => {
                self.worked_out(begin, letter, flags_allowed, parameters)
            }
            Err(Flaw::NoDigits) => Err(self.error(begin, Problem::NoDigits(letter))),
            Err(Flaw::SecondPoint) => Err(self.error(begin, Problem::SecondPoint(letter))),
        }
    }

    /// A word's value that is no plain number; none for a flag.
    #[cold]
    fn worked_out(
        &mut self,
        begin: usize,
        letter: char,
        flags_allowed: bool,
        parameters: &dyn Parameters,
    ) -> Result<Option<f64>, SyntaxError> {
        let mut reader = Reader::new(self.line, self.at, parameters);
        match reader.peek() {
            Some(byte) if expression::starts(byte) || matches!(byte, b'+' | b'-') || reader.is_function() => {
                let value = reader.value()?;
                self.at = reader.at;
                Ok(Some(value))
            }
            _ if flags_allowed => Ok(None),
            _ => Err(self.error(begin, Problem::MissingNumber(letter))),
        }
    }

    /// Returns the text behind a code that takes text, up to a `;`.
    pub(crate) fn text(&mut self) -> Result<Option<&'a str>, SyntaxError> {
        let begin = self.at;
        let rest = self.rest();
        self.at = self.line.len();
        let length = comment(rest);
        let text = core::str::from_utf8(rest.get(..length).unwrap_or(&[]));
        let text = text.map_err(|_| self.error(begin, Problem::NotText))?.trim_matches([' ', '\t']);
        Ok((!text.is_empty()).then_some(text))
    }
}

impl<'a> Iterator for Blocks<'a> {
    type Item = Result<Block<'a>, SyntaxError>;

    fn next(&mut self) -> Option<Self::Item> {
        let mut block = Block::new(None, 0);
        match self.read(&mut block, &mut NoParameters) {
            Ok(true) => Some(Ok(block)),
            Ok(false) => None,
            Err(error) => Some(Err(error)),
        }
    }
}

/// Comments that say something, or write it down (LinuxCNC's G-code overview).
fn is_remark(comment: &[u8]) -> bool {
    const WORDS: [&str; 10] =
        ["MSG,", "DEBUG,", "PRINT,", "LOG,", "LOGOPEN,", "LOGAPPEND,", "LOGCLOSE", "PROBEOPEN", "PROBECLOSE", "STOP"];
    let comment = comment.trim_ascii_start();
    WORDS.iter().any(|word| comment.get(..word.len()).is_some_and(|start| start.eq_ignore_ascii_case(word.as_bytes())))
}

fn takes_text(code: Code) -> bool {
    code.letter == Letter::M && code.subcode == 0 && TEXT_M_CODES.contains(&code.number)
}

/// `M30 (end of part)`, as mills write it: a comment, no file name.
fn is_end_of_program(code: Option<Code>, text: &str) -> bool {
    code == Some(Code::m(30)) && text.starts_with('(') && text.ends_with(')')
}

fn allows_flags(code: Code) -> bool {
    code.letter != Letter::G || !NUMBERED_G_CODES.contains(&code.number)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::expression::Parameter;
    use proptest::prelude::*;

    fn blocks(line: &str) -> Vec<Block<'_>> {
        Blocks::new(line.as_bytes()).map(|block| block.unwrap()).collect()
    }

    /// The blocks before the error, and the error.
    fn failing(line: &str) -> (usize, u16, Problem) {
        let all: Vec<_> = Blocks::new(line.as_bytes()).collect();
        let error = all.last().unwrap().clone().unwrap_err();
        assert!(all[..all.len() - 1].iter().all(Result::is_ok), "{line}: the error ends the line");
        (all.len() - 1, error.column, error.problem)
    }

    fn g(number: u16) -> Block<'static> {
        Block::new(Some(Code::g(number)), 1)
    }

    fn m(number: u16) -> Block<'static> {
        Block::new(Some(Code::m(number)), 1)
    }

    #[test]
    fn a_move_has_its_words_and_their_columns() {
        let line = blocks("G1 X10.5 y-.25E+3 F1500");
        assert_eq!(line, [g(1).with('X', 10.5).with('Y', -0.25).with('E', 3.0).with('F', 1500.0)]);
        assert_eq!(line[0].column, 1);
        assert_eq!([line[0].column_of('x'), line[0].column_of('Y'), line[0].column_of('F')], [4, 10, 19]);
    }

    #[test]
    fn blanks_and_case_do_not_matter() {
        for line in ["G1X10Y20", "g1 x10 y20", "  G01\tX 10  Y\t20  ", "g 1x1 0y20", "G1(to)X10(the ; edge)Y20;done"] {
            if line == "g 1x1 0y20" {
                // A blank inside a number ends it, unlike in RS-274: nobody writes it, and it hides slips.
                assert_eq!(failing(line), (0, 7, Problem::NotALetter(b'0')));
            } else {
                assert_eq!(blocks(line), [g(1).with('X', 10.0).with('Y', 20.0)], "{line}");
            }
        }
    }

    #[test]
    fn several_commands_on_a_line_run_in_order() {
        assert_eq!(
            blocks("G90G21 G0X1 M3S100 T1"),
            [g(90), g(21), g(0).with('X', 1.0), m(3).with('S', 100.0).with('T', 1.0)]
        );
        assert_eq!(blocks("T1 M6"), [Block::new(Some(Code::t(1)), 1), m(6)]);
        assert_eq!(blocks("M6 T1"), [m(6).with('T', 1.0)]);
    }

    #[test]
    fn subcodes_are_part_of_the_code() {
        assert_eq!(blocks("G38.2 Z-5")[0].code, Some(Code::g(38).sub(2)));
        assert_eq!(blocks("M106.1 S255")[0].code, Some(Code::m(106).sub(1)));
        assert_eq!(blocks("G59.3")[0].code, Some(Code::g(59).sub(3)));
        assert_eq!(blocks("G92.0 X0")[0].code, Some(Code::g(92)));
        assert_eq!(Code::g(59).sub(3).to_string(), "G59.3");
    }

    #[test]
    fn words_without_a_command_are_a_modal_block() {
        assert_eq!(blocks("X1 Y2"), [Block::new(None, 1).with('X', 1.0).with('Y', 2.0)]);
        assert_eq!(blocks("F300"), [Block::new(None, 1).with('F', 300.0)]);
    }

    #[test]
    fn letters_alone_are_flags_except_where_a_number_is_meant() {
        let home = &blocks("G28 X Y")[0];
        assert!(home.has('X') && home.has('Y') && !home.has('Z'));
        assert_eq!(home.get('X'), None);
        assert_eq!(failing("G1 X Y5"), (0, 4, Problem::MissingNumber('X')));
        assert_eq!(failing("hello"), (0, 1, Problem::MissingNumber('H')));
    }

    #[test]
    fn the_last_of_two_equal_letters_counts() {
        assert_eq!(blocks("G1 X1 X2"), [g(1).with('X', 2.0)]);
        assert_eq!(blocks("G28 X1 X")[0].get('X'), None);
    }

    /// Keeps #1 to #9; what is written is there at once.
    #[derive(Default)]
    struct Few([f64; 10]);

    impl Parameters for Few {
        fn get(&self, parameter: &Parameter) -> Option<f64> {
            let Parameter::Numbered(number) = parameter else { return None };
            self.0.get(usize::from(*number)).copied()
        }

        fn set(&mut self, parameter: Parameter, value: f64) -> Result<(), Problem> {
            let Parameter::Numbered(number) = parameter else { return Err(Problem::ReadOnly) };
            *self.0.get_mut(usize::from(number)).ok_or(Problem::NoParameter)? = value;
            Ok(())
        }
    }

    #[test]
    fn values_are_worked_out_and_parameters_set() {
        let mut few = Few::default();
        let mut read = |line: &'static str| {
            let mut block = Block::new(None, 0);
            assert!(Blocks::new(line.as_bytes()).read(&mut block, &mut few).unwrap(), "{line}");
            block
        };
        let wanted = g(1).with('X', 3.0).with('Y', -7.0).with('Z', 0.5);
        assert_eq!(read("#1 = [2+5] #2=3 G1 X#2 Y-#1 Z SQRT[.25] (after)"), wanted);
        assert_eq!(read("G1 X[#1 - 4]Y-[#1]Zsqrt[0.25]"), wanted);
        assert_eq!(read("x#2 y2"), Block::new(None, 1).with('X', 3.0).with('Y', 2.0));
        assert_eq!(few.0[1], 7.0);
    }

    #[test]
    fn polar_coordinates_are_words() {
        let words = blocks("G1 @5^-30 F100");
        assert_eq!(words, [g(1).with('@', 5.0).with('^', -30.0).with('F', 100.0)]);
        assert_eq!(words[0].to_string(), "G1 F100 @5 ^-30");
        assert!(words[0].has_rare_coordinate() && !blocks("G1 X1 F5")[0].has_rare_coordinate());
    }

    #[test]
    fn comments_that_say_something_are_kept() {
        let mut blocks = Blocks::new(b"(plain) (MSG, hello there) M0 (PRINT, #1)");
        let mut block = Block::new(None, 0);
        assert!(blocks.read(&mut block, &mut NoParameters).unwrap());
        assert_eq!(blocks.take_remark(), Some(&b"PRINT, #1"[..]), "of two, the last");
        assert_eq!(blocks.take_remark(), None);
    }

    #[test]
    fn comments_may_hold_anything() {
        assert!(Blocks::new(b"; \xff\xfe *12 (").next().is_none());
        assert!(Blocks::new(b" (\xe9t\xe9) ").next().is_none());
        assert!(Blocks::new(b"").next().is_none());
    }

    #[test]
    fn bad_words_name_their_column_and_reason() {
        assert_eq!(failing("G1 X1 $5"), (0, 7, Problem::NotALetter(b'$')));
        assert_eq!(failing("G90 G1 X1..2"), (1, 8, Problem::SecondPoint('X')));
        assert_eq!(failing("G1 X-"), (0, 4, Problem::NoDigits('X')));
        assert_eq!(failing("G1 X.Y1"), (0, 4, Problem::NoDigits('X')));
        assert_eq!(failing("G"), (0, 1, Problem::BadCode('G')));
        assert_eq!(failing("M-5"), (0, 1, Problem::BadCode('M')));
        assert_eq!(failing("G70000"), (0, 1, Problem::BadCode('G')));
        assert_eq!(failing("G38.300"), (0, 1, Problem::BadSubcode('G')));
        assert_eq!(failing("T1.5"), (0, 1, Problem::BadSubcode('T')));
        assert_eq!(failing("G1 X1 (open"), (0, 7, Problem::UnclosedComment));
        assert_eq!(failing("#1=5"), (0, 1, Problem::ReadOnly));
        assert_eq!(failing("G1 X[1+2"), (0, 9, Problem::Expected(b']')));
        assert_eq!(failing("G1 X1*"), (0, 6, Problem::BadChecksum));
    }

    #[test]
    fn the_reason_begins_with_smoothieware_words_and_ends_with_the_column() {
        let error = Blocks::new(b"G1 X1 $5").next().unwrap().unwrap_err();
        assert_eq!(error.to_string(), "Illegal word: '$' where a letter should be, column 7");
    }

    proptest! {
        #[test]
        fn a_printed_block_reads_back_as_itself(
            letter in "[GMT]", number in 0_u16..1000, subcode in 0_u8..10,
            words in proptest::collection::btree_map("[A-FH-LN-SU-Z]", -1e6_f64..1e6, 0..10),
        ) {
            let code = match letter.as_str() {
                "G" => Code::g(number).sub(subcode),
                "M" => Code::m(number).sub(subcode),
                _ => Code::t(number),
            };
            prop_assume!(!takes_text(code));
            let block = words.iter().fold(Block::new(Some(code), 1), |block, (letter, value)| {
                block.with(letter.chars().next().unwrap(), *value)
            });
            let text = block.to_string();
            prop_assert_eq!(blocks(&text), [block]);
        }

        #[test]
        fn words_alone_printed_read_back_as_themselves(line in "[XYZ]1( [A-FH-LN-Z]-?[0-9]{1,4}){0,5}") {
            let read = blocks(&line);
            let printed = read[0].to_string();
            prop_assert_eq!(blocks(&printed), read);
        }

        #[test]
        fn no_bytes_make_it_panic_or_run_on(line in proptest::collection::vec(any::<u8>(), 0..255)) {
            let all: Vec<_> = Blocks::new(&line).collect();
            prop_assert!(all.len() <= line.len());
            for (index, block) in all.iter().enumerate() {
                if let Err(error) = block {
                    prop_assert_eq!(index, all.len() - 1);
                    prop_assert!((1..=line.len()).contains(&usize::from(error.column)));
                    prop_assert!(!error.to_string().is_empty());
                }
            }
        }

        #[test]
        fn no_plausible_line_makes_it_panic(line in "[GMTXYZEFNO0-9 .+*;()#/%-]{0,60}") {
            for block in Blocks::new(line.as_bytes()).flatten() {
                let _ = block.to_string();
            }
        }
    }
}
