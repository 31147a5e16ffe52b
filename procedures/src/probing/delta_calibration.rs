//! G32 on a linear delta: trims of the switches, radius, angles of towers and lengths of arms from touches of
//! the bed.

use base::failure::{Answer, Failure, Outcome};
use program::Words;
use units::{Axis, AxisSet};

use super::delta_fit::{Arms, Belief, Evidence, Found, Sought, Ways, deviation, fit, spread};
use super::delta_records::{DeltaRecords, MOST_TOUCHES};
use super::points::{clear_of, find_bed, probe_point};
use crate::arms;
use crate::homing;
use crate::leveling;
use crate::probing::ProbeHands;

/// Number of touches of a round: trims and radius need seven; further parameters need a second ring.
const FEW: usize = 7;
const MANY: usize = 13;
/// Greatest number of rounds. The second measures the remaining error; more are only for machines that do not
/// repeat themselves.
const ROUNDS: u32 = 5;
const _: () = assert!(MANY * ROUNDS as usize <= MOST_TOUCHES);
/// Greatest share of the deviation that a fit may leave to be worth another round; the rest is noise, or the
/// bed.
const LEAST_GAIN: f64 = 0.8;
/// Least scatter of touches of the same place, as a share of their deviation, that counts as noise.
const LEAST_SCATTER: f64 = 0.5;

/// Directions of the touches, as cosine and sine: the middle; then the three towers, each followed by the
/// place opposite to it; and halfway out, between those.
const PLACES: [[f64; 2]; MANY] = {
    const C: f64 = 0.866_025_403_784_438_6;
    let (c, h) = (C / 2.0, 0.25);
    [
        [0.0, 0.0],
        [-C, -0.5],
        [C, 0.5],
        [C, -0.5],
        [-C, 0.5],
        [0.0, 1.0],
        [0.0, -1.0],
        [0.5, 0.0],
        [-0.5, 0.0],
        [h, c],
        [-h, -c],
        [h, -c],
        [-h, c],
    ]
};

/// Goal of a calibration, and its means.
#[derive(Clone, Copy, Debug)]
struct Goal {
    /// Radius of the touches, mm.
    circle: f64,
    /// Spread that suffices, mm.
    tolerance: f64,
    /// Parameters that the calibration may change.
    sought: Sought,
}

/// G29: measures the bed's heights at the seven points.
pub(super) fn measure_delta<'c>(hands: &mut impl ProbeHands<'c>, words: &Words<'_>) -> Outcome {
    let circle = circle(hands, words)?;
    hands.delta_records().touches.clear();
    let belief = touch_delta(hands, circle, FEW)?;
    let spread = spread(&belief, &hands.delta_records().touches);
    hands.say(format_args!("Spread: {spread:.4}\n"));
    Ok(Answer::Ok)
}

/// G32: R leaves the trims as they are, E the radius; S is the number of parameters to find, I the spread to
/// reach, J the circle's radius. K is Smoothieware's for starting from the present trims, which is always so:
/// the result does not depend on them.
pub(super) fn calibrate_delta<'c>(hands: &mut impl ProbeHands<'c>, words: &Words<'_>) -> Outcome {
    let factors = words.get('S').map_or(hands.config().delta_calibration.factors, |factors| factors as u8);
    let sought = sought(factors, words)?;
    let tolerance = words.as_length('I').unwrap_or(hands.config().delta_calibration.tolerance.0);
    let goal = Goal { circle: circle(hands, words)?, tolerance, sought };
    // Leveling belongs to the geometry that is about to change.
    leveling::take_off(hands)?;
    let before = belief(hands)?;
    hands.delta_records().touches.clear();
    let calibrated = calibration_rounds(hands, &goal);
    if calibrated.is_err() {
        // After a failure the records and the geometry are those of before.
        hands.delta_records().touches.clear();
        homing::come_to_rest(hands);
        believe(hands, &before)?;
    }
    calibrated
}

