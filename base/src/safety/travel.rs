//! Soft endstops: positions to which homed axes may be commanded, from the configuration (`[soft endstop]`)
//! or else from its homing switches.
//!
//! A switch is at an end of its axis, at `homing_position`. No place of the axis is further from it than
//! `max_travel`: from there the machine could not be homed. So travel ends at the switch on one side, and
//! `max_travel` from it on the other.
//!
//! The range is plain if a switch belongs to an axis. Towers and arms have their switches at motors: of a
//! linear delta the height above which no carriage can go is known, of the others no place that they can
//! reach is refused. A, B and C may turn without end. Homing and searches are exempt: they go to switches and
//! contacts.
//!
//! Positions are machine coordinates as programs see them: after work, tool and G92 offsets, before leveling
//! and skew. So a bed that is measured anew does not move the ends of a program's space, and a lift of some
//! tenths of a mm is not what soft endstops are for.

use core::fmt;

use config::{ArmSolution, HomingDirection, MachineConfig};
use motion::path::Bounds;
use units::{Axis, AxisSet, PerAxis};

use crate::failure::{Failure, FailureKind, Texts};
use crate::reason::{Alarm, Reason};
use crate::tuning::Tuning;

/// Rounding error of targets, of inches for example, mm.
const ROUNDING: f64 = 1e-4;

/// The machine positions that an axis has, mm.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Range {
    least: f64,
    most: f64,
}

impl Range {
    const ENDLESS: Self = Self { least: f64::NEG_INFINITY, most: f64::INFINITY };

    /// Returns this range extended to the axis' present place: from outside the axis may come closer, and go
    /// no further out.
    fn and(self, place: f64) -> Self {
        Self {
            least: if place < self.least { place } else { self.least },
            most: if place > self.most { place } else { self.most },
        }
    }

    /// Returns the end that a target is beyond. A NaN is beyond neither, and motion refuses it.
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

/// Ranges of the machine's axes. No place is outside before [`Travel::up_to_date`].
#[derive(Clone, Debug)]
pub struct Travel {
    ranges: PerAxis<Range>,
    /// Axes that have an end.
    ending: AxisSet,
    /// Version of the homing positions from which the ranges were computed.
    home_changes: Option<u32>,
    /// State set by M211; `None`: the configuration's.
    switched: Option<bool>,
}

impl Default for Travel {
    fn default() -> Self {
        let ranges = PerAxis([Range::ENDLESS; units::MAX_AXES]);
        Self { ranges, ending: AxisSet::NONE, home_changes: None, switched: None }
    }
}

/// A move out of the travel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OutOfTravel {
    /// Axis that would leave its travel.
    pub axis: Axis,
    /// The furthest machine position asked for, mm.
    pub target: f64,
    /// Last machine position before that target within the travel, mm.
    pub end: f64,
}

impl fmt::Display for OutOfTravel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (letter, target, end) = (self.axis.letter(), self.target, self.end);
        let (small, which) = (letter.to_ascii_lowercase(), if target < end { "min" } else { "max" });
        write!(
            f,
            "machine {letter} {target:.3} is out of travel, which ends at {end:.3} ([soft endstop] {small}_{which})"
        )
    }
}

impl OutOfTravel {
    /// Returns the failure: the machine halts, or only the move is refused.
    #[cold]
    #[must_use]
    pub fn failure(&self, texts: &Texts, config: &MachineConfig) -> Failure {
        let refused = texts.refused(format_args!("{self}")).with_reason(Reason::Target).with_alarm(Alarm::SoftLimit);
        if config.soft_endstops.halt { refused.meaning(FailureKind::Alarm) } else { refused }
    }
}

impl Travel {
    /// Returns the travel, computed anew if homing positions have been corrected since, or M211 has switched
    /// it.
    pub fn up_to_date(&mut self, config: &MachineConfig, tuning: &Tuning) -> &Self {
        let changes = Some(tuning.home_changes());
        if self.home_changes != changes {
            self.home_changes = changes;
            self.ranges = PerAxis(Axis::ALL.map(|axis| range(config, tuning, axis)));
            let is_on = self.switched.unwrap_or(config.soft_endstops.enable);
            let ends = |axis: &Axis| is_on && self.ranges[*axis] != Range::ENDLESS;
            self.ending = AxisSet::collect(Axis::ALL.into_iter().filter(ends));
        }
        self
    }

