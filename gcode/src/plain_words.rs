//! Words with plain numbers, ` X12.5`: nearly all words of a program. They are read here in one pass over
//! their bytes; what is anything else is left where it begins, for the scanner to read or to refuse.

use crate::block::Block;
use crate::number::{POWERS_OF_TEN, SHORT};

/// Reads words from a place of the line on into the block, up to the first that is no plain one, or is
/// another command. Returns the place behind them.
///
/// Not inlined: everything it needs is in registers then.
#[inline(never)]
pub(crate) fn read_plain_words(line: &[u8], mut at: usize, block: &mut Block<'_>) -> usize {
    while let Some(word) = plain_word(line, at) {
        let column = word.begin.saturating_add(1).min(usize::from(u8::MAX));
        block.set_plain(word.letter, word.value, column as u8);
        at = word.end;
    }
    at
}

/// A word and its place in the line.
#[derive(Clone, Copy, Debug, PartialEq)]
struct PlainWord {
    /// Letter in upper case.
    letter: u8,
    value: f64,
    /// Offset of the letter, bytes.
    begin: usize,
    /// Offset of what follows the number.
    end: usize,
}

/// Returns the word at an offset of the line, behind blanks. `None`: it is none, belongs to another command,
/// or has more digits than fit 32 bits.
#[inline(always)]
fn plain_word(line: &[u8], mut at: usize) -> Option<PlainWord> {
    while byte_at(line, at) == b' ' {
        at += 1;
    }
    // Letters of both cases, and nothing else, become capitals so.
    let (begin, letter) = (at, byte_at(line, at) & 0xDF);
    if !letter.is_ascii_uppercase() || matches!(letter, b'G' | b'M') {
        return None;
    }
    at += 1;
    let negative = byte_at(line, at) == b'-';
    at += usize::from(negative);
    let whole = at;
    let mut mantissa = digits_behind(0, line, &mut at);
    let (mut digits, mut decimals) = (at - whole, 0);
    if byte_at(line, at) == b'.' {
        at += 1;
        let point = at;
        mantissa = digits_behind(mantissa, line, &mut at);
        decimals = at - point;
        digits += decimals;
    }
    if digits == 0 || digits > SHORT || byte_at(line, at) == b'.' {
        return None;
    }
    // Both are exact, so that the quotient is the nearest number: see `number`.
    let magnitude = f64::from(mantissa) / POWERS_OF_TEN.get(decimals)?;
    Some(PlainWord { letter, value: if negative { -magnitude } else { magnitude }, begin, end: at })
}

/// The byte at an offset. The end of the line is as good as any byte that no word has.
#[inline(always)]
fn byte_at(line: &[u8], at: usize) -> u8 {
    line.get(at).copied().unwrap_or(0)
}

/// Puts the digits at an offset behind those of a mantissa, which may wrap, and passes over them.
#[inline(always)]
fn digits_behind(mut mantissa: u32, line: &[u8], at: &mut usize) -> u32 {
    loop {
        let digit = byte_at(line, *at).wrapping_sub(b'0');
        if digit >= 10 {
            return mantissa;
        }
        mantissa = mantissa.wrapping_mul(10).wrapping_add(u32::from(digit));
        *at += 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scanner::Blocks;
    use proptest::prelude::*;

    /// The words of a line by the scanner's general way.
    fn general(line: &[u8]) -> Option<(u8, f64, usize)> {
        let mut blocks = Blocks::new(line);
        let letter = blocks.next_word(&mut crate::expression::NoParameters).ok()??;
        let value = blocks.value(letter, false, &crate::expression::NoParameters).ok()??;
        Some((letter, value, blocks.at))
    }

    proptest! {
        #[test]
        fn a_plain_word_is_what_the_scanner_reads(
            line in prop_oneof![
                "[ ]{0,2}[A-Za-z@^][ ]?[+-]?[0-9]{0,5}[.]?[0-9]{0,6}[ A-Z.#;(*]?[0-9]?",
                "[ -~\t]{0,12}",
            ],
        ) {
            if let Some(word) = plain_word(line.as_bytes(), 0) {
                let (letter, value, end) = general(line.as_bytes()).expect("a word");
                prop_assert_eq!((word.letter, word.value.to_bits(), word.end), (letter, value.to_bits(), end));
                prop_assert_eq!(line.as_bytes()[word.begin].to_ascii_uppercase(), letter);
            }
        }
    }

    #[test]
    fn words_of_a_move_are_plain_and_others_are_left() {
        for (line, letter, value, length) in [
            ("X12.5 Y3", b'X', 12.5, 5),
            (" y-.25", b'Y', -0.25, 6),
            ("  F1500;", b'F', 1500.0, 7),
            ("T1", b'T', 1.0, 2),
        ] {
            let word = plain_word(line.as_bytes(), 0).expect(line);
            assert_eq!((word.letter, word.value, word.end), (letter, value, length), "{line}");
        }
        for line in
            ["", " ", "X", "X 1", "X+1", "X[1]", "X#1", "G1", "m3", "X-", "X.", "X1.2.", "X1234567890", "@1", ";X1"]
        {
            assert_eq!(plain_word(line.as_bytes(), 0), None, "{line}");
        }
    }
}
