//! Fast-forward: the lines of a file up to a place of it are read, and nothing moves, heats or waits.
//!
//! The program goes through them as it does in check mode: units, offsets, tools, parameters, subroutines and
//! loops are then as they are at that place. Settings of speeds, accelerations and filters are made too, and
//! requests to heaters and switches are noted ([`Passed`]): the caller that goes on from there decides when
//! they are carried out.
//!
//! A fast-forward is a frame of its own: nothing else is carried out meanwhile, sessions are served, and the
//! frame below comes next.

use base::Ports;
use base::failure::{Answer, Failure, Outcome};
use base::safety::Event;
use procedures::homing;
use program::Action;

use crate::machine::Machine;
use crate::machine::fast_forward_record::{Passed, Until};
use crate::machine::frames::Frame;
use crate::machine::program_io;

/// Reads the job's lines up to a place, once this frame's turn comes. The frame below finds the result by
/// [`take`].
///
/// # Errors
/// While the machine moves, is suspended or halted.
pub(crate) fn begin<P: Ports>(machine: &mut Machine<'_, P>, until: Until) -> Result<(), Failure> {
    if !machine.safety.apply(Event::CheckBegins) {
        return Err(Failure::refused(&"the machine has to stand, without a suspended job, for lines to be read over"));
    }
    if !machine.frames.push(Frame::FastForward) {
        machine.safety.apply(Event::CheckEnds);
        return Err(Failure::refused(&"scripts start each other without end"));
    }
    machine.passed = Some(Passed::new(until, *machine.program.position()));
    Ok(())
}

/// Keeps settings of motion that a file may change while it is read over, in case the job does not go on.
pub(crate) fn keep<P: Ports>(machine: &mut Machine<'_, P>) {
    machine.set_before = machine.world.ports.motion(|motion| motion.config().copied());
}

/// Puts limits, steps and filters back as before the file was read over: the job does not go on.
pub(crate) fn put_back<P: Ports>(machine: &mut Machine<'_, P>) {
    if let Some(before) = machine.set_before.take() {
        // The old values were in force, so neither is refused. A halted machine's steps are not configured.
        let _ = machine.world.ports.motion(|motion| motion.set_limits(before.limits));
        if !machine.safety.is_halted() {
            let _ = machine.world.ports.motion(|motion| motion.configure(before));
        }
    }
}

/// Takes the result of the fast-forward. The program stands where the file does, the machine anywhere.
pub(crate) fn take<P: Ports>(machine: &mut Machine<'_, P>) -> Option<Passed> {
    machine.passed.take()
}

/// Returns whether the fast-forward has come to its place, and ends it then.
pub(crate) fn is_there<P: Ports>(machine: &mut Machine<'_, P>) -> bool {
    let (begun, (_, next), layer) = (machine.jobs.begun(), machine.jobs.places(), machine.jobs.layers().current);
    let is_there =
        machine.passed.as_ref().is_none_or(|passed| passed.until.is_reached(begun, next, layer, passed.seconds));
    if is_there {
        end(machine, true);
    }
    is_there
}

/// Ends the fast-forward at this line.
pub(crate) fn end<P: Ports>(machine: &mut Machine<'_, P>, has_arrived: bool) {
    if let Some(passed) = &mut machine.passed {
        passed.has_arrived = has_arrived;
    }
    machine.frames.drop_top();
    machine.safety.apply(Event::CheckEnds);
}

/// Follows a line that is about to be read over.
pub(crate) fn at_line<P: Ports>(machine: &mut Machine<'_, P>) {
    let here = *machine.program.position();
    if let Some(passed) = &mut machine.passed {
        passed.line_began_at = here;
    }
}

/// Reads over an action, as far as the program, the job or the planner keeps its effect. `None`: none of them
/// does, and it is carried out as in check mode.
pub(crate) fn pass_over<P: Ports>(machine: &mut Machine<'_, P>, action: &Action<'_>) -> Option<Outcome> {
    let passed = machine.passed.as_mut()?;
    match *action {
        // The flow of the program, and its end, are as in the file.
        Action::Call { .. }
        | Action::Return
        | Action::Halt
        | Action::EndProgram
        | Action::Acceleration(_)
        | Action::Function(..) => {
            return None;
        }
        Action::Effect(what) => passed.note(what),
        Action::Move(ref request) => passed.go(request),
        Action::HeatAndWait { heater, target, .. } => passed.note_target(heater, target),
        Action::ProbeDown(_) | Action::ProbeAlong(_) | Action::AwaitInput(_) => passed.has_asked = true,
        Action::Home(axes) => {
            let place = homing::ends_at(machine.world.config, &machine.tuning, axes, machine.program.position());
            machine.program.resynchronise(place);
        }
        Action::SetPosition { ref to, .. } => {
            let mut place = *machine.program.position();
            units::Axis::ALL.into_iter().for_each(|axis| place[axis] = to[axis].unwrap_or(place[axis]));
            machine.program.resynchronise(place);
        }
        Action::Overrides { feed, spindle, hold } => {
            let enabled = program_io::enable_overrides(machine, feed, spindle, hold);
            return Some(enabled.map(|()| Answer::Ok));
        }
        // Nothing of these lasts.
        Action::Dwell(_) | Action::Finish | Action::Pause { .. } | Action::RetractByHand => {}
        Action::Message(_) | Action::Note(_) | Action::Keep | Action::ReadTools => {}
        Action::Suspend { .. } | Action::Resume | Action::Release => {}
        Action::ForgetHoming(_) | Action::ChangeTool(_) => {}
        Action::RigidTap { .. } | Action::Orient { .. } | Action::SurfaceSpeed(_) => {}
    }
    Some(Ok(Answer::Ok))
}
