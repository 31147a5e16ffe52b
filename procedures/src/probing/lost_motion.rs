//! Lost motion of an axis when it reverses: the contact closes on the way there and opens on the way back,
//! and between the two places lie the backlash of the axis and the contact's own hysteresis.

use base::failure::Failure;
use program::Contact;
use units::{Axis, MmPerSecond, PerAxis};

use super::search::{Search, check_homed, search};
use crate::leveling;
use crate::probing::ProbeHands;

/// Number of measurements of the lost motion.
const ROUNDS: u32 = 5;
/// Distance back from the contact before the next round, mm: more than any backlash.
const BACK: f64 = 2.0;

/// Measures the lost motion: towards the contact by this distance at most, mm.
///
/// # Errors
/// Without a probe, or when its contact is not where it should be.
pub fn lost_motion<'c>(hands: &mut impl ProbeHands<'c>, axis: Axis, distance: f64) -> Result<(), Failure> {
    if !hands.config().probe.enable {
        return Err(Failure::refused(&"no probe is configured: [zprobe] enable"));
    }
    check_homed(hands)?;
    hands.standstill()?;
    let start = hands.position();
    leveling::set_compensation_aside(hands)?;
    let measured = rounds(hands, axis, distance);
    let rate = hands.tuning().probe.fast_rate;
    let back = match measured {
        Err(failure) if !failure.is_refusal() => Ok(()),
        _ => hands.go_there(start, rate),
    };
    let put_back = leveling::put_compensation_back(hands);
    let (mean, range) = measured?;
    back.and(put_back)?;
    let letter = axis.letter();
    hands.say(format_args!(
        "{letter}: {mean:.4} mm between closing and opening, within {range:.4} mm over {ROUNDS} rounds: backlash and the \
         contact's own hysteresis\n"
    ));
    Ok(())
}

/// Returns mean and range of the lost motion, mm.
fn rounds<'c>(hands: &mut impl ProbeHands<'c>, axis: Axis, distance: f64) -> Result<(f64, f64), Failure> {
    let rate = hands.tuning().probe.slow_rate;
    let towards = if distance < 0.0 { -1.0 } else { 1.0 };
    let (mut sum, mut least, mut most) = (0.0, f64::INFINITY, f64::NEG_INFINITY);
    let mut way = distance;
    for _ in 0..ROUNDS {
        let closes = find(hands, axis, way, rate, Contact::Closes)?;
        let opens = find(hands, axis, -towards * BACK, rate, Contact::Opens)?;
        let lost = (closes - opens) * towards;
        (sum, least, most) = (sum + lost, f64::min(least, lost), f64::max(most, lost));
        // The axis goes well away from the contact, so that the next approach comes from the same side.
        let mut back = hands.position();
        back[axis] = opens - towards * BACK;
        hands.go_there(back, rate)?;
        way = towards * 2.0 * BACK;
    }
    Ok((sum / f64::from(ROUNDS), most - least))
}

/// Returns the position at which the contact changes, mm.
fn find<'c>(
    hands: &mut impl ProbeHands<'c>,
    axis: Axis,
    way: f64,
    rate: MmPerSecond,
    until: Contact,
) -> Result<f64, Failure> {
    let mut target: PerAxis<f64> = hands.position();
    target[axis] += way;
    let found = search(hands, &Search { target, rate, until })?;
    let place = found.ok_or_else(|| match until {
        Contact::Closes => Failure::refused(&"test backlash: the probe was not triggered on its way"),
        Contact::Opens => Failure::refused(&"test backlash: the probe stays triggered 2 mm back from where it closed"),
    })?;
    Ok(place[axis])
}
