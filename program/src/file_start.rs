//! State of a program at the beginning of a file, as bytes, so that the file can be read again from there
//! after a power cut. Modes that only files set are left out: they must be as at boot.

use units::{MmPerSecond, Plane};

use crate::action::Corner;
use crate::interpreter::Interpreter;
use crate::state::auxiliary::Auxiliary;
use crate::state::cycle::Retract;
use crate::state::modal::{FeedMode, Modal, MotionMode};

/// Number of bytes of a saved state.
pub const BEGINNING_BYTES: usize = 475;

type Bytes = [u8; BEGINNING_BYTES];

/// Cursor that either writes every field to bytes or reads every field from them.
struct Fields<'b> {
    bytes: &'b mut Bytes,
    at: usize,
    reads: bool,
}

impl Fields<'_> {
    fn number(&mut self, value: &mut f64) {
        let Some(bytes) = self.bytes.get_mut(self.at..self.at + 8).and_then(|bytes| bytes.first_chunk_mut::<8>())
        else {
            return;
        };
        if self.reads {
            *value = f64::from_le_bytes(*bytes);
        } else {
            *bytes = value.to_le_bytes();
        }
        self.at += 8;
    }

    fn numbers(&mut self, values: &mut [f64]) {
        values.iter_mut().for_each(|value| self.number(value));
    }

    fn byte(&mut self, value: &mut u8) {
        if let Some(byte) = self.bytes.get_mut(self.at) {
            if self.reads {
                *value = *byte;
            } else {
                *byte = *value;
            }
        }
        self.at += 1;
    }

    fn rate(&mut self, rate: &mut MmPerSecond) {
        self.number(&mut rate.0);
    }

    fn flag(&mut self, flag: &mut bool) {
        let mut byte = u8::from(*flag);
        self.byte(&mut byte);
        *flag = byte != 0;
    }
}

/// Visits every field in order. Returns false when the bytes hold something else.
fn go_through(program: &mut Interpreter, fields: &mut Fields<'_>) -> bool {
    let modal = &mut program.modal;
    for rate in [&mut modal.feed_rate, &mut modal.seek_rate] {
        fields.rate(rate);
    }
    modal.systems.iter_mut().for_each(|offsets| fields.numbers(offsets));
    for offsets in [&mut modal.g92, &mut modal.g92_kept, &mut modal.tool_offset, &mut modal.shift] {
        fields.numbers(offsets);
    }
    fields.numbers(core::slice::from_mut(&mut modal.thermal_z));
    fields.numbers(&mut program.position.0);
    let mut tools = [[0.0, 1.0, f64::NAN]; crate::state::tools::MAX_TOOLS];
    for (kept, tool) in tools.iter_mut().zip(&program.tools.tools) {
        *kept = [tool.e, tool.flow, tool.retracted.unwrap_or(f64::NAN)];
    }
    tools.iter_mut().for_each(|kept| fields.numbers(kept));
    for (tool, [e, flow, retracted]) in program.tools.tools.iter_mut().zip(tools) {
        (tool.e, tool.flow, tool.retracted) = (e, flow, Some(retracted).filter(|lift| !lift.is_nan()));
    }
    for flag in [
        &mut modal.inches,
        &mut modal.absolute,
        &mut modal.e_absolute,
        &mut modal.e_places,
        &mut modal.g92_is_on,
        &mut modal.has_tool_length,
    ] {
        fields.flag(flag);
    }
    let (mut active, mut system) = (program.tools.active as u8, modal.system as u8);
    let mut motion = modal.motion_code().number as u8;
    let mut plane = modal.plane as u8;
    for byte in [&mut active, &mut system, &mut motion, &mut plane] {
        fields.byte(byte);
    }
    let plane = [Plane::Xy, Plane::Xz, Plane::Yz].get(usize::from(plane)).copied();
    let motion = MotionMode::from_g(u16::from(motion), 0);
    let has = usize::from(active) < program.tools.tools.len().max(1) && usize::from(system) < modal.systems.len();
    let (Some(plane), Some(motion), true) = (plane, motion, has) else { return false };
    (modal.plane, modal.motion) = (plane, motion);
    (program.tools.active, modal.system) = (usize::from(active), usize::from(system));
    true
}

/// Whether all state that is not saved is as at boot.
fn is_plain(program: &Interpreter) -> bool {
    let modal = &program.modal;
    let modes = Auxiliary { speed: None, ..modal.auxiliary } == Auxiliary::START;
    let modes = modes && modal.corner == Corner::Sharp && modal.feed_mode == FeedMode::PerMinute;
    let modes = modes && modal.retract == Retract::Initial && !modal.arc_absolute && !modal.diameters;
    modes
        && !modal.rotations.any()
        && program.flow.is_at_rest()
        && modal.motion_code().subcode == 0
        && !matches!(modal.motion, MotionMode::Cycle | MotionMode::Synchronised | MotionMode::Threading)
}

/// Returns the program's state; `None` while modes are in force that are not saved.
pub fn beginning(program: &mut Interpreter) -> Option<Bytes> {
    let (bytes, is_whole) = standing(program);
    is_whole.then_some(bytes)
}

/// Returns the saved part of the program's state, and whether that part is all of the state.
pub fn standing(program: &mut Interpreter) -> (Bytes, bool) {
    let mut bytes = [0; BEGINNING_BYTES];
    let is_kept = go_through(program, &mut Fields { bytes: &mut bytes, at: 0, reads: false });
    (bytes, is_kept && is_plain(program))
}

/// Restores a program to a saved state, whatever modes a file has set since. Returns false when the bytes
/// hold something else.
pub fn begin_again(program: &mut Interpreter, bytes: &mut Bytes) -> bool {
    program.halt();
    program.modal = Modal::new(program.setup.feed_rate, program.modal.seek_rate);
    is_plain(program) && go_through(program, &mut Fields { bytes, at: 0, reads: true })
}

/// Sets the flow factors of the extruders, in the order of their numbers.
pub fn set_flow(program: &mut Interpreter, flow: &[f64]) {
    program.tools.tools.iter_mut().zip(flow).for_each(|(tool, flow)| tool.flow = *flow);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::state::setup::Setup;

    #[test]
    fn a_beginning_is_come_back_to() {
        let mut program = Interpreter::new(Setup::default());
        program.modal.inches = true;
        program.modal.system = 3;
        program.modal.systems[3] = [1.0, -2.0, 0.5];
        program.modal.g92 = [0.0, 0.0, 7.25];
        program.position.0[2] = 12.5;
        let mut bytes = beginning(&mut program).unwrap();
        let mut other = Interpreter::new(Setup::default());
        assert!(begin_again(&mut other, &mut bytes));
        assert_eq!(beginning(&mut other).unwrap(), bytes);
        assert!(other.modal.inches && other.modal.systems[3] == [1.0, -2.0, 0.5] && other.position.0[2] == 12.5);
        other.modal.feed_mode = FeedMode::InverseTime;
        other.modal.corner = Corner::Stop;
        assert!(beginning(&mut other).is_none(), "modes that are not kept");
        assert!(begin_again(&mut other, &mut bytes) && beginning(&mut other) == Some(bytes));
    }

    #[test]
    fn bytes_of_something_else_are_none() {
        let mut program = Interpreter::new(Setup::default());
        assert!(!begin_again(&mut program, &mut [0xFF; BEGINNING_BYTES]));
    }
}
