//! A SCARA of the Morgan kind: two links, both motors in the tower, their angles counted from +X in degrees.
//!
//! Alpha is the angle of the inner link, beta that of the outer one in space (not of the elbow), gamma is Z.
//! With r the distance of the tool from the tower, the elbow's cosine is `(r^2 - l1^2 - l2^2) / 2 l1 l2`; the
//! elbow bends to the left.

use super::space::{Axes, Motors, TINY};

use crate::square_root;

/// Configured geometry of a Morgan SCARA; lengths in mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Morgan {
    /// Length of the inner link.
    pub arm1: f64,
    /// Length of the outer link.
    pub arm2: f64,
    /// The tower, from the bed's origin.
    pub tower: [f64; 2],
    /// Scale of X and Y.
    pub scaling: [f64; 2],
    /// The elbow's cosine stays above minus the first (folded) and below the second (stretched).
    pub cosine: [f64; 2],
}

impl Default for Morgan {
    fn default() -> Self {
        Self { arm1: 150.0, arm2: 150.0, tower: [100.0, -60.0], scaling: [1.0; 2], cosine: [0.95; 2] }
    }
}

impl Morgan {
    /// Whether both links have a length, no axis is scaled to nothing, and the elbow can turn.
    pub(super) fn is_sound(&self) -> bool {
        let ([sx, sy], [folded, stretched]) = (self.scaling, self.cosine);
        self.arm1 > 0.0 && self.arm2 > 0.0 && sx != 0.0 && sy != 0.0 && stretched > -folded
    }

    /// Returns X and Y seen from the tower.
    fn local(&self, [x, y, _]: Axes) -> [f64; 2] {
        let ([tx, ty], [sx, sy]) = (self.tower, self.scaling);
        [x * sx - tx, y * sy - ty]
    }

    fn elbow_cosine(&self, r_sq: f64) -> f64 {
        (r_sq - self.arm1 * self.arm1 - self.arm2 * self.arm2) / (2.0 * self.arm1 * self.arm2)
    }

    /// Cosine and sine of the elbow.
    fn elbow(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let cosine = crate::least(crate::greatest(self.elbow_cosine(x * x + y * y), -1.0), 1.0);
        [cosine, square_root(crate::greatest(1.0 - cosine * cosine, TINY))]
    }

    /// Returns the motors' positions at a point.
    pub(super) fn motors(&self, axes: Axes) -> Motors {
        let ([x, y], [_, _, z]) = (self.local(axes), axes);
        let [cosine, sine] = self.elbow([x, y]);
        let inner = libm::atan2(y, x) - libm::atan2(self.arm2 * sine, self.arm1 + self.arm2 * cosine);
        [inner.to_degrees(), (inner + libm::atan2(sine, cosine)).to_degrees(), z]
    }

    /// Returns the motors' speeds at a point, from the axes' speeds.
    pub(super) fn velocities(&self, axes: Axes, [vx, vy, vz]: Axes) -> Motors {
        let ([x, y], [sx, sy]) = (self.local(axes), self.scaling);
        let (vx, vy) = (vx * sx, vy * sy);
        let [cosine, sine] = self.elbow([x, y]);
        // The elbow, from the tower: the tool's place turned back by the angle at the tower.
        let share = self.arm1 / crate::greatest(x * x + y * y, TINY);
        let (along, sideways) = (self.arm1 + self.arm2 * cosine, self.arm2 * sine);
        let (ex, ey) = (share * (along * x + sideways * y), share * (along * y - sideways * x));
        // Cramer's rule gives both angles' velocities from the tool's.
        let across = self.arm1 * self.arm2 * sine;
        let inner = (vx * (x - ex) + vy * (y - ey)) / across;
        let outer = -(vx * ex + vy * ey) / across;
        [inner.to_degrees(), outer.to_degrees(), vz]
    }

    /// Returns the point for the motors' positions.
    pub(super) fn axes(&self, [alpha, beta, gamma]: Motors) -> Axes {
        let ([tx, ty], [sx, sy]) = (self.tower, self.scaling);
        let (alpha, beta) = (alpha.to_radians(), beta.to_radians());
        let x = self.arm1 * libm::cos(alpha) + self.arm2 * libm::cos(beta);
        let y = self.arm1 * libm::sin(alpha) + self.arm2 * libm::sin(beta);
        [(x + tx) / sx, (y + ty) / sy, gamma]
    }

    /// Distance in mm to where the arm is stretched or folded completely.
    pub(super) fn clearance(&self, axes: Axes) -> f64 {
        let ([x, y], [sx, sy]) = (self.local(axes), self.scaling);
        let r = square_root(x * x + y * y);
        let stretched = self.arm1 + self.arm2 - r;
        let folded = r - libm::fabs(self.arm1 - self.arm2);
        crate::least(stretched, folded) / crate::greatest(libm::fabs(sx), libm::fabs(sy))
    }

    /// Whether the configuration allows the elbow's angle.
    pub(super) fn is_within_limits(&self, axes: Axes) -> bool {
        let ([x, y], [folded, stretched]) = (self.local(axes), self.cosine);
        let cosine = self.elbow_cosine(x * x + y * y);
        cosine >= -folded && cosine <= stretched
    }

    /// The place nearest to the tower on the line from `from` on, as a share of the way along `by`.
    pub(super) fn nearest(&self, from: Axes, [dx, dy, _]: Axes) -> f64 {
        let ([x, y], [sx, sy]) = (self.local(from), self.scaling);
        let (dx, dy) = (dx * sx, dy * sy);
        -(x * dx + y * dy) / (dx * dx + dy * dy)
    }

    /// The parameters M665 knows, with their letters.
    pub(super) const fn parameters(&self) -> [(char, f64); 8] {
        let ([x, y], [a, b], [d, e]) = (self.tower, self.scaling, self.cosine);
        [('L', self.arm1), ('P', self.arm2), ('X', x), ('Y', y), ('A', a), ('B', b), ('D', d), ('E', e)]
    }

    /// Creates a machine with the values of [`Self::parameters`] in their order.
    pub(super) const fn with_parameters(values: [f64; 8]) -> Self {
        let [arm1, arm2, x, y, a, b, d, e] = values;
        Self { arm1, arm2, tower: [x, y], scaling: [a, b], cosine: [d, e] }
    }
}
