//! Pending work about firmware, from one look to the next.

/// Pending work about the firmware that runs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Watch {
    pub is_confirmed: bool,
    /// The firmware came from the file on the card, which is to be renamed.
    pub from_file: bool,
    /// The card's file is to be looked at.
    pub at_boot: bool,
    /// A host has asked for the download.
    pub is_asked: bool,
}

impl Watch {
    /// Whether there may be something to do when nothing else is.
    pub(crate) const fn waits(self) -> bool {
        self.is_asked || self.at_boot || self.from_file
    }
}