    /// Switches the check of moves on or off (M211).
    pub const fn switch(&mut self, on: bool) {
        self.switched = Some(on);
        self.home_changes = None;
    }

    /// Returns whether moves are checked.
    #[must_use]
    pub fn is_on(&self, config: &MachineConfig) -> bool {
        self.switched.unwrap_or(config.soft_endstops.enable)
    }

    /// Returns the least and the greatest places of the axes, mm; infinite if an axis does not end.
    #[must_use]
    pub fn ends(&self) -> [PerAxis<f64>; 2] {
        [PerAxis(self.ranges.0.map(|range| range.least)), PerAxis(self.ranges.0.map(|range| range.most))]
    }

    /// Returns whether a place is within the travel of the axes that are homed.
    #[must_use]
    pub fn has(&self, place: &PerAxis<f64>, homed: AxisSet) -> bool {
        let held = self.ending.and(homed);
        // Each axis is tested in turn, since every line asks for this.
        Axis::ALL.into_iter().all(|axis| !held.has(axis) || self.ranges[axis].end_before(place[axis]).is_none())
    }

    /// Checks that a straight move stays within the travel of the axes that are homed. A move that begins
    /// outside may go back or come closer.
    ///
    /// # Errors
    /// The first axis that the move takes out.
    pub fn check(&self, from: &PerAxis<f64>, to: &PerAxis<f64>, homed: AxisSet) -> Result<(), OutOfTravel> {
        self.ending.and(homed).axes().try_for_each(|axis| self.check_axis(axis, from[axis], to[axis]))
    }

    /// Checks a curved move by its bounds: the furthest places along the axes.
    ///
    /// # Errors
    /// The first axis that the move takes out.
    pub fn check_bounds(&self, from: &PerAxis<f64>, bounds: &Bounds, homed: AxisSet) -> Result<(), OutOfTravel> {
        self.check(from, &bounds.least, homed)?;
        self.check(from, &bounds.most, homed)
    }

    fn check_axis(&self, axis: Axis, from: f64, target: f64) -> Result<(), OutOfTravel> {
        let range = self.ranges[axis];
        match range.and(from).end_before(target) {
            // A target further out than the beginning of the move is refused.
            Some(_) => Err(OutOfTravel { axis, target, end: range.end_before(target).unwrap_or_default() }),
            None => Ok(()),
        }
    }

    /// Returns the end of a straight move that stays within the travel of the axes that are homed: its own
    /// end, or the last point of its line before.
    #[must_use]
    pub fn cut(&self, from: &PerAxis<f64>, to: &PerAxis<f64>, homed: AxisSet) -> PerAxis<f64> {
        let mut share = 1.0;
        for axis in self.ending.and(homed).axes() {
            if let Some(end) = self.ranges[axis].and(from[axis]).end_before(to[axis]) {
                // The target is beyond the end and the beginning is not, so they differ.
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

/// Returns the range of an axis by the configuration, with missing ends by homing.
fn range(config: &MachineConfig, tuning: &Tuning, axis: Axis) -> Range {
    let (by_homing, ends) = (range_by_homing(config, tuning, axis), &config.soft_endstops);
    let written = |ends: &[Option<units::Mm>; 3]| Some(ends.get(axis as usize).copied()??.0);
    Range {
        least: written(&ends.least).unwrap_or(by_homing.least),
        most: written(&ends.most).unwrap_or(by_homing.most),
    }
}

fn range_by_homing(config: &MachineConfig, tuning: &Tuning, axis: Axis) -> Range {
    let Some(stop) = config.homing_endstop(axis) else { return Range::ENDLESS };
    let configured = tuning.homing_position(config, axis);
    // A correction is in force from the next homing on: until then the former position is.
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
        // The probe or switch on which Z homes may close above the bed: then the zero of Z is below.
        HomingDirection::ToMin if axis == Axis::Z && low > 0.0 => Range { least: 0.0, most: high + travel },
        HomingDirection::ToMin => Range { least: low, most: high + travel },
        HomingDirection::ToMax => Range { least: low - travel, most: high },
        HomingDirection::None => Range::ENDLESS,
    }
}

/// Returns whether a switch of this axis is at an end of the axis itself.
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
mod tests;
