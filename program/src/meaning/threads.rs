//! Moves that follow the spindle: G33 and G33.1, with the words LinuxCNC gives them.

use crate::action::{Action, Corner, Move, Rate, Shape};
use crate::context::{Context, Meaning, NOTHING};
use crate::fault::{Fault, Problem};
use crate::interpreter::Interpreter;
use crate::meaning::{moves, spindle};
use crate::modal::{FeedMode, MotionMode};
use crate::words::Words;

/// G33 and G33.1.
pub(crate) fn follow<'b>(program: &mut Interpreter, context: &Context<'b>) -> Result<Meaning<'b>, Fault> {
    let words = &context.words;
    let taps = words.code().subcode != 0;
    begin(program, context, MotionMode::Synchronised)?;
    let pitch = words.length('K').filter(|_| words.has('K')).ok_or(Problem::MustSupply('K').refused(words.column()))?;
    if !"XYZABC@^".chars().any(|letter| words.has(letter)) {
        return Err(Problem::NoWay.refused(words.column()));
    }
    let (target, _) = moves::target_of(program, words)?;
    program.modal.machine_next = false;
    if taps {
        // It ends where it began.
        let faster = words.get('I').unwrap_or(1.0);
        return Ok(Meaning::Action(Action::RigidTap {
            target,
            pitch,
            faster: if faster > 1.0 { faster } else { 1.0 },
        }));
    }
    if target == program.position {
        return NOTHING;
    }
    program.position = target;
    let shape = Shape::Line { names_xy: words.has('X') || words.has('Y') };
    let (rate, power) = (Rate::PerRevolution(pitch), program.modal.power);
    Ok(Meaning::Action(Action::Move(Move { target, shape, rate, power, corner: Corner::Sharp })))
}

/// What holds for all of them.
fn begin(program: &mut Interpreter, context: &Context<'_>, mode: MotionMode) -> Result<(), Fault> {
    spindle::needs_encoder(program, context)?;
    program.end_cycles();
    program.modal.motion = mode;
    let column = context.words.column();
    if program.modal.feed_mode == FeedMode::InverseTime {
        return Err(Problem::NeedsFeedPerMinute.refused(column));
    }
    if program.modal.auxiliary.spindle == crate::Spindle::Stopped {
        return Err(Problem::SpindleStands.refused(column));
    }
    Ok(())
}
