//! A section of the file: its settings, the form of its lines, its instances.

use crate::machine::MachineConfig;
use crate::setting::value::Value;
use crate::setting::{Docs, Setting};

/// The noun of instances that nothing keeps yet.
pub(crate) const UNREAD: &str = "entry";

/// A section of the file.
pub struct Section {
    /// The text between the brackets.
    pub name: &'static str,
    /// Documentation of the section.
    pub docs: Docs,
    /// Form of the section's lines.
    pub form: Form,
    /// Consequence of an error in the section.
    pub scope: Scope,
    /// Settings of the section.
    pub settings: &'static [Setting],
    /// Stores a value of the setting at a place.
    pub(crate) store: Store,
}

/// Stores a value in the description: the place of the instance, the place of the setting, the value.
pub(crate) type Store = for<'v> fn(&mut MachineConfig, usize, usize, &'v Value<'v>);

/// Consequence of an error in a section.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scope {
    /// The machine does not start: motion or safety depends on the section.
    Machine,
    /// Everything configured by the section stays off.
    Section,
    /// The instance stays off; all of them, when nobody can tell which is meant.
    Instance,
}

/// Form of the lines in a section.
#[derive(Clone, Copy)]
pub enum Form {
    /// Lines `key = value` without instances.
    Plain,
    /// Lines `name.key = value`, with `common.key` where a setting says so.
    Named(Instances),
    /// Lines `name = value`: each key is an instance's name, and there is one setting.
    Keyed(Instances),
}

/// Access to the instances of a section in the description.
#[derive(Clone, Copy)]
pub struct Instances {
    /// Noun for an instance in messages: `motor`, `switch`.
    pub noun: &'static str,
    /// Finds the place of an existing instance.
    pub find: fn(&MachineConfig, &str) -> Option<usize>,
    /// Makes a place for a new instance.
    pub create: fn(&mut MachineConfig, &str) -> Result<usize, CannotCreate>,
    /// Returns the name of the instance at a place.
    pub name: fn(&MachineConfig, usize) -> &str,
    /// Returns whether the instance at a place takes part, so that its pins are claimed.
    pub is_live: fn(&MachineConfig, usize) -> bool,
}

/// Reason why an instance cannot be made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CannotCreate {
    /// There are this many already.
    Full(usize),
    /// Only these names exist.
    UnknownName(&'static [&'static str]),
    /// The name is longer than 24 characters.
    NameTooLong,
}

impl Section {
    /// Returns the instances, when the section has any.
    #[must_use]
    pub const fn instances(&self) -> Option<&Instances> {
        match &self.form {
            Form::Plain => None,
            Form::Named(instances) | Form::Keyed(instances) => Some(instances),
        }
    }

    /// Returns the place of a setting in [`Section::settings`].
    #[must_use]
    pub fn position(&self, key: &str, is_common: bool) -> Option<usize> {
        self.settings.iter().position(|setting| setting.key == key && setting.is_common == is_common)
    }
}
