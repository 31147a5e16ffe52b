//! Values of words that are no numbers: RepRapFirmware's strings, `P"zvd"`, and lists, `E400:400`, in M-codes
//! and in G29; and the texts of codes that take one.

use crate::block::{Block, Letter};
use crate::number;

/// Returns the length and the text of a value that is a string or a list. Of a list the first number counts,
/// which has been read already.
pub(crate) fn string_or_list(rest: &[u8]) -> Option<(usize, Option<&str>)> {
    match rest {
        [b'"', string @ ..] => {
            let length = memchr::memchr(b'"', string)?;
            Some((length + 2, string.get(..length).and_then(|text| core::str::from_utf8(text).ok())))
        }
        [b':', list @ ..] => Some((1 + list.iter().take_while(|byte| number::starts(**byte)).count(), None)),
        _ => None,
    }
}

/// Returns what follows the first power of a move's S, at an offset of the line: `:0:0.5` of `S0.8:0:0.5`,
/// `@12:0@5` of `S1@12:0@5`.
pub(crate) fn powers<'a>(line: &'a [u8], at: usize, block: &Block<'_>) -> Option<&'a str> {
    let moves = block.code.is_none_or(|code| code.letter == Letter::G && code.number <= 3);
    let first = line.get(usize::from(block.column_of('S'))..at)?;
    let is_power = moves && block.has('S') && first.iter().all(|byte| number::starts(*byte));
    let list = line.get(at..).filter(|list| is_power && list.first().is_some_and(parts_powers))?;
    let length = list.iter().take_while(|byte| parts_powers(byte) || number::starts(**byte)).count();
    core::str::from_utf8(list.get(..length)?).ok()
}

/// Whether a byte stands between powers, or between a power and its number of pixels.
const fn parts_powers(byte: &u8) -> bool {
    matches!(byte, b':' | b'@')
}

/// Returns the beginning of a comment in a text; in a string of RepRapFirmware, `S"a; b"`, a `;` is a
/// character.
pub(crate) fn comment(text: &[u8]) -> usize {
    let quotes = |text: &[u8]| text.iter().filter(|byte| **byte == b'"').count();
    let whole = quotes(text) % 2 == 0;
    let begins = |at: &usize| text.get(..*at).is_some_and(|before| !whole || quotes(before) % 2 == 0);
    memchr::memchr_iter(b';', text).find(begins).unwrap_or(text.len())
}

#[cfg(test)]
mod tests {
    use crate::{Block, Blocks, Code, Problem, SyntaxError};

    fn blocks(line: &str) -> Vec<Block<'_>> {
        Blocks::new(line.as_bytes()).map(|block| block.unwrap()).collect()
    }

    fn failing(line: &str) -> (u16, Problem) {
        let error = Blocks::new(line.as_bytes()).last().unwrap().unwrap_err();
        (error.column, error.problem)
    }

    fn g(number: u16) -> Block<'static> {
        Block::new(Some(Code::g(number)), 1)
    }

    fn m(number: u16) -> Block<'static> {
        Block::new(Some(Code::m(number)), 1)
    }

    #[test]
    fn m_codes_may_have_strings_and_lists() {
        assert_eq!(blocks("M593 P\"zvd; 2\" F40.5")[0].text, Some("zvd; 2"));
        assert_eq!(blocks("M593 P\"zvd\" F40.5")[0].get('F'), Some(40.5));
        assert_eq!(blocks("M862.3 P \"MK3S\" ; model")[0].text, Some("MK3S"));
        assert_eq!(blocks("M566 X600 E120:130:-1 Y5"), [m(566).with('X', 600.0).with('E', 120.0).with('Y', 5.0)]);
        assert_eq!(blocks("M115 U3.12.2")[0].text, Some("U3.12.2"));
        assert_eq!(blocks("M486 AShape-Box (1)")[0].text, Some("AShape-Box (1)"));
        assert_eq!(failing("G1 X1:2"), (6, Problem::NotALetter(b':')));
        assert_eq!(blocks("G29 S1 P\"0:/sys/x.csv\"")[0].text, Some("0:/sys/x.csv"));
        assert_eq!(failing("G28 P\"x\""), (6, Problem::NotALetter(b'"')));
        assert_eq!(failing("M98 P\"x"), (6, Problem::NotALetter(b'"')));
    }

    #[test]
    fn the_power_of_a_move_may_be_a_list() {
        let block = &blocks("G1 Y-0.8S0.875:0:0:0.5 F600")[0];
        assert_eq!((block.get('S'), block.text, block.get('F')), (Some(0.875), Some(":0:0:0.5"), Some(600.0)));
        assert_eq!(blocks("X1 S1:0")[0].text, Some(":0"));
        let block = &blocks("G1 S255@12:0@5 X3")[0];
        assert_eq!((block.get('S'), block.text, block.get('X')), (Some(255.0), Some("@12:0@5"), Some(3.0)));
        // Behind a blank, and behind other words, it is LinuxCNC's distance of polar coordinates.
        for polar in ["G1 S1 @5", "G1 F1@5", "G4 S1@5"] {
            let block = &blocks(polar)[0];
            assert_eq!((block.get('@'), block.text), (Some(5.0), None), "{polar}");
        }
        assert_eq!(failing("G1 S1 X1:2"), (9, Problem::NotALetter(b':')));
        assert_eq!(failing("G4 S1:2"), (6, Problem::NotALetter(b':')));
        assert_eq!(failing("G1 S1 :2"), (7, Problem::NotALetter(b':')));
    }

    #[test]
    fn text_codes_keep_their_text() {
        assert_eq!(blocks("M117 Hello, World! (50%)  ; note")[0].text, Some("Hello, World! (50%)"));
        assert_eq!(blocks("m23 My File.gcode")[0].text, Some("My File.gcode"));
        assert_eq!(blocks("M28 a.g")[0].text, Some("a.g"));
        assert_eq!(blocks("M32/b.g")[0].text, Some("/b.g"));
        assert_eq!(blocks("G4 P1 M30"), [g(4).with('P', 1.0), m(30)]);
        assert_eq!(blocks("M23.1 S1")[0].text, None);
        assert_eq!(blocks("M30 (end of part)")[0].text, None);
        assert_eq!(blocks("M30 old (2).gcode")[0].text, Some("old (2).gcode"));
        assert_eq!(
            Blocks::new(b"M117 \xff").next().unwrap().unwrap_err(),
            SyntaxError { column: 5, problem: Problem::NotText }
        );
    }
}
