//! A bore that the operator draws the tool out of (G88).

use base::Ports;
use base::failure::{Answer, Failure, Outcome};
use program::LeftHole;

use crate::machine::Machine;
use crate::machine::frames::Frame;
use crate::machine::operator_pauses;

/// Has the operator draw the tool out; the rest of the block waits until then.
pub(crate) fn retract_by_hand<P: Ports>(machine: &mut Machine<'_, P>) -> Outcome {
    let left = machine.program.leave_hole();
    machine.standstill()?;
    let height = machine.frames.len();
    operator_pauses::wait(machine, format_args!("draw the tool out by hand (G88)"))?;
    if machine.frames.len() == height {
        return take_up(machine, &left).map(|()| Answer::Ok);
    }
    if machine.frames.push_below(height, Frame::Hole(left)) {
        return Ok(Answer::Ok);
    }
    machine.frames.drop_down_to(height);
    Err(Failure::refused(&"scripts start each other without end"))
}

/// Takes up the program once the operator has drawn the tool out: its next actions follow.
///
/// # Errors
/// When other holes have been drilled meanwhile.
pub(crate) fn take_up<P: Ports>(machine: &mut Machine<'_, P>, left: &LeftHole) -> Result<(), Failure> {
    machine.resynchronise();
    if machine.program.return_to(left) {
        return Ok(());
    }
    Err(Failure::refused(&"other holes were drilled while this one waited (G88): nothing of it goes on"))
}
