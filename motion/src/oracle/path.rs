//! Places on a path, computed from its definition with the standard library's functions.

use units::PerAxis;

use std::vec::Vec;

use crate::path::{Arc, Curve, Path, Spline};

/// The place after `s` mm, and what the next millimetre adds to each axis. A spline needs its table.
pub fn place(path: &Path, table: Option<&Table>, s: f64) -> (PerAxis<f64>, PerAxis<f64>) {
    let mut place = path.origin;
    let mut direction = path.direction;
    for axis in units::Axis::ALL {
        place[axis] += path.direction[axis] * s;
    }
    let (offset, slope) = match &path.curve {
        Curve::Line => return (place, direction),
        Curve::Arc(arc) => circle(arc, s),
        Curve::Spline(spline) => match table {
            Some(table) => table.place(s / spline.length(), spline.length()),
            None => return (place, direction),
        },
    };
    for axis in 0..3 {
        place.0[axis] += offset[axis];
        direction.0[axis] += slope[axis];
    }
    (place, direction)
}

/// A circle around the centre that the start has at the other end of its arm: the arm turned about the axis
/// of rotation, by Rodrigues' formula.
fn circle(arc: &Arc, s: f64) -> ([f64; 3], [f64; 3]) {
    let arm = arc.arm();
    let radius_sq: f64 = arm.iter().map(|part| part * part).sum();
    let axis = cross(arm, arc.ahead()).map(|part| part / radius_sq);
    let angle = arc.angle() * s / arc.length();
    let (sine, cosine) = angle.sin_cos();
    let sideways = cross(axis, arm);
    let turned = [0, 1, 2].map(|n| arm[n] * cosine + sideways[n] * sine);
    let onward = cross(axis, turned);
    let rate = arc.angle() / arc.length();
    ([0, 1, 2].map(|n| turned[n] - arm[n]), onward.map(|part| part * rate))
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// Lengths of a cubic from its beginning to many places: Simpson's rule on each of many short cells.
#[derive(Clone, Debug)]
pub struct Table {
    cubic: [[f64; 3]; 3],
    lengths: Vec<f64>,
}

/// Cells of a table.
const CELLS: usize = 512;

impl Table {
    /// Tabulates a spline.
    pub fn new(spline: &Spline) -> Self {
        let mut table = Self { cubic: *spline.cubic(), lengths: std::vec![0.0] };
        for cell in 0..CELLS {
            let from = cell as f64 / CELLS as f64;
            let so_far = table.lengths.last().copied().unwrap_or_default();
            table.lengths.push(so_far + table.part(from, from + 1.0 / CELLS as f64));
        }
        table
    }

    fn slope(&self, u: f64) -> [f64; 3] {
        [0, 1, 2].map(|n| self.cubic[0][n] + 2.0 * u * self.cubic[1][n] + 3.0 * u * u * self.cubic[2][n])
    }

    fn pace(&self, u: f64) -> f64 {
        self.slope(u).iter().map(|part| part * part).sum::<f64>().sqrt()
    }

    /// Length between two places of a cell.
    fn part(&self, from: f64, to: f64) -> f64 {
        let step = (to - from) / 4.0;
        let at = |n: f64| self.pace(from + n * step);
        step / 3.0 * (at(0.0) + 4.0 * at(1.0) + 2.0 * at(2.0) + 4.0 * at(3.0) + at(4.0))
    }

    /// The place at this share of the way, and what the next of `length` millimetres adds.
    fn place(&self, share: f64, length: f64) -> ([f64; 3], [f64; 3]) {
        let whole = self.lengths[CELLS];
        let wanted = share * whole;
        let cell = self.lengths.partition_point(|length| *length <= wanted).clamp(1, CELLS) - 1;
        let from = cell as f64 / CELLS as f64;
        let mut u = from + (wanted - self.lengths[cell]) / self.pace(from);
        for _ in 0..6 {
            u += (wanted - self.lengths[cell] - self.part(from, u)) / self.pace(u);
        }
        let place =
            [0, 1, 2].map(|n| self.cubic[0][n] * u + self.cubic[1][n] * u.powi(2) + self.cubic[2][n] * u.powi(3));
        let pace = self.pace(u);
        (place, self.slope(u).map(|part| part / pace * whole / length))
    }
}
