//! Step times of one motor within one segment.
//!
//! Local time u runs from 0 to 1 over the segment. The position relative to the step the motor stands on is the
//! cubic `x0 + u (c1 + u (c2 + u c3))` in steps, in `f32`: with at most a thousand steps and 100 000 ticks in a segment, 24 bits
//! resolve a hundredth of a tick. How many steps the segment has is not found by solving: it is the difference of the nearest
//! steps at its two knots, in integers. Solving only says when, and its result is kept between its neighbours.
//!
//! From one crossing to the next: with speed v, acceleration a and r steps to go, the time is the root of
//! `v d + a d^2 / 2 = r`, whose series in `q = a r / v^2` is `d = r/v (1 - q/2 + q^2/2 - 5 q^3/8)`. One Newton step on the
//! cubic then removes what the series leaves. Near standstill, where q is large, a bracketed search takes over; it is bounded
//! and rare (the first and last step or two of a ramp).

use crate::knots::{STEP_UNITS, Span, nearest_step};

/// One motor's way through the current segment.
#[derive(Clone, Copy, Debug, Default)]
pub struct Lane {
    x0: f32,
    c1: f32,
    c2: f32,
    c3: f32,
    /// `2 c2` and `3 c3`: the speed is `c1 + u (d2 + u d3)`.
    d2: f32,
    d3: f32,
    /// Local time of the last crossing, and the steps from there to the next.
    u: f32,
    to_go: f32,
    /// Position of the next crossing, relative as `x0`.
    target: f32,
    /// Crossings left in the current stretch, and their sign.
    left: u32,
    sign: f32,
    /// The same as a count.
    step: i32,
    /// Where the current stretch ends.
    stretch_end: f32,
    /// Position at the ends of the stretches that follow: the segment is cut where the motor turns.
    stretches: Stretches,
}

/// Monotonic stretches of a segment; a cubic has at most three.
#[derive(Clone, Copy, Debug, Default)]
struct Stretches {
    /// Local time and relative step at the end of each.
    ends: [(f32, i32); 3],
    /// How many there are, and which is current.
    count: u8,
    current: u8,
    /// Relative step at the beginning of the current one.
    step: i32,
}

/// Accept a solution when the last correction was below this share of a segment: two ticks of 100 000.
const TOLERANCE: f32 = 2e-5;
/// Relative change of speed over one step up to which the series converges fast.
const SERIES_LIMIT: f32 = 0.2;
/// The bracketed search halves 24 bits at worst, and Newton needs a few more.
const MAX_ITERATIONS: u32 = 40;

impl Lane {
    /// A motor that has nothing to do.
    pub const NONE: Self = Self {
        x0: 0.0,
        c1: 0.0,
        c2: 0.0,
        c3: 0.0,
        d2: 0.0,
        d3: 0.0,
        u: 0.0,
        to_go: 0.0,
        target: 0.0,
        left: 0,
        sign: 1.0,
        step: 1,
        stretch_end: 0.0,
        stretches: Stretches { ends: [(0.0, 0); 3], count: 0, current: 0, step: 0 },
    };

    /// Prepares the crossings of a segment. False when the motor makes no step in it.
    pub fn load(&mut self, span: &Span) -> bool {
        let first = nearest_step(span.start);
        let last = nearest_step(span.end);
        let offset_units = span.start.to_bits() - (i64::from(first) << 24);
        let way = (span.end.to_bits() - span.start.to_bits()) as f64 / STEP_UNITS;
        let (c1, c2, c3) = (span.entry, 3.0 * way - 2.0 * span.entry - span.exit, span.entry + span.exit - 2.0 * way);
        self.x0 = (offset_units as f64 / STEP_UNITS) as f32;
        self.c1 = c1 as f32;
        self.c2 = c2 as f32;
        self.c3 = c3 as f32;
        self.d2 = 2.0 * self.c2;
        self.d3 = 3.0 * self.c3;
        self.u = 0.0;
        self.stretches = Stretches::new(offset_units as f64 / STEP_UNITS, [c1, c2, c3], last - first);
        self.next_stretch()
    }

    /// Moves on to the next stretch that has crossings.
    fn next_stretch(&mut self) -> bool {
        while self.stretches.current < self.stretches.count {
            let Some((end, step)) = self.stretches.ends.get(usize::from(self.stretches.current)).copied() else {
                return false;
            };
            let steps = step - self.stretches.step;
            let from = self.stretches.step;
            self.stretches.current += 1;
            self.stretches.step = step;
            self.stretch_end = end;
            if steps != 0 {
                self.left = steps.unsigned_abs();
                self.step = steps.signum();
                self.sign = self.step as f32;
                self.target = from as f32 + 0.5 * self.sign;
                self.to_go = self.target - self.position(self.u);
                return true;
            }
            self.u = end;
        }
        false
    }

