//! M852: axes that are not square to each other.

use config::LevelingConfig;
use motion::Skew;
use program::Words;

use super::compensation::{recompensate, rounded};
use crate::executor::Hands;
use crate::failure::{Answer, Outcome};
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

/// M852: skew factors I (XY), J (XZ), K (YZ); without words shows them.
pub(crate) async fn skew<P: Ports>(hands: &mut Hands<'_, '_, P>, words: &Words<'_>) -> Outcome {
    let mut skew = hands.motion(|motion| motion.compensation().skew());
    let mut any = false;
    for (letter, factor) in [('I', &mut skew.xy), ('J', &mut skew.xz), ('K', &mut skew.yz)] {
        if let Some(word) = words.get(letter) {
            *factor = rounded(word, SKEW_PARTS);
            any = true;
        }
    }
    if any {
        recompensate(hands, |motion| motion.set_skew(skew)).await?;
    }
    hands.say(format_args!("Skew factors: XY {:.8} XZ {:.8} YZ {:.8}\n", skew.xy, skew.xz, skew.yz));
    Ok(Answer::Ok)
}
