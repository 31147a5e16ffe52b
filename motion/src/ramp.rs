//! Ramps: from one speed to another within an acceleration and a jerk, beginning and ending without
//! acceleration.
//!
//! Symbols: the speeds u and w, their difference d, acceleration a, jerk j. The acceleration rises with j for
//! a time t1, stays for t2, falls for t1. With `d >= a^2 / j` the acceleration a is reached: `t1 = a / j`,
//! `t2 = d / a - t1`; else `t1 = sqrt(d / j)`, `t2 = 0`. The speed over time is symmetric about its middle,
//! so the length is `(u + w) / 2 * (2 t1 + t2)`.
//!
//! A longer and a shorter ramp to the same side begin alike: until its acceleration falls, a ramp may still
//! be given another end ([`Ramp::soonest`]).
//!
//! All is in closed form. For a cubic `v t + k t^3 = x` that must be solved, Cardano's formula (k > 0) or the
//! first step of Newton's method from zero (k < 0, where it can only come from below) is polished by a fixed
//! number of Newton steps.

use crate::{arithmetic::cube_root, least, profile::Phase, square_root};

/// The greatest acceleration and jerk of a ramp; both above zero.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Bounds {
    /// Greatest acceleration, in mm/s^2.
    pub acceleration: f64,
    /// Greatest jerk, in mm/s^3.
    pub jerk: f64,
}

impl Bounds {
    /// Returns the bounds that exceed neither these nor the others.
    pub fn and(&self, other: &Self) -> Self {
        Self { acceleration: least(self.acceleration, other.acceleration), jerk: least(self.jerk, other.jerk) }
    }

    /// Seconds from no acceleration to all of it.
    fn rise(&self) -> f64 {
        self.acceleration / self.jerk
    }

    /// Durations of each of the two phases with jerk, and of the one between them, for a change of speed.
    fn times(&self, change: f64) -> (f64, f64) {
        let rise = self.rise();
        if change >= self.acceleration * rise {
            (rise, change / self.acceleration - rise)
        } else {
            (square_root(change / self.jerk), 0.0)
        }
    }

    /// Length of the ramp between two speeds, in either direction, mm.
    pub fn length(&self, from: f64, to: f64) -> f64 {
        let (turn, steady) = self.times(libm::fabs(to - from));
        0.5 * (from + to) * (2.0 * turn + steady)
    }

    /// Distance in which the speed can grow from `low`, without acceleration, to `high`, still accelerating.
    /// The same backwards: no ramp down to `low` is faster than `high` this far before its end.
    pub fn launch(&self, low: f64, high: f64) -> f64 {
        let change = high - low;
        if change <= 0.0 {
            return 0.0;
        }
        let rise = self.rise();
        let gain = 0.5 * self.acceleration * rise;
        if change <= gain {
            return square_root(2.0 * change / self.jerk) * (low + change / 3.0);
        }
        let risen = low + gain;
        rise * (low + gain / 3.0) + (high - risen) * (high + risen) / (2.0 * self.acceleration)
    }

    /// Greatest speed from which a ramp down to `low` fits into `length`.
    pub fn reach(&self, low: f64, length: f64) -> f64 {
        if length <= 0.0 {
            return low;
        }
        let full = self.acceleration * self.rise();
        if length >= (low + 0.5 * full) * 2.0 * self.rise() {
            let offset = low - 0.5 * full;
            return square_root(offset * offset + 2.0 * self.acceleration * length) - 0.5 * full;
        }
        let time = cubic(2.0 * low, self.jerk, length);
        low + self.jerk * time * time
    }
}

/// The root t of `v t + k t^3 = x` next to zero; v and x not negative, and for a negative k the root before
/// the maximum.
fn cubic(v: f64, k: f64, x: f64) -> f64 {
    if x <= 0.0 {
        return 0.0;
    }
    let (mut t, steps) = if k > 0.0 {
        let (p, q) = (v / k, x / k);
        let u = cube_root(0.5 * q + square_root(0.25 * q * q + p * p * p / 27.0));
        (u - p / (3.0 * u), 3)
    } else {
        (x / v, 6)
    };
    for _ in 0..steps {
        let slope = v + 3.0 * k * t * t;
        if slope > 0.0 {
            t -= (v * t + k * t * t * t - x) / slope;
        }
    }
    if t > 0.0 { t } else { 0.0 }
}

/// A ramp between two speeds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Ramp {
    /// Speed at its beginning, mm/s.
    pub from: f64,
    /// Speed at its end, mm/s.
    pub to: f64,
    /// Limits of the ramp.
    pub bounds: Bounds,
    /// Durations of the phases with jerk and of the one between, seconds.
    turn: f64,
    steady: f64,
}

