//! Changes of lights (M150).

/// A change of the colour of lights (M150).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LightChange {
    /// Strip by its index in the configuration's list; `None` means every strip.
    pub strip: Option<u8>,
    /// Lights of the strip that change.
    pub which: Lights,
    /// Brightness of red, green, blue and white, 0 to 255; `None` leaves a colour as it is.
    pub parts: [Option<u8>; 4],
    /// Whether the change is shown at once; otherwise with the strip's next change that is shown.
    pub shown: bool,
    /// Whether the change waits for its point of the path; otherwise it happens at once.
    pub rides: bool,
}

/// Selection of lights of a strip.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lights {
    /// Every light of the strip.
    All,
    /// Light at this index, from 0.
    One(u16),
    /// Group of lights that begins at the end of the previous group.
    Next {
        /// Number of lights in the group.
        count: u16,
        /// Whether the next group continues here; otherwise it begins at the first light.
        more: bool,
    },
}
