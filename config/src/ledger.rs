//! Line of each setting in the file, and requested pins: data for the checks after the text is gone.

use crate::machine::MachineConfig;
use crate::module::Module;
use crate::pin::PinName;
use crate::schema::{Form, SECTIONS, Section, Setting};
use crate::text::cut;
use heapless::{String, Vec};

/// Settings a file can write. A full printer configuration has about 150.
pub(crate) const MAX_WRITTEN: usize = 512;
const MAX_PINS: usize = 200;
const MAX_WISHES: usize = 64;
/// Beyond these, findings that only follow from others are reported too.
const MAX_UNREADABLE: usize = 32;

/// The place of what is common to all instances.
const NO_INSTANCE: u8 = u8::MAX;

/// A setting of an instance. Positions in [`SECTIONS`] and in its settings, and the instance's place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Path {
    pub(crate) section: u8,
    pub(crate) setting: u8,
    pub(crate) place: u8,
}

impl Path {
    pub(crate) fn new(section: usize, setting: usize, place: usize) -> Self {
        let row = SECTIONS.get(section).and_then(|section| section.settings.get(setting));
        let place = if row.is_some_and(|row| row.is_common) { NO_INSTANCE } else { place as u8 };
        // The schema has fewer than 256 of each; a test holds it to that.
        Self { section: section as u8, setting: setting as u8, place }
    }

    /// By name; the setting may be common or an instance's.
    pub(crate) fn named(section: &str, place: usize, key: &str) -> Option<Self> {
        let (index, section) = crate::schema::section(section)?;
        let setting = section.settings.iter().position(|setting| setting.key == key)?;
        Some(Self::new(index, setting, place))
    }

    pub(crate) fn section(self) -> Option<&'static Section> {
        SECTIONS.get(usize::from(self.section))
    }

    pub(crate) fn setting(self) -> Option<&'static Setting> {
        self.section()?.settings.get(usize::from(self.setting))
    }

    /// Returns the part of the machine that stays off when this setting cannot be used.
    pub(crate) fn module(self, config: &MachineConfig) -> Module<'_> {
        let Some(section) = self.section() else { return Module::MACHINE };
        let name = section.instances().filter(|_| self.place != NO_INSTANCE);
        Module::new(section, name.map_or("", |instances| (instances.name)(config, usize::from(self.place))))
    }

    /// `[switch] fan.output_pin`
    pub(crate) fn text(self, config: &MachineConfig) -> String<72> {
        let (Some(section), Some(setting)) = (self.section(), self.setting()) else { return String::new() };
        let name = section.instances().map_or("", |instances| (instances.name)(config, usize::from(self.place)));
        match section.form {
            Form::Plain => cut(format_args!("[{}] {}", section.name, setting.key)),
            Form::Named(_) if setting.is_common => cut(format_args!("[{}] common.{}", section.name, setting.key)),
            Form::Named(_) if name.is_empty() => cut(format_args!("[{}] {}", section.name, setting.key)),
            Form::Named(_) => cut(format_args!("[{}] {name}.{}", section.name, setting.key)),
            Form::Keyed(_) => cut(format_args!("[{}] {name}", section.name)),
        }
    }
}

/// A stretch of a line. Line 0: nowhere in the file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Span {
    pub(crate) line: u16,
    pub(crate) column: u8,
    pub(crate) length: u8,
}

/// Everything the reader remembers of the file beside the description itself.
#[derive(Default)]
pub(crate) struct Ledger {
    written: Vec<(Path, Span), MAX_WRITTEN>,
    /// Settings whose value could not be read: what follows from that is not reported again.
    unreadable: Vec<Path, MAX_UNREADABLE>,
    /// Settings that have been warned of for an implausible value: one warning is enough.
    doubted: Vec<Path, MAX_UNREADABLE>,
    pins: Vec<(Path, PinName), MAX_PINS>,
    /// Settings that ask for what Velvet cannot do yet.
    wishes: Vec<(Path, Span), MAX_WISHES>,
    /// Bit n: section n has been opened.
    pub(crate) sections: u128,
    /// Bit n: a key that section n does not have has been reported, and nothing of the section is supported.
    reported: u128,
}

