//! Knots: each motor's position and speed at points of the trajectory, and the segments between them.
//!
//! Between two knots a motor follows the cubic that has the right position and speed at both ends (Hermite).
//! For a trajectory that is a cubic of time at most, and linear kinematics, the cubic is the trajectory
//! itself. Otherwise the error is bounded by `T^4 / 384` times the fourth derivative of position (standard
//! Hermite remainder): with [`SEGMENT_SECONDS`] that is 1.6e-16 s^4 times it, a thousandth of a microstep for
//! anything a machine can follow.
//!
//! Positions at knots are fixed point, rounded once: what one segment ends with the next begins with, so
//! steps add up exactly for ever.

use units::{Actuator, Axis, PerActuator, PerAxis, StepPosition};

use crate::{
    config::MotionConfig,
    convert::{fixed_24, float_of_i64},
    greatest,
    trajectory::TickTime,
};

/// Greatest distance of knots. Shorter than the millisecond that accuracy asks for, so that a hold finds
/// little already written ahead.
pub const SEGMENT_SECONDS: f64 = 0.000_5;
/// Greatest distance of knots where many blocks with a limit of jerk wait, and more must be written ahead: a
/// hold waits for segment and lead together ([`crate::feed_schedule`]).
pub(crate) const SHORT_SEGMENT_SECONDS: f64 = 0.000_3;

/// Steps below which a position is surely within [`units::StepCount`]: half its range.
pub(crate) const MAX_STEPS: f64 = 1_073_741_824.0;

/// Fixed-point units of a [`StepPosition`] in one step.
pub(crate) const STEP_UNITS: f64 = 16_777_216.0;

/// The movement of one motor between two knots.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Span {
    /// Position at the beginning.
    pub start: StepPosition,
    /// Position at the end.
    pub end: StepPosition,
    /// Speed at the beginning, in steps per segment duration.
    pub entry: f64,
    /// Speed at the end, in steps per segment duration.
    pub exit: f64,
}

/// All motors between two knots.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Segment {
    /// Time at its beginning.
    pub start: TickTime,
    /// Duration, in step clock ticks.
    pub duration: TickTime,
    /// Movement of each motor.
    pub motors: PerActuator<Span>,
    /// Power of a laser changes in it.
    pub(crate) has_power: bool,
}

/// Motor positions in steps at a machine position.
#[must_use]
pub fn step_positions(config: &MotionConfig, point: &PerAxis<f64>) -> PerActuator<StepPosition> {
    let mut steps = config.kinematics.actuators(point);
    let mut positions = PerActuator::default();
    for actuator in Actuator::ALL {
        steps[actuator] *= config.steps_per_mm(actuator);
        positions[actuator] = StepPosition::from_bits(fixed_24(steps[actuator]));
    }
    positions
}

/// Returns the motor positions as [`step_positions`] does, but of equal postures the one nearest to `before`:
/// a bed goes on turning past half a turn.
#[must_use]
pub(crate) fn step_positions_after(
    config: &MotionConfig,
    point: &PerAxis<f64>,
    before: &PerActuator<StepPosition>,
) -> PerActuator<StepPosition> {
    let mut positions = step_positions(config, point);
    for actuator in Actuator::ALL {
        if let Some(turn) = config.kinematics.turn_of(actuator) {
            let turn_units = turn * config.steps_per_mm(actuator) * STEP_UNITS;
            let behind = float_of_i64(before[actuator].to_bits() - positions[actuator].to_bits());
            let turns = if turn_units > 0.0 { libm::floor(behind / turn_units + 0.5) } else { 0.0 };
            let whole = libm::floor(turns * turn_units + 0.5) as i64;
            positions[actuator] = StepPosition::from_bits(positions[actuator].to_bits() + whole);
        }
    }
    positions
}

/// Machine position for whole steps of every motor.
#[must_use]
pub fn point_of_steps(config: &MotionConfig, steps: &PerActuator<units::StepCount>) -> PerAxis<f64> {
    let mut actuators = PerActuator::default();
    for actuator in Actuator::ALL {
        let scale = config.steps_per_mm(actuator);
        actuators[actuator] = if scale > 0.0 { f64::from(steps[actuator]) / scale } else { 0.0 };
    }
    config.kinematics.point(&actuators)
}

/// Returns the distance from the origin, mm (degrees), within which the steps of every motor can be counted;
/// zero where motors do not follow the axes in proportion.
#[inline(never)]
pub(crate) fn countable_within(config: &MotionConfig) -> f64 {
    if !config.kinematics.is_linear() {
        return 0.0;
    }
    let mut steps = PerActuator::<f64>::default();
    for axis in Axis::ALL {
        let mut unit = PerAxis::default();
        unit[axis] = 1.0;
        let motors = config.kinematics.actuators(&unit);
        for actuator in Actuator::ALL {
            steps[actuator] += libm::fabs(motors[actuator]) * config.steps_per_mm(actuator);
        }
    }
    // Half, for sums of six are rounded. At least one step for each mm, so that there is a distance.
    0.5 * MAX_STEPS / steps.0.into_iter().fold(1.0, greatest)
}

/// Whether every coordinate is a number, and every motor's steps there can be counted.
#[inline(never)]
pub(crate) fn is_countable(config: &MotionConfig, point: &PerAxis<f64>) -> bool {
    let motors = config.kinematics.actuators(point);
    let in_range = Actuator::ALL.into_iter().all(|actuator| {
        let steps = motors[actuator] * config.steps_per_mm(actuator);
        libm::fabs(steps) < MAX_STEPS
    });
    in_range && point.0.iter().all(|part| part.is_finite())
}

/// The step that a position belongs to: the nearest, halves upwards. A step is due where this changes.
#[must_use]
pub const fn nearest_step(position: StepPosition) -> units::StepCount {
    ((position.to_bits() + (1 << 23)) >> 24) as units::StepCount
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kinematics::{CoreXz, Generic, Kinematics};
    use crate::tests::rig::printer;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn steps_within_the_distance_can_be_counted(
            kind in 0_usize..6,
            scale in prop_oneof![0.01..1e6, 1.0..1000.0],
            shares in proptest::array::uniform6(-1.0..1.0),
        ) {
            let linear = [
                Kinematics::Cartesian,
                Kinematics::CoreXy,
                Kinematics::CoreXz(CoreXz::default()),
                Kinematics::HybridCoreXy,
                Kinematics::HybridCoreXz,
                Kinematics::Generic(Generic::new([[1.0, 0.5, 0.0], [-2.0, 1.0, 0.0], [0.0, 3.0, 1.0]]).expect("a map")),
            ];
            let mut config = MotionConfig { kinematics: linear[kind], ..printer() };
            config.actuators.0.iter_mut().flatten().for_each(|motor| motor.steps_per_mm *= scale);
            let reach = countable_within(&config);
            prop_assert!(reach > 0.0);
            let place = PerAxis(shares.map(|share: f64| share * reach));
            prop_assert!(is_countable(&config, &place));
        }
    }

    #[test]
    fn arms_and_towers_have_no_such_distance() {
        let config = MotionConfig { kinematics: Kinematics::LinearDelta(Default::default()), ..printer() };
        assert_eq!(countable_within(&config), 0.0);
    }

    #[test]
    fn the_nearest_step_changes_at_the_half() {
        for (position, step) in [(0.0, 0), (0.49, 0), (0.5, 1), (1.49, 1), (-0.5, 0), (-0.51, -1), (-1.5, -1)] {
            assert_eq!(nearest_step(StepPosition::from_num(position)), step, "{position}");
        }
    }
}
