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
use base::failure::Failure;
use base::safety::Event;
use program::Effect;

use crate::machine::Machine;
use crate::machine::fast_forward_record::{Passed, Until};
use crate::machine::frames::Frame;
use crate::machine::moments::{Features, Moments as _};

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

/// Follows an effect in check mode, or reads it over.
#[cold]
pub(crate) fn follow<P: Ports>(machine: &mut Machine<'_, P>, effect: Effect) {
    let Some(passed) = &mut machine.passed else { return };
    match effect {
        Effect::Target { heater, target } => passed.note_target(heater, target),
        Effect::Switch { switch, on, value } => passed.note_switch(switch, on, value),
        // Rules act later, when a temperature passes their threshold, and lights harm nobody: both are set as
        // they are read.
        Effect::Arm { rule, armed } => Features::<P>::arm(machine, rule, armed),
        Effect::Light(change) => Features::<P>::pass_light(machine, &change),
        Effect::Ignored { .. } => {}
    }
}
