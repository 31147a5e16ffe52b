//! Pressure advance: an extruder runs ahead by a factor K (seconds) times its speed, to build up pressure in
//! the nozzle in time, and is smoothed, since a speed that jumps would ask for a jump in place.
//!
//! The advanced position is `p(t) + K p'(t)`, the second term only on moves that push filament while X or Y
//! move. The output is its average over a window of width 2h with a triangular weight: `r(t) = integral of
//! pa(x) (h - |t - x|) dx / h^2` for `|t - x| < h`.
//!
//! With F the second antiderivative of pa, the average is the second difference `(F(t + h) - 2 F(t) + F(t -
//! h)) / h^2`: three evaluations, however many stretches the window covers. F and the first antiderivative
//! are kept at the beginning of each stretch (`super::history`); within one they are polynomials. For a
//! window that lies whole in one stretch, the average of a cubic is `pa(t) + pa''(t) h^2 / 12`, which has no
//! cancellation and is exact at rest.

use super::history::{Cursor, History, seconds};
use crate::trajectory::tick_time;

/// Longest and shortest smoothing time, seconds.
pub const SMOOTH_TIME_RANGE: (f64, f64) = (0.001, 0.2);
/// Largest pressure advance factor, seconds.
pub const MAX_FACTOR: f64 = 10.0;

/// Pressure advance of one extruder.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PressureAdvance {
    /// K: millimetres of filament ahead for each mm/s of filament, seconds. Zero: off.
    pub factor: f64,
    /// Width of the smoothing window, seconds.
    pub smooth_time: f64,
}

impl PressureAdvance {
    /// Whether factor and smoothing time are in range.
    #[must_use]
    pub fn is_valid(&self) -> bool {
        (0.0..=MAX_FACTOR).contains(&self.factor)
            && (SMOOTH_TIME_RANGE.0..=SMOOTH_TIME_RANGE.1).contains(&self.smooth_time)
    }
}

/// The smoothing window of an extruder, at work.
#[derive(Clone, Copy, Debug)]
pub(super) struct Window {
    /// Axis of the extruder.
    pub axis: usize,
    /// Cursors at the front, the middle and the back of the window.
    pub cursors: [Cursor; 3],
    factor: f64,
    /// Half its width, seconds.
    half: f64,
}

impl Window {
    /// Creates the window of an extruder behind a trajectory by the latency, seconds.
    pub fn new(axis: usize, advance: &PressureAdvance, latency: f64) -> Self {
        let middle = tick_time(latency).to_bits() as u64;
        // Half the window is rounded to time units, so that the three places lie at equal distances.
        let half = (tick_time(0.5 * advance.smooth_time).to_bits() as u64).min(middle);
        let cursor = |delay| Cursor { delay, count: 0 };
        Self {
            axis,
            cursors: [cursor(middle - half), cursor(middle), cursor(middle + half)],
            factor: advance.factor,
            half: seconds(half),
        }
    }

    /// Place and speed at `time`.
    pub fn output(&self, history: &History, time: u64) -> (f64, f64) {
        let [front, middle, back] = self.cursors;
        let sums = |cursor: &Cursor| {
            history.stretch(cursor.count).sums(
                self.axis,
                self.factor,
                time.wrapping_sub(cursor.delay),
                history.reference(self.axis),
            )
        };
        let square = self.half * self.half;
        if front.count == back.count {
            let stretch = history.stretch(middle.count);
            let time = time.wrapping_sub(middle.delay);
            let (way, speed) = stretch.along(time);
            let (origin, direction) = stretch.axis(self.axis);
            let factor = stretch.factor(self.axis, self.factor);
            let bend = direction * stretch.acceleration_at(time);
            let twist = direction * stretch.jerk;
            let ahead = factor * (direction * speed) + (bend + factor * twist) * square / 12.0;
            let rate = direction * speed + factor * bend + twist * square / 12.0;
            return (origin + direction * way + ahead, rate);
        }
        let ([once_front, twice_front], [once, twice], [once_back, twice_back]) =
            (sums(&front), sums(&middle), sums(&back));
        let second = |front: f64, middle: f64, back: f64| ((front - middle) - (middle - back)) / square;
        (history.reference(self.axis) + second(twice_front, twice, twice_back), second(once_front, once, once_back))
    }
}
