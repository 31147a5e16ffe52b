//! End and duration of homing, by the ways and speeds of the configuration.

use base::tuning::Tuning;
use config::{EndstopConfig, MachineConfig};
use units::{Axis, AxisSet, PerAxis};

const XY: AxisSet = AxisSet::of(Axis::X).with(Axis::Y);

/// Result of a foreseen homing.
#[derive(Clone, Copy, Debug)]
pub(super) struct Homed {
    /// Axes that have been homed.
    pub axes: AxisSet,
    /// Place at which the machine stands then.
    pub place: PerAxis<f64>,
    /// Duration of the homing, seconds.
    pub seconds: f64,
}

/// Returns the time to the switch at `fast_rate`, back by `retract` and to it again at `slow_rate`, seconds.
/// Nobody knows how far the switch is from a machine that has not been homed: the way is taken from where
/// motion counts.
fn seconds_of(stop: &EndstopConfig, way: f64) -> f64 {
    let at = |mm: f64, rate: f64| if rate > 0.0 { mm / rate } else { 0.0 };
    at(way, stop.fast_rate.get()) + at(2.0 * stop.retract.0, stop.slow_rate.get())
}

/// Foresees the homing of these axes, or of all when none is named.
pub(super) fn foresee(
    config: &MachineConfig,
    tuning: &Tuning,
    can_home: AxisSet,
    named: AxisSet,
    here: &PerAxis<f64>,
) -> Homed {
    let chosen = if named.is_empty() { can_home } else { named.and(can_home) };
    let mut homed = Homed { axes: chosen, place: *here, seconds: 0.0 };
    let mut together: f64 = 0.0;
    for axis in chosen.axes() {
        let Some(stop) = config.homing_endstop(axis) else { continue };
        let place = tuning.homing_position(config, axis) + tuning.home_offset()[axis];
        let seconds = seconds_of(stop, libm::fabs(here[axis] - place));
        if XY.has(axis) && !config.homing.corexy {
            together = if seconds > together { seconds } else { together };
        } else {
            homed.seconds += seconds;
        }
        homed.place[axis] = place;
    }
    homed.seconds += together;
    if config.homing.ends_over_origin(chosen) {
        (homed.place[Axis::X], homed.place[Axis::Y]) = (0.0, 0.0);
        if config.homing.delta {
            homed.place[Axis::Z] -= config.homing_endstop(Axis::Z).map_or(0.0, |stop| stop.retract.0);
        }
    }
    homed
}
