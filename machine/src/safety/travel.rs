//! Soft limits: how far homed axes may be commanded, from what the configuration says of their homing
//! switches.
//!
//! A switch is at one end of its axis, at `homing_position`. No place of the axis is further from it than
//! `max_travel`: from there the machine could not be homed. So travel ends at the switch on one side, and
//! `max_travel` from it on the other.
//!
//! What that means is plain where a switch belongs to an axis. Towers and arms have theirs at motors: of a
//! linear delta the height above which no carriage can go is known, of the others nothing is refused that
//! they can reach. A, B and C may turn without end. What homing and probing do is not held against this: they
//! go where switches and contacts are.

use core::fmt;

use config::{ArmSolution, HomingDirection, MachineConfig};
use units::{Axis, AxisSet, PerAxis};

use crate::tuning::Tuning;

/// Rounding of targets, of inches for one, mm.
const ROUNDING: f64 = 1e-4;

/// The machine positions that an axis has, mm.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Range {
    least: f64,
    most: f64,
}

impl Range {
    const ENDLESS: Self = Self { least: f64::NEG_INFINITY, most: f64::INFINITY };

    /// This range and a place where the axis already is: from outside it may come closer, and no further out.
    fn and(self, place: f64) -> Self {
        Self {
            least: if place < self.least { place } else { self.least },
            most: if place > self.most { place } else { self.most },
        }
    }

    /// The end that a target is beyond. What is no number is beyond neither, and motion refuses it.
    fn end_before(self, target: f64) -> Option<f64> {
        if target < self.least - ROUNDING {
            Some(self.least)
        } else if target > self.most + ROUNDING {
            Some(self.most)
        } else {
            None
        }
    }
}

/// Where a machine can go.
#[derive(Clone, Copy, Debug)]
pub struct Travel {
    ranges: PerAxis<Range>,
}

/// A move out of the travel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OutOfTravel {
    /// The axis.
    pub axis: Axis,
    /// The machine position asked for, mm.
    pub target: f64,
    /// The last one before it that the axis has, mm.
    pub end: f64,
}

impl fmt::Display for OutOfTravel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (letter, target, end) = (self.axis.letter(), self.target, self.end);
        write!(f, "machine {letter} {target:.3} is out of travel, which ends at {end:.3} (homing_position, max_travel)")
    }
}

impl Travel {
    /// The travel of a machine whose homing positions are corrected like this.
    #[must_use]
    pub fn new(config: &MachineConfig, tuning: &Tuning) -> Self {
        Self { ranges: PerAxis(Axis::ALL.map(|axis| range(config, tuning, axis))) }
    }

    /// Whether a move stays within the travel of the axes that are homed. One that begins outside may go back
    /// or come closer.
    ///
    /// # Errors
    /// The first axis that it takes out.
    pub fn check(&self, from: &PerAxis<f64>, to: &PerAxis<f64>, homed: AxisSet) -> Result<(), OutOfTravel> {
        for axis in homed.axes() {
            let allowed = self.ranges[axis].and(from[axis]);
            if allowed.end_before(to[axis]).is_some() {
                let range = self.ranges[axis];
                return Err(OutOfTravel {
                    axis,
                    target: to[axis],
                    end: range.end_before(to[axis]).unwrap_or_default(),
                });
            }
        }
        Ok(())
    }

    /// Where a straight move must end to stay within the travel of the axes that are homed: at its own end,
    /// or at the last point of its line before.
    #[must_use]
    pub fn cut(&self, from: &PerAxis<f64>, to: &PerAxis<f64>, homed: AxisSet) -> PerAxis<f64> {
        let mut share = 1.0;
        for axis in homed.axes() {
            if let Some(end) = self.ranges[axis].and(from[axis]).end_before(to[axis]) {
                // Beyond the end and not beyond the beginning: they differ.
                let own = (end - from[axis]) / (to[axis] - from[axis]);
                share = if own < share { own } else { share };
            }
        }
        if share == 1.0 {
            return *to;
        }
        PerAxis(Axis::ALL.map(|axis| from[axis] + share * (to[axis] - from[axis])))
    }
}

