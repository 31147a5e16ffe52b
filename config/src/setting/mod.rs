//! A setting of the file: its row in the schema, its value, its declaration.
//!
//! A row holds a setting's type, range, unit, default, meaning and its name in the previous generation. The
//! declaration of a section ([`declare`]) gives its rows and the struct that holds the values.

pub(crate) mod build;
pub(crate) mod declare;
mod docs;
pub(crate) mod field;
pub(crate) mod flaw;
mod lists;
pub(crate) mod value;

use crate::diagnostic::Severity;
pub use docs::Docs;
pub use lists::{KlipperSection, Unit};

/// A setting of the schema. There are some 700 rows, so rare or often repeated data is behind a reference.
#[derive(Clone, Copy)]
pub struct Setting {
    /// The key, without the instance's name.
    pub key: &'static str,
    /// Whether the key is `common.key` rather than `name.key` (or `key`, in a plain section).
    pub is_common: bool,
    /// Type and range of the value.
    pub kind: Kind,
    /// Unit of the value in the file.
    pub unit: Unit,
    /// Typical range of machines, where a wrong unit is an easy slip. Values beyond it are taken, with a
    /// warning.
    pub typical: Option<&'static (f64, f64)>,
    /// Whether Velvet can do no more than `typical`: a value beyond is taken as the nearest within, with a
    /// warning.
    pub is_limited: bool,
    /// Default for [`Setting::fallback`]: the text, and whether a missing text is derived.
    default: Option<&'static str>,
    is_derived: bool,
    /// Defaults of instances with these names, and of boards with these drivers (`tmc2660 board`).
    pub by_name: &'static ByName,
    /// Documentation of the setting.
    pub docs: Docs,
    /// Name in Smoothieware v1, with `<axis>` or `<name>`; empty for none.
    pub v1: &'static str,
    /// Section of Klipper with the nearest setting.
    pub klipper_section: KlipperSection,
    /// Whether Velvet acts on it.
    pub support: &'static Support,
}

/// Defaults of some instances: name and value.
pub struct ByName(pub &'static [(&'static str, &'static str)]);

/// The words that a setting takes.
#[derive(Debug, PartialEq, Eq)]
pub struct Words(pub &'static [&'static str]);

/// Meaning of a missing line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fallback {
    /// The default value, read as if the file contained it.
    Value(&'static str),
    /// The value is worked out from other settings.
    Derived,
    /// No default: the line must be there when the instance is used.
    Required,
}

/// Firmware that had a setting first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Since {
    /// Setting taken over from Smoothieware.
    Smoothieware,
    /// Setting of Velvet only.
    Velvet,
}

/// Whether Velvet acts on a setting.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Support {
    /// Velvet acts on the setting.
    Now,
    /// Not yet: a value other than the default is reported, with this advice.
    NotYet {
        /// Severity of going without the setting.
        severity: Severity,
        /// Advice for a replacement.
        advice: &'static str,
    },
    /// Never: there is nothing left for it to change. A value other than the default is reported with the
    /// reason.
    Needless {
        /// Reason why nothing needs the setting.
        why: &'static str,
    },
    /// Part of a function whose own switch is [`Support::NotYet`]; without that switch it does nothing
    /// anyway.
    Dormant,
}

/// The type of a setting, and the values it takes.
#[derive(Clone, Copy)]
pub enum Kind {
    /// Boolean, `true` or `false`.
    Bool,
    /// A whole number from `.0` to `.1`.
    Integer(&'static (i64, i64)),
    /// A number from `.0` to `.1`.
    Number(&'static (f64, f64)),
    /// Given number of numbers, with commas between; an empty value stands for none.
    Numbers(usize),
    /// Up to the given number of places, X and Y each, with commas or blanks between the numbers; an empty
    /// value stands for none.
    Places(usize),
    /// Word of the list, in either case.
    Word(&'static Words),
    /// Text of at most this many bytes.
    Text(usize),
    /// A G or M code such as `M106` or `M106.1`; an empty value stands for none.
    Command,
    /// Five hexadecimal numbers with commas between; an empty value stands for none.
    Registers,
    /// Axis letters, as in `ZXY`.
    Axes,
    /// Pin with the given capability.
    Pin(PinRole),
    /// A voltage input and an optional scale: `ADC3_5,11`.
    Voltage,
}

/// Capability that a setting needs of its pin.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PinRole {
    /// A GPIO output pin.
    Output,
    /// A GPIO input, read now and then.
    Input,
    /// A GPIO input, read now and then, or `external`.
    Button,
    /// A GPIO input that needs an interrupt line of its own.
    Interrupt,
    /// A GPIO output or a timer channel.
    OutputOrPwm,
    /// A channel of a PWM timer.
    Pwm,
    /// An analogue thermistor input.
    Thermistor,
}

impl Setting {
    /// Returns the meaning of a missing line.
    #[must_use]
    pub const fn fallback(&self) -> Fallback {
        match (self.default, self.is_derived) {
            (Some(text), _) => Fallback::Value(text),
            (None, true) => Fallback::Derived,
            (None, false) => Fallback::Required,
        }
    }

    /// Returns the default of the instance with this name, as text; none when it has to be derived or
    /// written.
    #[must_use]
    pub fn default_for(&self, instance: &str) -> Option<&'static str> {
        let own = self.by_name.0.iter().find(|(name, _)| *name == instance);
        own.map_or(self.default, |&(_, value)| Some(value))
    }
}
