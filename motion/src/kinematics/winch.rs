//! A tool that hangs on (or is held by) ropes: each motor's position is the length of its rope, mm.
//!
//! Motors beyond the third take the places of the auxiliary axes of their number.

use super::{
    space::{Axes, TINY},
    spheres,
};

use crate::square_root;

/// Greatest number of ropes.
pub const MOST_ANCHORS: usize = units::MAX_ACTUATORS;

/// Anchors: the places at which the ropes leave their winches.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Winch {
    anchors: [Axes; MOST_ANCHORS],
    count: usize,
}

impl Winch {
    /// Creates a machine with 3 to 6 anchors (X, Y, Z in mm), the first three not in one line. `None`
    /// otherwise.
    #[must_use]
    pub fn new(given: &[Axes]) -> Option<Self> {
        let mut anchors = [[0.0; 3]; MOST_ANCHORS];
        if given.len() < 3 || given.len() > MOST_ANCHORS {
            return None;
        }
        anchors.iter_mut().zip(given).for_each(|(slot, anchor)| *slot = *anchor);
        let [[ax, ay, az], [bx, by, bz], [cx, cy, cz], ..] = anchors;
        let (u, v) = ([bx - ax, by - ay, bz - az], [cx - ax, cy - ay, cz - az]);
        let ([ux, uy, uz], [vx, vy, vz]) = (u, v);
        let normal = [uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx];
        let area_sq: f64 = normal.iter().map(|part| part * part).sum();
        (area_sq > 1.0).then_some(Self { anchors, count: given.len() })
    }

    /// Returns the ropes' anchors, mm.
    #[must_use]
    pub fn anchors(&self) -> &[Axes] {
        self.anchors.get(..self.count).unwrap_or(&[])
    }

    fn distance([ax, ay, az]: Axes, [x, y, z]: Axes) -> f64 {
        let (dx, dy, dz) = (x - ax, y - ay, z - az);
        square_root(crate::greatest(dx * dx + dy * dy + dz * dz, TINY))
    }

    /// Writes the lengths over the motors that are winches.
    pub(super) fn motors(&self, axes: Axes, motors: &mut [f64; MOST_ANCHORS]) {
        for (motor, anchor) in motors.iter_mut().zip(self.anchors()) {
            *motor = Self::distance(*anchor, axes);
        }
    }

    /// Sets the speeds of the ropes at a point, from the axes' speeds.
    pub(super) fn velocities(&self, axes: Axes, [vx, vy, vz]: Axes, motors: &mut [f64; MOST_ANCHORS]) {
        let [x, y, z] = axes;
        for (motor, anchor) in motors.iter_mut().zip(self.anchors()) {
            let [ax, ay, az] = *anchor;
            *motor = ((x - ax) * vx + (y - ay) * vy + (z - az) * vz) / Self::distance(*anchor, axes);
        }
    }

    /// Returns the tool's place: three ropes leave two, of which the lower one, or the one that suits the
    /// fourth rope better, is taken.
    pub(super) fn axes(&self, motors: &[f64; MOST_ANCHORS]) -> Axes {
        let ([a, b, c, d, ..], [alpha, beta, gamma, delta, ..]) = (self.anchors, *motors);
        let [lower, upper] = spheres::meet([a, b, c], [alpha, beta, gamma]);
        let off = |point| libm::fabs(Self::distance(d, point) - delta);
        if self.count > 3 && off(upper) < off(lower) { upper } else { lower }
    }

    /// Returns the distance from the nearest anchor, mm.
    pub(super) fn clearance(&self, axes: Axes) -> f64 {
        self.anchors().iter().map(|anchor| Self::distance(*anchor, axes)).fold(f64::INFINITY, crate::least)
    }

    /// The place nearest to an anchor on the line from `from` on, as a share of the way along `by`.
    pub(super) fn nearest(&self, anchor: usize, [x, y, z]: Axes, [dx, dy, dz]: Axes) -> Option<f64> {
        let [ax, ay, az] = *self.anchors().get(anchor)?;
        Some(((ax - x) * dx + (ay - y) * dy + (az - z) * dz) / (dx * dx + dy * dy + dz * dz))
    }

    /// Motors that are winches, one bit each.
    pub(super) const fn mask(&self) -> u8 {
        ((1_u16 << self.count) - 1) as u8
    }
}
