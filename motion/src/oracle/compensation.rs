//! Compensation from its definition: the motors' place that leads the tool of a leaning machine over an
//! uneven bed.
//!
//! The surface is the natural cubic spline by its second derivatives, along X for each row of a grid and then
//! along Y through what the rows give. The grid is finer than that of the measured heights: straight lines,
//! polynomials (by Neville's scheme) or the spline of the measured ones give its heights. Beyond the last
//! point the surface goes on with its slope, turns back and lies at the height of the edge three fine grid
//! distances on.

use std::vec::Vec;

use crate::{
    Compensation, Fade, Skew,
    compensation::{Bed, Interpolation},
};

/// Compensation between the program and the motors.
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
    /// First point of the grid, step of the finer grid, its rows.
    Grid([f64; 2], [f64; 2], Vec<Spline>),
}

impl Warp {
    /// Copies the compensation in force; `None` when it changes nothing.
    #[must_use]
    pub fn of(compensation: &Compensation) -> Option<Self> {
        if compensation.is_suspended() {
            return None;
        }
        let shape = match (compensation.bed(), compensation.grid()) {
            (Bed::Plane(plane), _) => Shape::Plane([plane.x, plane.y, plane.z]),
            (Bed::Grid, Some(surface)) => {
                let ([nx, ny], [sx, sy]) = (surface.shape().count, surface.shape().step);
                let way = surface.interpolation();
                let (across, along) = (finer(way, nx, sx), finer(way, ny, sy));
                let rows = surface.heights().chunks(nx);
                let rows: Vec<_> = rows
                    .map(|row| refined(way, &row.iter().map(|height| f64::from(*height)).collect::<Vec<_>>(), across))
                    .collect();
                let column = |x: usize| refined(way, &rows.iter().map(|row| row[x]).collect::<Vec<_>>(), along);
                let columns: Vec<_> = (0..rows[0].len()).map(column).collect();
                let row = |y: usize| Spline::through(columns.iter().map(|column| column[y]).collect());
                let step = [sx / across as f64, sy / along as f64];
                Shape::Grid(surface.shape().origin, step, (0..columns[0].len()).map(row).collect())
            }
            _ => Shape::Flat,
        };
        let is_nothing = matches!(shape, Shape::Flat) && compensation.skew() == Skew::NONE;
        (!is_nothing).then(|| Self { skew: compensation.skew(), shape, fade: compensation.fade() })
    }

    /// Returns the height of the bed at a place, mm.
    #[must_use]
    pub fn height(&self, x: f64, y: f64) -> f64 {
        match &self.shape {
            Shape::Flat => 0.0,
            Shape::Plane([a, b, c]) => a * x + b * y + c,
            Shape::Grid(origin, step, rows) => {
                let (u, v) = ((x - origin[0]) / step[0], (y - origin[1]) / step[1]);
                Spline::through(rows.iter().map(|row| row.at(u)).collect()).at(v)
            }
        }
    }

    /// Returns the motors' axes for the tool to be at `axes` of the program.
    #[must_use]
    pub fn motors(&self, axes: &[f64; 6]) -> [f64; 6] {
        let [x, y, z, a, b, c] = *axes;
        let share = self.fade.map_or(1.0, |fade| {
            let t = ((z - fade.start) / (fade.end - fade.start)).clamp(0.0, 1.0);
            1.0 - 10.0 * t.powi(3) + 15.0 * t.powi(4) - 6.0 * t.powi(5)
        });
        let left = self.fade.map_or(0.0, |fade| fade.target);
        let z = z + share * self.height(x, y) + (1.0 - share) * left;
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

/// Returns the height above a spline's end, `far` grid distances beyond it: back to the height of the end by
/// the cubics that keep slope and bend.
fn run_out(slope: f64, far: f64) -> f64 {
    let (t, rest) = (far - 1.0, 3.0 - far);
    slope
        * match far {
            ..1.0 => far - far.powi(3) / 3.0,
            ..2.0 => (4.0 - 6.0 * t.powi(2) + 3.0 * t.powi(3)) / 6.0,
            ..3.0 => rest.powi(3) / 6.0,
            _ => 0.0,
        }
}

/// Cells of the finer grid for each measured one: four, or as many as find room and are not too small.
fn finer(way: Interpolation, count: usize, step: f64) -> usize {
    let has_room = |cells: &usize| (count - 1) * cells < 50;
    let is_needed = |cells: &usize| *cells == 2 && way == Interpolation::Bilinear;
    let is_large = |cells: &usize| *cells == 1 || is_needed(cells) || step.abs() / *cells as f64 >= 4.0;
    (1..=4).rev().find(|cells| has_room(cells) && is_large(cells)).unwrap_or(1)
}

/// The heights of a finer line.
fn refined(way: Interpolation, heights: &[f64], cells: usize) -> Vec<f64> {
    let spline = Spline::through(heights.to_vec());
    let places = (0..=(heights.len() - 1) * cells).map(|index| index as f64 / cells as f64);
    places
        .map(|place| match way {
            Interpolation::Spline => spline.at(place),
            Interpolation::Bilinear => {
                let before = (place.floor() as usize).min(heights.len() - 2);
                heights[before] + (place - before as f64) * (heights[before + 1] - heights[before])
            }
            Interpolation::Lagrange => neville(heights, place),
        })
        .collect()
}

/// The polynomial through heights one apart, by Neville's scheme.
fn neville(heights: &[f64], place: f64) -> f64 {
    let mut scheme = heights.to_vec();
    for order in 1..heights.len() {
        for first in 0..heights.len() - order {
            let (left, right) = (place - first as f64, place - (first + order) as f64);
            scheme[first] = (left * scheme[first + 1] - right * scheme[first]) / order as f64;
        }
    }
    scheme[0]
}
