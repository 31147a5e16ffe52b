//! Short names: eight characters and three, as every entry has one beside its long name.

use super::letter_case::capital;
use super::name::Name;

/// Number of tails, from `~1` to `~9`.
pub(super) const TAILS: u8 = 9;

/// Bits of an entry's byte 12 that Windows NT and its successors use, FatFs and Linux too: the name, or the
/// extension, is meant in small letters. The bits spare a long name; a system that does not know them shows
/// capitals. FAT 1.03 only reserves the byte.
const SMALL_NAME: u8 = 0x08;
const SMALL_EXTENSION: u8 = 0x10;

/// Characters above 7F in the code page of the IBM PC (437), which Western DOS and Windows wrote. A volume
/// does not say which code page it was written with.
const CODE_PAGE: [char; 128] = [
    'Ç', 'ü', 'é', 'â', 'ä', 'à', 'å', 'ç', 'ê', 'ë', 'è', 'ï', 'î', 'ì', 'Ä', 'Å', //
    'É', 'æ', 'Æ', 'ô', 'ö', 'ò', 'û', 'ù', 'ÿ', 'Ö', 'Ü', '¢', '£', '¥', '₧', 'ƒ', //
    'á', 'í', 'ó', 'ú', 'ñ', 'Ñ', 'ª', 'º', '¿', '⌐', '¬', '½', '¼', '¡', '«', '»', //
    '░', '▒', '▓', '│', '┤', '╡', '╢', '╖', '╕', '╣', '║', '╗', '╝', '╜', '╛', '┐', //
    '└', '┴', '┬', '├', '─', '┼', '╞', '╟', '╚', '╔', '╩', '╦', '╠', '═', '╬', '╧', //
    '╨', '╤', '╥', '╙', '╘', '╒', '╓', '╫', '╪', '┘', '┌', '█', '▄', '▌', '▐', '▀', //
    'α', 'ß', 'Γ', 'π', 'Σ', 'σ', 'µ', 'τ', 'Φ', 'Θ', 'Ω', 'δ', '∞', 'φ', 'ε', '∩', //
    '≡', '±', '≥', '≤', '⌠', '⌡', '÷', '≈', '°', '∙', '·', '√', 'ⁿ', '²', '■', '\u{A0}',
];

/// Returns the characters of a short name for display.
pub(super) fn units(name: [u8; 11], case_bits: u8) -> impl Iterator<Item = u16> {
    let length = |part: &[u8]| part.iter().rposition(|byte| *byte != b' ').map_or(0, |last| last + 1);
    let (stem, extension) = name.split_at(8);
    let (stem, extension) = (length(stem), length(extension));
    let point = (extension > 0).then_some(u16::from(b'.'));
    let part = move |from: usize, count: usize, small: u8| {
        name.into_iter().enumerate().skip(from).take(count).map(move |(at, byte)| match (at, byte) {
            // E5 as the first byte would mean a free slot.
            (0, 0x05) => decoded(0xE5),
            (_, byte) if case_bits & small != 0 => decoded(byte.to_ascii_lowercase()),
            (_, byte) => decoded(byte),
        })
    };
    part(0, stem, SMALL_NAME).chain(point).chain(part(8, extension, SMALL_EXTENSION))
}

fn decoded(byte: u8) -> u16 {
    let letter = byte.checked_sub(128).and_then(|index| CODE_PAGE.get(usize::from(index)).copied());
    // Every character of the table is in the basic plane.
    letter.map_or(u16::from(byte), |letter| u32::from(letter) as u16)
}

/// Returns whether a short name may have this character: a capital, a digit, or certain others.
const fn is_legal(byte: u8) -> bool {
    byte.is_ascii_uppercase()
        || byte.is_ascii_digit()
        || matches!(
            byte,
            b'$' | b'%'
                | b'\''
                | b'-'
                | b'_'
                | b'@'
                | b'~'
                | b'`'
                | b'!'
                | b'('
                | b')'
                | b'{'
                | b'}'
                | b'^'
                | b'#'
                | b'&'
        )
}

