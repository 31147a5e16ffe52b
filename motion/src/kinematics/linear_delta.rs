//! Three vertical towers, a carriage on each, rods of equal length down to the tool.
//!
//! A carriage stands at `z + sqrt(L^2 - d^2)`, d being the horizontal distance of tool and tower. Along a
//! straight line that is the arc of an ellipse: its slope grows steadily, and its bend is greatest at one of
//! the ends. So the ends of a move bound both. The places all three rods can reach are the intersection of
//! three discs, which is convex: a line between two of them stays inside.

use super::{Axes, Motors, spheres};

use crate::square_root;

/// Angles of the towers of alpha, beta and gamma, degrees.
const TOWERS: [f64; 3] = [210.0, 330.0, 90.0];

/// What a configuration says.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinearDeltaGeometry {
    /// Length of the rods, mm.
    pub arm_length: f64,
    /// Horizontal distance of a rod's joints with the tool in the middle, mm.
    pub arm_radius: f64,
    /// Added to the radius of each tower, mm.
    pub tower_offset: [f64; 3],
    /// Added to the angle of each tower, degrees.
    pub tower_angle: [f64; 3],
}

impl Default for LinearDeltaGeometry {
    fn default() -> Self {
        Self { arm_length: 250.0, arm_radius: 124.0, tower_offset: [0.0; 3], tower_angle: [0.0; 3] }
    }
}

/// A linear delta, ready to compute.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinearDelta {
    geometry: LinearDeltaGeometry,
    /// X and Y of the towers, drawn in by the effector's size.
    towers: [[f64; 2]; 3],
}

impl Default for LinearDelta {
    fn default() -> Self {
        Self::new(LinearDeltaGeometry::default())
    }
}

impl LinearDelta {
    /// With this geometry.
    #[must_use]
    pub fn new(geometry: LinearDeltaGeometry) -> Self {
        let mut towers = [[0.0; 2]; 3];
        let corrections = geometry.tower_offset.into_iter().zip(geometry.tower_angle);
        for ((place, nominal), (offset, angle)) in towers.iter_mut().zip(TOWERS).zip(corrections) {
            let radians = (nominal + angle).to_radians();
            let radius = geometry.arm_radius + offset;
            *place = [radius * libm::cos(radians), radius * libm::sin(radians)];
        }
        Self { geometry, towers }
    }

    /// Its geometry.
    #[must_use]
    pub const fn geometry(&self) -> &LinearDeltaGeometry {
        &self.geometry
    }

    /// Whether the towers stand apart and the rods span them.
    pub(super) fn is_sound(&self) -> bool {
        let [[ax, ay], [bx, by], [cx, cy]] = self.towers;
        let area = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax);
        libm::fabs(area) > 1.0 && self.clearance([0.0; 3]) > super::LEAST_CLEARANCE
    }

    /// From tool to tower, and how far the rod rises.
    fn rod(&self, [tx, ty]: [f64; 2], [x, y, _]: Axes) -> (f64, f64, f64) {
        let (dx, dy) = (tx - x, ty - y);
        let rise_sq = self.geometry.arm_length * self.geometry.arm_length - dx * dx - dy * dy;
        (dx, dy, square_root(crate::greatest(rise_sq, super::TINY)))
    }

    pub(super) fn motors(&self, axes: Axes) -> Motors {
        let [_, _, z] = axes;
        self.towers.map(|tower| z + self.rod(tower, axes).2)
    }

    pub(super) fn velocities(&self, axes: Axes, [vx, vy, vz]: Axes) -> Motors {
        self.towers.map(|tower| {
            let (dx, dy, rise) = self.rod(tower, axes);
            vz + (dx * vx + dy * vy) / rise
        })
    }

    pub(super) fn axes(&self, [alpha, beta, gamma]: Motors) -> Axes {
        let [[ax, ay], [bx, by], [cx, cy]] = self.towers;
        let [lower, _] =
            spheres::meet([[ax, ay, alpha], [bx, by, beta], [cx, cy, gamma]], [self.geometry.arm_length; 3]);
        lower
    }

    /// Distance in mm to where a rod would lie flat; negative beyond.
    pub(super) fn clearance(&self, [x, y, _]: Axes) -> f64 {
        let distance = |[tx, ty]: [f64; 2]| square_root((tx - x) * (tx - x) + (ty - y) * (ty - y));
        let farthest = self.towers.into_iter().map(distance).fold(0.0, crate::greatest);
        self.geometry.arm_length - farthest
    }

    /// The parameters M665 knows, with their letters.
    pub(super) fn parameters(&self) -> [(char, f64); 8] {
        let LinearDeltaGeometry { arm_length, arm_radius, tower_offset: [a, b, c], tower_angle: [d, e, h] } =
            self.geometry;
        [('L', arm_length), ('R', arm_radius), ('A', a), ('B', b), ('C', c), ('D', d), ('E', e), ('H', h)]
    }

    /// With the values of [`Self::parameters`] in their order.
    pub(super) fn with_parameters(values: [f64; 8]) -> Self {
        let [arm_length, arm_radius, a, b, c, d, e, h] = values;
        Self::new(LinearDeltaGeometry { arm_length, arm_radius, tower_offset: [a, b, c], tower_angle: [d, e, h] })
    }
}
