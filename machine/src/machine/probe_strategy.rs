//! G29, G31 and G32: the strategy, and around a cartesian grid the lines of the configuration.

use base::Ports;
use base::failure::Outcome;
use base::sessions::Recipient;
use gcode::Code;
use procedures::probing;
use program::Words;

use crate::machine::frames::Then;
use crate::machine::hands::MachineHands;
use crate::machine::{Machine, suspend};

/// The lines around a cartesian grid may hold any code, so they are run as scripts.
pub(crate) fn run<P: Ports>(machine: &mut Machine<'_, P>, words: &Words<'_>, code: Code, to: Recipient) -> Outcome {
    match probing::prepare(&mut MachineHands::new(machine, to), words, code)? {
        Some(plan) => {
            let [before, _] = &machine.world.config.probe_gcode;
            suspend::start_script(&mut machine.frames, before, Then::TouchGrid(plan, to))
        }
        None => {
            let hands = &mut MachineHands::new(machine, to);
            let ended = probing::strategy(hands, words, code);
            probing::stow_after(hands, ended)
        }
    }
}
