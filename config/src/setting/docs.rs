//! The documentation of sections and settings. The board's image leaves it out.

use super::Since;

/// Text about a section or a setting in the settings reference.
#[cfg(any(test, feature = "std"))]
#[derive(Clone, Copy, Debug)]
pub struct Docs {
    /// Purpose of the setting, in one or two sentences.
    pub summary: &'static str,
    /// Firmware that had the setting first.
    pub since: Since,
    /// Meaning of a missing line, where it is derived from other settings; empty elsewhere.
    pub derived: &'static str,
    /// The setting of Klipper that is nearest, as `[section] key`; empty for none. Units and meaning may
    /// differ.
    pub klipper: &'static str,
}

/// Documentation in the image of the board: none.
#[cfg(not(any(test, feature = "std")))]
#[derive(Clone, Copy, Debug)]
pub struct Docs;

#[cfg(any(test, feature = "std"))]
impl Docs {
    pub(crate) const fn new(summary: &'static str) -> Self {
        Self { summary: summary.trim_ascii_start(), since: Since::Smoothieware, derived: "", klipper: "" }
    }

    pub(crate) const fn summary(self, summary: &'static str) -> Self {
        Self { summary: summary.trim_ascii_start(), ..self }
    }

    pub(crate) const fn since(self, since: Since) -> Self {
        Self { since, ..self }
    }

    pub(crate) const fn derived(self, derived: &'static str) -> Self {
        Self { derived, ..self }
    }

    pub(crate) const fn klipper(self, klipper: &'static str) -> Self {
        Self { klipper, ..self }
    }
}

#[cfg(not(any(test, feature = "std")))]
impl Docs {
    pub(crate) const fn new(_: &'static str) -> Self {
        Self
    }

    pub(crate) const fn summary(self, _: &'static str) -> Self {
        self
    }

    pub(crate) const fn since(self, _: Since) -> Self {
        self
    }

    pub(crate) const fn derived(self, _: &'static str) -> Self {
        self
    }

    pub(crate) const fn klipper(self, _: &'static str) -> Self {
        self
    }
}
