//! G32 on a linear delta: trims of the switches and radius of the arms from seven touches of the bed.

use program::Words;
use units::{Axis, AxisSet};

use super::delta_fit::{Belief, fit, spread};
use super::points::{clear_of, find_bed, probe_point};
use crate::arms;
use crate::executor::Hands;
use crate::failure::{Answer, Failure, Outcome, message};
use crate::homing;
use crate::leveling;
use crate::ports::Ports;

/// Touches of a round.
const POINTS: usize = 7;
/// Rounds at most. The second one measures what is left; more are only for machines that do not repeat
/// themselves.
const ROUNDS: u32 = 5;

/// The middle; then the three towers, each followed by the place opposite to it, as cosine and sine.
const PLACES: [[f64; 2]; POINTS] = {
    const C: f64 = 0.866_025_403_784_438_6;
    [[0.0, 0.0], [-C, -0.5], [C, 0.5], [C, -0.5], [-C, 0.5], [0.0, 1.0], [0.0, -1.0]]
};

/// What a calibration is to reach, and by what.
#[derive(Clone, Copy, Debug)]
struct Goal {
    /// Of the touches, mm.
    circle: f64,
    /// The spread that will do, mm.
    tolerance: f64,
    /// It may change the trims.
    trims: bool,
    /// It may change the radius of the arms.
    radius: bool,
}

/// G29: how the bed lies at the seven points.
pub(super) async fn measure_delta<P: Ports>(hands: &mut Hands<'_, '_, P>, words: &Words<'_>) -> Outcome {
    let circle = circle(hands, words)?;
    let (belief, touches) = touch_delta(hands, circle).await?;
    hands.say(format_args!("Spread: {:.4}\n", spread(&belief, &touches)));
    Ok(Answer::Ok)
}

/// G32: R leaves the trims as they are, E the radius; I is the spread to reach, J the circle's radius. K is
/// Smoothieware's for starting from the present trims, which is always so: what is found does not depend on
/// them.
pub(super) async fn calibrate_delta<P: Ports>(hands: &mut Hands<'_, '_, P>, words: &Words<'_>) -> Outcome {
    let (trims, radius) = (!words.has('R'), !words.has('E'));
    if !trims && !radius {
        return Err(Failure::refused("G32: R leaves out the trims and E the radius, so nothing is left"));
    }
    let tolerance = words.as_length('I').unwrap_or(hands.config().delta_calibration.tolerance.0);
    let goal = Goal { circle: circle(hands, words)?, tolerance, trims, radius };
    // It belongs to the geometry that is about to change.
    leveling::recompensate(hands, motion::Motion::level_off).await?;
    let (arms, trim) = (hands.motion_config()?.kinematics, hands.tuning().trim());
    let calibrated = calibration_rounds(hands, &goal).await;
    if calibrated.is_err() {
        // As if nothing had been.
        hands.tuning().set_trim(trim);
        homing::come_to_rest(hands).await;
        let now = hands.motion_config()?;
        arms::change_arms(hands, now, arms)?;
    }
    calibrated
}

async fn calibration_rounds<P: Ports>(hands: &mut Hands<'_, '_, P>, goal: &Goal) -> Outcome {
    let mut reached = 0.0;
    for round in 1..=ROUNDS {
        let (belief, touches) = touch_delta(hands, goal.circle).await?;
        reached = spread(&belief, &touches);
        hands.say(format_args!("Spread: {reached:.4}\n"));
        if reached <= goal.tolerance {
            hands.say(format_args!("Calibrated. M500 saves it\n"));
            return Ok(Answer::Ok);
        }
        if round == ROUNDS {
            break;
        }
        let found = fit(&belief, &touches, goal.trims, goal.radius)
            .ok_or_else(|| Failure::refused("calibration: the heights of the points make no sense"))?;
        let now = hands.motion_config()?;
        arms::change_arms(hands, now, found.kinematics)?;
        hands.tuning().set_trim(found.trim);
        let [x, y, z] = found.trim;
        hands.say(format_args!("Trim: X:{x:.4} Y:{y:.4} Z:{z:.4} Radius: {:.4}\n", found.radius()));
        hands.drain().await;
    }
    let text = format_args!(
        "calibration: a spread of {reached:.4} mm is left, more than {:.4}; nothing was changed",
        goal.tolerance
    );
    Err(Failure::Refused(message(text)))
}

/// Radius of the touches, mm.
fn circle<P: Ports>(hands: &Hands<'_, '_, P>, words: &Words<'_>) -> Result<f64, Failure> {
    let radius = words.as_length('J').unwrap_or(hands.config().delta_calibration.radius.0);
    if radius > 0.0 { Ok(radius) } else { Err(Failure::refused("J is a radius, above zero")) }
}

/// Homes, finds the bed and touches it at every place. The ways of the carriages from their switches.
async fn touch_delta<P: Ports>(
    hands: &mut Hands<'_, '_, P>,
    circle: f64,
) -> Result<(Belief, [[f64; 3]; POINTS]), Failure> {
    homing::home(hands, AxisSet::PRIMARY).await?;
    let belief = belief(hands)?;
    let from = hands.config().delta_calibration.initial_height.0;
    let bed = find_bed(hands, [0.0; 2], from).await?;
    let height = clear_of(&hands.tuning().probe, bed[Axis::Z]);
    let mut touches = [[0.0; 3]; POINTS];
    for (touch, [cosine, sine]) in touches.iter_mut().zip(PLACES) {
        let at = [circle * cosine, circle * sine];
        let contact = probe_point(hands, at, height).await?;
        *touch = belief.ways_to(&contact);
        hands.say(format_args!("X:{:.4} Y:{:.4} Z:{:.4}\n", at[0], at[1], contact[Axis::Z]));
        hands.drain().await;
    }
    Ok((belief, touches))
}

fn belief<P: Ports>(hands: &mut Hands<'_, '_, P>) -> Result<Belief, Failure> {
    let kinematics = hands.motion_config()?.kinematics;
    let config = hands.config();
    let tuning = hands.tuning();
    Ok(Belief { kinematics, trim: tuning.trim(), home: arms::delta_home(config, tuning) })
}