/// Returns the parameters to find for this number of them, less those that the words leave out.
pub(super) fn sought(factors: u8, words: &Words<'_>) -> Result<Sought, Failure> {
    let (radius, angles, arms) = match factors {
        3 => (false, false, Arms::Known),
        4 => (true, false, Arms::Known),
        6 => (true, true, Arms::Known),
        7 => (true, true, Arms::Alike),
        9 => (true, true, Arms::Each),
        _ => {
            return Err(Failure::refused(
                &"S is 3 (trims), 4 (and radius), 6 (and angles), 7 (and the arms' length) or 9 (each arm's)",
            ));
        }
    };
    let sought = Sought { trims: !words.has('R'), radius: radius && !words.has('E'), angles, arms };
    if !sought.trims && !sought.radius && !sought.angles {
        return Err(Failure::refused(&"G32: R leaves out the trims and E the radius, so nothing is left"));
    }
    Ok(sought)
}

fn calibration_rounds<'c>(hands: &mut impl ProbeHands<'c>, goal: &Goal) -> Outcome {
    let count = if goal.sought.angles { MANY } else { FEW };
    let (mut first, mut reached) = (0.0, 0.0);
    for round in 1..=ROUNDS {
        let belief = touch_delta(hands, goal.circle, count)?;
        let latest = hands.delta_records().touches_of_last_round(count);
        reached = spread(&belief, latest);
        let before = deviation(&belief, latest);
        let alone = fit(&belief, Evidence { touches: latest, distances: &[] }, goal.sought);
        let after = alone.map_or(before, |found| deviation(&found.belief, latest));
        let is_scatter = round > 1 && scatter(&belief, &hands.delta_records().touches, count) > LEAST_SCATTER * before;
        let is_noise = is_scatter && before <= goal.tolerance && is_noise(before, after, count, goal.sought);
        first = if round == 1 { reached } else { first };
        hands.say(format_args!("Spread: {reached:.4}\n"));
        let is_reached = reached <= goal.tolerance;
        if !is_reached && (is_noise || round < ROUNDS) {
            // The touches of all rounds are fitted, which lessens the noise.
            let records = hands.delta_records();
            let found = fit(&belief, Evidence { touches: &records.touches, distances: &[] }, goal.sought)
                .ok_or_else(|| Failure::refused(&"calibration: the heights of the points make no sense"))?;
            adopt(hands, &found, goal.sought)?;
            hands.drain();
        }
        if is_noise && !is_reached {
            hands.say(format_args!("What is left, {before:.4} mm on average, is the probe's noise: M48 tells it\n"));
        }
        if is_reached || is_noise {
            hands.say(format_args!(
                "The touches differ by {reached:.4} mm, by {first:.4} mm at first\nCalibrated. M500 saves it\n"
            ));
            return Ok(Answer::Ok);
        }
    }
    let text = format_args!(
        "calibration: a spread of {reached:.4} mm is left, more than {:.4}; nothing was changed",
        goal.tolerance
    );
    Err(hands.texts().refused(text))
}

/// Returns whether a fit of these touches leaves a deviation as great as it leaves of any noise: the
/// parameters found take up their share.
fn is_noise(before: f64, after: f64, touches: usize, sought: Sought) -> bool {
    let free = touches.saturating_sub(sought.count()).max(1) as f64;
    after * libm::sqrt(touches as f64 / free) > LEAST_GAIN * before
}

/// Returns the deviation of a touch, mm, from the differences between touches of the same places in this
/// round and the last. An uneven bed shows the same each time, noise does not.
fn scatter(belief: &Belief, touches: &[Ways], count: usize) -> f64 {
    let latest = touches.len().saturating_sub(count);
    let before = touches.get(latest.saturating_sub(count)..latest).unwrap_or(&[]);
    let pairs = touches.iter().skip(latest).zip(before);
    let squares = pairs.map(|(now, then)| belief.height(now) - belief.height(then)).map(|off| off * off).sum::<f64>();
    libm::sqrt(0.5 * squares / count as f64)
}

