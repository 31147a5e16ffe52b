//! Compensation from its definition: the motors' place that leads the tool of a leaning machine over an
//! uneven bed.
//!
//! The surface is the natural cubic spline by its second derivatives, along X for each row of the grid and
//! then along Y through what the rows give; beyond the last point it goes on with its slope, bends back with
//! a third derivative of the slope's size (in grid distances) and lies flat two grid distances on.

use std::vec::Vec;

use crate::{
    Compensation, Fade, Skew,
    compensation::{Bed, GridShape},
};

/// What lies between program and motors.
#[derive(Clone, Debug)]
pub struct Warp {
    skew: Skew,
    shape: Shape,
    fade: Option<Fade>,
}

#[derive(Clone, Debug)]
enum Shape {
    Flat,
    Plane([f64; 3]),
    Grid(GridShape, Vec<Spline>),
}

impl Warp {
    /// A copy of what is in force; nothing where it changes nothing.
    #[must_use]
    pub fn of(compensation: &Compensation) -> Option<Self> {
        if compensation.is_suspended() {
            return None;
        }
        let shape = match (compensation.bed(), compensation.grid()) {
            (Bed::Plane(plane), _) => Shape::Plane([plane.x, plane.y, plane.z]),
            (Bed::Grid, Some(surface)) => {
                let rows = surface.heights().chunks(surface.shape().count[0]);
                let rows = rows.map(|row| Spline::through(row.iter().map(|height| f64::from(*height)).collect()));
                Shape::Grid(*surface.shape(), rows.collect())
            }
            _ => Shape::Flat,
        };
        let is_nothing = matches!(shape, Shape::Flat) && compensation.skew() == Skew::NONE;
        (!is_nothing).then(|| Self { skew: compensation.skew(), shape, fade: compensation.fade() })
    }

    /// The bed's height.
    #[must_use]
    pub fn height(&self, x: f64, y: f64) -> f64 {
        match &self.shape {
            Shape::Flat => 0.0,
            Shape::Plane([a, b, c]) => a * x + b * y + c,
            Shape::Grid(GridShape { origin, step, .. }, rows) => {
                let (u, v) = ((x - origin[0]) / step[0], (y - origin[1]) / step[1]);
                Spline::through(rows.iter().map(|row| row.at(u)).collect()).at(v)
            }
        }
    }

    /// Where the motors' axes are for the tool to be there.
    #[must_use]
    pub fn motors(&self, axes: &[f64; 6]) -> [f64; 6] {
        let [x, y, z, a, b, c] = *axes;
        let share = self.fade.map_or(1.0, |fade| {
            let t = ((z - fade.start) / (fade.end - fade.start)).clamp(0.0, 1.0);
            1.0 - 10.0 * t.powi(3) + 15.0 * t.powi(4) - 6.0 * t.powi(5)
        });
        let z = z + share * self.height(x, y);
        // Solves x = x' + xy y' + xz z, y = y' + yz z.
        let y = y - self.skew.yz * z;
        let x = x - self.skew.xy * y - self.skew.xz * z;
        [x, y, z, a, b, c]
    }
}

/// A natural cubic spline through points one apart.
#[derive(Clone, Debug)]
struct Spline {
    values: Vec<f64>,
    bends: Vec<f64>,
}

impl Spline {
    /// Second derivatives M: `M[i-1] + 4 M[i] + M[i+1] = 6 (h[i-1] - 2 h[i] + h[i+1])`, none at both ends. By
    /// Gauss.
    fn through(values: Vec<f64>) -> Self {
        let count = values.len();
        let (mut diagonal, mut bends) = (std::vec![4.0; count], std::vec![0.0; count]);
        for i in 1..count.saturating_sub(1) {
            bends[i] = 6.0 * (values[i - 1] - 2.0 * values[i] + values[i + 1]);
            if i > 1 {
                diagonal[i] -= 1.0 / diagonal[i - 1];
                bends[i] -= bends[i - 1] / diagonal[i - 1];
            }
        }
        for i in (1..count.saturating_sub(1)).rev() {
            bends[i] = (bends[i] - bends[i + 1]) / diagonal[i];
        }
        Self { values, bends }
    }

    fn at(&self, place: f64) -> f64 {
        let last = self.values.len() - 1;
        let beyond = place - last as f64;
        if place < 0.0 {
            let slope = self.values[1] - self.values[0] - self.bends[1] / 6.0 - self.bends[0] / 3.0;
            return self.values[0] - run_out(slope, -place);
        }
        if beyond > 0.0 {
            let slope = self.values[last] - self.values[last - 1] + self.bends[last - 1] / 6.0 + self.bends[last] / 3.0;
            return self.values[last] + run_out(slope, beyond);
        }
        let i = (place.floor() as usize).min(last - 1);
        let (after, before) = (place - i as f64, i as f64 + 1.0 - place);
        let line = before * self.values[i] + after * self.values[i + 1];
        line + ((before.powi(3) - before) * self.bends[i] + (after.powi(3) - after) * self.bends[i + 1]) / 6.0
    }
}

/// How far a spline goes on beyond its end, `far` grid distances out.
fn run_out(slope: f64, far: f64) -> f64 {
    if far < 1.0 { slope * (far - far.powi(3) / 6.0) } else { slope * (1.0 - (2.0 - far).max(0.0).powi(3) / 6.0) }
}
