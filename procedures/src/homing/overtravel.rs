//! Overtravel behind a switch: the braking distance, and the check that it is short enough.

use motion::Limits;
use units::{Actuator, Axis, MmPerSecond, MmPerSecond2, MmPerSecond3};

/// Part of the overtravel, mm, that the machine may use on purpose. The rest is for the step that closes the
/// switch and for bounces.
pub(super) const RUN_ON: f64 = 0.25;

/// Returns the distance that a motion at this speed goes on after its trigger when it brakes, mm: the steps
/// written ahead already, and the way to rest with this acceleration and jerk.
pub(super) fn braking_distance(rate: MmPerSecond, acceleration: MmPerSecond2, jerk: Option<MmPerSecond3>) -> f64 {
    let (v, a) = (rate.0, acceleration.0);
    let written_ahead = v * motion::feed::HORIZON.seconds();
    let seconds = match jerk {
        None => v / a,
        // The acceleration reaches its limit, and holds for a while...
        Some(MmPerSecond3(j)) if v * j >= a * a => v / a + a / j,
        // ...or rises and falls without reaching it.
        Some(MmPerSecond3(j)) => 2.0 * libm::sqrt(v / j),
    };
    // Deceleration is symmetric in time, so the mean speed is half the speed at its beginning.
    written_ahead + v * seconds / 2.0
}

/// Returns whether the machine may brake when the switches of these axes close at this speed; else it must
/// stop at once.
pub(super) fn brakes_in_time(rate: MmPerSecond, limits: &Limits, axes: impl Iterator<Item = Axis>) -> bool {
    let (mut acceleration, mut jerk) = (limits.acceleration, limits.jerk);
    for axis in axes {
        let own = Actuator::from_index(axis as usize).and_then(|motor| limits.actuator_acceleration[motor]);
        acceleration = own.filter(|own| *own < acceleration).unwrap_or(acceleration);
        let own = limits.axis_jerk.get(axis as usize).copied().flatten();
        jerk = own.filter(|own| jerk.is_none_or(|jerk| *own < jerk)).or(jerk);
    }
    braking_distance(rate, acceleration, jerk) <= RUN_ON
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_way_to_rest_is_that_of_the_textbook() {
        // At 30 mm/s and 500 mm/s2: 0.9 mm, and 1.5 ms written ahead.
        let braking = braking_distance(MmPerSecond(30.0), MmPerSecond2(500.0), None);
        assert!((braking - 0.945).abs() < 1e-9, "{braking}");
        // The way with limited jerk is v/2 (v/a + a/j).
        let smooth = braking_distance(MmPerSecond(30.0), MmPerSecond2(500.0), Some(MmPerSecond3(50_000.0)));
        assert!((smooth - 0.045 - 15.0 * (0.06 + 0.01)).abs() < 1e-9, "{smooth}");
        // Too slow to reach the acceleration: the way is v sqrt(v/j).
        let slow = braking_distance(MmPerSecond(2.0), MmPerSecond2(500.0), Some(MmPerSecond3(50_000.0)));
        assert!((slow - 0.003 - 2.0 * (2.0_f64 / 50_000.0).sqrt()).abs() < 1e-9, "{slow}");
    }

    #[test]
    fn slow_approaches_brake_and_fast_ones_with_lazy_axes_do_not() {
        let mut limits = Limits { acceleration: MmPerSecond2(3_000.0), ..Limits::DEFAULT };
        let brakes = |rate, limits: &Limits| brakes_in_time(MmPerSecond(rate), limits, [Axis::X, Axis::Z].into_iter());
        assert!(brakes(30.0, &limits) && !brakes(60.0, &limits));
        limits.actuator_acceleration[Actuator::Gamma] = Some(MmPerSecond2(50.0));
        assert!(!brakes(30.0, &limits) && brakes(4.0, &limits));
        limits.axis_jerk[0] = Some(MmPerSecond3(500.0));
        assert!(!brakes(4.0, &limits));
    }
}
