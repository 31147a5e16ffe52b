//! Splines (G5, G5.1, NURBS) as moves: divided where one curve cannot be travelled evenly, and nowhere else.
//!
//! Pieces begin and end at 1024ths of the parameter of each span. A piece shorter than a micrometre becomes a
//! line; so does a piece of a 1024th that still is not tame (a cusp, or an end where two control points are
//! one): it is a millionth of the curve long or so.

use units::{Axis, PerAxis};

use crate::square_root;

use crate::path::{Bounds, Curve, Path, Spline, Vector, size};

/// Anything that can be drawn as cubics.
pub trait ParametricCurve {
    /// Returns the number of spans, each with a parameter from 0 to 1.
    fn spans(&self) -> u32;

    /// The place at parameter t, from 0 to the number of spans, mm.
    fn place(&self, t: f64) -> [f64; 3];

    /// The part of a span from t to t + h as `u (a + u (b + u c))` from its beginning, if a cubic can be
    /// that.
    fn cubic(&self, t: f64, h: f64) -> Option<[[f64; 3]; 3]>;
}

/// A Bezier curve of the third degree.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bezier {
    start: Vector,
    /// `P(u) = start + u (a + u (b + u c))`.
    cubic: [Vector; 3],
}

fn sum(terms: [(f64, Vector); 4]) -> Vector {
    let mut total = [0.0; 3];
    for (factor, vector) in terms {
        total.iter_mut().zip(vector).for_each(|(sum, part)| *sum += factor * part);
    }
    total
}

impl Bezier {
    /// Creates a cubic from its four control points, mm.
    #[must_use]
    pub fn cubic([p, q, r, s]: [[f64; 3]; 4]) -> Self {
        Self {
            start: p,
            cubic: [
                sum([(-3.0, p), (3.0, q), (0.0, r), (0.0, s)]),
                sum([(3.0, p), (-6.0, q), (3.0, r), (0.0, s)]),
                sum([(-1.0, p), (3.0, q), (-3.0, r), (1.0, s)]),
            ],
        }
    }

    /// Creates a curve of the second degree from its three control points, mm.
    #[must_use]
    pub fn quadratic([p, q, r]: [[f64; 3]; 3]) -> Self {
        let cubic =
            [sum([(-2.0, p), (2.0, q), (0.0, r), (0.0, r)]), sum([(1.0, p), (-2.0, q), (1.0, r), (0.0, r)]), [0.0; 3]];
        Self { start: p, cubic }
    }
}

impl ParametricCurve for Bezier {
    fn spans(&self) -> u32 {
        1
    }

    fn place(&self, t: f64) -> [f64; 3] {
        let [a, b, c] = self.cubic;
        sum([(1.0, self.start), (t, a), (t * t, b), (t * t * t, c)])
    }

    fn cubic(&self, t: f64, h: f64) -> Option<[[f64; 3]; 3]> {
        let [a, b, c] = self.cubic;
        Some([
            sum([(h, a), (2.0 * t * h, b), (3.0 * t * t * h, c), (0.0, c)]),
            sum([(h * h, b), (3.0 * t * h * h, c), (0.0, b), (0.0, c)]),
            c.map(|part| part * h * h * h),
        ])
    }
}

/// Parts of a span at most.
const FINEST: u32 = 1024;
/// Pieces shorter than this, mm, become lines: far below a step.
const SHORTEST: f64 = 1e-3;

/// The pieces of a spline, in order: parameter at the end, and its curve.
#[derive(Clone, Copy, Debug)]
struct Pieces<S> {
    source: S,
    /// Parameter in 1024ths of a span.
    at: u32,
    step: u32,
}

impl<S: ParametricCurve> Iterator for Pieces<S> {
    type Item = (f64, Curve);

    fn next(&mut self) -> Option<(f64, Curve)> {
        if self.at >= FINEST * self.source.spans() {
            return None;
        }
        // A step never leaves its own multiples, so that a span ends with a piece.
        let aligned = (self.at | FINEST) & (self.at | FINEST).wrapping_neg();
        let mut step = aligned.min(2 * self.step);
        let t = f64::from(self.at) / f64::from(FINEST);
        loop {
            let h = f64::from(step) / f64::from(FINEST);
            let cubic = self.source.cubic(t, h);
            let is_short = cubic.is_some_and(|parts| parts.into_iter().map(size).sum::<f64>() < SHORTEST);
            let spline = if is_short { None } else { cubic.and_then(Spline::fit) };
            if spline.is_some() || is_short || step == 1 {
                (self.at, self.step) = (self.at + step, step);
                let curve = spline.map_or(Curve::Line, Curve::Spline);
                return Some((f64::from(self.at) / f64::from(FINEST), curve));
            }
            step /= 2;
        }
    }
}

