//! M0 and M1 with a text for the operator: `M0 S10 Insert the M3 nuts`.
//!
//! Marlin's and its relatives' take one. RS-274 has codes there instead (`M0 M9`), but no text: in all of its
//! lines each letter has a number, so what two letters in a row stand in is no code.

use crate::block::{Block, Code, Letter};
use crate::error::{SyntaxError, column};
use crate::number;
use crate::scanner::Blocks;

/// Whether a code is a program stop, M0 or M1.
pub(crate) fn is_stop(code: Code) -> bool {
    code.letter == Letter::M && code.number <= 1 && code.subcode == 0
}

impl<'a> Blocks<'a> {
    /// Reads the words behind a stop: S and P, the greatest duration of the stop, and the text. False when
    /// codes follow, or nothing.
    #[cold]
    pub(crate) fn stop(&mut self, block: &mut Block<'a>) -> Result<bool, SyntaxError> {
        while let Some((letter, value, length)) = {
            self.skip_blanks();
            time(self.rest())
        } {
            block.set(letter, Some(value), column(self.at).min(u16::from(u8::MAX)) as u8);
            self.at += length;
        }
        if !(self.stops_say || is_text(self.rest())) {
            return Ok(false);
        }
        block.text = self.text()?;
        Ok(true)
    }
}

/// S or P with a number and nothing behind it, and its length.
fn time(rest: &[u8]) -> Option<(u8, f64, usize)> {
    let letter = rest.first()?.to_ascii_uppercase();
    if !matches!(letter, b'S' | b'P') {
        return None;
    }
    let (value, length) = number::parse(rest.get(1..)?).ok()?;
    let ends = matches!(rest.get(1 + length), None | Some(b' ' | b'\t' | b';' | b'('));
    ends.then_some((letter, value, 1 + length))
}

/// Two letters in a row outside comments, or what is no ASCII; expressions have names of functions and
/// parameters.
fn is_text(rest: &[u8]) -> bool {
    let (mut in_comment, mut before) = (false, b' ');
    for byte in rest {
        match byte {
            b';' if !in_comment => return false,
            b'(' => in_comment = true,
            b')' => in_comment = false,
            _ if in_comment => {}
            b'[' | b'#' => return false,
            byte if !byte.is_ascii() || (byte.is_ascii_alphabetic() && before.is_ascii_alphabetic()) => return true,
            _ => {}
        }
        before = *byte;
    }
    false
}

#[cfg(test)]
mod tests {
    use super::*;

    fn blocks(line: &str, stops_say: bool) -> Vec<Block<'_>> {
        let mut blocks = Blocks::new(line.as_bytes());
        blocks.set_stops_say(stops_say);
        blocks.map(|block| block.unwrap()).collect()
    }

    #[test]
    fn nothing_of_a_text_behind_a_stop_is_a_code() {
        for text in [
            "Insert M3 nuts now",
            "Turn G28 part over",
            "Load T1 spool",
            "M3 nuts, then click",
            "Teil prüfen",
            "5 min M3",
        ] {
            for stops_say in [false, true] {
                let line = format!("M0 {text}");
                assert_eq!(blocks(&line, stops_say).len(), 1, "{line}");
                assert_eq!(blocks(&line, stops_say)[0].text, Some(text), "{line}");
            }
        }
        assert_eq!(blocks("M1 M3", true)[0].text, Some("M3"));
    }

    #[test]
    fn a_stop_has_its_time_before_its_text() {
        let both = &blocks("M0 P1500 S2 Insert the nuts ; slowly", false);
        assert_eq!(
            (both[0].get('P'), both[0].get('S'), both[0].text),
            (Some(1500.0), Some(2.0), Some("Insert the nuts"))
        );
        assert_eq!(blocks("M0 S2", true)[0].get('S'), Some(2.0));
        assert_eq!(blocks("M0 Stop", true)[0].text, Some("Stop"));
        assert_eq!(blocks("M0 S2mm screws", true)[0].text, Some("S2mm screws"));
    }

    #[test]
    fn codes_behind_a_stop_are_codes_where_no_text_can_be() {
        let codes = |line| blocks(line, false).iter().map(|block| block.code.unwrap().to_string()).collect::<Vec<_>>();
        assert_eq!(codes("M0 M9"), ["M0", "M9"]);
        assert_eq!(codes("M1 (change the M3 nuts) M5"), ["M1", "M5"]);
        assert_eq!(codes("M0 ; see to the M3 nuts"), ["M0"]);
    }
}
