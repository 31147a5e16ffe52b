//! The tool table: properties of tools by number, in a file of LinuxCNC's format, a tool a line: `T1 P1 Z12.5
//! D6 ;end mill` (LinuxCNC, "Tool Table Format").
//!
//! The program owns the table; the machine reads and writes the file.

use core::fmt;

use heapless::Vec;
use units::Axis;

/// Greatest number of tools in a table.
pub const MOST_TOOLS: usize = 64;
/// Greatest orientation of a lathe's tool (G10 L1 Q).
pub(crate) const MOST_ORIENTATION: u8 = 9;

/// Tool of the table. Lengths are mm, angles degrees.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ToolEntry {
    /// Tool number, above 0.
    pub number: u16,
    /// Pocket of a tool changer, P; kept in the table but without effect here.
    pub pocket: Option<u16>,
    /// Tool offset along X Y Z, mm.
    pub offset: [f64; 3],
    /// Tool offset along A B C, which is not supported: using such an offset is refused.
    pub rotary: [f32; 3],
    /// Diameter of the tool, D word, mm.
    pub diameter: f64,
    /// Front and back angle of a lathe's tool, I and J, degrees.
    pub angles: [f32; 2],
    /// Orientation of a lathe's tool, Q, 0 to 9.
    pub orientation: u8,
}

/// Reason why a line of the file is no tool.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ToolLineFlaw {
    /// T word missing, or outside 1 to 65535.
    Number,
    /// Word of this letter repeated, out of range, or unknown.
    Word(char),
    /// Offset of an axis that no supported machine has.
    NoAxis(char),
    /// Tool number that appears earlier in the file.
    Twice(u16),
    /// More tools than the table holds.
    Full,
}

impl fmt::Display for ToolLineFlaw {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Number => f.write_str("T is a whole number from 1 to 65535"),
            Self::Word(letter) => write!(f, "{letter} is not read here, or has a wrong value"),
            Self::NoAxis(letter) => write!(f, "there is no axis {letter}"),
            Self::Twice(number) => write!(f, "T{number} stands further up already"),
            Self::Full => write!(f, "the table holds {MOST_TOOLS} tools"),
        }
    }
}

impl ToolEntry {
    /// Reads a line of the file; `None` for a line without a tool: blank, or a comment.
    #[must_use]
    pub fn read(line: &str) -> Option<Result<Self, ToolLineFlaw>> {
        let words = line.split_once(';').map_or(line, |(words, _)| words);
        let mut words = words.split_ascii_whitespace().peekable();
        words.peek()?;
        let (mut entry, mut seen) = (Self::default(), 0_u32);
        for word in words {
            let letter = word.chars().next().unwrap_or(' ').to_ascii_uppercase();
            let bit = 1 << ((letter as u32).wrapping_sub('A' as u32) & 31);
            let text = word.get(letter.len_utf8()..).unwrap_or("");
            if seen & bit != 0 || !letter.is_ascii_uppercase() {
                return Some(Err(ToolLineFlaw::Word(letter)));
            }
            seen |= bit;
            if let Err(flaw) = entry.take(letter, text) {
                return Some(Err(flaw));
            }
        }
        Some(if entry.number == 0 { Err(ToolLineFlaw::Number) } else { Ok(entry) })
    }

