//! The speed of one block over its length: a trapezoid in closed form.
//!
//! Symbols: length L, entry speed u, cruise speed c, exit speed w, acceleration a. The peak of an
//! accelerate-decelerate pair is where the two parabolas of squared speed meet: `peak^2 = a L + (u^2 + w^2) /
//! 2`; the cruise speed cuts it off. Each ramp between speeds p and q takes `|p^2 - q^2| / 2a` of length and
//! `2 length / (p + q)` of time, which has no cancellation and no division by a.
//!
//! An override may lower the cruise speed below the entry speed; then the first ramp slows down. Rounding may
//! leave a pair of speeds that this length cannot join with exactly `a`; then one ramp over the whole length
//! joins them, and the planner's passes guarantee that its acceleration differs from `a` by rounding only.

use crate::square_root;

/// Part of a profile with constant jerk.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Phase {
    /// Duration of the phase, seconds.
    pub duration: f64,
    /// Speed at its beginning, mm/s.
    pub speed: f64,
    /// Signed acceleration at its beginning, mm/s^2.
    pub acceleration: f64,
    /// Signed jerk, mm/s^3: zero in a trapezoid.
    pub jerk: f64,
    /// Path length of the phase, mm.
    pub length: f64,
}

/// Most phases of a profile: a ramp up, a cruise, a ramp down. A block may need several profiles.
pub const MAX_PHASES: usize = 7;

/// The phases of a block. Phases that do not occur have no duration. A trapezoid has three: ramp, cruise,
/// ramp.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Profile {
    /// Phases in order of time.
    pub phases: [Phase; MAX_PHASES],
    /// Speed at the end, mm/s.
    pub exit: f64,
}

impl Phase {
    /// Path distance from its beginning after `t` seconds, mm.
    #[must_use]
    pub fn distance(&self, t: f64) -> f64 {
        (self.speed + (0.5 * self.acceleration + self.jerk / 6.0 * t) * t) * t
    }

    /// Path speed after `t` seconds, mm/s.
    #[must_use]
    pub fn speed_at(&self, t: f64) -> f64 {
        self.speed + (self.acceleration + 0.5 * self.jerk * t) * t
    }
}

/// Returns a ramp from speed `from` to speed `to` over `length`.
fn ramp(from: f64, to: f64, length: f64) -> Phase {
    let sum = from + to;
    if length <= 0.0 || sum <= 0.0 {
        return Phase::default();
    }
    let duration = 2.0 * length / sum;
    Phase { duration, speed: from, acceleration: (to - from) / duration, jerk: 0.0, length }
}

/// Returns a phase of constant speed, mm/s, over a length, mm.
pub(crate) fn cruise(speed: f64, length: f64) -> Phase {
    if length <= 0.0 || speed <= 0.0 {
        return Phase::default();
    }
    Phase { duration: length / speed, speed, acceleration: 0.0, jerk: 0.0, length }
}

impl Profile {
    /// Returns the trapezoid from `entry` over `length` mm to `exit`, at `cruise_speed` as long as possible,
    /// with `acceleration`. Speeds in mm/s, not negative; length and acceleration above zero.
    #[must_use]
    pub fn trapezoid(length: f64, entry: f64, cruise_speed: f64, exit: f64, acceleration: f64) -> Self {
        let (entry_sq, exit_sq, cruise_sq) = (entry * entry, exit * exit, cruise_speed * cruise_speed);
        let single = Self::of_phases([ramp(entry, exit, length), Phase::default(), Phase::default()], exit);
        if entry > cruise_speed {
            let slowing = (entry_sq - cruise_sq) / (2.0 * acceleration);
            let braking = (cruise_sq - exit_sq) / (2.0 * acceleration);
            if exit > cruise_speed || slowing + braking >= length {
                return single;
            }
            return Self::of(length, entry, cruise_speed, exit, [slowing, braking]);
        }
        let meeting_sq = acceleration * length + 0.5 * (entry_sq + exit_sq);
        let low_sq = if entry_sq > exit_sq { entry_sq } else { exit_sq };
        if meeting_sq <= low_sq {
            return single;
        }
        let (peak, peak_sq) =
            if meeting_sq < cruise_sq { (square_root(meeting_sq), meeting_sq) } else { (cruise_speed, cruise_sq) };
        if peak_sq < low_sq {
            return single;
        }
        let ramps = [(peak_sq - entry_sq) / (2.0 * acceleration), (peak_sq - exit_sq) / (2.0 * acceleration)];
        Self::of(length, entry, peak, exit, ramps)
    }