/// State of a ramp at some time.
#[derive(Clone, Copy, Debug)]
struct Moment {
    distance: f64,
    speed: f64,
    acceleration: f64,
}

impl Ramp {
    /// Creates the ramp between two speeds, mm/s, within these bounds.
    pub fn new(from: f64, to: f64, bounds: Bounds) -> Self {
        let (turn, steady) = bounds.times(libm::fabs(to - from));
        Self { from, to, bounds, turn, steady }
    }

    /// Returns the duration, seconds.
    pub fn duration(&self) -> f64 {
        2.0 * self.turn + self.steady
    }

    /// Returns the path length, mm.
    pub fn length(&self) -> f64 {
        0.5 * (self.from + self.to) * self.duration()
    }

    /// Whether the speed grows.
    pub fn rises(&self) -> bool {
        self.to > self.from
    }

    fn sign(&self) -> f64 {
        if self.rises() { 1.0 } else { -1.0 }
    }

    /// The acceleration is falling, `elapsed` seconds after the beginning: the ramp can only go on to its
    /// end.
    pub fn is_closing(&self, elapsed: f64) -> bool {
        elapsed > self.turn + self.steady
    }

    /// The end speed that is reached by letting the acceleration fall from now on.
    pub fn soonest(&self, elapsed: f64) -> f64 {
        if self.is_closing(elapsed) {
            return self.to;
        }
        let change = if elapsed < self.turn {
            self.bounds.jerk * elapsed * elapsed
        } else {
            self.bounds.jerk * self.turn * elapsed
        };
        self.from + self.sign() * change
    }

    fn moment(&self, elapsed: f64) -> Moment {
        let sign = self.sign();
        let jerk = sign * self.bounds.jerk;
        if self.is_closing(elapsed) {
            let left = self.duration() - elapsed;
            return Moment {
                distance: self.length() - (self.to - jerk * left * left / 6.0) * left,
                speed: self.to - 0.5 * jerk * left * left,
                acceleration: jerk * left,
            };
        }
        let t = if elapsed < self.turn { elapsed } else { self.turn };
        let steady = elapsed - t;
        let (speed, acceleration) = (self.from + 0.5 * jerk * t * t, jerk * t);
        Moment {
            distance: (self.from + jerk * t * t / 6.0) * t + (speed + 0.5 * acceleration * steady) * steady,
            speed: speed + acceleration * steady,
            acceleration,
        }
    }

    /// Path distance from the beginning after `elapsed` seconds, mm.
    pub fn distance(&self, elapsed: f64) -> f64 {
        self.moment(elapsed).distance
    }

    /// Path speed after `elapsed` seconds, mm/s.
    pub fn speed(&self, elapsed: f64) -> f64 {
        self.moment(elapsed).speed
    }

    /// Returns the time from the ramp's beginning at which it has covered `distance`, seconds.
    pub fn time_at(&self, distance: f64) -> f64 {
        let third = self.sign() * self.bounds.jerk / 6.0;
        let turned = self.moment(self.turn);
        if distance <= turned.distance {
            return cubic(self.from, third, distance);
        }
        let left = self.length() - distance;
        let last = (self.to - third * self.turn * self.turn) * self.turn;
        if left <= last {
            return self.duration() - cubic(self.to, -third, left);
        }
        let on = distance - turned.distance;
        let end_sq = turned.speed * turned.speed + 2.0 * turned.acceleration * on;
        self.turn + 2.0 * on / (turned.speed + square_root(if end_sq > 0.0 { end_sq } else { 0.0 }))
    }