/// The moves of a spline: where each piece ends, and its curve. The other axes go along evenly with the way.
pub struct SplineMoves<S> {
    pieces: Pieces<S>,
    from: PerAxis<f64>,
    to: PerAxis<f64>,
    /// Length of all in the plane of X and Y, and up to here, mm.
    whole: f64,
    done: f64,
    last: Vector,
    bounds: Bounds,
}

impl<S: ParametricCurve + Copy> SplineMoves<S> {
    /// Creates a move from `from`, with X and Y of the spline's beginning, to `to`, with X and Y of its end.
    /// Z and the others follow evenly; the spline itself must be level.
    pub fn new(source: S, from: PerAxis<f64>, to: PerAxis<f64>) -> Self {
        let pieces = Pieces { source, at: 0, step: FINEST };
        let bounds = Bounds::of(from).and(&to);
        let mut moves = Self { pieces, from, to, whole: 0.0, done: 0.0, last: source.place(0.0), bounds };
        let mut last = moves.last;
        for (t, curve) in pieces {
            let here = source.place(t);
            moves.whole += flat_length(&curve, last, here);
            moves.bounds = moves.bounds.or(&flat_bounds(&curve, from, last, here));
            last = here;
        }
        moves
    }

    /// Returns the extent of the curve along each axis.
    #[must_use]
    pub const fn bounds(&self) -> Bounds {
        self.bounds
    }

    /// Length of the curve in the plane, mm.
    #[must_use]
    pub const fn length(&self) -> f64 {
        self.whole
    }
}

fn flat_length(curve: &Curve, [x, y, _]: Vector, [to_x, to_y, _]: Vector) -> f64 {
    match curve {
        Curve::Spline(spline) => spline.flat_length(),
        _ => square_root((to_x - x) * (to_x - x) + (to_y - y) * (to_y - y)),
    }
}

/// Bounds of a piece in the plane; the other axes are where the whole begins.
fn flat_bounds(curve: &Curve, mut from: PerAxis<f64>, [x, y, _]: Vector, [to_x, to_y, _]: Vector) -> Bounds {
    let mut to = from;
    (from[Axis::X], from[Axis::Y]) = (x, y);
    (to[Axis::X], to[Axis::Y]) = (to_x, to_y);
    match curve {
        Curve::Spline(spline) => Path::new(from, &to, spline.length(), *curve).bounds(spline.length()),
        _ => Bounds::of(from).and(&to),
    }
}

impl<S: ParametricCurve + Copy> Iterator for SplineMoves<S> {
    type Item = (PerAxis<f64>, Curve);

    fn next(&mut self) -> Option<(PerAxis<f64>, Curve)> {
        let (t, curve) = self.pieces.next()?;
        let here = self.pieces.source.place(t);
        let flat = flat_length(&curve, self.last, here);
        let rise = if self.whole > 0.0 { (self.to[Axis::Z] - self.from[Axis::Z]) * flat / self.whole } else { 0.0 };
        self.done += flat;
        self.last = here;
        let curve = match curve {
            Curve::Spline(spline) => Curve::Spline(spline.rising(rise)),
            other => other,
        };
        if self.pieces.at >= FINEST * self.pieces.source.spans() {
            return Some((self.to, curve));
        }
        let share = if self.whole > 0.0 { self.done / self.whole } else { 0.0 };
        let mut place = self.from;
        for axis in Axis::ALL {
            place[axis] += (self.to[axis] - self.from[axis]) * share;
        }
        let [x, y, _] = here;
        (place[Axis::X], place[Axis::Y]) = (x, y);
        Some((place, curve))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        geometry::Nurbs,
        path::{EVEN_WITHIN, Path},
    };
    use proptest::prelude::*;
    use std::vec::Vec;
    use units::ControlPoint;

    fn at([x, y, z]: Vector) -> PerAxis<f64> {
        PerAxis([x, y, z, 0.0, 0.0, 0.0])
    }

