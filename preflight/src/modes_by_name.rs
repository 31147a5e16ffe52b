//! Modes of the program, to be kept by a name.

use units::Axis;

use super::kept_modes::Kept;
use super::state::Preflight;

/// Makes a number of a name, in upper or lower case (FNV-1a).
fn number_of(name: &str) -> u32 {
    name.bytes().fold(0x811C_9DC5, |sum, byte| (sum ^ u32::from(byte.to_ascii_uppercase())).wrapping_mul(0x0100_0193))
}

impl Preflight<'_> {
    /// Returns the modes that are in force, to be kept by a name.
    pub(super) fn modes_as(&self, name: &str) -> Kept {
        let program = &*self.program;
        let (place, extruder) = (program.position(), program.tools().active().map_or(0.0, |tool| tool.e));
        let at = [place[Axis::X], place[Axis::Y], place[Axis::Z]];
        Kept { name: number_of(name), modes: program::modes(program), at, extruder }
    }
}