/// Takes the machine for this geometry from now on. The distances of the carriages from their switches do not
/// depend on the geometry; the tool's position follows from them, so Z is right before the next homing too.
fn believe<'c>(hands: &mut impl ProbeHands<'c>, wanted: &Belief) -> Result<(), Failure> {
    let (now, mut place) = (belief(hands)?, hands.position());
    let ways = now.ways_to(&hands.motion(|motion| motion.compensation().motors(&place)));
    let texts = hands.texts();
    hands.motion(|motion| arms::words::change_arms(texts, motion, wanted.kinematics))?;
    hands.tuning().set_trim(wanted.trim);
    let tool = hands.motion(|motion| motion.compensation().program(&wanted.place(&ways)));
    Axis::PRIMARY.into_iter().for_each(|axis| place[axis] = tool[axis]);
    hands.set_position(place)
}

/// Puts the parameters found in force, and reports them.
pub(super) fn adopt<'c>(hands: &mut impl ProbeHands<'c>, found: &Found, sought: Sought) -> Result<(), Failure> {
    let belief = &found.belief;
    believe(hands, belief)?;
    let [x, y, z] = belief.trim;
    hands.say(format_args!("Trim: X:{x:.4} Y:{y:.4} Z:{z:.4} Radius: {:.4}\n", belief.radius()));
    if sought.angles {
        let [d, e] = ['D', 'E'].map(|letter| belief.parameter(letter));
        hands.say(format_args!("Towers X and Y stand {d:.4} and {e:.4} degrees from where they should\n"));
    }
    if let Some(within) = found.arms_within {
        let [i, j, k] = ['I', 'J', 'K'].map(|letter| belief.parameter(letter) + belief.parameter('L'));
        hands.say(format_args!("Arms: X:{i:.4} Y:{j:.4} Z:{k:.4} within {within:.2} mm\n"));
        if within > 0.5 {
            hands.say(format_args!("Touches tell the arms poorly: print a part and measure it (M665.1)\n"));
        }
    }
    Ok(())
}

/// Returns the radius of the touches, mm.
fn circle<'c>(hands: &impl ProbeHands<'c>, words: &Words<'_>) -> Result<f64, Failure> {
    let radius = words.as_length('J').unwrap_or(hands.config().delta_calibration.radius.0);
    if radius > 0.0 { Ok(radius) } else { Err(Failure::refused(&"J is a radius, above zero")) }
}

/// Homes, finds the bed and touches it at this many places; records the ways of the carriages from their
/// switches.
fn touch_delta<'c>(hands: &mut impl ProbeHands<'c>, circle: f64, count: usize) -> Result<Belief, Failure> {
    homing::home(hands, AxisSet::PRIMARY)?;
    let belief = belief(hands)?;
    let from = hands.config().delta_calibration.initial_height.0;
    let bed = find_bed(hands, [0.0; 2], from)?;
    let height = clear_of(&hands.tuning().probe, bed[Axis::Z]);
    for [cosine, sine] in PLACES.into_iter().take(count) {
        let at = [circle * cosine, circle * sine];
        let contact = probe_point(hands, at, height)?;
        // The list has room for the touches of every round.
        let _ = hands.delta_records().touches.push(belief.ways_to(&contact));
        hands.say(format_args!("X:{:.4} Y:{:.4} Z:{:.4}\n", at[0], at[1], contact[Axis::Z]));
        hands.drain();
    }
    Ok(belief)
}

/// Returns the geometry that the machine is taken for.
pub(super) fn belief<'c>(hands: &mut impl ProbeHands<'c>) -> Result<Belief, Failure> {
    let kinematics = hands.motion_config()?.kinematics;
    let config = hands.config();
    let tuning = hands.tuning();
    Ok(Belief { kinematics, trim: tuning.trim(), home: arms::delta_home(config, tuning) })
}

/// Records touches of a bed that is as flat as the present geometry says.
pub(super) fn assumed_touches(records: &mut DeltaRecords, belief: &Belief, circle: f64) {
    for [cosine, sine] in PLACES {
        let ways: Ways = belief.ways_to(&units::PerAxis([circle * cosine, circle * sine, 0.0, 0.0, 0.0, 0.0]));
        // The list was cleared, so there is room.
        let _ = records.touches.push(ways);
    }
}
