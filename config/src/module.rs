//! Parts of the machine that can stay off alone, and the consequences of an error in the file for each.

use crate::off::OffModule;
use crate::schema::{Scope, Section};
use crate::text::cut;
use core::fmt;

/// A part of the machine that a finding is about.
#[derive(Clone, Copy)]
pub(crate) struct Module<'n> {
    section: Option<&'static Section>,
    /// The instance; empty for the section as a whole.
    name: &'n str,
}

impl PartialEq for Module<'_> {
    fn eq(&self, other: &Self) -> bool {
        self.section_name() == other.section_name() && self.name == other.name
    }
}

impl<'n> Module<'n> {
    /// The machine as a whole.
    pub(crate) const MACHINE: Module<'static> = Module { section: None, name: "" };

    /// All of a section.
    pub(crate) const fn whole(section: &'static Section) -> Module<'static> {
        Module { section: Some(section), name: "" }
    }

    /// The instance of this name, or the section as a whole when there is no name or it has none that can be
    /// off alone.
    pub(crate) fn new(section: &'static Section, name: &'n str) -> Self {
        let name = if section.scope == Scope::Instance && name != "common" { name } else { "" };
        Self { section: Some(section), name }
    }

    /// Whether the machine cannot do without it.
    pub(crate) fn is_vital(self) -> bool {
        self.section.is_none_or(|section| section.scope == Scope::Machine)
    }

    fn section_name(self) -> &'static str {
        self.section.map_or("", |section| section.name)
    }

    /// Returns the out-of-service entry of the module, for the finding at this line.
    pub(crate) fn off(self, line: u16, key: &str) -> OffModule {
        OffModule {
            section: self.section_name(),
            name: cut(format_args!("{}", self.name)),
            line,
            key: cut(format_args!("{key}")),
        }
    }
}

impl fmt::Display for Module<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let noun = self.section.and_then(Section::instances).map_or("", |instances| instances.noun);
        write_label(f, self.section_name(), noun, self.name)
    }
}

/// `switch fan`, `every switch` or `[zprobe]`
fn write_label(f: &mut fmt::Formatter<'_>, section: &str, noun: &str, name: &str) -> fmt::Result {
    match (noun, name) {
        ("", _) | (crate::schema::UNREAD, "") => write!(f, "[{section}]"),
        (_, "") => write!(f, "every {noun}"),
        _ => write!(f, "{noun} {name}"),
    }
}

impl OffModule {
    pub(crate) fn is(&self, module: Module<'_>) -> bool {
        self.section == module.section_name() && self.name == module.name
    }
}

impl fmt::Display for OffModule {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let section = crate::schema::section(self.section).and_then(|(_, section)| section.instances());
        write_label(f, self.section, section.map_or("", |instances| instances.noun), &self.name)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::schema::SECTIONS;

    #[test]
    fn only_instances_stay_off_alone() {
        for section in SECTIONS {
            assert!(section.scope != Scope::Instance || section.instances().is_some(), "[{}]", section.name);
        }
    }

    #[test]
    fn what_motion_and_safety_depend_on_is_vital() {
        for name in ["motion control", "actuator", "tmc2590", "current control", "endstops", "kill button", "system"] {
            assert_eq!(crate::schema::section(name).unwrap().1.scope, Scope::Machine, "[{name}]");
        }
    }
}
