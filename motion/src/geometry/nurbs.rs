//! NURBS: control points with weights, as G5.2 gives them, on the clamped uniform knots that RS-274
//! prescribes: `0 .. 0 1 2 .. n n .. n`.
//!
//! Places come from de Boor's algorithm on `(w x, w y, w)`, derivatives from its last stage but one. A piece
//! of it is drawn as the cubic with the same ends and derivatives, where that is nowhere off by more than
//! [`DRAWN_WITHIN`]; for polynomial splines up to the third degree it is the same curve.

use units::{ControlPoint, MOST_CONTROL_POINTS};

use super::ParametricCurve;

/// Orders: 2 is a polygon, 3 bends like a parabola, 4 like a cubic.
pub const ORDERS: core::ops::RangeInclusive<usize> = 2..=6;
/// Greatest distance of a cubic from the curve it stands for, mm.
const DRAWN_WITHIN: f64 = 1e-5;

/// A level curve of this kind.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Nurbs {
    points: [ControlPoint; MOST_CONTROL_POINTS],
    count: usize,
    order: usize,
}

/// Homogeneous: `w x`, `w y`, `w`.
type Raised = [f64; 3];

fn between(a: Raised, b: Raised, share: f64) -> Raised {
    let ([ax, ay, aw], [bx, by, bw]) = (a, b);
    [ax + (bx - ax) * share, ay + (by - ay) * share, aw + (bw - aw) * share]
}

impl Nurbs {
    /// Creates a curve from its points and order. `None` when there are fewer points than the order or too
    /// many, the order is none of [`ORDERS`], or a weight is not above zero.
    #[must_use]
    pub fn new(given: &[ControlPoint], order: usize) -> Option<Self> {
        let fits = ORDERS.contains(&order) && given.len() >= order && given.len() <= MOST_CONTROL_POINTS;
        if !fits || given.iter().any(|point| !(point.weight.is_finite() && point.weight > 0.0)) {
            return None;
        }
        let mut points = [ControlPoint::default(); MOST_CONTROL_POINTS];
        points.iter_mut().zip(given).for_each(|(slot, point)| *slot = *point);
        Some(Self { points, count: given.len(), order })
    }

    fn last_span(&self) -> usize {
        self.count - self.order
    }

    fn knot(&self, index: usize) -> f64 {
        (index + 1).saturating_sub(self.order).min(self.last_span() + 1) as f64
    }

    /// The place at t and how it changes with t, by the polynomial of this span.
    fn evaluate(&self, span: usize, t: f64) -> ([f64; 2], [f64; 2]) {
        let degree = self.order - 1;
        let mut stage = [[0.0; 3]; *ORDERS.end()];
        for (slot, point) in stage.iter_mut().zip(self.points.iter().skip(span).take(self.order)) {
            *slot = [point.weight * point.x, point.weight * point.y, point.weight];
        }
        let mut change = [0.0; 3];
        for round in 1..=degree {
            if round == degree {
                // The interval of the span itself is one long.
                let [[ax, ay, aw], [bx, by, bw]] = self.last_two(&stage);
                change = [bx - ax, by - ay, bw - aw].map(|part| degree as f64 * part);
            }
            for index in (round..=degree).rev() {
                let (low, high) = (self.knot(span + index), self.knot(span + index + self.order - round));
                let share = (t - low) / (high - low);
                let pair = (stage.get(index - 1).copied(), stage.get_mut(index));
                if let (Some(before), Some(slot)) = pair {
                    *slot = between(before, *slot, share);
                }
            }
        }
        let [wx, wy, w] = stage.get(degree).copied().unwrap_or([0.0, 0.0, 1.0]);
        let ([cx, cy, cw], x, y) = (change, wx / w, wy / w);
        ([x, y], [(cx - x * cw) / w, (cy - y * cw) / w])
    }

    fn last_two(&self, stage: &[Raised]) -> [Raised; 2] {
        let at = |index: usize| stage.get(index).copied().unwrap_or_default();
        [at(self.order - 2), at(self.order - 1)]
    }
}

impl ParametricCurve for Nurbs {
    fn spans(&self) -> u32 {
        self.last_span() as u32 + 1
    }

    fn place(&self, t: f64) -> [f64; 3] {
        let ([x, y], _) = self.evaluate((t as usize).min(self.last_span()), t);
        [x, y, 0.0]
    }

