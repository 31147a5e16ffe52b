//! Names: UTF-16 units, case, and the slots that hold long names (FAT 1.03, "FAT Long Directory Entries").

use super::cursor::Cursor;
use super::letter_case::capital;
use super::slot::{SLOT_BYTES, Slot};
use super::{half, put};

/// Longest name in UTF-16 units.
pub(super) const MAX_UNITS: usize = 255;
/// UTF-16 units in a slot.
const UNITS_PER_SLOT: usize = 13;
/// Slots that the longest name takes.
pub(super) const MAX_SLOTS: usize = 20;
/// Bit in the ordinal of the slot with a name's end, which comes first.
const LAST: u8 = 0x40;
/// Offsets of a slot's UTF-16 units.
const OFFSETS: [usize; UNITS_PER_SLOT] = [1, 3, 5, 7, 9, 14, 16, 18, 20, 22, 24, 28, 30];

/// Long name in UTF-16 units.
#[derive(Clone, Debug)]
pub struct Name {
    units: [u16; MAX_SLOTS * UNITS_PER_SLOT],
    length: usize,
}

impl Default for Name {
    fn default() -> Self {
        Self::new()
    }
}

impl Name {
    /// Returns an empty name.
    #[must_use]
    pub const fn new() -> Self {
        Self { units: [0; MAX_SLOTS * UNITS_PER_SLOT], length: 0 }
    }

    /// Parses a name: blanks before it, and blanks and periods after it, do not count (FAT 1.03, "Name Limits
    /// and Character Sets"). Returns `None` when nothing is left or the name is too long.
    pub(crate) fn parse(text: &str) -> Option<Self> {
        let (mut name, text) = (Self::new(), stripped(text));
        name.set(text.encode_utf16());
        (name.length > 0 && text.encode_utf16().count() <= MAX_UNITS).then_some(name)
    }

    /// Sets the name to the first [`MAX_UNITS`] of these.
    pub(crate) fn set(&mut self, units: impl Iterator<Item = u16>) {
        self.length = 0;
        for (place, unit) in self.units.iter_mut().zip(units.take(MAX_UNITS)) {
            *place = unit;
            self.length += 1;
        }
    }

    /// Returns the UTF-16 units of the name.
    #[must_use]
    pub fn units(&self) -> &[u16] {
        self.units.get(..self.length).unwrap_or(&[])
    }

    /// Returns the characters of the name. Half a surrogate pair, which other systems may have left, shows as
    /// U+FFFD.
    pub fn chars(&self) -> impl Iterator<Item = char> {
        char::decode_utf16(self.units().iter().copied()).map(|decoded| decoded.unwrap_or(char::REPLACEMENT_CHARACTER))
    }

    /// Returns whether FAT allows a file of this name.
    pub(super) fn is_legal(&self) -> bool {
        self.units().iter().all(|unit| is_legal_unit(*unit))
    }

    /// Whether both are the same name, by [`same_name`]'s rule.
    pub(crate) fn same(&self, other: impl Iterator<Item = u16>) -> bool {
        self.units().iter().copied().map(capital).eq(other.map(capital))
    }

    /// Slots that its long form takes.
    pub(super) const fn slots(&self) -> usize {
        self.length.div_ceil(UNITS_PER_SLOT)
    }

    /// Returns the slot at this place of the long form; the name's end comes first.
    pub(super) fn slot(&self, place: usize, checksum: u8) -> Slot {
        let ordinal = self.slots().saturating_sub(place);
        let mut slot = [0; SLOT_BYTES];
        // The ordinal is at most 20.
        slot[0] = ordinal as u8 | if place == 0 { LAST } else { 0 };
        slot[11] = 0x0F;
        slot[13] = checksum;
        for (index, offset) in OFFSETS.into_iter().enumerate() {
            let at = ordinal.saturating_sub(1) * UNITS_PER_SLOT + index;
            // Behind the end comes a zero, and ones behind that.
            let unit = match self.units().get(at) {
                Some(unit) => *unit,
                None if at == self.length => 0,
                None => u16::MAX,
            };
            put(&mut slot, offset, &unit.to_le_bytes());
        }
        slot
    }
}

