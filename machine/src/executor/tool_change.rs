//! Tool change (M6): a script to where tools are changed, the operator's part, and a script behind it.

use base::failure::{Answer, Failure, Outcome};

use crate::machine::frames::Frame;
use crate::machine::operator_pauses::{self, OperatorHands};

/// Begins a tool change; the rest of its line waits for the end.
pub(crate) fn begin<'c>(hands: &mut impl OperatorHands<'c>, tool: u32) -> Outcome {
    hands.standstill()?;
    if hands.config().tool_change.before_gcode.is_empty() {
        put_in(hands, tool)?;
        return Ok(Answer::Ok);
    }
    let script = &hands.config().tool_change.before_gcode;
    let fits = hands.frames().push(Frame::ToolChange(tool)) && hands.frames().push_script(script);
    if !fits {
        return Err(without_end());
    }
    Ok(Answer::Ok)
}

/// Has the operator put the tool in, or take out the one that is there (0); then runs the second script.
pub(crate) fn put_in<'c>(hands: &mut impl OperatorHands<'c>, tool: u32) -> Result<(), Failure> {
    let script = &hands.config().tool_change.after_gcode;
    if !script.is_empty() && !hands.frames().push_script(script) {
        return Err(without_end());
    }
    if !hands.config().tool_change.prompt {
        return Ok(());
    }
    // The script may have moved to the place of the change.
    hands.standstill()?;
    let waited = if tool == 0 {
        operator_pauses::wait(hands, format_args!("take the tool out (T0 M6)"))
    } else {
        operator_pauses::wait(hands, format_args!("put in tool {tool} (M6)"))
    };
    waited.map(drop)
}

fn without_end() -> Failure {
    Failure::refused(&"scripts start each other without end")
}