    /// The moves of a spline as paths, joined as the planner joins them.
    fn paths<S: ParametricCurve + Copy>(source: S, rise: f64) -> Vec<(Path, f64)> {
        let from = at(source.place(0.0));
        let mut to = at(source.place(f64::from(source.spans())));
        (to[Axis::Z], to[Axis::A]) = (rise, 1.0);
        let mut here = from;
        SplineMoves::new(source, from, to)
            .map(|(target, curve)| {
                let way = (0..3).map(|n| (target.0[n] - here.0[n]).powi(2)).sum::<f64>().sqrt();
                let length = if curve.is_line() { way } else { curve.length() };
                let path = Path::new(here, &target, length, curve);
                here = target;
                (path, length)
            })
            .collect()
    }

    fn corner() -> impl Strategy<Value = Vector> {
        (-40.0..40.0_f64, -40.0..40.0_f64).prop_map(|(x, y)| [x, y, 0.0])
    }

    /// Directions are of length one, pieces join, and distances are those of the curve.
    fn even(paths: &[(Path, f64)]) -> Result<(), TestCaseError> {
        for (path, length) in paths.iter().filter(|(path, _)| !path.curve.is_line()) {
            let mut travelled = 0.0;
            for n in 0..64 {
                let s = length * (f64::from(n) + 0.5) / 64.0;
                let [x, y, z, ..] = path.tangent(s).0;
                let pace = (x * x + y * y + z * z).sqrt();
                travelled += pace * length / 64.0;
                prop_assert!((pace - 1.0).abs() < 2e-5, "goes {pace} mm for each");
                let step = 1e-4 * length;
                let slope = |s| path.curve.slope(s);
                let bend = [0, 1, 2].map(|n| (slope(s + step)[n] - slope(s - step)[n]) / (2.0 * step));
                let exact = path.curve.bend(s);
                let off = (0..3).map(|n| (bend[n] - exact[n]).powi(2)).sum::<f64>().sqrt();
                prop_assert!(off < 1e-4 * (1.0 / length + path.curvature(s)), "bends by {bend:?}, not {exact:?}");
            }
            prop_assert!((travelled - length).abs() < 1e-5 * length + EVEN_WITHIN);
        }
        Ok(())
    }

    proptest! {
        #[test]
        fn a_bezier_is_travelled_evenly_and_stays_on_its_curve(points in prop::array::uniform4(corner()), rise in -5.0..5.0_f64) {
            let bezier = Bezier::cubic(points);
            let paths = paths(bezier, rise);
            prop_assert!(paths.len() <= 250, "{} pieces", paths.len());
            even(&paths)?;
            let (last, length) = paths.last().expect("pieces");
            let end = last.point(*length).0;
            prop_assert!((end[0] - points[3][0]).abs() < 1e-9 && (end[2] - rise).abs() < 1e-9 && (end[3] - 1.0).abs() < 1e-9);
            // Every place of the moves is on the curve.
            for (path, length) in &paths {
                let [x, y, ..] = path.point(0.37 * length).0;
                let near = (0..=20_000).map(|n| bezier.place(f64::from(n) / 20_000.0));
                let off = near.map(|[px, py, _]| (px - x).hypot(py - y)).fold(f64::INFINITY, f64::min);
                prop_assert!(off < 0.02, "{off} mm off the curve");
            }
        }

        #[test]
        fn a_nurbs_is_travelled_evenly(
            points in prop::collection::vec((corner(), 0.3..3.0_f64), 4..9), order in 2_usize..=4,
        ) {
            let points: Vec<_> =
                points.into_iter().map(|([x, y, _], weight)| ControlPoint { x, y, weight }).collect();
            let paths = paths(Nurbs::new(&points, order).expect("a curve"), 0.0);
            even(&paths)?;
            let (last, length) = paths.last().expect("pieces");
            let end = last.point(*length).0;
            let goal = points.last().expect("points");
            prop_assert!((end[0] - goal.x).abs() < 1e-9 && (end[1] - goal.y).abs() < 1e-9);
        }
    }

    #[test]
    fn cusps_and_doubled_points_end_in_lines_too_short_to_see() {
        let cusp = [[0.0, 0.0, 0.0], [20.0, 20.0, 0.0], [0.0, 20.0, 0.0], [20.0, 0.0, 0.0]];
        let doubled = [[0.0; 3], [0.0; 3], [10.0, 10.0, 0.0], [20.0, 0.0, 0.0]];
        for points in [cusp, doubled, [[5.0, 5.0, 0.0]; 4]] {
            for (path, length) in paths(Bezier::cubic(points), 0.0) {
                assert!(!path.curve.is_line() || length < 1e-3, "a line of {length} mm");
            }
        }
    }
}
