//! M665.1 to M665.4: a delta's geometry from a part that it printed, measured with calipers.
//!
//! Touches say whether the bed is found flat, which hardly depends on the arms' length; the size of a part
//! does. So each distance is kept as the ways that the carriages made to its ends, and all of them together
//! with the touches of the last calibration give the geometry of the machine.

use base::failure::{Answer, Failure, Outcome, short};
use program::Words;
use units::{AxisSet, PerAxis};

use super::delta_calibration::{adopt, assumed_touches, belief, sought};
use super::delta_fit::{Belief, Distance, Evidence, deviation, fit};
use super::delta_records::MOST_DISTANCES;
use crate::arms::is_linear_delta;
use crate::probing::ProbeHands;

/// Greatest relative error of a distance: a greater one was misread, or is another distance.
const MOST_ERROR: f64 = 0.1;
/// Number of parameters to find without S.
const FACTORS: u8 = 9;

/// M665.1: notes that the part is S long from X Y to I J; without words, reports the kept distances. M665.2
/// calibrates by them, S as that of G32. M665.3 forgets them.
pub fn measured_part<'c>(hands: &mut impl ProbeHands<'c>, words: &Words<'_>) -> Outcome {
    let texts = hands.texts();
    if !is_linear_delta(hands.config()) {
        return Err(Failure::refused(
            &"only a linear delta is calibrated by measured parts; see M92 and M852 otherwise",
        ));
    }
    match words.code().subcode {
        1 if words.is_bare() => list(hands),
        1 => keep(hands, words),
        2 => calibrate(hands, words),
        4 if words.is_bare() => take_print(hands),
        4 => {
            hands.delta_records().print.keep(texts, words)?;
            Ok(Answer::Ok)
        }
        _ => {
            hands.delta_records().distances.clear();
            hands.say(format_args!("no distances are kept now\n"));
            Ok(Answer::Ok)
        }
    }
}

fn keep<'c>(hands: &mut impl ProbeHands<'c>, words: &Words<'_>) -> Outcome {
    let needs = || Failure::refused(&"M665.1 needs X Y I J, the places of both ends, and S, the measured distance");
    let [x, y, i, j, measured] = ['X', 'Y', 'I', 'J', 'S'].map(|letter| words.as_length(letter));
    let (Some(x), Some(y), Some(i), Some(j), Some(measured)) = (x, y, i, j, measured) else { return Err(needs()) };
    let text = keep_distance(hands, [[x, y], [i, j]], measured)?;
    hands.say(format_args!("{text}"));
    Ok(Answer::Ok)
}

/// Keeps a distance between two places of the program; returns a report of it.
fn keep_distance<'c>(
    hands: &mut impl ProbeHands<'c>,
    ends: [[f64; 2]; 2],
    measured: f64,
) -> Result<base::failure::ShortText, Failure> {
    let belief = belief(hands)?;
    let ends = ends.map(|[x, y]| belief.ways_to(&PerAxis([x, y, 0.0, 0.0, 0.0, 0.0])));
    let distance = Distance { ends, measured };
    let meant = belief.distance(&distance);
    let error = libm::fabs(measured - meant);
    if !meant.is_finite() || meant < 1.0 || error > MOST_ERROR * meant {
        let text = format_args!("{meant:.3} mm are meant there and {measured:.3} mm were measured: check both");
        return Err(hands.texts().refused(text));
    }
    let texts = hands.texts();
    let distances = &mut hands.delta_records().distances;
    distances
        .push(distance)
        .map_err(|_| texts.refused(format_args!("{MOST_DISTANCES} distances are kept at most: M665.3 forgets them")))?;
    let count = distances.len();
    Ok(short(format_args!("distance {count}: {meant:.3} mm meant, {:+.3} mm measured\n", measured - meant)))
}

/// Replaces the distances by those measured on the calibration part.
fn take_print<'c>(hands: &mut impl ProbeHands<'c>) -> Outcome {
    let texts = hands.texts();
    let all = hands.delta_records().print.distances(texts)?;
    let before = core::mem::take(&mut hands.delta_records().distances);
    for (ends, measured) in all {
        if let Err(why) = keep_distance(hands, ends, measured) {
            hands.delta_records().distances = before;
            return Err(why);
        }
    }
    hands.say(format_args!("{} distances of the part are kept\n", all.len()));
    Ok(Answer::Ok)
}

fn list<'c>(hands: &mut impl ProbeHands<'c>) -> Outcome {
    let belief = belief(hands)?;
    for index in 0..MOST_DISTANCES {
        let Some(distance) = hands.delta_records().distances.get(index).copied() else { break };
        let meant = belief.distance(&distance);
        let (count, off) = (index + 1, distance.measured - meant);
        hands.say(format_args!("distance {count}: {meant:.3} mm meant, {off:+.3} mm measured\n"));
        hands.drain();
    }
    if hands.delta_records().distances.is_empty() {
        hands.say(format_args!("no distances are kept: M665.1 X Y I J S\n"));
    }
    Ok(Answer::Ok)
}

/// Returns the root of the mean square of the distances' errors, mm.
fn distances_off(belief: &Belief, distances: &[Distance]) -> f64 {
    let squares = distances.iter().map(|distance| belief.distance(distance) - distance.measured).map(|off| off * off);
    libm::sqrt(squares.sum::<f64>() / distances.len().max(1) as f64)
}

fn calibrate<'c>(hands: &mut impl ProbeHands<'c>, words: &Words<'_>) -> Outcome {
    let sought = sought(words.get('S').map_or(FACTORS, |factors| factors as u8), words)?;
    let count = hands.delta_records().distances.len();
    if count < 3 {
        let text = format_args!("M665.2 needs three distances at least, in different directions, and has {count}");
        return Err(hands.texts().refused(text));
    }
    hands.standstill()?;
    let believed = belief(hands)?;
    if hands.delta_records().touches.is_empty() {
        hands.say(format_args!(
            "The bed was not touched since the start: it is taken for as flat as the machine finds it\n"
        ));
        let circle = hands.config().delta_calibration.radius.0;
        assumed_touches(hands.delta_records(), &believed, circle);
    }
    let Evidence { touches, distances } = hands.delta_records().evidence();
    let found = fit(&believed, Evidence { touches, distances }, sought).ok_or_else(|| {
        Failure::refused(&"these distances make no sense together: M665.1 lists them; nothing was changed")
    })?;
    let [before, after] = [&believed, &found.belief].map(|belief| distances_off(belief, distances));
    let flat = [&believed, &found.belief].map(|belief| deviation(belief, touches));
    adopt(hands, &found, sought)?;
    // The switches' positions have changed with the geometry.
    hands.axes().forget_homed(AxisSet::PRIMARY);
    hands.say(format_args!("{count} distances: {before:.3} mm off on average before, {after:.3} mm now\n"));
    let [was, is] = flat;
    hands.say(format_args!("The bed's touches deviate by {is:.4} mm then, {was:.4} mm before\n"));
    hands.say(format_args!("Home the machine (G28), then G32 S6. M500 saves it\n"));
    Ok(Answer::Ok)
}
