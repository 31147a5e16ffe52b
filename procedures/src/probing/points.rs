//! Probing of the bed at a series of places: over to each, down, and up again.

use base::bed::Bed;
use base::failure::{Answer, Failure};
use base::touches::Touches;
use config::ProbeConfig;
use heapless::Vec;
use units::{Axis, PerAxis};

use super::deployment::stow_after;
use super::search::{Search, search};
use crate::probing::ProbeHands;

/// Greatest depth of the bed below a touched place, mm, and the addition for each mm of way: a search beyond
/// that has a probe that fails.
const DEEPER: f64 = 1.0;
const STEEPEST: f64 = 0.05;

/// Returns the direction to the bed: -1, or 1 for a probe that searches upwards.
const fn towards_bed(probe: &ProbeConfig) -> f64 {
    if probe.reverse_z { 1.0 } else { -1.0 }
}

/// Returns the height `probe_height` away from a contact.
pub(super) fn clear_of(probe: &ProbeConfig, contact: f64) -> f64 {
    contact - towards_bed(probe) * probe.height.0
}

/// Returns the nozzle's position while the probe is over this place.
pub fn nozzle_over(bed: &Bed, [x, y]: [f64; 2]) -> [f64; 2] {
    let [dx, dy, _] = bed.probe_offsets;
    [x - dx, y - dy]
}

/// Returns the probe's position while the nozzle is here.
pub(super) fn probe_at(bed: &Bed, nozzle: &PerAxis<f64>) -> [f64; 2] {
    let [dx, dy, _] = bed.probe_offsets;
    [nozzle[Axis::X] + dx, nozzle[Axis::Y] + dy]
}

/// Checks that the probe can be brought over these places.
pub(super) fn check_reach<'c>(
    hands: &mut impl ProbeHands<'c>,
    places: impl IntoIterator<Item = [f64; 2]>,
) -> Result<(), Failure> {
    let bed = *hands.bed();
    places.into_iter().try_for_each(|place| hands.may_go_over(nozzle_over(&bed, place)))
}

/// Goes over to X and Y at this height: a nozzle that is nearer to the bed goes away from it first.
fn go_over<'c>(hands: &mut impl ProbeHands<'c>, at: [f64; 2], height: f64) -> Result<(), Failure> {
    hands.may_go_over(at)?;
    let probe = hands.tuning().probe;
    let mut target = hands.position();
    if (target[Axis::Z] - height) * towards_bed(&probe) > 0.0 {
        target[Axis::Z] = height;
        hands.go_there(target, probe.fast_rate)?;
    }
    (target[Axis::X], target[Axis::Y], target[Axis::Z]) = (at[0], at[1], height);
    hands.go_there(target, probe.fast_rate)
}

/// Finds the bed with the nozzle at X and Y, coming from this height. Stands `probe_height` away from it
/// afterwards.
pub(super) fn find_bed<'c>(hands: &mut impl ProbeHands<'c>, at: [f64; 2], from: f64) -> Result<PerAxis<f64>, Failure> {
    let probe = hands.tuning().probe;
    let mut over = hands.position();
    over[Axis::Z] = from;
    hands.go_there(over, probe.fast_rate)?;
    let contact = touch(hands, at, from, None)?;
    lift(hands, clear_of(&probe, contact[Axis::Z]))?;
    Ok(contact)
}

/// Probes the bed with the nozzle at X and Y, travelling there and back up at this height.
pub(super) fn probe_point<'c>(
    hands: &mut impl ProbeHands<'c>,
    at: [f64; 2],
    height: f64,
) -> Result<PerAxis<f64>, Failure> {
    let contact = touch(hands, at, height, None)?;
    lift(hands, height)?;
    Ok(contact)
}

/// A place of the bed that was touched: its neighbours cannot lie much deeper.
#[derive(Clone, Copy, Debug)]
pub(super) struct Neighbour {
    /// Place on the bed, X and Y, mm.
    pub at: [f64; 2],
    /// Height of the contact there, mm.
    pub contact: f64,
}

impl Neighbour {
    /// Returns the greatest distance below the neighbour's height that a search at this place goes, mm.
    fn reach(&self, [x, y]: [f64; 2]) -> f64 {
        DEEPER + STEEPEST * libm::hypot(x - self.at[0], y - self.at[1])
    }
}

/// Probes the bed like [`probe_point`] at a place with a known neighbour: a probe that fails is not pressed
/// into the bed.
pub(super) fn probe_beside<'c>(
    hands: &mut impl ProbeHands<'c>,
    place: [f64; 2],
    height: f64,
    neighbour: &Neighbour,
) -> Result<PerAxis<f64>, Failure> {
    let (bed, probe) = (*hands.bed(), hands.tuning().probe);
    // The probe reads the bed's height plus the axis's twist.
    let contact = neighbour.contact + bed.twist.at(place);
    let deepest = contact + towards_bed(&probe) * neighbour.reach(place);
    let contact = touch(hands, nozzle_over(&bed, place), height, Some(deepest))?;
    lift(hands, height)?;
    Ok(contact)
}