    fn of_phases([first, middle, last]: [Phase; 3], exit: f64) -> Self {
        let mut phases = [Phase::default(); MAX_PHASES];
        let [a, b, c, ..] = &mut phases;
        (*a, *b, *c) = (first, middle, last);
        Self { phases, exit }
    }

    fn of(length: f64, entry: f64, peak: f64, exit: f64, [first, last]: [f64; 2]) -> Self {
        let middle = length - first - last;
        Self::of_phases([ramp(entry, peak, first), cruise(peak, middle), ramp(peak, exit, last)], exit)
    }

    /// Braking from `entry` with `acceleration` until standstill, or to the end of `length` if that comes
    /// first.
    #[must_use]
    pub fn brake(length: f64, entry: f64, acceleration: f64) -> Self {
        let stopping = entry * entry / (2.0 * acceleration);
        if stopping <= length {
            return Self::of_phases([ramp(entry, 0.0, stopping), Phase::default(), Phase::default()], 0.0);
        }
        let exit = square_root(entry * entry - 2.0 * acceleration * length);
        Self::of_phases([ramp(entry, exit, length), Phase::default(), Phase::default()], exit)
    }

    /// Path length of all phases, mm.
    #[must_use]
    pub fn length(&self) -> f64 {
        self.phases.iter().map(|phase| phase.length).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn joined(profile: &Profile) -> Result<(), TestCaseError> {
        let mut speed: Option<f64> = None;
        for phase in profile.phases.iter().filter(|phase| phase.duration > 0.0) {
            if let Some(before) = speed {
                prop_assert!((before - phase.speed).abs() < 1e-6, "{before} jumps to {}", phase.speed);
            }
            let end = phase.speed + phase.acceleration * phase.duration;
            let length = 0.5 * (phase.speed + end) * phase.duration;
            prop_assert!((length - phase.length).abs() < 1e-9 * (1.0 + length), "{length} is not {}", phase.length);
            speed = Some(end);
        }
        prop_assert!((speed.unwrap_or(profile.exit) - profile.exit).abs() < 1e-6);
        Ok(())
    }

    proptest! {
        #[test]
        fn a_trapezoid_covers_its_length_within_its_limits(
            length in 1e-4_f64..500.0, entry in 0.0_f64..300.0, cruise in 0.1_f64..400.0, exit in 0.0_f64..300.0,
            acceleration in 10.0_f64..50_000.0,
        ) {
            // The case is limited to what the planner's passes allow: both ends below cruise, each reachable
            // from the other.
            let entry = entry.min(cruise);
            let exit = exit.min(cruise).min((entry * entry + 2.0 * acceleration * length).sqrt());
            let entry = entry.min((exit * exit + 2.0 * acceleration * length).sqrt());
            let profile = Profile::trapezoid(length, entry, cruise, exit, acceleration);
            prop_assert!((profile.length() - length).abs() < 1e-9 * (1.0 + length));
            // Nothing is known of the acceleration of a phase of no length.
            for phase in profile.phases.into_iter().filter(|phase| phase.duration > 1e-9) {
                prop_assert!(phase.acceleration.abs() <= acceleration * 1.000_1, "{phase:?}");
                prop_assert!(phase.speed <= cruise * 1.000_001);
            }
            joined(&profile)?;
        }

        #[test]
        fn a_lowered_cruise_speed_is_reached_by_slowing_down_first(
            length in 1.0_f64..100.0, entry in 50.0_f64..100.0, acceleration in 100.0_f64..10_000.0,
        ) {
            let lowest = (entry * entry - 2.0 * acceleration * length).max(0.0).sqrt();
            let profile = Profile::trapezoid(length, entry, 20.0, lowest.min(20.0).max(lowest), acceleration);
            prop_assert!((profile.length() - length).abs() < 1e-9 * (1.0 + length));
            let ramps = profile.phases.iter().filter(|phase| phase.duration > 1e-9);
            prop_assert!(ramps.into_iter().all(|phase| phase.acceleration.abs() <= acceleration * 1.000_1));
            joined(&profile)?;
        }

        #[test]
        fn braking_stops_or_reaches_the_end_still_moving(
            length in 1e-4_f64..100.0, entry in 0.0_f64..300.0, acceleration in 10.0_f64..50_000.0,
        ) {
            let profile = Profile::brake(length, entry, acceleration);
            prop_assert!(profile.length() <= length * 1.000_000_1);
            prop_assert!(profile.exit == 0.0 || (profile.length() - length).abs() < 1e-9);
            joined(&profile)?;
        }
    }
}
