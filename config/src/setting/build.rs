//! Builders of a row of the schema, for the declarations of [`super::declare`]: a function per type, which
//! takes the default and the range, then methods for the special properties of a row.

use super::{ByName, Docs, Kind, KlipperSection, PinRole, Setting, Since, Support, Unit, Words};

/// Any number a machine could mean.
pub const ANY: &(f64, f64) = &(-1e9, 1e9);
/// Range of zero or more.
pub const NOT_NEGATIVE: &(f64, f64) = &(0.0, 1e9);
/// Range of more than zero.
pub const POSITIVE: &(f64, f64) = &(1e-9, 1e9);

type Text = &'static str;

const fn row(kind: Kind, default: Option<Text>) -> Setting {
    Setting {
        key: "",
        is_common: false,
        kind,
        unit: Unit::NONE,
        typical: None,
        is_limited: false,
        default,
        is_derived: false,
        by_name: &ByName(&[]),
        docs: Docs::new(""),
        v1: "",
        klipper_section: KlipperSection::NONE,
        support: &Support::Now,
    }
}

/// Returns a setting that is on or off.
pub const fn bool(default: Text) -> Setting {
    row(Kind::Bool, Some(default))
}

/// Returns a whole number within a range.
pub const fn integer(default: Text, range: &'static (i64, i64)) -> Setting {
    row(Kind::Integer(range), Some(default))
}

/// Returns a number within a range.
pub const fn number(default: Text, range: &'static (f64, f64)) -> Setting {
    row(Kind::Number(range), Some(default))
}

/// Returns a list of so many numbers.
pub const fn numbers(count: usize) -> Setting {
    row(Kind::Numbers(count), Some(""))
}

/// Returns a list of places, `x,y;x,y`, so many at most.
pub const fn places(most: usize) -> Setting {
    row(Kind::Places(most), Some("")).unit("mm")
}

/// Returns one of some words.
pub const fn word(default: Text, words: &'static Words) -> Setting {
    row(Kind::Word(words), Some(default))
}

/// Returns a text of so many bytes at most.
pub const fn text(default: Text, longest: usize) -> Setting {
    row(Kind::Text(longest), Some(default))
}

/// Returns lines of G-code or a console command.
pub const fn command() -> Setting {
    row(Kind::Command, Some(""))
}

/// Returns the values of a driver's registers.
pub const fn registers() -> Setting {
    row(Kind::Registers, Some(""))
}

/// Returns a list of axes.
pub const fn axes() -> Setting {
    row(Kind::Axes, Some(""))
}

/// Returns a pin in a role.
pub const fn pin(default: Text, role: PinRole) -> Setting {
    row(Kind::Pin(role), Some(default))
}

/// Returns an analogue input.
pub const fn voltage() -> Setting {
    row(Kind::Voltage, None)
}

impl Setting {
    /// Sets the key and the summary, which the declaration knows.
    pub(crate) const fn named(self, key: Text, summary: Text) -> Self {
        Self { key, docs: self.docs.summary(summary), ..self }
    }

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
