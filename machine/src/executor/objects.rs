//! Objects of a print that are left out: which of its moves are not made, and how the machine comes to the
//! next one that is.

use program::{Action, Move, State};

use super::source::{Origin, Source};
use super::{Machine, actions};
use crate::failure::{Answer, Failure, Outcome, message};
use crate::ports::Ports;
use crate::sessions::{Recipient, Reply};

/// Whether a line is of the file being printed, or, while there is none, of whoever sends one. Nothing else
/// is left out: an operator who jogs, or a script that parks, means it.
pub(super) fn is_of_the_print<P: Ports>(machine: &Machine<'_, P>, source: Source) -> bool {
    let origin = if machine.jobs.is_open() { Origin::Job } else { Origin::Session };
    source.origin == origin
}

/// M486: says which object begins, or which one is to be left out.
pub(super) fn label<P: Ports>(machine: &mut Machine<'_, P>, text: &str, to: Recipient) -> Outcome {
    let Machine { jobs, sessions, program, .. } = machine;
    let labelled = jobs.objects.label(text, &mut Reply::new(sessions, to));
    program::objects::leave_out(program, jobs.objects.is_left_out());
    labelled.map(|()| Answer::Ok).map_err(Failure::refused)
}

/// The print has ended: the program is where the machine is.
pub(super) fn end<P: Ports>(machine: &mut Machine<'_, P>) {
    program::objects::leave_out(&mut machine.program, false);
    program::objects::stand_here(&mut machine.program);
}

/// A move while objects are left out: it is not made, or is the first one that is made again.
#[cold]
pub(super) async fn draw<P: Ports>(machine: &mut Machine<'_, P>, request: &Move, to: Recipient) -> Outcome {
    if program::objects::leaves_out(&mut machine.program, request) {
        while let Some(action) = machine.program.next_action() {
            match &action {
                Action::Move(request) if program::objects::leaves_out(&mut machine.program, request) => {}
                other => {
                    actions::carry_out(machine, other, to).await?;
                }
            }
        }
        return Ok(Answer::Ok);
    }
    if machine.safety.state() == State::Check {
        return Ok(Answer::Ok);
    }
    if let Some(back) = program::objects::way_back(&mut machine.program, request) {
        for step in &back.moves {
            actions::move_along(machine, step).await?;
        }
        // Extruders count from here as the file does.
        machine.standstill().await?;
        let set = machine.ports.motion(|motion| motion.set_position(back.place));
        set.map_err(|refusal| Failure::Alarm(message(format_args!("{refusal}"))))?;
    }
    actions::carry_out_all(machine, &Action::Move(*request), to).await
}
