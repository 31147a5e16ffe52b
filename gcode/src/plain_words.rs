//! Words with plain numbers, ` X12.5`: nearly all words of a program. They are read here in one pass over their
//! bytes; what is anything else is left where it begins, for the scanner to read or to refuse.

use crate::block::Block;
use crate::number::{POWERS_OF_TEN, SHORT, digits_behind};

/// Reads words from a place of the line on into the block, up to the first that is no plain one, or is another
/// command. Returns the place behind them.
///
/// Not inlined: everything it needs is in registers then.
#[inline(never)]
pub(crate) fn read_plain_words(line: &[u8], mut at: usize, block: &mut Block<'_>) -> usize {
    while let Some(word) = plain_word(line.get(at..).unwrap_or(&[])) {
        let column = (at + word.begin).saturating_add(1).min(usize::from(u8::MAX));
        block.set_plain(word.letter, word.value, column as u8);
        at += word.length;
    }
    at
}

/// A word and its place in the bytes it was read from.
#[derive(Clone, Copy, Debug, PartialEq)]
struct PlainWord {
    /// Letter in upper case.
    letter: u8,
    value: f64,
    /// Offset of the letter, bytes.
    begin: usize,
    /// Number of bytes up to the end of the number.
    length: usize,
}

/// Returns the word at the start of `bytes`, behind blanks. `None`: it is none, belongs to another command,
/// or has more digits than fit 32 bits.
#[inline(always)]
fn plain_word(bytes: &[u8]) -> Option<PlainWord> {
    // The end of the line is as good as any byte that no word has.
    let byte = |at: usize| bytes.get(at).copied().unwrap_or(0);
    let mut at = 0;
    while byte(at) == b' ' {
        at += 1;
    }
    let (begin, letter) = (at, byte(at).to_ascii_uppercase());
    if !letter.is_ascii_uppercase() || matches!(letter, b'G' | b'M') {
        return None;
    }
    at += 1;
    let negative = byte(at) == b'-';
    at += usize::from(negative);
    let (mantissa, whole) = digits_behind(0, bytes.get(at..).unwrap_or(&[]));
    at += whole;
    let (mut mantissa, mut decimals) = (mantissa, 0);
    if byte(at) == b'.' {
        (mantissa, decimals) = digits_behind(mantissa, bytes.get(at + 1..).unwrap_or(&[]));
        at += 1 + decimals;
    }
    let digits = whole + decimals;
    if digits == 0 || digits > SHORT || byte(at) == b'.' {
        return None;
    }
    // Both are exact, so that the quotient is the nearest number: see `number`.
    let magnitude = f64::from(mantissa) / POWERS_OF_TEN.get(decimals)?;
    Some(PlainWord { letter, value: if negative { -magnitude } else { magnitude }, begin, length: at })
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
            if let Some(word) = plain_word(line.as_bytes()) {
                let (letter, value, end) = general(line.as_bytes()).expect("a word");
                prop_assert_eq!((word.letter, word.value.to_bits(), word.length), (letter, value.to_bits(), end));
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
            let word = plain_word(line.as_bytes()).expect(line);
            assert_eq!((word.letter, word.value, word.length), (letter, value, length), "{line}");
        }
        for line in
            ["", " ", "X", "X 1", "X+1", "X[1]", "X#1", "G1", "m3", "X-", "X.", "X1.2.", "X1234567890", "@1", ";X1"]
        {
            assert_eq!(plain_word(line.as_bytes()), None, "{line}");
        }
    }
}
