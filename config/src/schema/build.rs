//! Builders for rows of the schema: a function per type, then methods for the special properties of a row.

use super::{ByName, CannotCreate, Docs, Kind, KlipperSection, PinRole, Set, Setting, Since, Support, Unit, Words};
use crate::machine::{CommandCode, MachineConfig, Name};
use crate::pin::{PinName, VoltageInput};

/// Any number a machine could mean.
pub const ANY: &(f64, f64) = &(-1e9, 1e9);
/// Range of zero or more.
pub const NOT_NEGATIVE: &(f64, f64) = &(0.0, 1e9);
/// Range of more than zero.
pub const POSITIVE: &(f64, f64) = &(1e-9, 1e9);

type Text = &'static str;

const fn row(key: Text, kind: Kind, default: Option<Text>, summary: Text) -> Setting {
    Setting {
        key,
        is_common: false,
        kind,
        unit: Unit::NONE,
        typical: None,
        is_limited: false,
        default,
        is_derived: false,
        by_name: &ByName(&[]),
        docs: Docs::new(summary),
        v1: "",
        klipper_section: KlipperSection::NONE,
        support: &Support::Now,
    }
}

pub const fn bool(key: Text, default: Text, set: Set<bool>, summary: Text) -> Setting {
    row(key, Kind::Bool(set), Some(default), summary)
}

pub const fn integer(key: Text, default: Text, range: &'static (i64, i64), set: Set<i64>, summary: Text) -> Setting {
    row(key, Kind::Integer(range, set), Some(default), summary)
}

pub const fn number(key: Text, default: Text, range: &'static (f64, f64), set: Set<f64>, summary: Text) -> Setting {
    row(key, Kind::Number(range, set), Some(default), summary)
}

pub const fn numbers(
    key: Text,
    count: usize,
    set: for<'v> fn(&mut MachineConfig, usize, &'v [f64]),
    summary: Text,
) -> Setting {
    row(key, Kind::Numbers(count, set), Some(""), summary)
}

pub const fn places(
    key: Text,
    most: usize,
    set: for<'v> fn(&mut MachineConfig, usize, &'v [[f64; 2]]),
    summary: Text,
) -> Setting {
    row(key, Kind::Places(most, set), Some(""), summary).unit("mm")
}

pub const fn word(key: Text, default: Text, words: &'static Words, set: Set<usize>, summary: Text) -> Setting {
    row(key, Kind::Word(words, set), Some(default), summary)
}

pub const fn text(
    key: Text,
    default: Text,
    longest: usize,
    set: for<'v> fn(&mut MachineConfig, usize, &'v str),
    summary: Text,
) -> Setting {
    row(key, Kind::Text(longest, set), Some(default), summary)
}

pub const fn command(key: Text, set: Set<Option<CommandCode>>, summary: Text) -> Setting {
    row(key, Kind::Command(set), Some(""), summary)
}

pub const fn registers(key: Text, set: Set<Option<[u32; 5]>>, summary: Text) -> Setting {
    row(key, Kind::Registers(set), Some(""), summary)
}

pub const fn axes(key: Text, set: for<'v> fn(&mut MachineConfig, usize, &'v [units::Axis]), summary: Text) -> Setting {
    row(key, Kind::Axes(set), Some(""), summary)
}

pub const fn pin(key: Text, default: Text, role: PinRole, set: Set<Option<PinName>>, summary: Text) -> Setting {
    row(key, Kind::Pin(role, set), Some(default), summary)
}

pub const fn voltage(key: Text, set: Set<(VoltageInput, f64)>, summary: Text) -> Setting {
    row(key, Kind::Voltage(set), None, summary)
}

impl Setting {
    pub(crate) const fn unit(self, unit: Text) -> Self {
        Self { unit: Unit::of(unit), ..self }
    }

    /// A value outside, unless it is 0 or less, is probably meant in another unit.
    pub(crate) const fn typical(self, typical: &'static (f64, f64)) -> Self {
        Self { typical: Some(typical), ..self }
    }

    /// A value outside, which Smoothieware takes, is taken as the nearest within, with a warning.
    pub(crate) const fn limited(self, within: &'static (f64, f64)) -> Self {
        Self { typical: Some(within), is_limited: true, ..self }
    }

    pub(crate) const fn v1(self, v1: Text) -> Self {
        Self { v1, ..self }
    }

    pub(crate) const fn klipper(self, klipper: Text) -> Self {
        Self { klipper_section: KlipperSection::of(klipper), docs: self.docs.klipper(klipper), ..self }
    }

    pub(crate) const fn common(self) -> Self {
        Self { is_common: true, ..self }
    }

    pub(crate) const fn by_name(self, by_name: &'static ByName) -> Self {
        Self { by_name, ..self }
    }

    pub(crate) const fn derived(self, how: Text) -> Self {
        Self { default: None, is_derived: true, docs: self.docs.derived(how), ..self }
    }

    pub(crate) const fn required(self) -> Self {
        Self { default: None, is_derived: false, ..self }
    }

    pub(crate) const fn velvet(self) -> Self {
        Self { docs: self.docs.since(Since::Velvet), ..self }
    }

    /// Sets the support of a setting that Velvet does not act on.
    pub(crate) const fn support(self, support: &'static Support) -> Self {
        Self { support, ..self }
    }

    pub(crate) const fn dormant(self) -> Self {
        Self { support: &Support::Dormant, ..self }
    }
}

/// The place of settings that nothing reads yet.
pub const fn nowhere<T: Copy>(_: &mut MachineConfig, _: usize, _: T) {}
/// The place of texts that nothing reads yet.
pub const fn no_text(_: &mut MachineConfig, _: usize, _: &str) {}

/// An instance's name, when it is short enough.
pub fn new_name(name: &str) -> Result<Name, CannotCreate> {
    Name::try_from(name).map_err(|_| CannotCreate::NameTooLong)
}