    fn cubic(&self, t: f64, h: f64) -> Option<[[f64; 3]; 3]> {
        let span = (t as usize).min(self.last_span());
        let ([x0, y0], [u0, v0]) = self.evaluate(span, t);
        let ([x1, y1], [u1, v1]) = self.evaluate(span, t + h);
        // Hermite's cubic from its ends and derivatives.
        let cubic = |from: f64, to: f64, entry: f64, exit: f64| {
            let way = to - from;
            (entry * h, 3.0 * way - (2.0 * entry + exit) * h, (entry + exit) * h - 2.0 * way)
        };
        let ((ax, bx, cx), (ay, by, cy)) = (cubic(x0, x1, u0, u1), cubic(y0, y1, v0, v1));
        let is_close = |u: f64| {
            let ([x, y], _) = self.evaluate(span, t + u * h);
            let (dx, dy) = (x0 + u * (ax + u * (bx + u * cx)) - x, y0 + u * (ay + u * (by + u * cy)) - y);
            dx * dx + dy * dy <= DRAWN_WITHIN * DRAWN_WITHIN
        };
        let close = is_close(0.25) && is_close(0.5) && is_close(0.75);
        close.then_some([[ax, ay, 0.0], [bx, by, 0.0], [cx, cy, 0.0]])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::vec::Vec;

    fn point(x: f64, y: f64, weight: f64) -> ControlPoint {
        ControlPoint { x, y, weight }
    }

    #[test]
    fn three_weighted_points_make_a_quarter_of_a_circle() {
        let middle = 0.5_f64.sqrt();
        let points = [point(1.0, 0.0, 1.0), point(1.0, 1.0, middle), point(0.0, 1.0, 1.0)];
        let quarter = Nurbs::new(&points, 3).expect("a curve");
        for t in [0.0, 0.1, 0.5, 0.9, 1.0] {
            let [x, y, _] = quarter.place(t);
            assert!((x.hypot(y) - 1.0).abs() < 1e-12, "{x} {y}");
        }
    }

    #[test]
    fn nonsense_is_no_curve() {
        let points = [point(0.0, 0.0, 1.0); 3];
        assert!(Nurbs::new(&points, 4).is_none() && Nurbs::new(&points, 1).is_none());
        assert!(Nurbs::new(&[point(0.0, 0.0, 0.0); 3], 3).is_none());
        assert!(Nurbs::new(&[point(0.0, 0.0, 1.0); MOST_CONTROL_POINTS + 1], 3).is_none());
    }

    /// The definition: a weighted sum of the basis functions of Cox and de Boor.
    fn basis(nurbs: &Nurbs, index: usize, order: usize, t: f64) -> f64 {
        let knot = |n| nurbs.knot(n);
        if order == 1 {
            let last = t >= knot(nurbs.count) && knot(index + 1) >= t && knot(index) < t;
            return f64::from(u8::from((knot(index) <= t && t < knot(index + 1)) || last));
        }
        let share = |value: f64, span: f64| if span > 0.0 { value / span } else { 0.0 };
        share(t - knot(index), knot(index + order - 1) - knot(index)) * basis(nurbs, index, order - 1, t)
            + share(knot(index + order) - t, knot(index + order) - knot(index + 1))
                * basis(nurbs, index + 1, order - 1, t)
    }

    proptest! {
        #[test]
        fn places_are_those_of_the_definition_and_pieces_join(
            points in prop::collection::vec((-50.0..50.0_f64, -50.0..50.0_f64, 0.2..5.0_f64), 6..12), order in 2_usize..=6,
            share in 0.0..1.0_f64,
        ) {
            let points: Vec<_> = points.into_iter().map(|(x, y, weight)| point(x, y, weight)).collect();
            let nurbs = Nurbs::new(&points, order).expect("a curve");
            let t = share * f64::from(nurbs.spans());
            let parts = points.iter().enumerate().map(|(n, p)| (p, p.weight * basis(&nurbs, n, order, t)));
            let (x, y, w) = parts.fold((0.0, 0.0, 0.0), |(x, y, w), (p, b)| (x + b * p.x, y + b * p.y, w + b));
            let [px, py, _] = nurbs.place(t);
            prop_assert!((px - x / w).abs() < 1e-9 && (py - y / w).abs() < 1e-9, "{px} {py} is not {} {}", x / w, y / w);
            let (span, h) = ((t as usize).min(nurbs.last_span()), 1e-5);
            let (_, [u, v]) = nurbs.evaluate(span, t);
            let (([ax, ay], _), ([bx, by], _)) = (nurbs.evaluate(span, t - h), nurbs.evaluate(span, t + h));
            let off = ((bx - ax) / (2.0 * h) - u).hypot((by - ay) / (2.0 * h) - v);
            prop_assert!(off < 1e-2 + 1e-3 * u.hypot(v), "{off} off {u} {v}");
        }
    }
}