fn range(config: &MachineConfig, tuning: &Tuning, axis: Axis) -> Range {
    let Some(stop) = config.homing_endstop(axis) else { return Range::ENDLESS };
    let configured = tuning.homing_position(config, axis);
    // A correction is in force from the next homing on: until then the other one is.
    let corrected = configured + tuning.home_offset()[axis];
    let (low, high) = if corrected < configured { (corrected, configured) } else { (configured, corrected) };
    if config.motion.arm_solution == ArmSolution::LinearDelta && axis == Axis::Z {
        // The middle, where all carriages are at the top, is the highest place; switches may sit higher by
        // their trims.
        let trim = tuning.trim().into_iter().fold(0.0, |least, trim| if trim < least { trim } else { least });
        return Range { most: high - trim, ..Range::ENDLESS };
    }
    if !is_of_the_axis(config.motion.arm_solution, axis) {
        return Range::ENDLESS;
    }
    let travel = stop.max_travel.0;
    match stop.homing_direction {
        // What Z homes to may close above the bed, as a probe does: then its zero is below.
        HomingDirection::ToMin if axis == Axis::Z && low > 0.0 => Range { least: 0.0, most: high + travel },
        HomingDirection::ToMin => Range { least: low, most: high + travel },
        HomingDirection::ToMax => Range { least: low - travel, most: high },
        HomingDirection::None => Range::ENDLESS,
    }
}

