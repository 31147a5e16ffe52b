//! State of splines between lines: data of G5 and G5.2 for later lines.

use heapless::Vec;
use units::{ControlPoint, MOST_CONTROL_POINTS};

/// State that a spline needs from earlier lines.
#[derive(Clone, Debug, Default)]
pub(crate) struct Splines {
    /// Default I and J of the next G5: the direction in which the previous G5 ended. `None` behind other
    /// moves.
    pub onward: Option<(f64, f64)>,
    /// Order of the NURBS whose control points are being read.
    pub open: Option<u8>,
    /// Control points of the current or last NURBS, kept until the next begins.
    pub points: Vec<ControlPoint, MOST_CONTROL_POINTS>,
}

impl Splines {
    /// Returns the control points of the last completed NURBS.
    pub fn closed(&self) -> &[ControlPoint] {
        &self.points
    }
}
