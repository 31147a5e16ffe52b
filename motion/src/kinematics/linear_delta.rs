//! Three vertical towers, a carriage on each, a rod from it down to the tool; the rods' lengths may differ a
//! little.
//!
//! A carriage stands at `z + sqrt(L^2 - d^2)`, L being its rod's length and d the horizontal distance of tool
//! and tower. Along a straight line that is the arc of an ellipse: its slope grows steadily, and its bend is
//! greatest at one of the ends. So the ends of a move bound both. The places all three rods can reach are the
//! intersection of three discs, which is convex: a line between two of them stays inside.

use units::LinearDeltaGeometry;

use super::{
    space::{Axes, LEAST_CLEARANCE, Motors, TINY},
    spheres,
};

use crate::square_root;

/// Angles of the towers of alpha, beta and gamma, degrees.
const TOWERS: [f64; 3] = [210.0, 330.0, 90.0];

/// Letters of M665: arm length, arm radius, radius of each tower, angle of each tower, length of each rod.
const LETTERS: [char; 11] = ['L', 'R', 'A', 'B', 'C', 'D', 'E', 'H', 'I', 'J', 'K'];

/// A tower and its rod.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Tower {
    /// Drawn in by the effector's size, mm.
    x: f64,
    y: f64,
    /// Length of the rod, mm.
    rod: f64,
}

/// A linear delta, ready to compute.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinearDelta {
    geometry: LinearDeltaGeometry,
    towers: [Tower; 3],
}

impl Default for LinearDelta {
    fn default() -> Self {
        Self::new(LinearDeltaGeometry::default())
    }
}

impl LinearDelta {
    /// Creates a machine of this geometry.
    #[must_use]
    pub fn new(geometry: LinearDeltaGeometry) -> Self {
        let mut towers = [Tower::default(); 3];
        let corrections = geometry.tower_offset.into_iter().zip(geometry.tower_angle).zip(geometry.arm_offset);
        for ((tower, nominal), ((offset, angle), longer)) in towers.iter_mut().zip(TOWERS).zip(corrections) {
            let radians = (nominal + angle).to_radians();
            let radius = geometry.arm_radius + offset;
            let rod = geometry.arm_length + longer;
            *tower = Tower { x: radius * libm::cos(radians), y: radius * libm::sin(radians), rod };
        }
        Self { geometry, towers }
    }

    /// Returns the configured geometry.
    #[must_use]
    pub const fn geometry(&self) -> &LinearDeltaGeometry {
        &self.geometry
    }

    /// Whether the towers stand apart and the rods span them.
    pub(super) fn is_sound(&self) -> bool {
        let [a, b, c] = self.towers;
        let area = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
        libm::fabs(area) > 1.0 && self.clearance([0.0; 3]) > LEAST_CLEARANCE
    }

    /// Returns the vector from tool to tower, and the rise of the rod, mm.
    fn rod(tower: Tower, [x, y, _]: Axes) -> (f64, f64, f64) {
        let (dx, dy) = (tower.x - x, tower.y - y);
        let rise_sq = tower.rod * tower.rod - dx * dx - dy * dy;
        (dx, dy, square_root(crate::greatest(rise_sq, TINY)))
    }

    /// Returns the motors' positions at a point.
    pub(super) fn motors(&self, axes: Axes) -> Motors {
        let [_, _, z] = axes;
        self.towers.map(|tower| z + Self::rod(tower, axes).2)
    }

    /// Returns the motors' speeds at a point, from the axes' speeds.
    pub(super) fn velocities(&self, axes: Axes, [vx, vy, vz]: Axes) -> Motors {
        self.towers.map(|tower| {
            let (dx, dy, rise) = Self::rod(tower, axes);
            vz + (dx * vx + dy * vy) / rise
        })
    }

    /// Returns the point for the motors' positions.
    pub(super) fn axes(&self, [alpha, beta, gamma]: Motors) -> Axes {
        let [a, b, c] = self.towers;
        let [lower, _] = spheres::meet([[a.x, a.y, alpha], [b.x, b.y, beta], [c.x, c.y, gamma]], [a.rod, b.rod, c.rod]);
        lower
    }

    /// Distance in mm to where a rod would lie flat; negative beyond.
    pub(super) fn clearance(&self, [x, y, _]: Axes) -> f64 {
        let left = |tower: Tower| {
            let (dx, dy) = (tower.x - x, tower.y - y);
            tower.rod - square_root(dx * dx + dy * dy)
        };
        self.towers.into_iter().map(left).fold(f64::INFINITY, crate::least)
    }

    /// The parameters M665 knows, with their letters.
    pub(super) fn parameters(&self) -> [(char, f64); 11] {
        let LinearDeltaGeometry { arm_length, arm_offset, arm_radius, tower_offset, tower_angle } = self.geometry;
        let ([a, b, c], [d, e, h], [i, j, k]) = (tower_offset, tower_angle, arm_offset);
        let values = [arm_length, arm_radius, a, b, c, d, e, h, i, j, k];
        core::array::from_fn(|n| (LETTERS.get(n).copied().unwrap_or(' '), values.get(n).copied().unwrap_or(0.0)))
    }

    /// Creates a machine with the values of [`Self::parameters`] in their order.
    pub(super) fn with_parameters(values: [f64; 11]) -> Self {
        let [arm_length, arm_radius, a, b, c, d, e, h, i, j, k] = values;
        Self::new(LinearDeltaGeometry {
            arm_length,
            arm_offset: [i, j, k],
            arm_radius,
            tower_offset: [a, b, c],
            tower_angle: [d, e, h],
        })
    }
}