    fn take(&mut self, letter: char, text: &str) -> Result<(), ToolLineFlaw> {
        let value = gcode::read_f64(text).filter(|value| value.is_finite());
        let wrong = ToolLineFlaw::Word(letter);
        let axis = Axis::from_letter(letter).map(|axis| axis as usize);
        match (letter, axis) {
            ('T', _) => self.number = text.parse().map_err(|_| ToolLineFlaw::Number)?,
            ('P', _) => self.pocket = Some(text.parse().map_err(|_| wrong)?),
            ('D', _) => self.diameter = value.ok_or(wrong)?,
            ('I', _) => self.angles[0] = value.ok_or(wrong)? as f32,
            ('J', _) => self.angles[1] = value.ok_or(wrong)? as f32,
            ('Q', _) => {
                let value = value.filter(|value| libm::floor(*value) == *value && *value >= 0.0);
                self.orientation = value.filter(|value| *value <= f64::from(MOST_ORIENTATION)).ok_or(wrong)? as u8;
            }
            ('U' | 'V' | 'W', _) if value == Some(0.0) => {}
            ('U' | 'V' | 'W', _) => return Err(ToolLineFlaw::NoAxis(letter)),
            (_, Some(axis)) => match (self.offset.get_mut(axis), self.rotary.get_mut(axis.wrapping_sub(3))) {
                (Some(offset), _) => *offset = value.ok_or(wrong)?,
                (None, Some(offset)) => *offset = value.ok_or(wrong)? as f32,
                (None, None) => return Err(wrong),
            },
            _ => return Err(wrong),
        }
        Ok(())
    }

    /// Returns the first of A B C with an offset.
    #[must_use]
    pub(crate) fn rotary_axis(&self) -> Option<char> {
        ['A', 'B', 'C'].into_iter().zip(self.rotary).find(|(_, offset)| *offset != 0.0).map(|(letter, _)| letter)
    }
}

/// Formats the tool as a line of the file, without line end. Zero values are left out.
impl fmt::Display for ToolEntry {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "T{}", self.number)?;
        self.pocket.map_or(Ok(()), |pocket| write!(f, " P{pocket}"))?;
        for (axis, offset) in Axis::ALL.into_iter().zip(self.offset) {
            if offset != 0.0 {
                write!(f, " {}{offset}", axis.letter())?;
            }
        }
        let [front, back] = self.angles;
        let [a, b, c] = self.rotary;
        for (letter, value) in [('A', a), ('B', b), ('C', c), ('I', front), ('J', back)] {
            if value != 0.0 {
                write!(f, " {letter}{value}")?;
            }
        }
        if self.diameter != 0.0 {
            write!(f, " D{}", self.diameter)?;
        }
        if self.orientation != 0 { write!(f, " Q{}", self.orientation) } else { Ok(()) }
    }
}

/// Tool table, with marks for tools that differ from the file on the card.
#[derive(Clone, Debug, Default)]
pub struct ToolTable {
    tools: Vec<ToolEntry, MOST_TOOLS>,
    /// Marks of unsaved tools, one bit each by index.
    unsaved: u64,
}

impl ToolTable {
    /// Returns the tool with this number.
    #[must_use]
    pub fn get(&self, number: u16) -> Option<&ToolEntry> {
        self.tools.iter().find(|tool| tool.number == number)
    }

    /// Returns all tools, in the order of the file.
    #[must_use]
    pub fn all(&self) -> &[ToolEntry] {
        &self.tools
    }

    /// Adds a tool read from the file.
    ///
    /// # Errors
    /// When the number exists already, or there is no room.
    pub fn add(&mut self, tool: ToolEntry) -> Result<(), ToolLineFlaw> {
        if self.get(tool.number).is_some() {
            return Err(ToolLineFlaw::Twice(tool.number));
        }
        self.tools.push(tool).map_err(|_| ToolLineFlaw::Full)
    }

    /// Forgets every tool, because the file is read again.
    pub fn clear(&mut self) {
        *self = Self::default();
    }

    /// Adds or replaces a tool and marks it as unsaved. Returns false when there is no room.
    pub(crate) fn set(&mut self, tool: ToolEntry) -> bool {
        let place = match self.tools.iter().position(|known| known.number == tool.number) {
            Some(place) => place,
            None if self.tools.push(tool).is_ok() => self.tools.len() - 1,
            None => return false,
        };
        if let Some(known) = self.tools.get_mut(place) {
            *known = tool;
        }
        self.unsaved |= 1 << place;
        true
    }

