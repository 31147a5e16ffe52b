//! The park positions of G28 and G30.

use units::Axis;

/// A place in machine coordinates, mm. Z takes part only where it was stored.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ParkPosition {
    /// X.
    pub x: f64,
    /// Y.
    pub y: f64,
    /// Z, where it can be homed.
    pub z: Option<f64>,
}

impl ParkPosition {
    /// What was stored for an axis.
    pub(crate) fn of(&self, axis: Axis) -> Option<f64> {
        match axis {
            Axis::X => Some(self.x),
            Axis::Y => Some(self.y),
            Axis::Z => self.z,
            _ => None,
        }
    }
}
