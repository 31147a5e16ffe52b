//! Plan of a grid of touches.

use motion::GridShape;

/// Grid of touches for leveling or a report.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plan {
    /// Places of the points.
    pub shape: GridShape,
    /// Greatest distance of a point from the middle, mm.
    pub radius: Option<f64>,
    /// Place of the bed whose height counts as zero.
    pub reference: [f64; 2],
    /// Height from which the bed is searched for.
    pub from: f64,
    /// Whether the machine is levelled by the grid; otherwise the heights are only shown.
    pub levels: bool,
}

impl Plan {
    /// Returns whether this place is to be touched; otherwise its height is computed from touches.
    pub fn touches(&self, [x, y]: [f64; 2]) -> bool {
        self.radius.is_none_or(|radius| x * x + y * y <= radius * radius)
    }
}
