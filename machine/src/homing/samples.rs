//! Slow approaches that are repeated: do they agree, and how well.

use core::cell::Cell;

use units::{Axis, AxisSet, PerAxis};

use crate::executor::Hands;
use crate::failure::{Failure, message};
use crate::grbl::numbers::{Alarm, Error};
use crate::ports::Ports;

/// How often a switch is approached slowly, and what is asked of it.
#[derive(Debug)]
pub(crate) struct Samples {
    /// Slow approaches.
    pub count: u8,
    /// How far they may lie apart, mm.
    pub tolerance: f64,
    /// Rounds that are added where they do not.
    pub retries: u8,
    /// Mean and deviation are said, too.
    pub tells_all: bool,
    /// How far from its place each axis has found its switch, mm: steps that were lost, or where the machine
    /// was not homed, anything.
    pub off: Cell<PerAxis<f64>>,
}

/// What the approaches to one switch have given, mm.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Spread {
    count: u32,
    least: f64,
    most: f64,
    sum: f64,
    squares: f64,
    first: f64,
}

impl Spread {
    /// One more. Sums are of the distances from the first: far from the origin squares would lose digits.
    pub(super) fn add(&mut self, at: f64) {
        if self.count == 0 {
            *self = Self { first: at, least: at, most: at, ..Self::default() };
        }
        let off = at - self.first;
        (self.least, self.most) = (self.least.min(at), self.most.max(at));
        (self.count, self.sum, self.squares) = (self.count + 1, self.sum + off, self.squares + off * off);
    }

    pub(super) fn range(&self) -> f64 {
        self.most - self.least
    }

    pub(super) fn mean(&self) -> f64 {
        self.first + self.sum / f64::from(self.count.max(1))
    }

    /// Standard deviation of the approaches.
    pub(super) fn deviation(&self) -> f64 {
        let count = f64::from(self.count.max(1));
        let mean = self.sum / count;
        libm::sqrt((self.squares / count - mean * mean).max(0.0))
    }
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

    /// The axis whose approaches lie furthest apart, where that is too far.
    pub(super) fn worst(&self, set: AxisSet, tolerance: f64) -> Option<(Axis, f64)> {
        let apart = self.of(set).map(|(axis, spread)| (axis, spread.range()));
        apart.filter(|(_, range)| *range > tolerance).max_by(|one, other| one.1.total_cmp(&other.1))
    }

    /// The mean of each.
    pub(super) fn means(&self, set: AxisSet, mut hits: PerAxis<f64>) -> PerAxis<f64> {
        self.of(set).for_each(|(axis, spread)| hits[axis] = spread.mean());
        hits
    }

    /// How well they agree.
    pub(super) fn say<P: Ports>(&self, hands: &mut Hands<'_, '_, P>, set: AxisSet, tells_all: bool) {
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

/// Why homing has failed.
pub(super) fn disagree((axis, range): (Axis, f64), samples: &Samples) -> Failure {
    let letter = axis.letter();
    let text = message(format_args!(
        "{letter}: approaches lie {range:.3} mm apart, homing_tolerance is {}: is the switch loose, or the slow_rate high?",
        samples.tolerance
    ));
    Failure::Alarm(text.numbered(Error::Locked).alarming(Alarm::HomingSearch))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn figures_are_those_of_the_approaches(at in proptest::collection::vec(-500.0..500.0_f64, 1..20)) {
            let mut spread = Spread::default();
            at.iter().for_each(|at| spread.add(*at));
            let mean = at.iter().sum::<f64>() / at.len() as f64;
            let variance = at.iter().map(|at| (at - mean) * (at - mean)).sum::<f64>() / at.len() as f64;
            let most = at.iter().copied().fold(f64::MIN, f64::max);
            let least = at.iter().copied().fold(f64::MAX, f64::min);
            prop_assert!((spread.mean() - mean).abs() < 1e-9);
            prop_assert!((spread.deviation() - variance.sqrt()).abs() < 1e-6);
            prop_assert_eq!(spread.range(), most - least);
        }
    }

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
