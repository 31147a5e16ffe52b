//! Splines of several lines: what G5 and G5.2 leave for the lines that follow.

use heapless::Vec;

use crate::action::{ControlPoint, MOST_POINTS};

/// What a spline needs to know of the lines before it.
#[derive(Clone, Debug, Default)]
pub(crate) struct Splines {
    /// From the end of the last move, if that was a G5, to where its direction goes on: the next one's I and
    /// J.
    pub onward: Option<(f64, f64)>,
    /// Order of the NURBS whose control points come in.
    pub open: Option<u8>,
    /// Its control points; those of the last one until the next begins.
    pub points: Vec<ControlPoint, MOST_POINTS>,
}

impl Splines {
    /// The control points of the NURBS that was closed last.
    pub fn closed(&self) -> &[ControlPoint] {
        &self.points
    }
}
