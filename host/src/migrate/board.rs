//! A table of the new board's pins in place of the old board's, which a person can read and change.

use std::collections::BTreeMap;

use anyhow::{Result, bail};

/// Table of the Smoothieboard v1, as shipped with the command.
const SMOOTHIEBOARD: &str = include_str!("../../assets/smoothieboard-v1.pins");
const MODIFIERS: [char; 5] = ['!', 'o', '^', 'v', '-'];

/// Table of old pins and their replacements.
pub struct Board {
    pins: BTreeMap<(u8, u8), Place>,
}

/// Replacement for an old pin.
struct Place {
    /// Name of the new pin; none if none is needed.
    pin: Option<String>,
    to_do: Option<String>,
}

/// Outcome for one pin of the old file.
#[derive(Debug, PartialEq, Eq)]
pub enum Mapped {
    /// New pin with modifiers, such as `PD0^`, and the rewiring to do.
    Pin(String, Option<String>),
    /// No pin is needed any more.
    Dropped,
    /// Missing pin: the table does not have it.
    Unknown,
}

impl Board {
    /// Reads a board file's text: `2.5 = PE3  # comment`.
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

    /// Returns the table of the Smoothieboard v1.
    pub fn smoothieboard() -> Self {
        Self::parse(SMOOTHIEBOARD).unwrap_or_else(|error| panic!("the table that was built in: {error}"))
    }

    /// Returns the new pin for an old one such as `1.24^`, with its modifiers.
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

/// Splits `1.24^` into port, number, and the modifiers behind them.
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

    /// The check would find two old pins on one new pin only when both are in use.
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
