//! M220: the factor of the rates of moves that are read from now on.

use crate::interpreter::Interpreter;

/// Has the moves that are read from now on made at `factor` times their rates; 1 is as programmed.
pub const fn set(program: &mut Interpreter, factor: f64) {
    program.modal.speed_factor = factor;
}

/// M220 B: what M220 R brings back.
pub const fn keep(program: &mut Interpreter) {
    program.modal.kept_speed_factor = program.modal.speed_factor;
}

/// Factors of the rates of working moves and of rapids, which have their own with `compliant_seek_rate`.
#[must_use]
pub const fn of_moves(program: &Interpreter) -> [f64; 2] {
    let factor = program.modal.speed_factor;
    [factor, if program.compliant_seek_rate { 1.0 } else { factor }]
}