impl Ledger {
    /// Notes the span of a setting and returns its earlier span. A full ledger forgets spans, not values.
    pub(crate) fn write(&mut self, path: Path, span: Span) -> Result<Option<Span>, Span> {
        match self.written.iter_mut().find(|(known, _)| *known == path) {
            Some((_, at)) => Ok(Some(core::mem::replace(at, span))),
            None => self.written.push((path, span)).map(|()| None).map_err(|(_, span)| span),
        }
    }

    /// Notes that a setting asks for what is not supported yet. False: there is no room.
    pub(crate) fn wish(&mut self, path: Path, span: Span) -> bool {
        self.wishes.push((path, span)).is_ok()
    }

    pub(crate) fn wishes(&self) -> &[(Path, Span)] {
        &self.wishes
    }

    /// Notes that the value of a setting could not be read.
    pub(crate) fn mark_unreadable(&mut self, path: Path) {
        let _ = self.unreadable.push(path);
    }

    pub(crate) fn is_unreadable(&self, path: Path) -> bool {
        self.unreadable.contains(&path)
    }

    /// Notes that the value of a setting is implausible.
    pub(crate) fn doubt(&mut self, path: Path) {
        let _ = self.doubted.push(path);
    }

    pub(crate) fn is_doubted(&self, path: Path) -> bool {
        self.doubted.contains(&path)
    }

    /// Returns the span of a written setting; none when its default stands.
    pub(crate) fn span(&self, path: Path) -> Option<Span> {
        self.written.iter().find(|(known, _)| *known == path).map(|&(_, span)| span)
    }

    /// The first written setting of an instance.
    pub(crate) fn first_of(&self, section: u8, place: u8) -> Option<Span> {
        self.written.iter().find(|(path, _)| (path.section, path.place) == (section, place)).map(|&(_, span)| span)
    }

    /// Returns true the first time for a section.
    pub(crate) fn tell_once(&mut self, section: &str) -> bool {
        let bit = crate::schema::section(section).map_or(0, |(index, _)| 1 << index);
        let is_new = self.reported & bit == 0;
        self.reported |= bit;
        is_new
    }

    /// Returns the span a finding points at: the setting's value, or the name of its instance when a default
    /// stands.
    pub(crate) fn place(&self, path: Path, config: &MachineConfig) -> Span {
        let name = path
            .section()
            .and_then(Section::instances)
            .map_or(0, |instances| (instances.name)(config, usize::from(path.place)).len());
        let of_instance =
            || self.first_of(path.section, path.place).map(|span| Span { column: 1, length: name as u8, ..span });
        self.span(path).or_else(of_instance).unwrap_or_default()
    }

    /// Notes the pin of a setting; none takes its claim back.
    pub(crate) fn ask(&mut self, path: Path, pin: Option<PinName>) {
        self.pins.retain(|(known, _)| *known != path);
        if let Some(pin) = pin {
            // There are fewer settings with pins than places: a test counts them.
            let _ = self.pins.push((path, pin));
        }
    }

    pub(crate) fn pins(&self) -> &[(Path, PinName)] {
        &self.pins
    }

    pub(crate) fn has_section(&self, name: &str) -> bool {
        crate::schema::section(name).is_some_and(|(index, _)| self.sections & (1 << index) != 0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::schema::{CannotCreate, Kind};

    /// Returns the greatest number of instances of a section.
    fn most(section: &Section) -> usize {
        let Some(instances) = section.instances() else { return 1 };
        if instances.noun == crate::schema::UNREAD {
            return 1;
        }
        let mut config = MachineConfig::default();
        for place in 0.. {
            match (instances.create)(&mut config, &std::format!("n{place}")) {
                Ok(_) => {}
                Err(CannotCreate::UnknownName(names)) => return names.len(),
                Err(_) => return place,
            }
        }
        unreachable!("every list is full at some time")
    }

    #[test]
    fn there_is_a_place_for_every_pin_that_a_file_can_ask_for() {
        let is_pin = |setting: &&Setting| matches!(setting.kind, Kind::Pin(..));
        let of = |section: &Section| {
            let common = section.settings.iter().filter(is_pin).filter(|setting| setting.is_common).count();
            let own = section.settings.iter().filter(is_pin).count() - common;
            common + own * most(section)
        };
        let pins: usize = SECTIONS.iter().map(of).sum();
        assert!(pins <= MAX_PINS, "{pins} settings with pins, {MAX_PINS} places");
    }
}
