//! Moves of the tool in a paper test.

use base::failure::Failure;
use motion::Mode;
use units::{Axis, MmPerSecond, PerAxis};

use crate::paper::PaperHands;

/// Height above the target, mm, from which the tool comes down, as in Klipper, so backlash is always taken up
/// the same way.
const APPROACH: f64 = 0.5;
/// Height by which the tool is lifted at the end, mm.
pub(super) const CLEAR: f64 = 5.0;

/// Goes down to a height, always from above.
pub(super) fn go_to_height<'c>(hands: &mut impl PaperHands<'c>, height: f64) -> Result<(), Failure> {
    let rate = rate(hands);
    let mut target = hands.position();
    if target[Axis::Z] < height + APPROACH {
        target[Axis::Z] = height + APPROACH;
        hands.go(target, rate, Mode::Rapid)?;
    }
    target[Axis::Z] = height;
    hands.go_there(target, rate)
}

fn rate<'c>(hands: &mut impl PaperHands<'c>) -> MmPerSecond {
    hands.tuning().probe.slow_rate
}

/// Goes over to a place at this height, then down to another.
pub(super) fn go_over<'c>(
    hands: &mut impl PaperHands<'c>,
    [x, y]: [f64; 2],
    high: f64,
    low: f64,
) -> Result<(), Failure> {
    hands.may_go_over([x, y])?;
    let (travel, slowly) = (hands.tuning().probe.fast_rate, rate(hands));
    let mut target: PerAxis<f64> = hands.position();
    target[Axis::Z] = if target[Axis::Z] > high { target[Axis::Z] } else { high };
    hands.go(target, travel, Mode::Rapid)?;
    (target[Axis::X], target[Axis::Y]) = (x, y);
    hands.go(target, travel, Mode::Rapid)?;
    target[Axis::Z] = low;
    hands.go_there(target, slowly)
}

/// Returns the height of a place of the tool without the leveling there, mm.
pub(super) fn unleveled<'c>(hands: &mut impl PaperHands<'c>, place: &PerAxis<f64>) -> f64 {
    hands.motion(|motion| motion.compensation().motors(place))[Axis::Z]
}

pub(super) fn lift<'c>(hands: &mut impl PaperHands<'c>) -> Result<(), Failure> {
    let rate = rate(hands);
    let mut target = hands.position();
    target[Axis::Z] += CLEAR;
    hands.go_there(target, rate)
}
