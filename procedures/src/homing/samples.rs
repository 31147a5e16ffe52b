//! Repeated slow approaches to a switch, and their agreement.

use core::cell::Cell;

use base::failure::{Failure, Texts};
use base::reason::{Alarm, Reason};
use base::spread::Spread;
use units::{Axis, AxisSet, PerAxis};

use crate::endstop_phase::PhaseHands;

/// Number of slow approaches to a switch, and requirements on them.
#[derive(Debug)]
pub struct Samples {
    /// Number of slow approaches.
    pub count: u8,
    /// Greatest distance between the approaches, mm.
    pub tolerance: f64,
    /// Number of rounds that are added if the approaches do not agree.
    pub retries: u8,
    /// Whether mean and deviation are reported, too.
    pub tells_all: bool,
    /// Distance from its place at which each axis has found its switch, mm: lost steps, or anything if the
    /// machine was not homed.
    pub off: Cell<PerAxis<f64>>,
}

/// The approaches to the switches of some axes.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Round {
    spreads: [Spread; units::MAX_AXES],
    count: u8,
}

impl Round {
    pub(super) fn add(&mut self, set: AxisSet, hits: &PerAxis<f64>) {
        self.count += 1;
        for (axis, spread) in Axis::ALL.into_iter().zip(&mut self.spreads) {
            if set.has(axis) {
                spread.add(hits[axis]);
            }
        }
    }

    pub(super) const fn count(&self) -> u8 {
        self.count
    }

    fn of(&self, set: AxisSet) -> impl Iterator<Item = (Axis, &Spread)> {
        Axis::ALL.into_iter().zip(&self.spreads).filter(move |(axis, _)| set.has(*axis))
    }

    /// Returns the axis whose approaches lie furthest apart, if the distance is too great.
    pub(super) fn worst(&self, set: AxisSet, tolerance: f64) -> Option<(Axis, f64)> {
        let apart = self.of(set).map(|(axis, spread)| (axis, spread.range()));
        apart.filter(|(_, range)| *range > tolerance).max_by(|one, other| one.1.total_cmp(&other.1))
    }

    /// Returns the mean of each axis, with `hits` for the others.
    pub(super) fn means(&self, set: AxisSet, mut hits: PerAxis<f64>) -> PerAxis<f64> {
        self.of(set).for_each(|(axis, spread)| hits[axis] = spread.mean());
        hits
    }

    /// Reports the agreement of the approaches.
    pub(super) fn say<'c>(&self, hands: &mut impl PhaseHands<'c>, set: AxisSet, tells_all: bool) {
        for (axis, spread) in self.of(set) {
            let (letter, count, range) = (axis.letter(), self.count, spread.range());
            hands.say(format_args!("// {letter}: {count} approaches within {range:.4} mm"));
            if tells_all {
                hands.say(format_args!(", standard deviation {:.4} mm", spread.deviation()));
            }
            hands.say(format_args!("\n"));
        }
    }
}

/// Returns the failure of approaches that disagree.
pub(super) fn disagree(texts: &Texts, (axis, range): (Axis, f64), samples: &Samples) -> Failure {
    let letter = axis.letter();
    let text = format_args!(
        "{letter}: approaches lie {range:.3} mm apart, homing_tolerance is {}: is the switch loose, or the slow_rate high?",
        samples.tolerance
    );
    texts.alarm(text).with_reason(Reason::Locked).with_alarm(Alarm::HomingSearch)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_worst_axis_is_named() {
        let (x, y) = (AxisSet::of(Axis::X), AxisSet::of(Axis::X).with(Axis::Y));
        let mut round = Round::default();
        for (x, y) in [(1.0, 2.0), (1.01, 2.1), (0.99, 2.05)] {
            let mut hits = PerAxis([0.0; units::MAX_AXES]);
            (hits[Axis::X], hits[Axis::Y]) = (x, y);
            round.add(AxisSet::of(Axis::X).with(Axis::Y), &hits);
        }
        assert_eq!(round.worst(y, 0.05).map(|(axis, _)| axis), Some(Axis::Y));
        assert_eq!(round.worst(x, 0.05), None);
        let means = round.means(x, PerAxis([9.0; units::MAX_AXES]));
        assert!((means[Axis::X] - 1.0).abs() < 1e-12 && means[Axis::Y] == 9.0);
    }
}
