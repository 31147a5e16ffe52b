//! Builders of a row of the schema, for the declarations of [`super::declare`]: a function per type, which
//! takes the default and the range.

use super::build::{no_text, nowhere};
use super::{ByName, Docs, Kind, KlipperSection, PinRole, Setting, Support, Unit, Words};

pub use super::build::{ANY, NOT_NEGATIVE, POSITIVE};

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

pub const fn bool(default: Text) -> Setting {
    row(Kind::Bool(nowhere), Some(default))
}

pub const fn integer(default: Text, range: &'static (i64, i64)) -> Setting {
    row(Kind::Integer(range, nowhere), Some(default))
}

pub const fn number(default: Text, range: &'static (f64, f64)) -> Setting {
    row(Kind::Number(range, nowhere), Some(default))
}

pub const fn numbers(count: usize) -> Setting {
    row(Kind::Numbers(count, |_, _, _| {}), Some(""))
}

pub const fn places(most: usize) -> Setting {
    row(Kind::Places(most, |_, _, _| {}), Some("")).unit("mm")
}

pub const fn word(default: Text, words: &'static Words) -> Setting {
    row(Kind::Word(words, nowhere), Some(default))
}

pub const fn text(default: Text, longest: usize) -> Setting {
    row(Kind::Text(longest, no_text), Some(default))
}

pub const fn command() -> Setting {
    row(Kind::Command(nowhere), Some(""))
}

pub const fn registers() -> Setting {
    row(Kind::Registers(nowhere), Some(""))
}

pub const fn axes() -> Setting {
    row(Kind::Axes(|_, _, _| {}), Some(""))
}

pub const fn pin(default: Text, role: PinRole) -> Setting {
    row(Kind::Pin(role, nowhere), Some(default))
}

pub const fn voltage() -> Setting {
    row(Kind::Voltage(nowhere), None)
}

impl Setting {
    /// Sets the key and the summary, which the declaration knows.
    pub(crate) const fn named(self, key: Text, summary: Text) -> Self {
        Self { key, docs: self.docs.summary(summary), ..self }
    }
}
