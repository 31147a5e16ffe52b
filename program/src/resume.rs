//! Resuming a program after a person has worked at the machine.

use units::{Axis, PerAxis, ToolId};

use crate::interpreter::Interpreter;
use crate::meaning::modes;
use crate::state::kept::Kept;

/// Rounding tolerance of positions, mm.
const NOTHING: f64 = 1e-9;

/// Restores the saved modes except offsets: offsets that were set meanwhile, for another cutter or another
/// part, stay. Spindle and coolant return to their former state by the next effects.
pub fn go_on_from(program: &mut Interpreter, mut kept: Kept) {
    take_up_tool(program, &kept);
    let before = program.modal.auxiliary;
    kept.modal.take_offsets_of(&program.modal);
    program.come_back_to(kept);
    program.effects.clear();
    modes::switch_from(program, &before);
}

/// Selects the extruder that was in use when `kept` was saved, with its offset; returns its number where
/// another one had been selected since.
pub fn take_up_tool(program: &mut Interpreter, kept: &Kept) -> Option<ToolId> {
    take_up(program, kept.tool)
}

/// Selects the extruder at this place, with its offset; returns its number where another one was selected.
pub(crate) fn take_up(program: &mut Interpreter, place: usize) -> Option<ToolId> {
    if program.tools.active == place {
        return None;
    }
    program.tools.active = place;
    let settings = &program.tools.active()?.settings;
    let (id, offset) = (settings.id, settings.offset);
    program.modal.set_tool_offset(offset);
    Some(id)
}

/// Returns the machine position that now has the work coordinates that `place` had when `kept` was saved, in
/// the coordinate system in force then.
pub fn same_work_place(program: &mut Interpreter, kept: &Kept, place: &PerAxis<f64>) -> PerAxis<f64> {
    let work = kept.modal.work(place);
    let in_force = core::mem::replace(&mut program.modal.system, kept.modal.system);
    let [x, y] = program.modal.machine_xy([work[Axis::X], work[Axis::Y]]);
    let z = work[Axis::Z] + program.modal.offset(Axis::Z);
    program.modal.system = in_force;
    let mut now = *place;
    for (axis, to) in Axis::PRIMARY.into_iter().zip([x, y, z]) {
        now[axis] = if libm::fabs(to - place[axis]) > NOTHING { to } else { place[axis] };
    }
    now
}
