//! Three shoulder motors, an upper arm on each, rods of equal length down to the tool.
//!
//! In the vertical plane of one arm, with D the joint of the effector beyond the shoulder (outwards), w its
//! depth below it and k its distance from the plane, the elbow at angle t (degrees, positive down) must be a
//! rod's length away: `D cos t + w sin t = c` with `c = (rf^2 + D^2 + w^2 + k^2 - re^2) / 2 rf`. With `p^2 =
//! D^2 + w^2` the solution with the elbow outside is `t = atan2(w, D) - acos(c / p)`; it exists while `c <
//! p`, and its derivative divides by `sqrt(p^2 - c^2)`.

use super::{
    space::{Axes, Motors, TINY},
    spheres,
};

use crate::square_root;

/// Outward directions of the arms of alpha, beta and gamma: 120 degrees apart, alpha towards -Y.
const ARMS: [[f64; 2]; 3] = [[0.0, -1.0], [0.866_025_403_784_438_6, 0.5], [-0.866_025_403_784_438_6, 0.5]];
/// Distance of an equilateral triangle's side from its middle, for a side of 1.
const INRADIUS: f64 = 0.288_675_134_594_812_9;

/// Configured geometry of a rotary delta; lengths in mm, angles in degrees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RotaryDelta {
    /// Side of the effector's triangle (`delta_e`).
    pub effector: f64,
    /// Side of the base's triangle (`delta_f`).
    pub base: f64,
    /// Length of the rods (`delta_re`).
    pub rod: f64,
    /// Length of the upper arms (`delta_rf`).
    pub arm: f64,
    /// Distance from the shafts down to the bed (`delta_z_offset`).
    pub z_offset: f64,
    /// Distance from the plane of the effector's joints to its bottom (`delta_ee_offs`).
    pub effector_offset: f64,
    /// Distance from the plane of the effector's joints to the tip of the tool (`delta_tool_offset`).
    pub tool_offset: f64,
    /// Least and greatest angle of an arm.
    pub angles: [f64; 2],
    /// X and Y count the other way round.
    pub mirror_xy: bool,
}

impl Default for RotaryDelta {
    fn default() -> Self {
        Self {
            effector: 131.636,
            base: 190.526,
            rod: 270.0,
            arm: 90.0,
            z_offset: 290.7,
            effector_offset: 15.0,
            tool_offset: 30.5,
            angles: [-45.0, 70.0],
            mirror_xy: true,
        }
    }
}

/// An arm seen in its plane.
struct Plane {
    /// D, w and k of the module's text.
    out: f64,
    down: f64,
    sideways: f64,
}

impl RotaryDelta {
    /// Whether every length is above zero, and the least angle below the greatest.
    pub(super) fn is_sound(&self) -> bool {
        let lengths = [self.effector, self.base, self.rod, self.arm];
        lengths.into_iter().all(|length| length > 0.0) && self.angles.is_sorted()
    }

    /// Returns the height of the shafts above the effector's joints when the tool is at Z 0.
    fn drop(&self) -> f64 {
        self.z_offset - self.tool_offset - self.effector_offset
    }

    fn sign(&self) -> f64 {
        if self.mirror_xy { -1.0 } else { 1.0 }
    }

    /// A direction, or a point less the constant parts, in an arm's plane.
    fn turned(&self, [nx, ny]: [f64; 2], [x, y, z]: Axes) -> Plane {
        let (x, y) = (self.sign() * x, self.sign() * y);
        Plane { out: x * nx + y * ny, down: -z, sideways: y * nx - x * ny }
    }

    fn plane(&self, arm: [f64; 2], axes: Axes) -> Plane {
        let turned = self.turned(arm, axes);
        Plane { out: turned.out + INRADIUS * (self.effector - self.base), down: turned.down + self.drop(), ..turned }
    }

    /// p, c and the root of their squares' difference.
    fn triangle(&self, plane: &Plane) -> (f64, f64, f64) {
        let span_sq = plane.out * plane.out + plane.down * plane.down;
        let c =
            (self.arm * self.arm + span_sq + plane.sideways * plane.sideways - self.rod * self.rod) / (2.0 * self.arm);
        (square_root(span_sq), c, square_root(crate::greatest(span_sq - c * c, TINY)))
    }

