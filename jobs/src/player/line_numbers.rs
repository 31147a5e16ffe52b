//! Line numbers: tags for a session's own numbers, and decoders for a file's.

use base::failure::short;
use gcode::Decoder;
use motion::Tag;

use super::tags::of_number;

/// Returns the tag for the moves of a line with a number.
pub fn tag_of(line: &[u8]) -> Tag {
    number_of(line).and_then(|number| u32::try_from(number).ok()).map_or(Tag::NONE, of_number)
}

/// Returns the number that a line begins with.
#[inline]
fn number_of(line: &[u8]) -> Option<i64> {
    let rest = line.trim_ascii_start().strip_prefix(b"N")?;
    number_in(rest.trim_ascii_start())
}

fn number_in(digits: &[u8]) -> Option<i64> {
    let digits = digits.iter().take_while(|digit| digit.is_ascii_digit());
    let number = digits.fold(0_i64, |sum, digit| sum.saturating_mul(10).saturating_add(i64::from(digit - b'0')));
    (1..=i64::from(i32::MAX)).contains(&number).then_some(number)
}

/// Returns a decoder for a line from a file, which takes the number as it is (order was checked, if at all,
/// at the upload), but not the checksum.
#[inline]
pub fn decoder_expecting(line: &[u8]) -> Decoder {
    // Most lines have no number, and every line comes through here.
    number_of(line).map_or(const { Decoder::new() }, decoder_before)
}

/// Returns a decoder that expects this number.
#[cold]
fn decoder_before(number: i64) -> Decoder {
    let mut decoder = Decoder::new();
    let setting = short(format_args!("N{} M110", number - 1));
    // A number too large for the decoder is refused by it, with the line itself.
    let _ = decoder.decode(setting.as_str().as_bytes());
    decoder
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_of_a_file_may_have_any_number_but_must_have_its_checksum() {
        for (line, is_whole) in [
            (&b"N1 G28*18"[..], true),
            (b"N57 G28*33", true),
            (b"N57 G28*34", false),
            (b"  N57 G28", true),
            (b"G28", true),
        ] {
            let decoded = decoder_expecting(line).decode(line);
            assert_eq!(decoded.is_ok(), is_whole, "{}: {decoded:?}", line.escape_ascii());
        }
    }
}
