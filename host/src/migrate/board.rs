//! Which pin of the new board takes the place of which pin of the old one: a table a person can read and
//! change.

use std::collections::BTreeMap;

use anyhow::{Result, bail};

/// The Smoothieboard v1, as shipped with the command.
const SMOOTHIEBOARD: &str = include_str!("../../assets/smoothieboard-v1.pins");
const MODIFIERS: [char; 5] = ['!', 'o', '^', 'v', '-'];

/// The table.
pub struct Board {
    pins: BTreeMap<(u8, u8), Place>,
}

/// What takes the place of a pin.
struct Place {
    /// None: nothing needs to.
    pin: Option<String>,
    to_do: Option<String>,
}

/// The outcome for one pin of the old file.
#[derive(Debug, PartialEq, Eq)]
pub enum Mapped {
    /// `PD0^`, and what has to be rewired.
    Pin(String, Option<String>),
    /// Not needed any more.
    Dropped,
    /// The table does not have it.
    Unknown,
}

impl Board {
    /// The board file's text: `2.5 = PE3  # comment`.
    pub fn parse(text: &str) -> Result<Self> {
        let mut pins = BTreeMap::new();
        for (number, line) in text.lines().enumerate() {
            let (line, comment) = line.split_once('#').unwrap_or((line, ""));
            let Some((old, new)) = line.split_once('=') else {
                if line.trim().is_empty() {
                    continue;
                }
                bail!("line {}: write `2.5 = PE3`", number + 1);
            };
            let (Some((place, "")), new) = (old_pin(old.trim()), new.trim()) else {
                bail!("line {}: '{}' is not a pin as in 2.5", number + 1, old.trim());
            };
            if new != "-" && !matches!(config::parse_pin(new), Ok(Some(_))) {
                bail!("line {}: '{new}' is not a pin of the new board", number + 1);
            }
            let to_do = comment.trim().strip_prefix("to do:").map(|text| text.trim().to_owned());
            pins.insert(place, Place { pin: (new != "-").then(|| new.to_owned()), to_do });
        }
        Ok(Self { pins })
    }

    /// The Smoothieboard v1.
    pub fn smoothieboard() -> Self {
        Self::parse(SMOOTHIEBOARD).unwrap_or_else(|error| panic!("the table that was built in: {error}"))
    }

    /// The new pin for `1.24^`, with its modifiers.
    pub fn map(&self, text: &str) -> Mapped {
        if text.eq_ignore_ascii_case("nc") {
            return Mapped::Pin("nc".into(), None);
        }
        let Some((place, modifiers)) = old_pin(text) else { return Mapped::Unknown };
        match self.pins.get(&place) {
            Some(Place { pin: Some(pin), to_do }) if modifiers.chars().all(|c| MODIFIERS.contains(&c)) => {
                let is_digital = pin.starts_with('P') && !pin.starts_with("PWM");
                Mapped::Pin(format!("{pin}{}", if is_digital { modifiers } else { "" }), to_do.clone())
            }
            Some(Place { pin: None, .. }) => Mapped::Dropped,
            _ => Mapped::Unknown,
        }
    }
}

/// `1.24^`: port, number, and what follows.
fn old_pin(text: &str) -> Option<((u8, u8), &str)> {
    let (port, rest) = text.split_once('.')?;
    let end = rest.find(|c: char| !c.is_ascii_digit()).unwrap_or(rest.len());
    let (number, modifiers) = rest.split_at(end);
    Some(((port.parse().ok()?, number.parse().ok()?), modifiers))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pins_keep_their_modifiers_and_bring_their_rewiring() {
        let board = Board::smoothieboard();
        assert_eq!(board.map("1.24!^"), Mapped::Pin("PD0!^".into(), None));
        assert!(matches!(board.map("2.5"), Mapped::Pin(pin, Some(_)) if pin == "PE3"));
        assert_eq!(board.map("0.4"), Mapped::Dropped);
        assert_eq!(board.map("nc"), Mapped::Pin("nc".into(), None));
        for unknown in ["3.25", "1.24@", "p24", ""] {
            assert_eq!(board.map(unknown), Mapped::Unknown, "{unknown}");
        }
    }

    #[test]
    fn a_bad_table_is_refused_with_its_line() {
        for (text, says) in [("2.5 PE3", "line 1"), ("\n2.5 = Q3", "line 2: 'Q3'"), ("x = PE3", "'x'")] {
            let error = Board::parse(text).err().map(|error| error.to_string()).unwrap_or_default();
            assert!(error.contains(says), "{text}: {error}");
        }
    }

    /// Two old pins on one new one would be found by the check only when both are in use.
    #[test]
    fn no_new_pin_is_given_out_twice() {
        let board = Board::smoothieboard();
        let mut given: Vec<_> = board.pins.values().filter_map(|place| place.pin.as_ref()).collect();
        given.sort();
        let count = given.len();
        given.dedup();
        assert_eq!(given.len(), count);
    }
}
