//! M220: speed factor, which scales the rates of later moves.

use crate::interpreter::Interpreter;

/// Sets the factor for the rates of later moves; 1 is as programmed.
pub const fn set(program: &mut Interpreter, factor: f64) {
    program.modal.speed_factor = factor;
}

/// M220 B: saves the factor for M220 R.
pub const fn keep(program: &mut Interpreter) {
    program.modal.kept_speed_factor = program.modal.speed_factor;
}

/// Returns the factors for feed moves and for rapids; with `compliant_seek_rate` rapids are not scaled.
#[must_use]
pub const fn of_moves(program: &Interpreter) -> [f64; 2] {
    let factor = program.modal.speed_factor;
    [factor, if program.compliant_seek_rate { 1.0 } else { factor }]
}
