//! M70 to M73: saving and restoring modes.

use crate::context::{Context, Meaning, NOTHING};
use crate::fault::{Fault, Problem};
use crate::interpreter::Interpreter;
use crate::state::auxiliary::{Auxiliary, Spindle};
use crate::state::saved_modes::SavedModes;

/// Saves, forgets or restores modes (M70, M71, M72, M73).
pub(crate) fn saved_modes<'b>(program: &mut Interpreter, context: &Context<'b>) -> Result<Meaning<'b>, Fault> {
    let (depth, number) = (program.flow.depth(), context.words.code().number);
    match number {
        70 | 73 => program.frames.save(depth, number == 73, &program.modal),
        71 => program.frames.forget(depth),
        _ => {
            let modes = program.frames.at(depth).ok_or(Problem::NoSavedModes.refused(context.words.column()))?;
            bring_back(program, &modes);
            return Ok(program.next_action().map_or(Meaning::Nothing, Meaning::Action));
        }
    }
    NOTHING
}

/// Restores the modes that M73 saved in subroutines that have ended. The changes are the next effects and
/// actions.
pub(crate) fn subroutines_ended(program: &mut Interpreter) {
    let depth = program.flow.depth();
    if let Some(modes) = program.frames.end_down_to(depth) {
        program.begin_block();
        bring_back(program, &modes);
    }
}

fn bring_back(program: &mut Interpreter, saved: &SavedModes) {
    let before = program.modal.auxiliary;
    saved.restore(&mut program.modal);
    program.modal.auxiliary = saved.auxiliary;
    switch_from(program, &before);
    let modes = saved.auxiliary;
    if (modes.feed_override, modes.spindle_override) != (before.feed_override, before.spindle_override) {
        program.then(modes.overrides());
    }
}

/// Switches spindle and coolant from the modes `before` to the current modes, as the next effects.
pub(crate) fn switch_from(program: &mut Interpreter, before: &Auxiliary) {
    let modes = program.modal.auxiliary;
    program.modal.auxiliary.spindle = before.spindle;
    if modes.spindle != before.spindle || modes.spindle != Spindle::Stopped && modes.speed != before.speed {
        program.turn_spindle(modes.spindle);
    }
    if (modes.mist, modes.flood) != (before.mist, before.flood) {
        // M9 turns both off, so coolant that stays on is turned on again.
        for (number, wanted) in [(9, true), (7, modes.mist), (8, modes.flood)] {
            if wanted {
                program.switch(number);
            }
        }
    }
}

/// Stops spindle and coolant, as M5 and M9 do.
pub(crate) fn stop(program: &mut Interpreter) {
    let modes = &mut program.modal.auxiliary;
    (modes.spindle, modes.mist, modes.flood) = (Spindle::Stopped, false, false);
    for number in [5, 9] {
        program.switch(number);
    }
}