/// Touches the bed at each of these places, travelling at least at this height the first time, and reports X,
/// Y and height of each, mm.
pub fn touch_places<'c, const N: usize>(
    hands: &mut impl ProbeHands<'c>,
    places: &Vec<[f64; 2], N>,
    from: f64,
) -> Result<Vec<[f64; 3], N>, Failure> {
    check_reach(hands, places.iter().copied())?;
    let (offsets, probe) = (*hands.bed(), hands.tuning().probe);
    let mut touches = Vec::new();
    for place in places {
        let contact = probe_point(hands, nozzle_over(&offsets, *place), from)?[Axis::Z];
        let [x, y] = *place;
        hands.say(format_args!("X:{x:.4} Y:{y:.4} Z:{contact:.4}\n"));
        hands.drain();
        // The list holds a touch for every place.
        let _ = touches.push([x, y, contact]);
    }
    // The next place may lie far away, so the probe is lifted clear of all.
    let heights = touches.iter().map(|touch| clear_of(&probe, touch[2]));
    let clear = heights.reduce(if probe.reverse_z { f64::min } else { f64::max }).unwrap_or(from);
    lift(hands, clear)?;
    Ok(touches)
}

/// Touches with the nozzle at X and Y, coming from this height, and stays there. The excess of the probe's
/// reading by the axis's twist is subtracted from the height.
fn touch<'c>(
    hands: &mut impl ProbeHands<'c>,
    at: [f64; 2],
    height: f64,
    deepest: Option<f64>,
) -> Result<PerAxis<f64>, Failure> {
    let mut contact = touch_down_to(hands, at, height, deepest)?;
    let bed = hands.bed();
    contact[Axis::Z] -= bed.twist.at(probe_at(bed, &contact));
    Ok(contact)
}

/// Touches without correction of the twist, as often as is configured. The result of the touches is the place
/// of the contact.
pub fn touch_uncorrected<'c>(
    hands: &mut impl ProbeHands<'c>,
    nozzle: [f64; 2],
    height: f64,
) -> Result<PerAxis<f64>, Failure> {
    touch_down_to(hands, nozzle, height, None)
}

/// Touches without correction of the twist, but not beyond the Z `deepest`.
fn touch_down_to<'c>(
    hands: &mut impl ProbeHands<'c>,
    nozzle: [f64; 2],
    height: f64,
    deepest: Option<f64>,
) -> Result<PerAxis<f64>, Failure> {
    let texts = hands.texts();
    let probe = hands.tuning().probe;
    let settings = probe.samples;
    go_over(hands, nozzle, height)?;
    let over = hands.position();
    let at = probe_at(hands.bed(), &over);
    for again in 0..=u32::from(settings.retries) {
        let mut touches = Touches::default();
        let mut contact = touch_once(hands, height, deepest)?;
        touches.add(contact[Axis::Z]);
        while touches.count() < usize::from(settings.count) {
            lift(hands, contact[Axis::Z] - towards_bed(&probe) * settings.retract.0)?;
            contact = touch_once(hands, height, deepest)?;
            touches.add(contact[Axis::Z]);
        }
        if touches.agree(&settings) {
            hands.bed().scatter.add(at, &touches, again, settings.median);
            contact[Axis::Z] = touches.result(&settings);
            return Ok(contact);
        }
        lift(hands, height)?;
        let (range, [x, y]) = (touches.range(), at);
        if again == u32::from(settings.retries) {
            let text = format_args!(
                "touches at X{x:.1} Y{y:.1} lie {range:.3} mm apart, samples_tolerance is {}: is the probe firm and clean?",
                settings.tolerance.0
            );
            return Err(texts.refused(text));
        }
        hands.say(format_args!("// touches at X{x:.1} Y{y:.1} lie {range:.3} mm apart: again\n"));
        hands.drain();
    }
    // The last round always returns before this point.
    Err(Failure::refused(&"the probe was not used"))
}

/// Searches from the probe's position, not beyond `deepest`.
fn touch_once<'c>(hands: &mut impl ProbeHands<'c>, height: f64, deepest: Option<f64>) -> Result<PerAxis<f64>, Failure> {
    let probe = hands.tuning().probe;
    let over = hands.position();
    let most = probe.max_travel.0;
    let travel =
        deepest.map_or(most, |deepest| units::within((deepest - over[Axis::Z]) * towards_bed(&probe), 0.0, most));
    let down = Search::down(over, probe.slow_rate, travel, probe.reverse_z);
    let Some(contact) = search(hands, &down)? else {
        lift(hands, height)?;
        let (x, y) = (over[Axis::X], over[Axis::Y]);
        let texts = hands.texts();
        return Err(if travel < most {
            texts.refused(format_args!(
                "ZProbe not triggered at X{x:.3} Y{y:.3} on {travel:.1} mm of way, far below the point before"
            ))
        } else {
            texts.refused(format_args!("ZProbe not triggered at X{x:.3} Y{y:.3} on {travel} mm of way"))
        });
    };
    Ok(contact)
}

/// Touches the bed under the probe, at the machine's position, and lifts to the height of before.
pub fn touch_here<'c>(hands: &mut impl ProbeHands<'c>) -> Result<PerAxis<f64>, Failure> {
    let start = hands.position();
    let touched = touch(hands, [start[Axis::X], start[Axis::Y]], start[Axis::Z], None);
    let ended = match &touched {
        Ok(_) => lift(hands, start[Axis::Z]).map(|()| Answer::Ok),
        Err(failure) => Err(*failure),
    };
    stow_after(hands, ended)?;
    touched
}

fn lift<'c>(hands: &mut impl ProbeHands<'c>, height: f64) -> Result<(), Failure> {
    let mut target = hands.position();
    target[Axis::Z] = height;
    let rate = hands.tuning().probe.return_rate;
    hands.go_there(target, rate)
}
