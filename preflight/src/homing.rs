//! Duration of homing, by the ways and speeds of the configuration.

use config::{EndstopConfig, MachineConfig};
use units::{Axis, AxisSet, PerAxis};

const XY: AxisSet = AxisSet::of(Axis::X).with(Axis::Y);

/// Returns the time to the switch at `fast_rate`, back by `retract` and to it again at `slow_rate`, seconds.
/// Nobody knows how far the switch is from a machine that has not been homed: the way is taken from where
/// motion counts.
fn seconds_of(stop: &EndstopConfig, way: f64) -> f64 {
    let at = |mm: f64, rate: f64| if rate > 0.0 { mm / rate } else { 0.0 };
    at(way, stop.fast_rate.get()) + at(2.0 * stop.retract.0, stop.slow_rate.get())
}

/// Returns the time that homing these axes takes, seconds, which are so far from their switches, mm.
pub(super) fn seconds(config: &MachineConfig, axes: AxisSet, ways: &PerAxis<f64>) -> f64 {
    let (mut seconds, mut together): (f64, f64) = (0.0, 0.0);
    for axis in axes.axes() {
        let Some(stop) = config.homing_endstop(axis) else { continue };
        let own = seconds_of(stop, ways[axis]);
        if XY.has(axis) && !config.homing.corexy {
            together = if own > together { own } else { together };
        } else {
            seconds += own;
        }
    }
    seconds + together
}

#[cfg(test)]
mod tests {
    use super::*;
    use config::BoardId;

    /// Returns the time to home all axes of the sample printer, with this setting beside its own.
    fn homing(more: &str, ways: [f64; 3]) -> f64 {
        let text = include_str!("../../config/samples/cartesian.ini").replace("[endstops]\n", more);
        let (config, summary) = config::parse(text.as_bytes(), BoardId::default(), &mut ());
        assert!(summary.is_usable());
        let [x, y, z] = ways;
        seconds(&config, AxisSet::PRIMARY, &PerAxis([x, y, z, 0.0, 0.0, 0.0]))
    }

    #[test]
    fn x_and_y_home_together_unless_a_belt_joins_them() {
        // 1 s each for X and Y behind the switch, 2 s for Z; 50 mm/s to it, Z 10 mm/s.
        assert!((homing("[endstops]\n", [100.0, 50.0, 10.0]) - (3.0 + 3.0)).abs() < 1e-9);
        assert!((homing("[endstops]\n", [50.0, 150.0, 0.0]) - (4.0 + 2.0)).abs() < 1e-9);
        let belts = "[endstops]\ncommon.corexy_homing = true\n";
        assert!((homing(belts, [100.0, 50.0, 10.0]) - (3.0 + 2.0 + 3.0)).abs() < 1e-9);
    }
}
