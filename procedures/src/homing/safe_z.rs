//! Clearance over the bed: Z rises before X and Y home, and homes at a place of its own.

use base::failure::Failure;
use motion::Mode;
use units::{Axis, AxisSet};

use super::XY;
use super::switches::{slowest, switch_of, towards};
use crate::endstop_phase::PhaseHands;

/// Raises Z before X or Y home, or go to the place where Z homes. A Z that homes upwards goes up anyhow, and
/// may stand on its switch.
pub(super) fn lift<'c>(hands: &mut impl PhaseHands<'c>, chosen: AxisSet) -> Result<(), Failure> {
    let config = hands.config();
    let lift = config.homing.lift.0;
    let z = switch_of(config, Axis::Z);
    let homes_up = z.is_some_and(|(_, stop)| towards(stop) > 0.0);
    let goes_aside = chosen.has(Axis::Z) && config.homing.safe_z != [None; 2] && hands.axes().homed().has_all(XY);
    if lift <= 0.0 || homes_up || chosen.and(XY).is_empty() && !goes_aside {
        return Ok(());
    }
    let Some(rate) = z.map(|(_, stop)| stop.fast_rate) else { return Ok(()) };
    let (here, homed) = (hands.position(), hands.axes().homed());
    let mut target = here;
    target[Axis::Z] += lift;
    let target = hands.travel().cut(&here, &target, homed);
    hands.go(target, rate, Mode::Feed)?;
    hands.standstill()
}

/// Goes to the place where Z homes, before it homes.
///
/// # Errors
/// When X or Y is not homed.
pub(super) fn before<'c>(hands: &mut impl PhaseHands<'c>, cycle: AxisSet) -> Result<(), Failure> {
    let config = hands.config();
    let place = config.homing.safe_z;
    if !cycle.has(Axis::Z) || place == [None; 2] {
        return Ok(());
    }
    if !hands.axes().homed().has_all(XY) {
        return Err(Failure::refused(&"Z homes at safe_z_x and safe_z_y: home X and Y first"));
    }
    let mut target = hands.position();
    for (axis, place) in [Axis::X, Axis::Y].into_iter().zip(place) {
        target[axis] = place.map_or(target[axis], |place| place.0);
    }
    let rate = slowest(config, XY, |stop| stop.fast_rate);
    hands.go(target, rate, Mode::Feed)?;
    hands.standstill()
}