/// Returns the short name equal to this name but for its case, with the case bits if they can express the
/// case.
pub(super) fn plain(name: &Name) -> Option<([u8; 11], Option<u8>)> {
    let (stem, extension) = match name.units().iter().position(|unit| *unit == u16::from(b'.')) {
        Some(point) => (name.units().get(..point)?, name.units().get(point + 1..)?),
        None => (name.units(), &[][..]),
    };
    let has_point = stem.len() < name.units().len();
    if !(1..=8).contains(&stem.len()) || extension.len() > 3 || (has_point && extension.is_empty()) {
        return None;
    }
    let mut short = [b' '; 11];
    let places = (0..).zip(stem).chain((8..).zip(extension));
    let mut cases = [(false, false); 2];
    for (place, unit) in places {
        let byte = u8::try_from(*unit).ok()?;
        *short.get_mut(place)? = Some(byte.to_ascii_uppercase()).filter(|byte| is_legal(*byte))?;
        let (small, capital) = cases.get_mut(place / 8)?;
        *small |= byte.is_ascii_lowercase();
        *capital |= byte.is_ascii_uppercase();
    }
    let mixed = cases.contains(&(true, true));
    let bit = |part: (bool, bool), bit| if part.0 { bit } else { 0 };
    Some((short, (!mixed).then_some(bit(cases[0], SMALL_NAME) | bit(cases[1], SMALL_EXTENSION))))
}

/// Beginning and extension of a long name's short name (FAT 1.03, "The Basis-Name Generation Algorithm").
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Basis {
    stem: [u8; 8],
    stem_length: usize,
    extension: [u8; 3],
}

impl Basis {
    /// Returns the characters of a long name that a short one may have.
    pub fn of(name: &Name) -> Self {
        let point = u16::from(b'.');
        let leading = name.units().iter().position(|unit| *unit != point).unwrap_or(0);
        let name = name.units().get(leading..).unwrap_or(&[]);
        let mut basis = Self { stem: [b' '; 8], stem_length: 0, extension: [b' '; 3] };
        let stem = name.iter().take_while(|unit| **unit != point).filter_map(|unit| short(*unit));
        for (to, byte) in basis.stem.iter_mut().zip(stem) {
            *to = byte;
            basis.stem_length += 1;
        }
        if let Some(last) = name.iter().rposition(|unit| *unit == point) {
            let extension = name.iter().skip(last + 1).filter_map(|unit| short(*unit));
            basis.extension.iter_mut().zip(extension).for_each(|(to, byte)| *to = byte);
        }
        basis
    }

    /// Makes another basis for the same name, when the tails are used up: two of its letters and four
    /// hexadecimal digits, as Windows does. Each `round` gives another one.
    pub fn hashed(mut self, name: &Name, round: u16) -> Self {
        // FNV-1a, 32 bits, folded to 16.
        let bytes =
            round.to_le_bytes().into_iter().chain(name.units().iter().flat_map(|unit| capital(*unit).to_le_bytes()));
        let hash = bytes.fold(0x811C_9DC5_u32, |hash, byte| (hash ^ u32::from(byte)).wrapping_mul(0x0100_0193));
        let hash = (hash >> 16) ^ hash;
        let kept = self.stem_length.min(2);
        let digits = [12, 8, 4, 0].map(|shift| b"0123456789ABCDEF"[(hash >> shift & 15) as usize]);
        self.stem.iter_mut().skip(kept).zip(digits).for_each(|(to, digit)| *to = digit);
        self.stem_length = kept + 4;
        self
    }

    /// Returns the short name with `~1` to `~9` at the end (FAT 1.03, "The Numeric-Tail Generation
    /// Algorithm").
    pub fn with_tail(&self, tail: u8) -> [u8; 11] {
        let mut name = [b' '; 11];
        let kept = self.stem_length.min(6);
        let stem = self.stem.iter().copied().take(kept).chain([b'~', b'0' + tail]);
        name.iter_mut().zip(stem).for_each(|(to, byte)| *to = byte);
        name.iter_mut().skip(8).zip(self.extension).for_each(|(to, byte)| *to = byte);
        name
    }

    /// Returns the tail that makes this name.
    pub fn tail_of(&self, name: &[u8; 11]) -> Option<u8> {
        (1..=TAILS).find(|tail| self.with_tail(*tail) == *name)
    }
}

/// Converts a character for short names; `None` for characters that they leave out.
fn short(unit: u16) -> Option<u8> {
    const BLANK: u16 = b' ' as u16;
    match u8::try_from(unit).map(|byte| byte.to_ascii_uppercase()) {
        _ if unit == BLANK => None,
        Ok(byte) if is_legal(byte) => Some(byte),
        _ => Some(b'_'),
    }
}