/// A switch of this axis is at an end of the axis itself.
const fn is_of_the_axis(arms: ArmSolution, axis: Axis) -> bool {
    match arms {
        ArmSolution::Cartesian
        | ArmSolution::CoreXy
        | ArmSolution::CoreXz
        | ArmSolution::HybridCoreXy
        | ArmSolution::HybridCoreXz
        | ArmSolution::Generic
        | ArmSolution::Lathe => axis.is_primary(),
        ArmSolution::Polar => matches!(axis, Axis::Z),
        ArmSolution::Deltesian => matches!(axis, Axis::Y),
        ArmSolution::LinearDelta | ArmSolution::RotaryDelta | ArmSolution::Morgan | ArmSolution::Winch => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use config::EndstopConfig;
    use proptest::prelude::*;
    use units::Mm;

    fn stop(axis: Axis, homing_direction: HomingDirection, position: f64, travel: f64) -> EndstopConfig {
        EndstopConfig {
            axis: Some(axis),
            homing_direction,
            homing_position: Mm(position),
            max_travel: Mm(travel),
            ..EndstopConfig::default()
        }
    }

    /// X from -5 to 215, Y without switch, Z from -100 to 0 as on a mill.
    fn mill() -> MachineConfig {
        let mut config = MachineConfig::default();
        config.endstops.push(stop(Axis::X, HomingDirection::ToMin, -5.0, 220.0)).unwrap();
        config.endstops.push(stop(Axis::Z, HomingDirection::ToMax, 0.0, 100.0)).unwrap();
        config
    }

    fn travel(config: &MachineConfig) -> Travel {
        Travel::new(config, &Tuning::new(config))
    }

    fn at(x: f64, y: f64, z: f64) -> PerAxis<f64> {
        PerAxis([x, y, z, 0.0, 0.0, 0.0])
    }

    #[test]
    fn travel_ends_at_the_switch_and_max_travel_from_it() {
        let travel = travel(&mill());
        let from = at(0.0, 0.0, 0.0);
        for inside in [at(-5.0, -1e6, -100.0), at(215.0, 1e6, 0.0), at(215.000_05, 0.0, 0.0)] {
            assert_eq!(travel.check(&from, &inside, AxisSet::ALL), Ok(()), "{inside:?}");
        }
        for (target, axis, end) in [
            (at(-5.1, 0.0, 0.0), Axis::X, -5.0),
            (at(215.1, 0.0, 0.0), Axis::X, 215.0),
            (at(0.0, 0.0, 0.1), Axis::Z, 0.0),
            (at(0.0, 0.0, -101.0), Axis::Z, -100.0),
        ] {
            let out = travel.check(&from, &target, AxisSet::ALL).unwrap_err();
            assert_eq!(out, OutOfTravel { axis, target: target[axis], end });
            assert_eq!(travel.check(&from, &target, AxisSet::ALL.without(AxisSet::of(axis))), Ok(()), "not homed");
        }
        let out = travel.check(&from, &at(300.0, 0.0, 0.0), AxisSet::ALL).unwrap_err();
        let text = "machine X 300.000 is out of travel, which ends at 215.000 (homing_position, max_travel)";
        assert_eq!(out.to_string(), text);
    }

    #[test]
    fn a_correction_moves_the_end_and_a_probe_above_the_bed_does_not_hide_it() {
        let mut config = mill();
        config.endstops.push(stop(Axis::Y, HomingDirection::ToMin, 0.0, 200.0)).unwrap();
        let mut tuning = Tuning::new(&config);
        tuning.set_home_offset(Axis::Y, -2.0);
        let corrected = Travel::new(&config, &tuning);
        assert_eq!(corrected.check(&at(0.0, 0.0, 0.0), &at(0.0, -2.0, 0.0), AxisSet::ALL), Ok(()));
        assert!(corrected.check(&at(0.0, 0.0, 0.0), &at(0.0, -2.1, 0.0), AxisSet::ALL).is_err());

        let mut printer = MachineConfig::default();
        printer.endstops.push(stop(Axis::Z, HomingDirection::ToMin, 1.5, 200.0)).unwrap();
        let printer = travel(&printer);
        assert_eq!(printer.check(&at(0.0, 0.0, 1.5), &at(0.0, 0.0, 0.0), AxisSet::ALL), Ok(()));
        assert!(printer.check(&at(0.0, 0.0, 1.5), &at(0.0, 0.0, -0.1), AxisSet::ALL).is_err());
    }

    #[test]
    fn of_towers_and_arms_only_the_top_of_a_delta_is_known() {
        let mut config = MachineConfig::default();
        for axis in Axis::ALL {
            config.endstops.push(stop(axis, HomingDirection::ToMax, 250.0, 300.0)).unwrap();
        }
        let from = at(0.0, 0.0, 0.0);
        let far = PerAxis([-1e4, 1e4, -1e4, 1e4, 1e4, 1e4]);
        for arms in [ArmSolution::LinearDelta, ArmSolution::RotaryDelta, ArmSolution::Morgan, ArmSolution::Winch] {
            config.motion.arm_solution = arms;
            assert_eq!(travel(&config).check(&from, &far, AxisSet::ALL), Ok(()), "{arms:?}");
        }
        config.motion.arm_solution = ArmSolution::LinearDelta;
        let mut tuning = Tuning::new(&config);
        tuning.set_trim([0.0, -0.5, 0.2]);
        let delta = Travel::new(&config, &tuning);
        assert_eq!(delta.check(&from, &at(0.0, 0.0, 250.5), AxisSet::ALL), Ok(()));
        assert!(delta.check(&from, &at(0.0, 0.0, 251.0), AxisSet::ALL).is_err());
    }

    #[test]
    fn a_jog_along_two_axes_ends_where_its_line_leaves_the_travel() {
        let travel = travel(&mill());
        let cut = travel.cut(&at(205.0, 0.0, 0.0), &at(225.0, 40.0, 0.0), AxisSet::ALL);
        assert_eq!(cut, at(215.0, 20.0, 0.0));
    }

    proptest! {
        /// From anywhere: the way inwards is free, no move goes further out than it begins, and what is cut
        /// passes the check.
        #[test]
        fn a_move_from_outside_may_come_closer_only(from in -500.0..500.0_f64, to in -500.0..500.0_f64) {
            let travel = travel(&mill());
            let outside = |x: f64| (-5.0 - x).max(x - 215.0).max(0.0);
            let (start, target) = (at(from, 0.0, 0.0), at(to, 3.0, 0.0));
            let same_side = (from - 105.0) * (to - 105.0) > 0.0;
            let allowed = outside(to) <= ROUNDING || same_side && outside(to) <= outside(from) + ROUNDING;
            let check = travel.check(&start, &target, AxisSet::ALL);
            prop_assert_eq!(check.is_ok(), allowed, "{:?}", check);
            let cut = travel.cut(&start, &target, AxisSet::ALL);
            prop_assert!(travel.check(&start, &cut, AxisSet::ALL).is_ok());
            prop_assert!((cut[Axis::X] - from) * (to - from) >= 0.0, "turned back: {:?}", cut);
            prop_assert_eq!(cut == target, check.is_ok());
        }
    }
}
