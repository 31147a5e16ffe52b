//! Klipper's pins: `!` inverts, `^` pulls up, `~` pulls down, a controller's name stands before a colon, and
//! `[board_pins]` gives other names.

use std::collections::BTreeMap;

use super::source::Source;

/// Pin as an option names it.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Pin {
    /// Controller it is on; `mcu` unless the option says another.
    pub mcu: String,
    /// Name with aliases resolved.
    pub name: String,
    pub is_inverted: bool,
    pub is_pulled_up: bool,
    pub is_pulled_down: bool,
}

impl Pin {
    /// Returns what tells a pin from all others.
    pub fn id(&self) -> String {
        format!("{}:{}", self.mcu, self.name)
    }

    /// Returns whether another section makes the pin: `probe:z_virtual_endstop`.
    pub fn is_virtual(&self) -> bool {
        self.name.ends_with("virtual_endstop") || self.name.starts_with("virtual_pin")
    }
}

/// Names that `[board_pins]` gives to pins, by controller.
#[derive(Debug, Default)]
pub struct Aliases(BTreeMap<(String, String), String>);

impl Aliases {
    /// Reads all `[board_pins]` of a file.
    pub fn of(source: &Source) -> Self {
        let mut names = BTreeMap::new();
        for section in source.sections.iter().filter(|section| section.kind() == "board_pins") {
            let of = section.get("mcu").unwrap_or("mcu");
            let lists = section.options.iter().filter(|option| option.name.starts_with("aliases"));
            for (alias, pin) in lists.flat_map(|list| list.value.split(',')).filter_map(|pair| pair.split_once('=')) {
                for mcu in of.split(',').map(str::trim) {
                    names.insert((mcu.to_owned(), alias.trim().to_owned()), pin.trim().to_owned());
                }
            }
        }
        Self(names)
    }

    /// Reads a pin; none where it is empty.
    pub fn pin(&self, text: &str) -> Option<Pin> {
        let mut pin = Pin { mcu: "mcu".to_owned(), ..Pin::default() };
        let mut rest = text.trim();
        while let Some(first) = rest.chars().next() {
            match first {
                '!' => pin.is_inverted = !pin.is_inverted,
                '^' => pin.is_pulled_up = true,
                '~' => pin.is_pulled_down = true,
                c if c.is_whitespace() => {}
                _ => break,
            }
            rest = rest.get(first.len_utf8()..)?;
        }
        if let Some((mcu, name)) = rest.split_once(':') {
            pin.mcu = mcu.trim().to_owned();
            rest = name;
        }
        let mut name = rest.trim().to_owned();
        // An alias may stand for another one; a circle of them ends after so many.
        for _ in 0..8 {
            match self.0.get(&(pin.mcu.clone(), name.clone())) {
                Some(other) => name = other.clone(),
                None => break,
            }
        }
        pin.name = name;
        (!pin.name.is_empty()).then_some(pin)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::migrate::klipper::source::{Entry, Section};

    fn aliases(lists: &[(&str, &str, &str)]) -> Aliases {
        let section = |(mcu, option, value): &(&str, &str, &str)| {
            let entry = |name: &str, value: &str| Entry { name: name.into(), value: value.into(), ..Entry::default() };
            let options = vec![entry("mcu", mcu), entry(option, value)];
            Section { name: "board_pins x".into(), options, ..Section::default() }
        };
        Aliases::of(&Source { sections: lists.iter().map(section).collect(), ..Source::default() })
    }

    #[test]
    fn signs_controllers_and_aliases_are_read() {
        let names = aliases(&[
            ("mcu", "aliases", "\nEXP1_1=PE8, EXP1_2=PE9,\nBEEP=EXP1_1"),
            ("z", "aliases_more", "STOP=P1.2"),
        ]);
        let pin = |text: &str| names.pin(text).unwrap_or_default();
        assert_eq!(pin("^!PA4"), Pin { is_inverted: true, is_pulled_up: true, ..pin("PA4") });
        assert_eq!(pin("! ~ z:STOP").id(), "z:P1.2");
        assert_eq!(pin("BEEP").id(), "mcu:PE8", "an alias of an alias");
        assert_eq!(pin("STOP").id(), "mcu:STOP", "aliases belong to their controller");
        assert!(pin("probe:z_virtual_endstop").is_virtual() && pin("tmc2209_stepper_x:virtual_endstop").is_virtual());
        assert_eq!(names.pin("^"), None);
    }

    #[test]
    fn a_circle_of_aliases_ends() {
        let names = aliases(&[("mcu", "aliases", "A=B, B=A")]);
        assert!(names.pin("A").is_some());
    }
}
