//! What is to be done about firmware, from one look to the next.

/// What is still to be done about the firmware that runs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Watch {
    pub is_confirmed: bool,
    /// It came from the file on the card, which is to have another name.
    pub from_file: bool,
    /// The file is to be looked at.
    pub at_boot: bool,
    /// A host has asked for the download.
    pub is_asked: bool,
}

impl Watch {
    /// There may be something to do when nothing else is.
    pub(super) const fn waits(self) -> bool {
        self.is_asked || self.at_boot || self.from_file
    }
}