    /// Gives the phases from one time to a later one, in order.
    pub fn phases(&self, from: f64, until: f64, mut each: impl FnMut(Phase)) {
        let jerk = self.sign() * self.bounds.jerk;
        let mut begin = 0.0;
        for (duration, jerk) in [(self.turn, jerk), (self.steady, 0.0), (self.turn, -jerk)] {
            let end = begin + duration;
            let (first, last) = (if from > begin { from } else { begin }, if until < end { until } else { end });
            if last > first {
                // A moment inside the phase settles on which side of its ends it is.
                let at = self.moment(first);
                let acceleration =
                    if first >= self.turn + self.steady { -jerk * (self.duration() - first) } else { at.acceleration };
                let mut phase = Phase { duration: last - first, speed: at.speed, acceleration, jerk, length: 0.0 };
                phase.length = phase.distance(phase.duration);
                each(phase);
            }
            begin = end;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::vec::Vec;

    fn bounds() -> impl Strategy<Value = Bounds> {
        (50.0..30_000.0_f64, 2e-4..0.2_f64)
            .prop_map(|(acceleration, rise)| Bounds { acceleration, jerk: acceleration / rise })
    }

    fn speeds() -> impl Strategy<Value = f64> {
        prop_oneof![Just(0.0), 1e-3..1.0_f64, 1.0..500.0_f64]
    }

    proptest! {
        #[test]
        fn a_ramp_keeps_its_bounds_and_joins_its_speeds(from in speeds(), to in speeds(), bounds in bounds()) {
            let ramp = Ramp::new(from, to, bounds);
            let mut phases = Vec::new();
            ramp.phases(0.0, ramp.duration(), |phase| phases.push(phase));
            let (mut speed, mut acceleration, mut length) = (from, 0.0, 0.0);
            for phase in &phases {
                prop_assert!((phase.speed - speed).abs() < 1e-9 * (1.0 + speed), "{phase:?} after {speed} mm/s");
                prop_assert!((phase.acceleration - acceleration).abs() < 1e-9 * bounds.acceleration);
                speed = phase.speed_at(phase.duration);
                acceleration = phase.acceleration + phase.jerk * phase.duration;
                length += phase.length;
                prop_assert!(acceleration.abs() <= bounds.acceleration * (1.0 + 1e-9));
                prop_assert!(phase.jerk.abs() <= bounds.jerk);
            }
            prop_assert!((speed - to).abs() < 1e-9 * (1.0 + from + to) && acceleration.abs() < 1e-9 * bounds.acceleration);
            prop_assert!((length - bounds.length(from, to)).abs() < 1e-9 * (1e-3 + length));
        }

        #[test]
        fn a_place_on_a_ramp_has_its_time(
            from in speeds(), to in speeds(), bounds in bounds(), share in 0.0..1.0_f64,
        ) {
            let ramp = Ramp::new(from, to, bounds);
            if ramp.length() < 1e-9 {
                return Ok(());
            }
            let distance = share * ramp.length();
            let time = ramp.time_at(distance);
            prop_assert!(time >= 0.0 && time <= ramp.duration() * (1.0 + 1e-9), "{time} of {}", ramp.duration());
            prop_assert!((ramp.distance(time) - distance).abs() < 1e-11 * (1.0 + ramp.length()), "{} not {distance}", ramp.distance(time));
        }

        #[test]
        fn any_part_of_a_ramp_is_as_long_as_its_phases(
            from in speeds(), to in speeds(), bounds in bounds(), a in 0.0..1.0_f64, b in 0.0..1.0_f64,
        ) {
            let ramp = Ramp::new(from, to, bounds);
            let (a, b) = (a.min(b) * ramp.duration(), a.max(b) * ramp.duration());
            let mut length = 0.0;
            ramp.phases(a, b, |phase| length += phase.length);
            prop_assert!((length - (ramp.distance(b) - ramp.distance(a))).abs() < 1e-9 * (1e-3 + ramp.length()));
        }

        #[test]
        fn the_speed_in_reach_uses_up_the_length(low in speeds(), length in 1e-6..500.0_f64, bounds in bounds()) {
            let high = bounds.reach(low, length);
            prop_assert!(high >= low);
            prop_assert!((bounds.length(high, low) - length).abs() <= 1e-9 * length, "{} not {length}", bounds.length(high, low));
        }

        #[test]
        fn no_ramp_is_faster_than_the_launch(low in speeds(), more in 0.01..400.0_f64, share in 0.01..1.0_f64, bounds in bounds()) {
            let ramp = Ramp::new(low, low + more, bounds);
            let time = share * ramp.duration();
            let launch = bounds.launch(low, ramp.speed(time));
            prop_assert!(launch <= ramp.distance(time) * (1.0 + 1e-9) + 1e-12, "{launch} after {}", ramp.distance(time));
            // While the acceleration has not fallen it is the launch itself.
            if !ramp.is_closing(time) {
                prop_assert!((launch - ramp.distance(time)).abs() < 1e-9 * (1e-3 + launch));
            }
        }

        #[test]
        fn until_it_closes_a_ramp_may_end_elsewhere(
            from in speeds(), to in speeds(), more in 0.0..1.0_f64, bounds in bounds(), share in 0.0..1.0_f64,
        ) {
            let ramp = Ramp::new(from, to, bounds);
            let elapsed = share * ramp.duration();
            let soonest = ramp.soonest(elapsed);
            let other = if ramp.rises() { soonest + 300.0 * more } else { soonest * more };
            if ramp.is_closing(elapsed) {
                return Ok(());
            }
            for target in [soonest, other] {
                let changed = Ramp::new(from, target, bounds);
                let (was, is) = (ramp.moment(elapsed), changed.moment(elapsed));
                prop_assert!((was.distance - is.distance).abs() < 1e-9 * (1e-3 + was.distance));
                prop_assert!((was.speed - is.speed).abs() < 1e-7 * (1.0 + from));
                prop_assert!((was.acceleration - is.acceleration).abs() < 1e-6 * bounds.acceleration, "{was:?} {is:?}");
            }
        }
    }
}
