//! How rows of the schema are written: one call per type, then what is special about the row.

use super::{CannotCreate, Docs, Fallback, Kind, PinRole, Set, Setting, Since, Support};
use crate::diagnostic::Severity;
use crate::machine::{CommandCode, MachineConfig, Name};
use crate::pin::{PinName, VoltageInput};

/// Any number a machine could mean.
pub const ANY: (f64, f64) = (-1e9, 1e9);
/// Zero or more.
pub const NOT_NEGATIVE: (f64, f64) = (0.0, 1e9);
/// More than zero.
pub const POSITIVE: (f64, f64) = (1e-9, 1e9);

const fn row(key: &'static str, kind: Kind, default: Fallback, summary: &'static str) -> Setting {
    Setting {
        key,
        is_common: false,
        kind,
        unit: "",
        typical: None,
        default,
        by_name: &[],
        docs: Docs::new(summary),
        v1: "",
        klipper: "",
        support: Support::Now,
    }
}

type Text = &'static str;

pub const fn bool(key: Text, default: Text, set: Set<bool>, summary: Text) -> Setting {
    row(key, Kind::Bool(set), Fallback::Value(default), summary)
}

pub const fn integer(key: Text, default: Text, range: (i64, i64), set: Set<i64>, summary: Text) -> Setting {
    row(key, Kind::Integer(range, set), Fallback::Value(default), summary)
}

pub const fn number(key: Text, default: Text, range: (f64, f64), set: Set<f64>, summary: Text) -> Setting {
    row(key, Kind::Number(range, set), Fallback::Value(default), summary)
}

pub const fn numbers(
    key: Text,
    count: usize,
    set: for<'v> fn(&mut MachineConfig, usize, &'v [f64]),
    summary: Text,
) -> Setting {
    row(key, Kind::Numbers(count, set), Fallback::Value(""), summary)
}

pub const fn places(
    key: Text,
    most: usize,
    set: for<'v> fn(&mut MachineConfig, usize, &'v [[f64; 2]]),
    summary: Text,
) -> Setting {
    row(key, Kind::Places(most, set), Fallback::Value(""), summary).unit("mm")
}

pub const fn word(key: Text, default: Text, words: &'static [&'static str], set: Set<usize>, summary: Text) -> Setting {
    row(key, Kind::Word(words, set), Fallback::Value(default), summary)
}

pub const fn text(
    key: Text,
    default: Text,
    longest: usize,
    set: for<'v> fn(&mut MachineConfig, usize, &'v str),
    summary: Text,
) -> Setting {
    row(key, Kind::Text(longest, set), Fallback::Value(default), summary)
}

pub const fn command(key: Text, set: Set<Option<CommandCode>>, summary: Text) -> Setting {
    row(key, Kind::Command(set), Fallback::Value(""), summary)
}

pub const fn registers(key: Text, set: Set<Option<[u32; 5]>>, summary: Text) -> Setting {
    row(key, Kind::Registers(set), Fallback::Value(""), summary)
}

pub const fn axes(key: Text, set: for<'v> fn(&mut MachineConfig, usize, &'v [units::Axis]), summary: Text) -> Setting {
    row(key, Kind::Axes(set), Fallback::Value(""), summary)
}

pub const fn pin(key: Text, default: Text, role: PinRole, set: Set<Option<PinName>>, summary: Text) -> Setting {
    row(key, Kind::Pin(role, set), Fallback::Value(default), summary)
}

pub const fn voltage(key: Text, set: Set<(VoltageInput, f64)>, summary: Text) -> Setting {
    row(key, Kind::Voltage(set), Fallback::Required, summary)
}

impl Setting {
    pub(super) const fn unit(self, unit: Text) -> Self {
        Self { unit, ..self }
    }

    /// A value outside, unless it is 0 or less, is probably meant in another unit.
    pub(super) const fn typical(self, low: f64, high: f64) -> Self {
        Self { typical: Some((low, high)), ..self }
    }

    pub(super) const fn v1(self, v1: Text) -> Self {
        Self { v1, ..self }
    }

    pub(super) const fn klipper(self, klipper: Text) -> Self {
        Self { klipper, ..self }
    }

    pub(super) const fn common(self) -> Self {
        Self { is_common: true, ..self }
    }

    pub(super) const fn by_name(self, by_name: &'static [(&'static str, &'static str)]) -> Self {
        Self { by_name, ..self }
    }

    pub(super) const fn derived(self, how: Text) -> Self {
        Self { default: Fallback::Derived, docs: self.docs.derived(how), ..self }
    }

    pub(super) const fn required(self) -> Self {
        Self { default: Fallback::Required, ..self }
    }

    pub(super) const fn velvet(self) -> Self {
        Self { docs: self.docs.since(Since::Velvet), ..self }
    }

    /// Reported as an error when it is used: the machine would do something else than meant.
    pub(super) const fn not_yet(self, advice: Text) -> Self {
        Self { support: Support::NotYet { severity: Severity::Error, advice }, ..self }
    }

    /// Reported as a warning when it is used: the machine works without.
    pub(super) const fn not_yet_harmless(self, advice: Text) -> Self {
        Self { support: Support::NotYet { severity: Severity::Warning, advice }, ..self }
    }

    /// Velvet has no use for it.
    pub(super) const fn needless(self, why: Text) -> Self {
        Self { support: Support::Needless { why }, ..self }
    }

    pub(super) const fn dormant(self) -> Self {
        Self { support: Support::Dormant, ..self }
    }
}

/// The place of settings that nothing reads yet.
pub const fn nowhere<T: Copy>(_: &mut MachineConfig, _: usize, _: T) {}
/// The same for texts.
pub const fn no_text(_: &mut MachineConfig, _: usize, _: &str) {}

/// An instance's name, when it is short enough.
pub fn new_name(name: &str) -> Result<Name, CannotCreate> {
    Name::try_from(name).map_err(|_| CannotCreate::NameTooLong)
}
