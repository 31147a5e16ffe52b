//! M852: axes that are not square to each other.

use config::LevelingConfig;
use motion::Skew;
use program::Words;

use super::compensation::{recompensate, rounded};
use crate::executor::Hands;
use crate::failure::{Answer, Failure, Outcome, message};
use crate::ports::{MotionPort, Ports};
use crate::sessions::Reply;

/// Skew factors are kept to as many parts of one: so they are saved exactly.
const SKEW_PARTS: f64 = 1e8;

/// At boot, before anything moves: the skew of the configuration.
pub(crate) fn configure(motion: &mut impl MotionPort, config: &config::MachineConfig, reply: &mut Reply<'_>) {
    let skew = configured(&config.leveling);
    if let Err(error) = motion.motion(|motion| motion.set_skew(skew)) {
        reply.say(format_args!("ERROR: config.ini: [skew correction] {error}\n"));
    }
}

/// The skew of the configuration.
pub(super) fn configured(leveling: &LevelingConfig) -> Skew {
    let [xy, xz, yz] = leveling.skew.map(|skew| {
        let factor = match skew.measured {
            Some([ac, bd, ad]) => Skew::from_square(ac, bd, ad).unwrap_or(0.0),
            None => skew.factor,
        };
        rounded(factor, SKEW_PARTS)
    });
    Skew { xy, xz, yz }
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
    let mut skew = hands.motion(|motion| motion.compensation().skew());
    let mut any = false;
    let plane = words.get('P').map_or(0, |plane| plane as usize);
    for (index, (letter, factor)) in
        [('I', &mut skew.xy), ('J', &mut skew.xz), ('K', &mut skew.yz)].into_iter().enumerate()
    {
        let by_square = measured.filter(|_| index == plane);
        if let Some(word) = words.get(letter).or(by_square) {
            *factor = rounded(word, SKEW_PARTS);
            any = true;
        }
    }
    if any {
        recompensate(hands, |motion| motion.set_skew(skew)).await?;
    }
    if let Some(factor) = measured {
        say_lean(hands, factor);
    }
    hands.say(format_args!("Skew factors: XY {:.8} XZ {:.8} YZ {:.8}\n", skew.xy, skew.xz, skew.yz));
    Ok(Answer::Ok)
}

const SQUARE: &str = "a square needs A, B and D: both diagonals AC and BD, and the side AD";

/// The factor that the words' lengths tell, where they name any.
fn square(words: &Words<'_>) -> Result<Option<f64>, Failure> {
    let [ac, bd, ad] = ['A', 'B', 'D'].map(|letter| words.as_length(letter));
    match (ac, bd, ad) {
        (None, None, None) => Ok(None),
        (Some(ac), Some(bd), Some(ad)) => {
            let factor = Skew::from_square(ac, bd, ad);
            let text = format_args!("no nearly square figure has diagonals of {ac} and {bd} mm and a side of {ad} mm");
            factor.map(Some).ok_or_else(|| Failure::Refused(message(text)))
        }
        _ => Err(Failure::refused(SQUARE)),
    }
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
