//! Modes that M120 and Klipper's `SAVE_GCODE_STATE` keep.

use crate::interpreter::Interpreter;
use crate::state::modal::Saved;

/// Returns the modes that are in force.
#[must_use]
pub const fn modes(program: &Interpreter) -> Saved {
    program.modal.save()
}

/// Comes back to modes that were kept.
pub const fn come_back_to_modes(program: &mut Interpreter, saved: &Saved) {
    let seek_rate = program.modal.seek_rate;
    program.modal.restore(saved);
    if program.compliant_seek_rate {
        program.modal.seek_rate = seek_rate;
    }
}
