//! The way of a block through space, exact at every place: a straight line, an arc or helix, a spline.
//!
//! A path is what every axis does for each millimetre (`direction`) plus a curve of X, Y and Z. So a helix is
//! a circle and a direction that rises, an extruder goes along evenly with any curve, and what an end point
//! is off its circle by is spread over the whole arc instead of being jumped. Distances are those along the
//! curve, in mm of X, Y and Z.

mod arc;
mod bounds;
mod ring;
mod spline;

pub use arc::Arc;
pub use bounds::Bounds;
pub(crate) use ring::CurveRing;
pub use spline::{EVEN_WITHIN, Spline};

use units::{Axis, PerAxis};

use crate::square_root;

/// X, Y and Z of something.
pub(crate) type Vector = [f64; 3];

/// Deviation of X, Y and Z from the straight line.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Curve {
    /// None: a straight line.
    #[default]
    Line,
    /// A part of a circle, or several turns of it.
    Arc(Arc),
    /// A cubic in space.
    Spline(Spline),
}

impl Curve {
    /// Returns whether the curve is a straight line.
    #[must_use]
    pub const fn is_line(&self) -> bool {
        matches!(self, Self::Line)
    }

    /// Length of the path it was made for, mm; zero for a line, which fits any.
    #[must_use]
    pub const fn length(&self) -> f64 {
        match self {
            Self::Line => 0.0,
            Self::Arc(arc) => arc.length(),
            Self::Spline(spline) => spline.length(),
        }
    }

    /// Whether every number of the curve is finite, and its length that of something.
    #[must_use]
    pub(crate) fn is_sound(&self) -> bool {
        self.is_line() || (self.length().is_finite() && size(self.offset(0.5 * self.length())).is_finite())
    }

    /// Returns which of X, Y and Z the curve moves beside the straight line by more than `least` mm.
    pub(crate) fn moves(&self, least: f64) -> [bool; 3] {
        match self {
            Self::Line => [false; 3],
            Self::Arc(arc) => [0, 1, 2].map(|n| parts_exceed([arc.arm(), arc.ahead(), [0.0; 3]], n, least)),
            Self::Spline(spline) => [0, 1, 2].map(|n| parts_exceed(*spline.cubic(), n, least)),
        }
    }

    /// Returns the curve's addition to X, Y and Z after `s` mm of path.
    #[must_use]
    pub fn offset(&self, s: f64) -> [f64; 3] {
        match self {
            Self::Line => [0.0; 3],
            Self::Arc(arc) => arc.offset(s),
            Self::Spline(spline) => spline.offset(s),
        }
    }

    /// Returns the curve's addition for the next millimetre of path, after `s` mm.
    #[must_use]
    pub fn slope(&self, s: f64) -> [f64; 3] {
        match self {
            Self::Line => [0.0; 3],
            Self::Arc(arc) => arc.slope(s),
            Self::Spline(spline) => spline.slope(s),
        }
    }

    /// The change of [`Self::slope`] for each millimetre of path: towards the centre, and one by the radius
    /// in size.
    #[must_use]
    pub fn bend(&self, s: f64) -> [f64; 3] {
        match self {
            Self::Line => [0.0; 3],
            Self::Arc(arc) => arc.bend(s),
            Self::Spline(spline) => spline.bend(s),
        }
    }

    /// The change of [`Self::bend`] for each millimetre of path, 1/mm^2.
    #[must_use]
    pub(crate) fn twist(&self, s: f64) -> [f64; 3] {
        match self {
            Self::Line => [0.0; 3],
            Self::Arc(arc) => arc.twist(s),
            Self::Spline(spline) => spline.twist(s),
        }
    }
}

/// The way of a block.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Path {
    /// Beginning of the path, in machine space.
    pub origin: PerAxis<f64>,
    /// Movement of each axis for a millimetre of path, without the curve.
    pub direction: PerAxis<f64>,
    /// Movement of X, Y and Z beside the straight line.
    pub curve: Curve,
}

impl Path {
    /// Creates a path from `origin` to `target` in `length` mm, along this curve.
    #[must_use]
    pub fn new(origin: PerAxis<f64>, target: &PerAxis<f64>, length: f64, curve: Curve) -> Self {
        let mut direction = PerAxis::default();
        let [x, y, z] = curve.offset(length);
        for (axis, curved) in Axis::ALL.into_iter().zip([x, y, z, 0.0, 0.0, 0.0]) {
            direction[axis] = (target[axis] - origin[axis] - curved) / length;
        }
        Self { origin, direction, curve }
    }

    /// A straight path from `origin`.
    #[must_use]
    pub const fn line(origin: PerAxis<f64>, direction: PerAxis<f64>) -> Self {
        Self { origin, direction, curve: Curve::Line }
    }

    /// Returns the place after `s` mm.
    #[must_use]
    pub fn point(&self, s: f64) -> PerAxis<f64> {
        let mut point = self.origin;
        for axis in Axis::ALL {
            point[axis] += self.direction[axis] * s;
        }
        if !self.curve.is_line() {
            add(&mut point, self.curve.offset(s));
        }
        point
    }

    /// Returns the movement of each axis for a millimetre of path after `s` mm: of length one in X, Y and Z.
    #[must_use]
    pub fn tangent(&self, s: f64) -> PerAxis<f64> {
        let mut tangent = self.direction;
        if !self.curve.is_line() {
            add(&mut tangent, self.curve.slope(s));
        }
        tangent
    }

    /// Returns the curvature (one by the radius) after `s` mm, 1/mm: zero where the path is straight.
    #[must_use]
    pub fn curvature(&self, s: f64) -> f64 {
        size(self.curve.bend(s))
    }
}

/// Whether this part of any of these vectors does.
fn parts_exceed(vectors: [Vector; 3], part: usize, least: f64) -> bool {
    vectors.iter().any(|vector| vector.get(part).is_some_and(|part| libm::fabs(*part) > least))
}

fn add(point: &mut PerAxis<f64>, [x, y, z]: Vector) {
    point[Axis::X] += x;
    point[Axis::Y] += y;
    point[Axis::Z] += z;
}

/// Returns the scalar product.
pub(crate) fn dot([ax, ay, az]: Vector, [bx, by, bz]: Vector) -> f64 {
    ax * bx + ay * by + az * bz
}

/// Returns the length of a vector.
pub(crate) fn size(a: Vector) -> f64 {
    square_root(dot(a, a))
}

/// Unit direction of X, Y and Z.
pub(crate) fn unit(path: &Path, s: f64) -> Vector {
    let tangent = primary(&path.tangent(s));
    let length = size(tangent);
    tangent.map(|part| part / length)
}

/// `a x + b y` for vectors x and y.
pub(crate) fn mix(a: f64, [px, py, pz]: Vector, b: f64, [qx, qy, qz]: Vector) -> Vector {
    [a * px + b * qx, a * py + b * qy, a * pz + b * qz]
}

/// X, Y and Z of a point or direction.
pub(crate) const fn primary(of: &PerAxis<f64>) -> Vector {
    let [x, y, z, ..] = of.0;
    [x, y, z]
}
