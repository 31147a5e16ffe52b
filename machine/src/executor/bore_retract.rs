//! A bore that the operator draws the tool out of (G88).

use base::failure::{Answer, Failure, Outcome};
use program::LeftHole;

use crate::machine::frames::Frame;
use crate::machine::operator_pauses::{self, OperatorHands};

/// Has the operator draw the tool out; the rest of the block waits until then.
pub(crate) fn retract_by_hand<'c>(hands: &mut impl OperatorHands<'c>) -> Outcome {
    let left = hands.program().leave_hole();
    hands.standstill()?;
    let height = hands.frames().len();
    operator_pauses::wait(hands, format_args!("draw the tool out by hand (G88)"))?;
    if hands.frames().len() == height {
        return take_up(hands, &left).map(|()| Answer::Ok);
    }
    if hands.frames().push_below(height, Frame::Hole(left)) {
        return Ok(Answer::Ok);
    }
    hands.frames().drop_down_to(height);
    Err(Failure::refused(&"scripts start each other without end"))
}

/// Takes up the program once the operator has drawn the tool out: its next actions follow.
///
/// # Errors
/// When other holes have been drilled meanwhile.
pub(crate) fn take_up<'c>(hands: &mut impl OperatorHands<'c>, left: &LeftHole) -> Result<(), Failure> {
    let position = hands.position();
    let program = hands.program();
    program.resynchronise(position);
    if program.return_to(left) {
        return Ok(());
    }
    Err(Failure::refused(&"other holes were drilled while this one waited (G88): nothing of it goes on"))
}
