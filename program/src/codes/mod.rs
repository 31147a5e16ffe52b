//! The table of codes: each code's help text, words, states in which it may run, kind of waiting, and
//! handler.
//!
//! Dispatch, `help`, the documentation and the test for completeness all read this table. To add a code, add
//! its row to the file of its topic.

mod cycles;
mod extruder;
mod files;
mod flavours;
mod heat;
mod leveling;
#[cfg(feature = "docs")]
mod markdown;
mod mill;
mod motion;
mod motors;
mod offsets;
mod printers;
mod program;
mod row;
#[cfg(all(test, feature = "docs"))]
mod tested;
#[cfg(feature = "docs")]
mod varying;

use gcode::{Code, Letter};

use crate::state::claims::Claim;
pub use crate::word::{Bounds, Doc, Unit, WordInfo};
use gcode::Dialect;
#[cfg(feature = "docs")]
pub use markdown::{write_codes, write_commands, write_named, write_otherwise};
pub(crate) use row::Handler;
pub use row::{CodeInfo, Group, Waits};

/// Rows by topic, each topic with its title.
pub const TOPICS: [(&str, &[CodeInfo]); 11] = [
    ("Moves", motion::ROWS),
    ("Canned cycles and feed modes", cycles::ROWS),
    ("Units, planes and offsets", offsets::ROWS),
    ("Homing, probing and leveling", leveling::ROWS),
    ("Mills and lathes", mill::ROWS),
    ("Extruders", extruder::ROWS),
    ("Heaters and switches", heat::ROWS),
    ("Motors and limits", motors::ROWS),
    ("Jobs, files and settings", files::ROWS),
    ("Program and machine", program::ROWS),
    ("Codes of printers beside Smoothieware's", printers::ROWS),
];

pub use flavours::{Otherwise, READ_OTHERWISE};

/// Lowest number of G-codes that some dialect reads otherwise.
const FIRST_G_READ_OTHERWISE: u16 = 10;

/// Returns the row of a code that a dialect reads otherwise than Smoothieware.
#[inline]
pub(crate) fn find_in(code: Code, dialect: Dialect) -> Option<&'static CodeInfo> {
    // Moves mean the same in all dialects, so most lines need no search.
    if !dialect.reads_otherwise() || code.letter != Letter::M && code.number < FIRST_G_READ_OTHERWISE {
        return None;
    }
    let reads = |other: &&Otherwise| other.row.code == code && other.dialects.has(dialect);
    READ_OTHERWISE.iter().find(reads).map(|other| &other.row)
}

/// Returns every row of the table.
pub fn all() -> impl Iterator<Item = &'static CodeInfo> {
    TOPICS.iter().flat_map(|(_, rows)| rows.iter())
}

/// Row of T, the tool selection.
pub(crate) const TOOL: &CodeInfo = &extruder::TOOL;

/// Returns the row for a code that only the configuration gives a meaning to.
pub(crate) const fn claimed(claim: Claim) -> &'static CodeInfo {
    match claim {
        Claim::Target(_) => &heat::TARGET,
        Claim::TargetAndWait(_) => &heat::TARGET_AND_WAIT,
        Claim::Temperature(_) => &heat::TEMPERATURE,
        Claim::SwitchOn(_) | Claim::SwitchOff(_) => &heat::SWITCH,
        Claim::Arm(_) => &heat::ARM,
    }
}

/// Numbers below this are found in the index by one look.
const G_NUMBERS: usize = 128;
const M_NUMBERS: usize = 1_024;
const NO_ROW: u16 = u16::MAX;

/// First row of each number: topic in the high byte, index in the low byte.
struct Index {
    g: [u16; G_NUMBERS],
    m: [u16; M_NUMBERS],
}

static INDEX: Index = index();

const fn index() -> Index {
    let mut index = Index { g: [NO_ROW; G_NUMBERS], m: [NO_ROW; M_NUMBERS] };
    let mut topic = 0;
    while topic < TOPICS.len() {
        let rows = TOPICS[topic].1;
        let mut place = 0;
        while place < rows.len() {
            let code = rows[place].code;
            let number = code.number as usize;
            let entry = (topic as u16) << 8 | place as u16;
            let slot = match code.letter {
                Letter::G => &mut index.g[number],
                Letter::M => &mut index.m[number],
                Letter::T => panic!("T has a row of its own"),
            };
            if *slot == NO_ROW {
                *slot = entry;
            } else {
                let before = &rows[place - 1].code;
                let follows = before.number == code.number && is_same(before.letter, code.letter);
                assert!(follows, "the rows of one number stand together");
                assert!(!rows[place - 1].any_subcode, "the row for other subcodes is the last one of its number");
            }
            place += 1;
        }
        topic += 1;
    }
    index
}

const fn is_same(a: Letter, b: Letter) -> bool {
    matches!((a, b), (Letter::G, Letter::G) | (Letter::M, Letter::M) | (Letter::T, Letter::T))
}

/// Returns the row of a code.
#[must_use]
pub fn find(code: Code) -> Option<&'static CodeInfo> {
    let numbers: &[u16] = match code.letter {
        Letter::G => &INDEX.g,
        Letter::M => &INDEX.m,
        Letter::T => return Some(TOOL),
    };
    let entry = numbers.get(usize::from(code.number)).copied().filter(|entry| *entry != NO_ROW)?;
    let (_, rows) = TOPICS.get(usize::from(entry >> 8))?;
    let rows = rows.get(usize::from(entry & 0xFF)..)?;
    let mut rows = rows.iter().take_while(|row| row.code.number == code.number);
    rows.find(|row| row.code.subcode == code.subcode || row.any_subcode)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn every_row_is_found_by_its_code_and_no_code_has_two() {
        let mut seen = BTreeSet::new();
        for row in all() {
            let code = row.code;
            assert!(seen.insert(std::format!("{code}")), "{code} has two rows");
            let found = find(code).unwrap_or_else(|| panic!("{code} is not found"));
            assert!(core::ptr::eq(found, row), "{code} finds {}", found.code);
        }
        for code in [Code::g(6), Code::g(1).sub(1), Code::m(1_023), Code::m(60_000), Code::g(200)] {
            assert!(find(code).is_none(), "{code}");
        }
        assert!(find(Code::t(5)).is_some());
    }

    #[test]
    fn every_row_says_what_it_does_in_one_line() {
        for row in all() {
            let help = row.help;
            assert!(help.len() > 8 && help.len() <= 90 && !help.contains('\n'), "{}: {help}", row.code);
            assert!(!help.ends_with('.') && help.starts_with(|c: char| !c.is_uppercase()), "{}: {help}", row.code);
        }
    }

    #[test]
    fn no_row_names_a_letter_twice() {
        for row in all() {
            let letters: BTreeSet<char> = row.words.iter().map(|word| word.letter()).collect();
            assert_eq!(letters.len(), row.words.len(), "{}", row.code);
            assert!(
                letters.iter().all(|letter| gcode::WORD_LETTERS.contains(letter) && !"GMN".contains(*letter)),
                "{}",
                row.code
            );
        }
    }

    #[cfg(feature = "docs")]
    #[test]
    fn every_word_says_what_it_is() {
        for row in all() {
            for word in row.words {
                assert!(!word.text.text().is_empty(), "{} {}", row.code, word.letter());
            }
        }
    }
}
