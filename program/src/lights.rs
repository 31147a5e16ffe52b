//! What is asked of lights.

/// A change of the colour of lights (M150).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LightChange {
    /// The strip, by its place in the configuration's list; none: every one.
    pub strip: Option<u8>,
    /// Which lights of it.
    pub which: Lights,
    /// How bright red, green, blue and white are to be, 0 to 255; what is none stays as it is.
    pub parts: [Option<u8>; 4],
    /// It is seen at once; else with the next change of the strip that is.
    pub shown: bool,
    /// It happens where the path has come to it; else now, whatever moves.
    pub rides: bool,
}

/// Lights of a strip.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lights {
    /// All of them.
    All,
    /// The one at this place, from 0.
    One(u16),
    /// So many, from where the last ones ended; more are to follow, or the next ones begin anew.
    Next {
        /// How many.
        count: u16,
        /// Whether more follow.
        more: bool,
    },
}
