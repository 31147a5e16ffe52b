//! The laser, as the machine sets it.

use gcode::Code;

use crate::interpreter::Interpreter;
use crate::state::auxiliary::Spindle;
use crate::state::setup::LaserSetup;
use units::PowerLaw;

/// Returns the laser, if there is one.
#[must_use]
pub const fn of(program: &Interpreter) -> Option<LaserSetup> {
    program.setup.laser
}

/// Whether an output listens to M3, as that of a spindle does.
#[must_use]
pub fn has_m3_of_outputs(program: &Interpreter) -> bool {
    program.setup.claims.of(Code::m(3)).next().is_some()
}

/// Sets laser mode, and whether the power of M3 follows the speed too, where there is a laser.
pub fn set(program: &mut Interpreter, laser: LaserSetup) {
    if program.setup.laser.is_some() {
        program.setup.laser = Some(laser);
    }
}

/// Returns the S of constant power in force, M3 in laser mode; 0 without.
#[must_use]
pub fn constant_s(program: &Interpreter) -> f32 {
    let (s, law) = program.setup.power_of_moves(&program.modal);
    if law == PowerLaw::Constant { s } else { 0.0 }
}

/// Ends M3 or M4 without a word of the program; S stays.
pub const fn stop(program: &mut Interpreter) {
    (program.modal.auxiliary.spindle, program.modal.power) = (Spindle::Stopped, 0.0);
}
