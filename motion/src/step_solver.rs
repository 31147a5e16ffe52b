//! Step times of one motor within one segment.
//!
//! Local time u runs from 0 to 1 over the segment. The position relative to the step the motor stands on is
//! the cubic `x0 + u (c1 + u (c2 + u c3))` in steps, in `f32`: with at most a thousand steps and 100 000
//! ticks in a segment, 24 bits resolve a hundredth of a tick. The segment's number of steps is not found by
//! solving: it is the difference of the nearest steps at its two knots, in integers. Solving only says when,
//! and its result is kept between its neighbours.
//!
//! At a speed that changes little, consecutive steps come from one `Series`. Near standstill and turning
//! points, or where the steps are few, each is solved by itself: with speed v, acceleration a and r steps to
//! go, the time is the root of `v d + a d^2 / 2 = r`, whose series in `q = a r / v^2` is `d = r/v (1 - q/2 +
//! q^2/2 - 5 q^3/8)`. One Newton step on the cubic then removes what the series leaves. For large q, a
//! bracketed search takes over; it is bounded and rare (the first and last step or two of a ramp).

use crate::{
    convert::{float_of_i64, floor_i32},
    knots::{STEP_UNITS, Span, nearest_step},
    series::{End, Scale, Series, key},
    square_root,
};

/// Solver of one motor's step times in the current segment.
#[derive(Clone, Copy, Debug)]
pub struct StepSolver {
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
    /// Direction of the steps as a count.
    step: i32,
    /// Local time at the end of the current stretch.
    stretch_end: f32,
    /// Position at the ends of the stretches that follow: the segment is cut where the motor turns.
    stretches: Stretches,
    /// The steps from `target` on, if they are many and easy, and the local time where that ends.
    series: Series,
    series_end: f32,
    /// Steps to be solved one by one before the next series is tried.
    singles: u32,
}

/// Monotonic stretches of a segment; a cubic has at most three.
#[derive(Clone, Copy, Debug, Default)]
struct Stretches {
    /// Local time and relative step at the end of each.
    ends: [(f32, i32); 3],
    /// Number of stretches, and index of the current one.
    count: u8,
    current: u8,
    /// Relative step at the beginning of the current one.
    step: i32,
}

/// Steps in a unit, a power of two: multiplying is as exact as dividing.
const STEPS_PER_UNIT: f64 = 1.0 / STEP_UNITS;
/// Accept a solution when the last correction was below this share of a segment: two ticks of 100 000.
const TOLERANCE: f32 = 2e-5;
/// Relative change of speed over one step up to which the series converges fast.
const SERIES_LIMIT: f32 = 0.2;
/// Fewer steps than this are solved one by one.
const LEAST_SERIES: u32 = 3;
/// Number of times that a series that is not good enough is tried over half the way.
const HALVINGS: u32 = 4;
/// Steps solved one by one where no series will do, before another try.
const SINGLES: u32 = 4;
/// The bracketed search halves 24 bits at worst, and Newton needs a few more.
const MAX_ITERATIONS: u32 = 40;