    fn angle(&self, plane: &Plane) -> f64 {
        let (_, c, root) = self.triangle(plane);
        // acos(c / p) without dividing, good everywhere.
        libm::atan2(plane.down, plane.out) - libm::atan2(root, c)
    }

    /// Returns the motors' positions at a point.
    pub(super) fn motors(&self, axes: Axes) -> Motors {
        ARMS.map(|arm| self.angle(&self.plane(arm, axes)).to_degrees())
    }

    /// Returns the motors' speeds at a point, from the axes' speeds.
    pub(super) fn velocities(&self, axes: Axes, velocity: Axes) -> Motors {
        ARMS.map(|arm| {
            let (plane, turned) = (self.plane(arm, axes), self.turned(arm, velocity));
            let (span, c, root) = self.triangle(&plane);
            // Cosine and sine of the angle, from the two parts of which it is the difference.
            let span_sq = crate::greatest(span * span, TINY);
            let cosine = (plane.out * c + plane.down * root) / span_sq;
            let sine = (plane.down * c - plane.out * root) / span_sq;
            let change =
                (plane.out * turned.out + plane.down * turned.down + plane.sideways * turned.sideways) / self.arm;
            let pull = turned.out * cosine + turned.down * sine;
            ((change - pull) / root).to_degrees()
        })
    }

    /// Returns the point for the motors' positions.
    pub(super) fn axes(&self, [alpha, beta, gamma]: Motors) -> Axes {
        let elbow = |[nx, ny]: [f64; 2], degrees: f64| {
            let radians = degrees.to_radians();
            let out = INRADIUS * (self.base - self.effector) + self.arm * libm::cos(radians);
            [nx * out, ny * out, -self.arm * libm::sin(radians)]
        };
        let [a, b, c] = ARMS;
        let [[x, y, z], _] = spheres::meet([elbow(a, alpha), elbow(b, beta), elbow(c, gamma)], [self.rod; 3]);
        [self.sign() * x, self.sign() * y, z + self.drop()]
    }

    /// A lower bound of the distance in mm to where an arm and its rod lie in one line, or the rod across the
    /// plane.
    pub(super) fn clearance(&self, axes: Axes) -> f64 {
        let of_arm = |arm| {
            let plane = self.plane(arm, axes);
            let (span, ..) = self.triangle(&plane);
            let across = self.rod - libm::fabs(plane.sideways);
            let rod = square_root(crate::greatest(self.rod * self.rod - plane.sideways * plane.sideways, 0.0));
            let stretched = rod + self.arm - span;
            let folded = span - libm::fabs(rod - self.arm);
            // Moving sideways shortens the rod as seen in the plane too: half of the distance is surely free.
            0.5 * crate::least(across, crate::least(stretched, folded))
        };
        ARMS.map(of_arm).into_iter().fold(f64::INFINITY, crate::least)
    }

    /// Whether the arms can stand at the angles that a point takes.
    pub(super) fn is_within_angles(&self, axes: Axes) -> bool {
        let [least, greatest] = self.angles;
        self.motors(axes).into_iter().all(|angle| angle >= least && angle <= greatest)
    }

    /// The parameters M665 knows, with their letters.
    pub(super) const fn parameters(&self) -> [(char, f64); 7] {
        [
            ('A', self.effector),
            ('B', self.base),
            ('C', self.rod),
            ('D', self.arm),
            ('E', self.z_offset),
            ('I', self.effector_offset),
            ('H', self.tool_offset),
        ]
    }

    /// Returns the machine with the values of [`Self::parameters`] in their order.
    pub(super) const fn with_parameters(self, values: [f64; 7]) -> Self {
        let [effector, base, rod, arm, z_offset, effector_offset, tool_offset] = values;
        Self { effector, base, rod, arm, z_offset, effector_offset, tool_offset, ..self }
    }
}
