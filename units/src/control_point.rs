//! Control points of curves.

/// Greatest number of control points of a NURBS.
pub const MOST_CONTROL_POINTS: usize = 32;

/// A control point of a NURBS.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ControlPoint {
    /// Machine X of the point, mm.
    pub x: f64,
    /// Machine Y of the point, mm.
    pub y: f64,
    /// Weight: strength with which the point attracts the curve, above zero.
    pub weight: f64,
}
