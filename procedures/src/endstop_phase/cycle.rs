//! The motor's electrical cycle: counting in it, and an axis' travel for it.

use motion::Kinematics;
use units::{Actuator, Axis, MAX_ACTUATORS, PerActuator};

/// Microstep places of a cycle: four full steps of 256 each, as Trinamic's sine tables have them.
pub(super) const CYCLE: f64 = 1_024.0;
/// Microstep places of a full step.
pub(super) const FULL_STEP: f64 = CYCLE / 4.0;

/// Reduces places to the same place of a cycle, 0 to below `period`.
pub(super) fn within(places: f64, period: f64) -> f64 {
    let rest = places - period * libm::floor(places / period);
    // A value a hair below zero comes out as the whole period.
    if rest < period { rest } else { 0.0 }
}

/// Returns the offset to the same place of the cycle that is nearest to zero, -`period`/2 to `period`/2.
pub(super) fn nearest(places: f64, period: f64) -> f64 {
    places - period * libm::floor(places / period + 0.5)
}

/// Relation of an axis' travel to the cycles of its motors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Gearing {
    /// Direction of the axis for each motor: 1 up, -1 down, 0 if the motor does not move it.
    signs: PerActuator<i8>,
    /// Travel of the axis for a millimetre of a single motor, mm.
    pub share: f64,
}

impl Gearing {
    /// Returns the gearing of an axis of these kinematics. `None` if the axis does not follow its motors
    /// evenly everywhere, or not all of them alike: then no sum of their phases belongs to a place of the
    /// axis.
    pub(super) fn of(kinematics: &Kinematics, axis: Axis) -> Option<Self> {
        if Axis::PRIMARY.contains(&axis) && !kinematics.is_linear() {
            return None;
        }
        let at = |motors: [f64; MAX_ACTUATORS]| kinematics.point(&PerActuator(motors))[axis];
        let zero = at([0.0; MAX_ACTUATORS]);
        let mut gearing = Self { signs: PerActuator([0; MAX_ACTUATORS]), share: 0.0 };
        for motor in Actuator::ALL {
            let mut motors = PerActuator([0.0; MAX_ACTUATORS]);
            motors[motor] = 1.0;
            let share = at(motors.0) - zero;
            if libm::fabs(share) < 1e-9 {
                continue;
            }
            let alike = gearing.share == 0.0 || libm::fabs(libm::fabs(share) - gearing.share) < 1e-9 * gearing.share;
            if !alike {
                return None;
            }
            gearing.share = libm::fabs(share);
            gearing.signs[motor] = if share > 0.0 { 1 } else { -1 };
        }
        (gearing.share > 0.0).then_some(gearing)
    }

    /// Returns the motors that move the axis, and their directions.
    pub(super) fn motors(&self) -> impl Iterator<Item = (Actuator, f64)> {
        let signs = self.signs;
        Actuator::ALL.into_iter().map(move |motor| (motor, f64::from(signs[motor]))).filter(|(_, sign)| *sign != 0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use motion::kinematics::CoreXz;
    use proptest::prelude::*;
    use units::PerAxis;

    proptest! {
        #[test]
        fn places_wrap_at_both_ends(places in -1e6..1e6_f64, turns in -50..50_i32) {
            for period in [CYCLE, FULL_STEP] {
                let rest = within(places, period);
                prop_assert!((0.0..period).contains(&rest));
                let off = nearest(places, period);
                prop_assert!(libm::fabs(off) <= period / 2.0);
                let same = nearest(places + period * f64::from(turns), period);
                prop_assert!(libm::fabs(nearest(same - off, period)) < 1e-6);
                prop_assert!(libm::fabs(nearest(rest - places, period)) < 1e-6);
            }
        }

        /// The sum of the motors' phases belongs to the axis' place, wherever the other axes are.
        #[test]
        fn phases_of_the_motors_add_up_to_the_place_of_the_axis(
            place in proptest::array::uniform6(-200.0..200.0_f64), by in -50.0..50.0_f64,
        ) {
            let machines = [
                Kinematics::Cartesian,
                Kinematics::CoreXy,
                Kinematics::CoreXz(CoreXz { x: 1.0, z: 3.0 }),
                Kinematics::HybridCoreXy,
                Kinematics::HybridCoreXz,
            ];
            for (kinematics, axis) in machines.iter().flat_map(|machine| Axis::ALL.map(|axis| (machine, axis))) {
                let gearing = Gearing::of(kinematics, axis).expect("a linear machine");
                let mm = |place: &PerAxis<f64>| {
                    let motors = kinematics.actuators(place);
                    gearing.motors().map(|(motor, sign)| sign * motors[motor]).sum::<f64>() * gearing.share
                };
                let here = PerAxis(place);
                let mut there = PerAxis(place.map(|place| place * 0.5 - 3.0));
                there[axis] = here[axis] + by;
                prop_assert!((mm(&there) - mm(&here) - by).abs() < 1e-9, "{kinematics:?} {axis:?}");
            }
        }
    }

    #[test]
    fn machines_whose_axes_do_not_follow_evenly_have_no_phase() {
        for kinematics in [Kinematics::Polar, Kinematics::LinearDelta(motion::kinematics::LinearDelta::default())] {
            assert_eq!(Gearing::of(&kinematics, Axis::X), None);
        }
        assert_eq!(Gearing::of(&Kinematics::Lathe, Axis::Y), None, "no motor");
        let generic = |rows| Kinematics::Generic(motion::kinematics::Generic::new(rows).expect("a machine"));
        let uneven = generic([[1.0, 0.5, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
        assert_eq!(Gearing::of(&uneven, Axis::X), None);
        assert_eq!(Gearing::of(&uneven, Axis::Y).map(|gearing| gearing.share), Some(1.0));
        assert_eq!(Gearing::of(&Kinematics::CoreXy, Axis::X).map(|gearing| gearing.share), Some(0.5));
    }
}
