//! Step times of one motor as a cubic of the step's number: many crossings for the price of one.
//!
//! A motor's position in a segment is a cubic of time; where its speed keeps its sign it can be turned round,
//! and time is a smooth function of position. [`Series::between`] takes the cubic of position that has the
//! right time and the right slope (one over the speed) at both ends: Hermite interpolation of the inverse.
//! The error of the series is largest in the middle, and there it is measured, against the cubic itself: a
//! series that misses by more than [`TOLERANCE_TICKS`] is refused, and the solver tries half the way. For
//! constant acceleration a and speed v over a time T the error is about `T (a T / v)^3 / 26`: at 3000 mm/s^2
//! and above 25 mm/s a whole half millisecond is one series.

use crate::queue::StepEvent;

/// Greatest error of a series where it is measured: 2 ns.
const TOLERANCE_TICKS: f32 = 0.4;
/// Ends whose speeds differ by more than this factor are not tried.
const MAX_RATIO: f32 = 3.0;

/// Scale from local time of a segment (0 to 1) to ticks.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Scale {
    /// Length of the segment in ticks.
    pub length: f32,
    /// Part of a tick by which the segment begins after its first tick, and half a tick more, so that cutting
    /// off the fraction rounds.
    pub offset: f32,
}

/// An end of the stretch: local time, position relative to the segment's in steps, speed in steps per unit of
/// local time. Position and speed count in the direction of movement.
#[derive(Clone, Copy, Debug)]
pub(crate) struct End {
    pub u: f32,
    pub x: f32,
    pub v: f32,
}

/// Ticks of consecutive steps.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Series {
    /// Tick of step k: `a[0] + k (a[1] + k (a[2] + k a[3]))`.
    a: [f32; 4],
    /// Number of the next step.
    k: f32,
    /// Number of steps left.
    left: u32,
}

impl Series {
    /// No steps.
    pub const NONE: Self = Self { a: [0.0; 4], k: 0.0, left: 0 };

    /// The `count` steps from `first` (a position) on, whose last is at `to` at the latest. `position` is the
    /// solver's. `None` when the cubic is not good enough.
    #[inline]
    pub fn between(
        from: End,
        to: End,
        first: f32,
        count: u32,
        scale: &Scale,
        position: impl Fn(f32) -> f32,
    ) -> Option<Self> {
        // A NaN compares false, so there is no series.
        if !(from.v > 0.0 && to.v > 0.0 && from.v < MAX_RATIO * to.v && to.v < MAX_RATIO * from.v) {
            return None;
        }
        let (way, d) = (to.x - from.x, to.u - from.u);
        let per_way = 1.0 / way;
        let (m0, m1) = (way / from.v, way / to.v);
        let (p2, p3) = (3.0 * d - 2.0 * m0 - m1, m0 + m1 - 2.0 * d);
        let ticks_per_way = per_way * d * scale.length;
        for s in [0.5, 0.25] {
            let there = from.u + s * (m0 + s * (p2 + s * p3));
            let missed = (position(there) - from.x - s * way) * ticks_per_way;
            if !(missed < TOLERANCE_TICKS && missed > -TOLERANCE_TICKS) {
                return None;
            }
        }
        let s = (first - from.x) * per_way;
        // Coefficients of the same polynomial about the first step, one step a unit.
        let bend = 3.0 * s * p3;
        let b0 = from.u + s * (m0 + s * (p2 + s * p3));
        let b1 = per_way * (m0 + s * (2.0 * p2 + bend));
        let b2 = per_way * per_way * (p2 + bend);
        let b3 = per_way * per_way * per_way * p3;
        let a = [b0 * scale.length + scale.offset, b1 * scale.length, b2 * scale.length, b3 * scale.length];
        Some(Self { a, k: 0.0, left: count })
    }

    /// Returns the number of steps left.
    #[inline]
    pub const fn left(&self) -> u32 {
        self.left
    }

    /// Writes the next steps' events as [`key`]s; at most as many as are left.
    #[inline]
    pub fn write(&mut self, keys: &mut [u32], word: u32) {
        let [a0, a1, a2, a3] = self.a;
        let mut k = self.k;
        for slot in keys.iter_mut() {
            *slot = key(a0 + k * (a1 + k * (a2 + k * a3)), word);
            k += 1.0;
        }
        self.k = k;
        self.left -= keys.len() as u32;
    }
}

/// An event in one word: ticks from the beginning of the segment, then the event's own word. Comparing keys
/// compares times, and breaks ties by motor, so that the order is the same on every machine. The tick is cut
/// to a whole number; a negative one is zero.
#[inline]
pub(crate) fn key(tick: f32, word: u32) -> u32 {
    // A float cast saturates.
    (tick as u32) << StepEvent::BITS | word
}
