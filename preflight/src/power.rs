//! Power of a laser that is not what a file asks for: found once a file, of each kind.

use base::failure::{Failure, ShortText, short};
use gcode::{Block, Code};
use motion::Motion;
use parts::laser as laser_codes;
use program::{CodeInfo, Move, Rate, Spindle, Words};

use super::finding::Kind;
use super::state::Preflight;

/// Greatest relative difference of an S from that of full power that is rounding.
const SAME: f32 = 1e-6;

/// Returns what is to be said of a working move whose S is another power than the file may think.
pub(super) fn of_move(preflight: &mut Preflight<'_>, request: &Move) -> Option<(Kind, ShortText)> {
    let Preflight { program, tuning, once, .. } = preflight;
    let (modal, most) = (program.modal(), tuning.laser.most_s);
    let s = modal.power;
    if s <= 0.0 || modal.auxiliary.spindle == Spindle::Stopped || matches!(request.rate, Rate::Rapid(_)) {
        return None;
    }
    match program::laser::of(program) {
        None if !once.unheard && !program::laser::has_m3_of_outputs(program) => {
            once.unheard = true;
            let text = format_args!("M3 turns nothing on, and S{s} is no power here");
            Some((Kind::NothingBurns, short(text)))
        }
        Some(laser) if !laser.is_laser_mode && !once.laser_mode => {
            once.laser_mode = true;
            Some((Kind::LaserMode, short(format_args!("laser mode is off: moves do not burn, whatever S"))))
        }
        Some(laser) if laser.is_laser_mode && !once.full_power && s > most * (1.0 + SAME) => {
            once.full_power = true;
            let text = format_args!("S{s} is more than full power, which is S{most}: it burns at full power");
            Some((Kind::Power, short(text)))
        }
        _ => None,
    }
}

/// Returns what is to be said of an S above zero on the very line of a rapid, while a laser burns: rapids are
/// dark.
pub(super) fn of_rapid(preflight: &mut Preflight<'_>, row: &CodeInfo, block: &Block<'_>) -> Option<(Kind, ShortText)> {
    let Preflight { program, once, .. } = preflight;
    let s = block.get('S').filter(|s| *s > 0.0 && row.code == Code::g(0) && !once.dark_rapid)?;
    let burns = program.modal().auxiliary.spindle != Spindle::Stopped;
    program::laser::of(program).filter(|laser| burns && laser.is_laser_mode)?;
    once.dark_rapid = true;
    Some((Kind::DarkRapid, short(format_args!("a rapid does not burn: S{s} counts from the next G1 on"))))
}

/// Follows M452, and M221 of a laser.
///
/// # Errors
/// When the machine would refuse it.
pub(super) fn set(preflight: &mut Preflight<'_>, motion: &mut Motion, words: &Words<'_>) -> Result<(), Failure> {
    let Some(laser) = program::laser::of(preflight.program) else { return Ok(()) };
    let (scale, laser) = laser_codes::changed(preflight.texts, words, preflight.tuning.laser, laser)?;
    let taken = motion.configure_laser(scale.in_motions_terms(preflight.config));
    taken.map_err(|error| preflight.texts.refused(format_args!("{error}")))?;
    preflight.tuning.laser = scale;
    program::laser::set(preflight.program, laser);
    Ok(())
}
