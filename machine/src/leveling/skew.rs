//! M852: axes that are not square to each other.

use program::Words;

use super::compensation::recompensate;
use super::words::{SQUARE, configured, skew_of, square};
use crate::executor::Hands;
use crate::failure::{Answer, Failure, Outcome};
use crate::ports::{MotionPort, Ports};
use crate::sessions::Reply;

/// At boot, before anything moves: the skew of the configuration.
pub(crate) fn configure(motion: &mut impl MotionPort, config: &config::MachineConfig, reply: &mut Reply<'_>) {
    let skew = configured(&config.leveling);
    if let Err(error) = motion.motion(|motion| motion.set_skew(skew)) {
        reply.say(format_args!("ERROR: config.ini: [skew correction] {error}\n"));
    }
}

/// M852: skew factors I (XY), J (XZ), K (YZ), or the measured lengths A (AC), B (BD), D (AD) of a square in
/// plane P; without words says them. M852.1 says what a square means, and changes nothing.
pub(crate) async fn skew<P: Ports>(hands: &mut Hands<'_, '_, P>, words: &Words<'_>) -> Outcome {
    let measured = square(words)?;
    if words.code().subcode == 1 {
        let factor = measured.ok_or_else(|| Failure::refused(SQUARE))?;
        say_lean(hands, factor);
        return Ok(Answer::Ok);
    }
    let before = hands.motion(|motion| motion.compensation().skew());
    let changed = skew_of(before, words)?;
    if let Some(skew) = changed {
        recompensate(hands, |motion| motion.set_skew(skew)).await?;
    }
    let skew = changed.unwrap_or(before);
    if let Some(factor) = measured {
        say_lean(hands, factor);
    }
    hands.say(format_args!("Skew factors: XY {:.8} XZ {:.8} YZ {:.8}\n", skew.xy, skew.xz, skew.yz));
    Ok(Answer::Ok)
}

/// A factor in words.
fn say_lean<P: Ports>(hands: &mut Hands<'_, '_, P>, factor: f64) {
    let (degrees, hundred) = (libm::atan(factor).to_degrees(), 100.0 * factor);
    hands.say(format_args!(
        "The corner A is {:.3} degrees, {:+.3} mm on 100 mm: a factor of {factor:.8}\n",
        90.0 - degrees,
        hundred
    ));
}
