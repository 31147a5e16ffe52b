//! G29, G31 and G32: the strategy, and around a cartesian grid the lines of the configuration.

use base::failure::Outcome;
use base::sessions::Recipient;
use gcode::Code;
use procedures::probing;
use program::Words;

use crate::machine::frames::Then;
use crate::machine::suspend;
use crate::machine::work_hands::JobHands;

/// The lines around a cartesian grid may hold any code, so they are run as scripts.
pub(crate) fn run<'c>(hands: &mut impl JobHands<'c>, words: &Words<'_>, code: Code, to: Recipient) -> Outcome {
    let prepared = probing::prepare(&mut hands.sequence(to), words, code)?;
    match prepared {
        Some(plan) => {
            let [before, _] = &hands.world().config.probe_gcode;
            suspend::start_script(hands.frames(), before, Then::TouchGrid(plan, to))
        }
        None => {
            let hands = &mut hands.sequence(to);
            let ended = probing::strategy(hands, words, code);
            probing::stow_after(hands, ended)
        }
    }
}
