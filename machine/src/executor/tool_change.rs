//! Tool change (M6): a script to where tools are changed, the operator's part, and a script behind it.

use base::Ports;
use base::failure::{Answer, Failure, Outcome};

use crate::machine::Machine;
use crate::machine::frames::Frame;
use crate::machine::operator_pauses;

/// Begins a tool change; the rest of its line waits for the end.
pub(crate) fn begin<P: Ports>(machine: &mut Machine<'_, P>, tool: u32) -> Outcome {
    machine.standstill()?;
    if machine.world.config.tool_change.before_gcode.is_empty() {
        put_in(machine, tool)?;
        return Ok(Answer::Ok);
    }
    let script = &machine.world.config.tool_change.before_gcode;
    let fits = machine.frames.push(Frame::ToolChange(tool)) && machine.frames.push_script(script);
    if !fits {
        return Err(without_end());
    }
    Ok(Answer::Ok)
}

/// Has the operator put the tool in, or take out the one that is there (0); then runs the second script.
pub(crate) fn put_in<P: Ports>(machine: &mut Machine<'_, P>, tool: u32) -> Result<(), Failure> {
    let script = &machine.world.config.tool_change.after_gcode;
    if !script.is_empty() && !machine.frames.push_script(script) {
        return Err(without_end());
    }
    if !machine.world.config.tool_change.prompt {
        return Ok(());
    }
    // The script may have moved to the place of the change.
    machine.standstill()?;
    let waited = if tool == 0 {
        operator_pauses::wait(machine, format_args!("take the tool out (T0 M6)"))
    } else {
        operator_pauses::wait(machine, format_args!("put in tool {tool} (M6)"))
    };
    waited.map(drop)
}

fn without_end() -> Failure {
    Failure::refused(&"scripts start each other without end")
}