/// The sum of a short name that every slot of its long name repeats.
pub(super) fn checksum(short_name: &[u8; 11]) -> u8 {
    short_name.iter().fold(0, |sum: u8, byte| sum.rotate_right(1).wrapping_add(*byte))
}

/// A long name put together from slots. Pieces that do not follow one another, or do not belong to the entry
/// behind them, are left aside (FAT 1.03, "Organization and Association of Short & Long Directory Entries").
pub(super) struct Assembly<'a> {
    name: &'a mut Name,
    /// Ordinal of the last piece taken, and the checksum that all pieces have; an ordinal of 1 is a whole
    /// name.
    state: Option<(u8, u8)>,
    first: Option<Cursor>,
}

impl<'a> Assembly<'a> {
    /// Creates an assembly that puts the pieces into `name`.
    pub fn new(name: &'a mut Name) -> Self {
        Self { name, state: None, first: None }
    }

    /// Takes a slot with a piece of a long name.
    pub fn take(&mut self, slot: &Slot, at: Cursor) {
        let (ordinal, sum) = (slot[0] & !LAST, slot[13]);
        let begins = slot[0] & LAST != 0;
        let follows = self.state.is_some_and(|(last, of)| ordinal + 1 == last && sum == of);
        let sane = (1..=MAX_SLOTS).contains(&usize::from(ordinal)) && slot[12] == 0 && half(slot, 26) == 0;
        if !sane || !(begins || follows) {
            self.state = None;
            return;
        }
        if begins {
            self.first = Some(at);
        }
        let offset = usize::from(ordinal - 1) * UNITS_PER_SLOT;
        let pieces = OFFSETS.map(|offset| half(slot, offset));
        let count = pieces.iter().position(|unit| *unit == 0).unwrap_or(UNITS_PER_SLOT);
        if begins {
            self.name.length = offset + count;
        }
        // A name ends in its last piece, which has some of it.
        let whole = if begins { count > 0 && self.name.length <= MAX_UNITS } else { count == UNITS_PER_SLOT };
        self.name.units.iter_mut().skip(offset).zip(pieces).for_each(|(unit, piece)| *unit = piece);
        self.state = whole.then_some((ordinal, sum));
    }

    /// Ends the pieces at their entry: returns the beginning of its name, if the pieces are its name.
    pub fn finish(&mut self, short_name: &[u8; 11]) -> Option<Cursor> {
        let state = self.state.take();
        self.first.take().filter(|_| state == Some((1, checksum(short_name))))
    }

    /// Drops the pieces at a slot that is free, or no file's.
    pub fn forget(&mut self) {
        self.state = None;
    }
}

/// Returns the text without the characters that do not count in a name: blanks before it, blanks and periods
/// after it.
#[must_use]
pub fn stripped(text: &str) -> &str {
    text.trim_start_matches(' ').trim_end_matches([' ', '.'])
}

/// Returns whether a name may have this unit: the characters of FAT 1.03, "Name Limits and Character Sets",
/// and everything beyond ASCII.
const fn is_legal_unit(unit: u16) -> bool {
    match unit {
        0..0x20 | 0x7F => false,
        0x20..0x7F => !matches!(unit as u8, b'"' | b'*' | b'/' | b':' | b'<' | b'>' | b'?' | b'\\' | b'|'),
        _ => true,
    }
}

/// Whether a file can be given this name.
#[must_use]
pub fn is_legal_name(name: &str) -> bool {
    let stripped = stripped(name);
    let units = || stripped.encode_utf16();
    !stripped.is_empty() && units().count() <= MAX_UNITS && units().all(is_legal_unit)
}

/// Whether two names stand for the same file: without regard to case, blanks around them and periods at the
/// end.
///
/// Letters are the same when one is the other's only capital, and the other the only small letter of that:
/// `ä` and `Ä`, but not `ß` and `SS`, nor dotless `ı` and `I`. Letters beyond the basic plane are only the
/// same as themselves.
#[must_use]
pub fn same_name(one: &str, other: &str) -> bool {
    stripped(one).encode_utf16().map(capital).eq(stripped(other).encode_utf16().map(capital))
}