impl StepSolver {
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
        series: Series::NONE,
        series_end: 0.0,
        singles: 0,
    };

    /// Prepares the crossings of a segment. False when the motor makes no step in it.
    pub fn load(&mut self, span: &Span) -> bool {
        let first = nearest_step(span.start);
        let last = nearest_step(span.end);
        let offset_units = span.start.to_bits() - (i64::from(first) << 24);
        let way = float_of_i64(span.end.to_bits() - span.start.to_bits()) * STEPS_PER_UNIT;
        let (c1, c2, c3) = (span.entry, 3.0 * way - 2.0 * span.entry - span.exit, span.entry + span.exit - 2.0 * way);
        let offset = f64::from(offset_units as i32) * STEPS_PER_UNIT;
        self.x0 = offset as f32;
        self.c1 = c1 as f32;
        self.c2 = c2 as f32;
        self.c3 = c3 as f32;
        self.d2 = 2.0 * self.c2;
        self.d3 = 3.0 * self.c3;
        self.u = 0.0;
        self.stretches = Stretches::new(offset, [c1, c2, c3], last - first);
        self.drop_stretch();
        self.has_more()
    }

    /// Drops the rest of the current stretch.
    fn drop_stretch(&mut self) {
        self.left = 0;
        self.series = Series::NONE;
        self.singles = 0;
    }

    /// Forgets the segment and its steps.
    pub fn clear(&mut self) {
        self.drop_stretch();
        self.stretches.count = 0;
    }

    /// Whether the segment has another step; [`Self::sign`] is that step's then.
    #[inline]
    pub fn has_more(&mut self) -> bool {
        self.left > 0 || self.next_stretch()
    }

    /// Greatest speed anywhere in the segment at most, in steps per segment.
    pub fn speed_bound(&self) -> f32 {
        let size = |part: f32| if part < 0.0 { -part } else { part };
        size(self.c1) + size(self.d2) + size(self.d3)
    }

    /// Moves on to the next stretch that has crossings.
    #[inline(never)]
    fn next_stretch(&mut self) -> bool {
        if self.stretches.current > 0 {
            self.u = self.stretch_end;
        }
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

    /// Returns the change of the count by the next step: 1 or -1.
    #[must_use]
    #[inline]
    pub fn sign(&self) -> i32 {
        self.step
    }

    /// Writes the [`key`]s of the next steps of the current stretch, which all have [`Self::sign`], with this
    /// event word; as many as there are and fit. Says how many.
    pub(crate) fn fill(&mut self, scale: &Scale, word: u32, keys: &mut [u32]) -> usize {
        let mut filled = 0;
        while let Some(rest) = keys.get_mut(filled..)
            && !rest.is_empty()
            && self.left > 0
        {
            if self.series.left() == 0 && (self.singles > 0 || !self.begin_series(scale)) {
                self.singles = self.singles.saturating_sub(1);
                rest[0] = key(self.solve() * scale.length + scale.offset, word);
                self.pass(1);
                self.to_go = self.sign;
                filled += 1;
                continue;
            }
            let count = (self.series.left() as usize).min(rest.len());
            self.series.write(&mut rest[..count], word);
            self.pass(count as u32);
            filled += count;
            if self.series.left() == 0 {
                self.u = self.series_end;
                self.to_go = self.target - self.position(self.u);
            }
        }
        filled
    }

    /// Counts these steps as found.
    #[inline]
    fn pass(&mut self, count: u32) {
        self.left -= count;
        self.target += self.sign * count as f32;
    }

    /// Finds a series from here on, as long as it is good. False: none will be found for a while.
    fn begin_series(&mut self, scale: &Scale) -> bool {
        let sign = self.sign;
        let end = |solver: &Self, u: f32, x: f32| End { u, x: x * sign, v: solver.speed(u) * sign };
        let from = end(self, self.u, self.target - self.to_go);
        let first = self.target * sign;
        let (mut until, mut count) = (self.stretch_end, self.left);
        for _ in 0..=HALVINGS {
            if count < LEAST_SERIES {
                break;
            }
            let to = end(self, until, self.position(until));
            let series = Series::between(from, to, first, count, scale, |u| self.position(u) * sign);
            if let Some(series) = series {
                self.series = series;
                self.series_end = until;
                return true;
            }
            until = 0.5 * (self.u + until);
            let beyond = self.position(until) * sign - first;
            count = if beyond >= 0.0 { (beyond as u32 + 1).min(self.left) } else { 0 };
        }
        self.singles = SINGLES;
        false
    }

    /// Local time (0 to 1) of the next step.
    #[inline]
    fn solve(&mut self) -> f32 {
        let (u, end) = (self.u, self.stretch_end);
        let bend = u * self.d3;
        let v = self.c1 + u * (self.d2 + bend);
        let a = self.d2 + bend + bend;
        let per_step = 1.0 / v;
        let way = self.to_go * per_step;
        let q = a * way * per_step;
        // A NaN compares false, so every oddity goes the careful way.
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
        // The speed is a parabola of u. With ends of equal sign and its vertex outside, or of that sign too,
        // it never turns.
        let vertex_inside = -c2 * c3 > 0.0 && libm::fabs(c2) < libm::fabs(3.0 * c3);
        if (c1 * exit < 0.0) || (vertex_inside && (c1 - c2 * c2 / (3.0 * c3)) * (c1 + exit) < 0.0) {
            let position = |u: f64| x0 + u * (c1 + u * (c2 + u * c3));
            for turn in turns(c1, c2, c3).into_iter().flatten() {
                if let Some(slot) = stretches.ends.get_mut(usize::from(stretches.count) - 1) {
                    *slot = (turn as f32, floor_i32(position(turn) + 0.5));
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

/// Returns the roots of `c1 + 2 c2 u + 3 c3 u^2` with 0 < u < 1, in order.
fn turns(c1: f64, c2: f64, c3: f64) -> [Option<f64>; 2] {
    let root = square_root(crate::greatest(c2 * c2 - 3.0 * c3 * c1, 0.0));
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

    /// Ticks in a segment of half a millisecond.
    const LENGTH: f32 = 100_000.0;

    /// Local times and signs, taken in batches of this many.
    fn crossings(span: &Span, batch: usize) -> Vec<(f64, i32)> {
        let scale = Scale { length: LENGTH, offset: 0.5 };
        let (mut solver, mut found, mut keys) = (StepSolver::NONE, Vec::new(), std::vec![0; batch]);
        let mut more = solver.load(span);
        while more {
            let (sign, count) = (solver.sign(), solver.fill(&scale, 0, &mut keys));
            assert!(count > 0, "a step was promised");
            found.extend(keys[..count].iter().map(|key| (f64::from(key >> 5) / f64::from(LENGTH), sign)));
            more = solver.has_more();
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
        fn steps_of_a_motor_that_turns_add_up_and_stand_on_the_cubic(span in spans(), batch in 1_usize..40) {
            let found = crossings(&span, batch);
            prop_assert!(found.is_sorted_by(|a, b| a.0 <= b.0) && found.iter().all(|(u, _)| (0.0..=1.0).contains(u)));
            let mut count = nearest_step(span.start);
            for (u, sign) in &found {
                // Within two ticks of the crossing, or a rounding of it where the motor hardly moves.
                let crossing = f64::from(count) + 0.5 * f64::from(*sign);
                let off = |ticks: f64| (cubic(&span, u + ticks / f64::from(LENGTH)) - crossing) * f64::from(*sign);
                prop_assert!(off(-2.0) < 1e-4 && off(2.0) > -1e-4, "{} steps off at {u}", off(0.0));
                count += sign;
            }
            prop_assert_eq!(count, nearest_step(span.end));
        }

        #[test]
        fn the_size_of_the_batches_changes_nothing(span in spans(), batch in 1_usize..40) {
            prop_assert_eq!(crossings(&span, batch), crossings(&span, 2_000));
        }

        #[test]
        fn between_steps_the_cubic_stays_within_half_a_step(span in spans()) {
            let mut found = crossings(&span, 32).into_iter().peekable();
            let mut count = nearest_step(span.start);
            for tick in 0..=2_000 {
                let u = f64::from(tick) / 2_000.0;
                while let Some((_, sign)) = found.next_if(|(at, _)| *at <= u) {
                    count += sign;
                }
                let off = (cubic(&span, u) - f64::from(count)).abs();
                // Half a step, and what it makes in a tick at two steps in a hundred ticks.
                prop_assert!(off <= 0.525, "stands {off} steps away at {u}");
            }
        }
    }

    #[test]
    fn a_motor_that_only_shivers_between_two_steps_makes_none() {
        let here = StepPosition::from_num(0.3);
        assert_eq!(crossings(&Span { start: here, end: here, entry: 0.5, exit: 0.5 }, 8), []);
        let there_and_back = crossings(&Span { start: here, end: here, entry: 4.0, exit: -4.0 }, 8);
        assert_eq!(there_and_back.iter().map(|(_, sign)| *sign).collect::<Vec<_>>(), [1, -1]);
    }
}
