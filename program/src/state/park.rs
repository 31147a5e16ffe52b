//! The park positions of G28 and G30.

use units::Axis;

/// Position in machine coordinates, mm. Z takes part only if it was stored.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ParkPosition {
    /// X in machine coordinates, mm.
    pub x: f64,
    /// Y in machine coordinates, mm.
    pub y: f64,
    /// Z in machine coordinates, mm, if Z can be homed.
    pub z: Option<f64>,
}

impl ParkPosition {
    /// Returns the stored coordinate of an axis.
    pub(crate) fn of(&self, axis: Axis) -> Option<f64> {
        match axis {
            Axis::X => Some(self.x),
            Axis::Y => Some(self.y),
            Axis::Z => self.z,
            _ => None,
        }
    }
}
