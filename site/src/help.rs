//! Codes, commands and macros with their help, which the page completes lines with.

use core::fmt::Write as _;

use heapless::String;
use http::json::Writer;
use program::{codes, commands};

use crate::macros::{Macro, Macros};

/// Rows of a part: each is a name and a line of 90 letters at the most.
const ROWS: usize = 7;

/// Returns name and help of every code and command.
fn rows() -> impl Iterator<Item = (String<16>, &'static str)> {
    let codes = codes::all().map(|row| {
        let mut name = String::new();
        // A code is shorter.
        let _ = write!(name, "{}", row.code);
        (name, row.help)
    });
    codes.chain(commands::COMMANDS.iter().map(|row| (String::try_from(row.word).unwrap_or_default(), row.help)))
}

/// Writes the rows of a part: codes and commands, then a macro in each. No answer until the machine has told
/// of the macro; false behind the last one.
pub fn write(part: u32, macros: &Macros, json: &mut Writer<'_, '_>) -> Option<bool> {
    let parts = (codes::all().count() + commands::COMMANDS.len()).div_ceil(ROWS) as u32;
    if let Some(number) = part.checked_sub(parts) {
        let Some(Macro { name, about }) = macros.at(number as u16)? else { return Some(false) };
        let mut name = name.clone();
        name.make_ascii_uppercase();
        // A code that a macro has taken keeps its own words.
        if rows().all(|(code, _)| code != name.as_str()) {
            json.key(&name);
            json.text(if about.is_empty() { "macro" } else { about });
        }
        return Some(true);
    }
    for (name, help) in rows().skip((part as usize).saturating_mul(ROWS)).take(ROWS) {
        json.key(&name);
        json.text(help);
    }
    Some(true)
}

#[cfg(test)]
mod tests {
    use http::Made;
    use http::json::{Next, Parts};

    use super::*;

    #[test]
    fn every_part_has_room_and_every_row_is_told() {
        let (mut text, mut told, mut macros) = ([0; 960], 0, Macros::new());
        macros.tell(0, Some(("a\"".repeat(48).as_str(), "\"".repeat(96).as_str())));
        macros.tell(1, None);
        for part in 0.. {
            let mut is_there = false;
            let made = Parts::new().make(&mut text, |_, json| {
                is_there = write(part, &macros, json).expect("a macro that is told");
                Next::End
            });
            assert!(matches!(made, Made::Last(_)), "part {part}: {made:?}");
            if !is_there {
                break;
            }
            told += ROWS;
        }
        assert!(told >= rows().count() && rows().count() > 300);
        assert!(rows().all(|(name, _)| !name.is_empty()));
    }
}
