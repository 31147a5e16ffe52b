//! The plane that arcs lie in.

use crate::Axis;

/// Plane of an arc; the axis that is left out is the helix axis.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Plane {
    /// G17: the plane of X and Y.
    #[default]
    Xy,
    /// G18: X and Z, in this order: counter-clockwise turns X towards Z. Smoothieware's way, and the mirror
    /// image of RS274's, which looks at the plane from +Y.
    Xz,
    /// G19: the plane of Y and Z.
    Yz,
}

impl Plane {
    /// Returns the first and the second axis, so that counter-clockwise turns the first towards the second.
    #[must_use]
    pub const fn axes(self) -> (Axis, Axis) {
        match self {
            Self::Xy => (Axis::X, Axis::Y),
            Self::Xz => (Axis::X, Axis::Z),
            Self::Yz => (Axis::Y, Axis::Z),
        }
    }
}
