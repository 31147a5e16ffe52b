//! The documentation of sections and settings. The board's image leaves it out.

use super::Since;

/// What the settings reference says of a section or a setting.
#[cfg(any(test, feature = "std"))]
#[derive(Clone, Copy, Debug)]
pub struct Docs {
    /// What it is for, in one or two sentences.
    pub summary: &'static str,
    /// Who had it first.
    pub since: Since,
    /// What a missing line means, where that is worked out from other settings; empty elsewhere.
    pub derived: &'static str,
    /// The setting of Klipper that is nearest, as `[section] key`; empty for none. Units and meaning may
    /// differ.
    pub klipper: &'static str,
}

/// The same in an image: nothing of it.
#[cfg(not(any(test, feature = "std")))]
#[derive(Clone, Copy, Debug)]
pub struct Docs;

#[cfg(any(test, feature = "std"))]
impl Docs {
    pub(super) const fn new(summary: &'static str) -> Self {
        Self { summary, since: Since::Smoothieware, derived: "", klipper: "" }
    }

    pub(super) const fn since(self, since: Since) -> Self {
        Self { since, ..self }
    }

    pub(super) const fn derived(self, derived: &'static str) -> Self {
        Self { derived, ..self }
    }

    pub(super) const fn klipper(self, klipper: &'static str) -> Self {
        Self { klipper, ..self }
    }
}

#[cfg(not(any(test, feature = "std")))]
impl Docs {
    pub(super) const fn new(_: &'static str) -> Self {
        Self
    }

    pub(super) const fn since(self, _: Since) -> Self {
        self
    }

    pub(super) const fn derived(self, _: &'static str) -> Self {
        self
    }

    pub(super) const fn klipper(self, _: &'static str) -> Self {
        self
    }
}
