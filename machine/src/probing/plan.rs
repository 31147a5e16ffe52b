//! Which grid is to be touched.

use motion::GridShape;

/// A grid to touch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Plan {
    /// Where its points are.
    pub shape: GridShape,
    /// Only points within this distance of the middle, mm.
    pub radius: Option<f64>,
    /// Heights are told from that of the bed here.
    pub reference: [f64; 2],
    /// Height from which the bed is searched for.
    pub from: f64,
    /// The machine is levelled by it; else what was found is only shown.
    pub levels: bool,
}

impl Plan {
    /// Whether this place is to be touched, or worked out from what is.
    pub fn touches(&self, [x, y]: [f64; 2]) -> bool {
        self.radius.is_none_or(|radius| x * x + y * y <= radius * radius)
    }
}