    /// What the step that [`Self::solve`] finds next adds to the count: 1 or -1.
    #[must_use]
    #[inline]
    pub fn sign(&self) -> i32 {
        self.step
    }

    /// Local time (0 to 1) of the next step. Call only while [`Self::load`] or [`Self::advance`] said there is one.
    #[must_use]
    #[inline]
    pub fn solve(&mut self) -> f32 {
        let (u, end) = (self.u, self.stretch_end);
        let bend = u * self.d3;
        let v = self.c1 + u * (self.d2 + bend);
        let a = self.d2 + bend + bend;
        let per_step = 1.0 / v;
        let way = self.to_go * per_step;
        let q = a * way * per_step;
        // Not a number compares false, so every oddity goes the careful way.
        if q < SERIES_LIMIT && q > -SERIES_LIMIT {
            let guess = u + way * (1.0 + q * (-0.5 + q * (0.5 - 0.625 * q)));
            let correction = (self.target - self.position(guess)) * per_step * (1.0 - q);
            if correction < TOLERANCE && correction > -TOLERANCE {
                self.u = between(guess + correction, u, end);
                return self.u;
            }
        }
        self.u = self.search(u, end);
        self.u
    }

    /// Steps past the crossing just solved. False when the segment has no more.
    #[inline]
    pub fn advance(&mut self) -> bool {
        self.left -= 1;
        if self.left > 0 {
            // The last solution is good to a fraction of a tick, so the next crossing is one step on; whatever is
            // missing the correction finds.
            self.target += self.sign;
            self.to_go = self.sign;
            return true;
        }
        self.u = self.stretch_end;
        self.next_stretch()
    }

    #[inline]
    fn position(&self, u: f32) -> f32 {
        self.x0 + u * (self.c1 + u * (self.c2 + u * self.c3))
    }

    #[inline]
    fn speed(&self, u: f32) -> f32 {
        self.c1 + u * (self.d2 + u * self.d3)
    }

    /// Newton's method kept inside a bracket, from the better guess of a constant acceleration.
    #[cold]
    #[inline(never)]
    fn search(&self, from: f32, to: f32) -> f32 {
        let (mut low, mut high) = (from, to);
        let mut u = self.quadratic_guess(from, to);
        for _ in 0..MAX_ITERATIONS {
            let beyond = (self.position(u) - self.target) * self.sign;
            if beyond < 0.0 {
                low = u;
            } else {
                high = u;
            }
            let v = self.speed(u);
            let next = u - beyond * self.sign / v;
            let usable = next > low && next < high;
            let better = if usable { next } else { low + 0.5 * (high - low) };
            let moved = better - u;
            u = better;
            // A fiftieth of a tick, or the end of what the bracket can resolve.
            if (moved < 2e-7 && moved > -2e-7) || high - low < 2e-7 {
                break;
            }
        }
        between(u, from, to)
    }

    /// The root of `v d + a d^2 / 2 = r` from `from`, or the middle when there is none.
    fn quadratic_guess(&self, from: f32, to: f32) -> f32 {
        let r = (self.target - self.position(from)) * self.sign;
        let v = self.speed(from) * self.sign;
        let a = (self.d2 + 2.0 * from * self.d3) * self.sign;
        let root = v + libm::sqrtf(v * v + 2.0 * a * r);
        let guess = from + 2.0 * r / root;
        if guess > from && guess < to { guess } else { from + 0.5 * (to - from) }
    }
}

fn between(u: f32, low: f32, high: f32) -> f32 {
    if u > high {
        high
    } else if u > low {
        u
    } else {
        low
    }
}

impl Stretches {
    /// Cuts the cubic where its speed changes sign. `steps` is what the whole segment must add up to.
    fn new(x0: f64, [c1, c2, c3]: [f64; 3], steps: i32) -> Self {
        let mut stretches = Self { count: 1, ..Self::default() };
        let exit = c1 + 2.0 * c2 + 3.0 * c3;
        // The speed is a parabola of u. With ends of equal sign and its vertex outside, or of that sign too, it never turns.
        let vertex_inside = -c2 * c3 > 0.0 && libm::fabs(c2) < libm::fabs(3.0 * c3);
        if (c1 * exit < 0.0) || (vertex_inside && (c1 - c2 * c2 / (3.0 * c3)) * (c1 + exit) < 0.0) {
            let position = |u: f64| x0 + u * (c1 + u * (c2 + u * c3));
            for turn in turns(c1, c2, c3).into_iter().flatten() {
                if let Some(slot) = stretches.ends.get_mut(usize::from(stretches.count) - 1) {
                    *slot = (turn as f32, libm::floor(position(turn) + 0.5) as i32);
                    stretches.count += 1;
                }
            }
        }
        if let Some(slot) = stretches.ends.get_mut(usize::from(stretches.count) - 1) {
            *slot = (1.0, steps);
        }
        stretches
    }
}

