//! Power of a laser along the path: its law over the speed, levels along a block, and changes of duty on
//! their way to the step queue. `motion` knows the path and asks; nothing here is looked at per step, so the
//! image has it small rather than fast.
#![cfg_attr(not(test), no_std)]
#![forbid(unsafe_code)]

use units::PowerLaw;

/// Power of a laser during a move.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Power {
    /// Share of full power at the requested speed, in 1/65535.
    pub level: u16,
    /// Dependence on the speed.
    pub law: PowerLaw,
}

impl Power {
    /// No power.
    pub const OFF: Self = Self { level: 0, law: PowerLaw::Off };
    /// Level of full power.
    pub const FULL: u16 = u16::MAX;
}

mod changes;
mod law;
mod levels;
mod output;
mod slice;
mod state;
mod store;

pub use changes::{Changes, NextChange};
pub use law::{Kind, Law};
pub use levels::{Levels, MOST_BLOCKS, Step};
pub use output::Output;
pub use slice::Slice;
pub use state::Laser;
pub use store::{Pending, PowerStore};

/// The lesser of two numbers, the same on every machine.
fn least(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

/// The greater of two numbers.
fn greatest(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

/// Most points of a [`PowerCurve`].
pub const MOST_CURVE_POINTS: usize = 32;

/// Optical power of a laser over its duty. Used backwards: a level gives that share of the optical power.
/// The duty of its points is counted from 0 at [`LaserConfig::least`] to 1 at [`LaserConfig::most`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PowerCurve {
    /// Points as `(duty, power)`, both from 0 to 1, ascending in both.
    pub points: [(f32, f32); MOST_CURVE_POINTS],
    /// Number of points in use; none for a laser whose power is proportional to the duty.
    pub count: usize,
}

/// Properties of a laser.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LaserConfig {
    /// Ticks by which the output goes up later than the power of the path does, 20 ms at most; never earlier,
    /// as the motors would have to wait for the laser.
    pub on_delay: i32,
    /// Ticks by which the output goes down later than the power of the path does, likewise.
    pub off_delay: i32,
    /// Duty of the least power above zero, 0 to 1. Levels between zero and full lie evenly between it and
    /// `most`.
    pub least: f32,
    /// Duty of full power, 0 to 1.
    pub most: f32,
    /// Powers that the laser makes of duties.
    pub curve: PowerCurve,
}

/// Longest delay of either edge: 20 ms, in ticks.
const MOST_DELAY: i32 = 4_000_000;

impl LaserConfig {
    /// Whether a laser can be like this: duties from 0 to 1 and in order, a curve that rises, delays of 20 ms
    /// at most.
    #[must_use]
    #[inline(never)]
    pub fn is_valid(&self) -> bool {
        let is_share = |value: f32| (0.0..=1.0).contains(&value);
        let delays = [self.on_delay, self.off_delay].iter().all(|delay| (0..=MOST_DELAY).contains(delay));
        delays && is_share(self.least) && is_share(self.most) && self.least <= self.most && self.curve.is_valid()
    }

    /// Returns the duty, in 1/65535, of a power from 0 to 1 of full power.
    #[must_use]
    #[inline(never)]
    pub fn duty(&self, power: f32) -> u16 {
        // A NaN is no power.
        if power.is_nan() || power <= 0.0 {
            return 0;
        }
        let share = self.curve.duty_for(if power < 1.0 { power } else { 1.0 });
        // A float cast saturates.
        ((self.least + (self.most - self.least) * share) * f32::from(Power::FULL) + 0.5) as u16
    }
}

impl PowerCurve {
    /// The points in use; `None` when there are more than fit.
    fn in_use(&self) -> Option<&[(f32, f32)]> {
        self.points.get(..self.count)
    }

    fn is_valid(&self) -> bool {
        let Some(points) = self.in_use() else { return false };
        let is_share = |value: f32| (0.0..=1.0).contains(&value);
        let is_rising = points.iter().zip(points.iter().skip(1)).all(|(a, b)| a.0 < b.0 && a.1 < b.1);
        points.iter().all(|(duty, power)| is_share(*duty) && is_share(*power)) && is_rising
    }

    /// Returns the duty that gives this share of the greatest power.
    fn duty_for(&self, share: f32) -> f32 {
        let points = self.in_use().unwrap_or_default();
        let Some((_, greatest)) = points.last() else { return share };
        let power = share * greatest;
        let mut before = (0.0, 0.0);
        for &(duty, reached) in points {
            let rise = reached - before.1;
            if power <= reached && rise > 0.0 {
                return before.0 + (duty - before.0) * (power - before.1) / rise;
            }
            before = (duty, reached);
        }
        before.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn laser(points: &[(f32, f32)]) -> LaserConfig {
        let mut curve = PowerCurve::default();
        curve.points[..points.len()].copy_from_slice(points);
        curve.count = points.len();
        LaserConfig { on_delay: 0, off_delay: 0, least: 0.1, most: 0.9, curve }
    }

    #[test]
    fn duties_lie_between_the_least_and_the_most_and_no_power_is_no_duty() {
        let plain = laser(&[]);
        let share = |power: f32| f64::from(plain.duty(power)) / 65_535.0;
        assert_eq!((plain.duty(0.0), plain.duty(-1.0), plain.duty(f32::NAN)), (0, 0, 0));
        for (power, duty) in [(1e-6, 0.1), (0.5, 0.5), (1.0, 0.9), (7.0, 0.9)] {
            assert!((share(power) - duty).abs() < 1e-4, "{power}: {}", share(power));
        }
    }

    proptest! {
        #[test]
        fn a_curve_is_used_backwards(power in 0.001..1.0_f32) {
            // Power is the square of the duty, to a third of full power, in 31 straight lines.
            let points: std::vec::Vec<_> = (1..=31).map(|n| n as f32 / 31.0).map(|duty| (duty, duty * duty / 3.0)).collect();
            let duty = f64::from(laser(&points).duty(power)) / 65_535.0;
            let wanted = 0.1 + 0.8 * f64::from(power).sqrt();
            prop_assert!((duty - wanted).abs() < 0.01, "{duty} for {wanted}");
        }
    }

    #[test]
    fn what_no_laser_can_be_like_is_refused() {
        let good = laser(&[(0.2, 0.1), (0.8, 1.0)]);
        assert!(good.is_valid());
        let mut many = good;
        many.curve.count = MOST_CURVE_POINTS + 1;
        let bad = [
            LaserConfig { least: 0.95, ..good },
            LaserConfig { most: 1.1, ..good },
            LaserConfig { least: f32::NAN, ..good },
            LaserConfig { on_delay: MOST_DELAY + 1, ..good },
            LaserConfig { off_delay: -1, ..good },
            laser(&[(0.8, 0.1), (0.2, 1.0)]),
            laser(&[(0.2, 0.5), (0.8, 0.5)]),
            many,
        ];
        assert!(bad.iter().all(|config| !config.is_valid()));
    }
}
