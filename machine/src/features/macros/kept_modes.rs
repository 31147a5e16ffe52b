//! Modes of the program that are kept by names: `SAVE_GCODE_STATE` and `RESTORE_GCODE_STATE`.

use core::fmt::Write as _;

use base::failure::{Answer, Failure, Outcome};
use base::sessions::Recipient;
use gcode::Extended;
use heapless::String;
use printer_cfg::Section;
use units::Axis;

use super::calls::{self, Shares};
use super::hands::{MacroHands, Seen};
use super::state::Kept;

/// Parameter of the line behind those that go back to the place: only the modes are left to come back to.
const IS_THERE: &str = "_IS_THERE";

/// Returns machine coordinates of X Y Z, and the place of the extruder in use.
fn here<'c>(hands: &mut impl MacroHands<'c>) -> ([f64; 3], f64) {
    let Seen { program, .. } = hands.seen();
    let place = program.position();
    let extruder = program.tools().active().map_or(0.0, |tool| tool.e);
    ([place[Axis::X], place[Axis::Y], place[Axis::Z]], extruder)
}

fn name_of<'n>(command: &Extended<'n>) -> &'n str {
    command.get("NAME").filter(|name| !name.is_empty()).unwrap_or("default")
}

/// Keeps the modes by a name.
pub(super) fn save<'c>(hands: &mut impl MacroHands<'c>, command: &Extended<'_>) -> Outcome {
    let Ok(name) = String::try_from(name_of(command)) else {
        return Err(Failure::refused(&"SAVE_GCODE_STATE: a name has at most 24 letters"));
    };
    let (at, extruder) = here(hands);
    let modes = program::modes(hands.program());
    let kept = &mut hands.macros().modes.kept;
    kept.retain(|known| known.name != name);
    if kept.is_full() {
        // Names that nobody came back to make room.
        kept.remove(0);
    }
    // There is room, as was made.
    let _ = kept.push(Kept { name, modes, at, extruder });
    Ok(Answer::Ok)
}

/// Reads a parameter that is a number, if it is there.
fn number(command: &Extended<'_>, key: &str) -> Result<Option<f64>, Failure> {
    let Some(text) = command.get(key) else { return Ok(None) };
    gcode::read_f64(text.trim())
        .map(Some)
        .ok_or(Failure::refused(&"RESTORE_GCODE_STATE: MOVE and MOVE_SPEED are numbers"))
}

/// Comes back to the modes of a name; before that, with MOVE=1, to the place, and the extruder counts on from
/// where it was, as in Klipper.
pub(super) fn restore<'c>(hands: &mut impl MacroHands<'c>, command: &Extended<'_>, to: Recipient) -> Outcome {
    let name = name_of(command);
    let found = hands.macros().modes.kept.iter().rev().find(|kept| kept.name.eq_ignore_ascii_case(name)).cloned();
    let Some(Kept { modes, at: [x, y, z], extruder, name }) = found else {
        return Err(hands.world().texts.refused(format_args!("RESTORE_GCODE_STATE: no state is kept as {name}")));
    };
    let (moves, speed) = (number(command, "MOVE")?, number(command, "MOVE_SPEED")?);
    let moves = moves.is_some_and(|moves| moves != 0.0);
    let (_, now) = here(hands);
    if command.get(IS_THERE).is_some() || !moves && now == extruder {
        program::come_back_to_modes(hands.program(), &modes);
        return Ok(Answer::Ok);
    }
    // The lines come back here once they have been carried out.
    let (mut lines, mut last) = (String::<160>::new(), String::<80>::new());
    if moves {
        let rate = speed.unwrap_or(hands.program().modal().feed_rate.0) * 60.0;
        let _ = write!(lines, "G21\nG90\nG53 G1 X{x} Y{y} Z{z} F{rate}\n");
    }
    if now != extruder {
        let _ = writeln!(lines, "G92 E{extruder}");
    }
    let _ = write!(last, "\nRESTORE_GCODE_STATE NAME={name} {IS_THERE}=1");
    calls::run_text(hands, Section(u16::MAX), [&lines, &last], to, Shares::No)
}