    /// Whether a tool is not saved.
    #[must_use]
    pub const fn is_unsaved(&self) -> bool {
        self.unsaved != 0
    }

    /// Returns the marks of unsaved tools, one bit each by index.
    #[must_use]
    pub const fn unsaved(&self) -> u64 {
        self.unsaved
    }

    /// Marks all tools as saved.
    pub const fn saved(&mut self) {
        self.unsaved = 0;
    }

    /// Returns the index of a tool in the table, which is its bit in the marks.
    #[must_use]
    pub fn place_of(&self, number: u16) -> Option<usize> {
        self.tools.iter().position(|tool| tool.number == number)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::string::ToString;

    fn read(line: &str) -> Result<ToolEntry, ToolLineFlaw> {
        ToolEntry::read(line).unwrap()
    }

    #[test]
    fn lines_are_read_as_linuxcnc_writes_them() {
        let tool = read("T1  P17 D+0.125000 X-1 Z+0.511000 I10 J20 Q3 U+0.000000 ;1/8 end mill T9").unwrap();
        assert_eq!((tool.number, tool.pocket, tool.offset), (1, Some(17), [-1.0, 0.0, 0.511]));
        assert_eq!((tool.diameter, tool.angles, tool.orientation), (0.125, [10.0, 20.0], 3));
        assert_eq!(tool.to_string(), "T1 P17 X-1 Z0.511 I10 J20 D0.125 Q3");
        assert_eq!(ToolEntry::read("; nothing but a comment"), None);
        assert_eq!(ToolEntry::read("  "), None);
    }

    #[test]
    fn what_is_no_tool_says_why() {
        assert_eq!(read("P1 Z5"), Err(ToolLineFlaw::Number));
        assert_eq!(read("T0 P1"), Err(ToolLineFlaw::Number));
        assert_eq!(read("T70000"), Err(ToolLineFlaw::Number));
        assert_eq!(read("T1 Zlong"), Err(ToolLineFlaw::Word('Z')));
        assert_eq!(read("T1 Z1 Z2"), Err(ToolLineFlaw::Word('Z')));
        assert_eq!(read("T1 K2"), Err(ToolLineFlaw::Word('K')));
        assert_eq!(read("T1 Q10"), Err(ToolLineFlaw::Word('Q')));
        assert_eq!(read("T1 W1"), Err(ToolLineFlaw::NoAxis('W')));
        let mut table = ToolTable::default();
        table.add(read("T1").unwrap()).unwrap();
        assert_eq!(table.add(read("T1 Z1").unwrap()), Err(ToolLineFlaw::Twice(1)));
        for number in 2..=MOST_TOOLS as u16 {
            table.add(ToolEntry { number, ..ToolEntry::default() }).unwrap();
        }
        assert_eq!(table.add(read("T100").unwrap()), Err(ToolLineFlaw::Full));
        assert!(!table.set(read("T100").unwrap()) && !table.is_unsaved());
        assert!(table.set(read("T64 Z1").unwrap()) && table.is_unsaved());
    }

    proptest! {
        #[test]
        fn a_tool_written_and_read_is_the_same(
            number in 1_u16.., pocket in proptest::option::of(any::<u16>()),
            offset in proptest::array::uniform3(-1e3_f64..1e3), rotary in proptest::array::uniform3(-1e3_f32..1e3),
            diameter in 0.0_f64..100.0, angles in proptest::array::uniform2(-360_f32..360.0), orientation in 0_u8..10,
        ) {
            let tool = ToolEntry { number, pocket, offset, rotary, diameter, angles, orientation };
            prop_assert_eq!(read(&tool.to_string()), Ok(tool));
        }

        #[test]
        fn any_text_is_a_tool_or_not(line in "[TPXYZABCUVWDIJQ0-9. +;-]{0,40}") {
            let _ = ToolEntry::read(&line);
        }
    }
}
