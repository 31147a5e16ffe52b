//! Codes and commands with their help, which the page completes lines with.

use core::fmt::Write as _;

use heapless::String;
use http::json::Writer;
use program::{codes, commands};

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

/// Writes the rows of a part. False if there are none.
pub fn write(part: u32, json: &mut Writer<'_, '_>) -> bool {
    let mut is_there = false;
    for (name, help) in rows().skip((part as usize).saturating_mul(ROWS)).take(ROWS) {
        is_there = true;
        json.key(&name);
        json.text(help);
    }
    is_there
}

#[cfg(test)]
mod tests {
    use http::Made;
    use http::json::{Next, Parts};

    use super::*;

    #[test]
    fn every_part_has_room_and_every_row_is_told() {
        let (mut text, mut told) = ([0; 960], 0);
        for part in 0.. {
            let mut is_there = false;
            let made = Parts::new().make(&mut text, |_, json| {
                is_there = write(part, json);
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
