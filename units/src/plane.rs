//! The plane that arcs lie in.

use crate::Axis;

/// The plane of an arc; the axis that is left out is the helix axis.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Plane {
    /// G17: X and Y.
    #[default]
    Xy,
    /// G18: X and Z, in this order: counter-clockwise turns X towards Z. Smoothieware's way, and the mirror
    /// image of RS274's, which looks at the plane from +Y.
    Xz,
    /// G19: Y and Z.
    Yz,
}

impl Plane {
    /// First and second axis, so that counter-clockwise turns the first towards the second.
    #[must_use]
    pub const fn axes(self) -> (Axis, Axis) {
        match self {
            Self::Xy => (Axis::X, Axis::Y),
            Self::Xz => (Axis::X, Axis::Z),
            Self::Yz => (Axis::Y, Axis::Z),
        }
    }
}
