//! G93, G94 and G95: feed modes, the meaning of F.

use units::MmPerSecond;

use crate::action::{Action, Rate};
use crate::context::{Context, Meaning};
use crate::fault::{Fault, Problem};
use crate::interpreter::Interpreter;
use crate::meaning::{cycles, moves};
use crate::state::modal::{FeedMode, MotionMode};
use crate::words::Words;

/// Letters of words that make a move.
const WAY: &str = "XYZABCEIJKR@^";

/// Sets the feed mode (G93, G94, G95); words behind the code are those of the motion code in force.
pub(crate) fn feed_mode<'b>(program: &mut Interpreter, context: &Context<'b>) -> Result<Meaning<'b>, Fault> {
    program.modal.feed_mode = match context.words.code().number {
        93 => FeedMode::InverseTime,
        94 => FeedMode::PerMinute,
        _ => FeedMode::PerRevolution,
    };
    cycles::by_motion_code(program, context)
}

/// Makes a move in inverse time or per revolution. The move is planned as if F were length a minute, and then
/// takes the rate of its mode; after G94 the F before G93 and G95 holds again.
#[cold]
pub(crate) fn motion_block<'b>(program: &mut Interpreter, context: &Context<'b>) -> Result<Meaning<'b>, Fault> {
    let rate = rate(program, &context.words)?;
    let (mode, feed_rate, seek_rate) = (program.modal.feed_mode, program.modal.feed_rate, program.modal.seek_rate);
    program.modal.feed_mode = FeedMode::PerMinute;
    if let Some(Rate::PerRevolution(_)) = rate {
        // A motion block needs a valid rate, whatever F was under G94.
        program.modal.feed_rate = MmPerSecond(1.0);
    }
    let mut done = moves::motion_block(program, context);
    (program.modal.feed_mode, program.modal.feed_rate, program.modal.seek_rate) = (mode, feed_rate, seek_rate);
    if let Ok(Meaning::Action(Action::Move(request))) = &mut done {
        request.rate = rate.unwrap_or(Rate::Rapid(seek_rate));
    }
    done
}

/// Returns the rate of a block's move; `None` for rapid moves and blocks without a move.
fn rate(program: &mut Interpreter, words: &Words<'_>) -> Result<Option<Rate>, Fault> {
    let mode = program.modal.motion;
    let per_turn = program.modal.feed_mode == FeedMode::PerRevolution;
    if let Some(travel) = words.as_length('F').filter(|_| per_turn) {
        program.modal.feed_per_turn = travel;
    }
    if mode == MotionMode::Rapid || !WAY.chars().any(|letter| words.has(letter)) {
        return Ok(None);
    }
    let column = words.column();
    if per_turn && !program.setup.spindle.has_encoder {
        return Err(Problem::Needs(FeedMode::PerRevolution.code(), "a spindle encoder").refused(column));
    }
    if matches!(mode, MotionMode::Cubic | MotionMode::Quadratic | MotionMode::Nurbs) {
        return Err(Problem::NeedsFeedPerMinute.refused(column));
    }
    if per_turn {
        let travel = program.modal.feed_per_turn;
        return if travel > 0.0 {
            Ok(Some(Rate::PerRevolution(travel)))
        } else {
            Err(Problem::NoFeedRate.refused(column))
        };
    }
    let modal = &program.modal;
    let factor = if modal.auxiliary.feed_override { modal.speed_factor } else { 1.0 };
    let seconds = words.as_written('F').map(|per_minute| 60.0 / (per_minute * factor));
    let seconds = seconds.filter(|seconds| seconds.is_finite() && *seconds > 0.0);
    seconds.map(|seconds| Some(Rate::Duration(seconds))).ok_or(Problem::InverseTime.refused(words.column_of('F')))
}