/// Where `c1 + 2 c2 u + 3 c3 u^2` is zero with 0 < u < 1, in order.
fn turns(c1: f64, c2: f64, c3: f64) -> [Option<f64>; 2] {
    let root = libm::sqrt(crate::greatest(c2 * c2 - 3.0 * c3 * c1, 0.0));
    // The two roots without cancellation: one by the larger sum, the other from their product c1 / 3 c3.
    let sum = if c2 < 0.0 { root - c2 } else { -root - c2 };
    let (first, second) = (c1 / sum, sum / (3.0 * c3));
    let inside = |u: f64| if u > 0.0 && u < 1.0 { Some(u) } else { None };
    let (low, high) = if second < first { (second, first) } else { (first, second) };
    [inside(low), inside(high)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::vec::Vec;
    use units::StepPosition;

    fn crossings(span: &Span) -> Vec<(f32, i32)> {
        let mut lane = Lane::NONE;
        let mut found = Vec::new();
        let mut more = lane.load(span);
        while more {
            found.push((lane.solve(), lane.sign()));
            more = lane.advance();
        }
        found
    }

    /// The cubic of a span in `f64`, from its definition by both ends.
    fn cubic(span: &Span, u: f64) -> f64 {
        let (start, end) = (span.start.to_num::<f64>(), span.end.to_num::<f64>());
        let (rest, u2) = (1.0 - u, u * u);
        let ends = start * (1.0 + 2.0 * u) * rest * rest + end * u2 * (3.0 - 2.0 * u);
        ends + span.entry * u * rest * rest - span.exit * u2 * rest
    }

    fn spans() -> impl Strategy<Value = Span> {
        let size = prop_oneof![Just(1.0), Just(30.0), Just(500.0)];
        (-3.0..3.0_f64, -1.0..1.0_f64, -2.0..2.0_f64, -2.0..2.0_f64, size).prop_map(
            |(start, way, entry, exit, size)| Span {
                start: StepPosition::from_num(start),
                end: StepPosition::from_num(start + way * size),
                entry: entry * size,
                exit: exit * size,
            },
        )
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(2_000))]

        #[test]
        fn steps_of_a_motor_that_turns_add_up_and_stand_on_the_cubic(span in spans()) {
            let found = crossings(&span);
            prop_assert!(found.is_sorted_by(|a, b| a.0 <= b.0) && found.iter().all(|(u, _)| (0.0..=1.0).contains(u)));
            let mut count = nearest_step(span.start);
            for (u, sign) in &found {
                let off = cubic(&span, f64::from(*u)) - (f64::from(count) + 0.5 * f64::from(*sign));
                prop_assert!(off.abs() < 2e-3, "{off} steps off at {u}");
                count += sign;
            }
            prop_assert_eq!(count, nearest_step(span.end));
        }

        #[test]
        fn between_steps_the_cubic_stays_within_half_a_step(span in spans()) {
            let mut found = crossings(&span).into_iter().peekable();
            let mut count = nearest_step(span.start);
            for tick in 0..=2_000 {
                let u = f64::from(tick) / 2_000.0;
                while let Some((_, sign)) = found.next_if(|(at, _)| f64::from(*at) <= u) {
                    count += sign;
                }
                let off = (cubic(&span, u) - f64::from(count)).abs();
                prop_assert!(off <= 0.505, "stands {off} steps away at {u}");
            }
        }
    }

    #[test]
    fn a_motor_that_only_shivers_between_two_steps_makes_none() {
        let here = StepPosition::from_num(0.3);
        assert_eq!(crossings(&Span { start: here, end: here, entry: 0.5, exit: 0.5 }), []);
        let there_and_back = crossings(&Span { start: here, end: here, entry: 4.0, exit: -4.0 });
        assert_eq!(there_and_back.iter().map(|(_, sign)| *sign).collect::<Vec<_>>(), [1, -1]);
    }
}
