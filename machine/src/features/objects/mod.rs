//! Objects of a print that are left out: the choice of moves that are not made, and the way to the next move
//! that is.

pub(crate) mod leave_out;

use base::failure::{Answer, Failure, Outcome};
use base::own_frame::apart;
use base::sessions::{Recipient, Reply};
use base::{Ports, World};
use jobs::player::By;
use motion::Tag;
use program::Move;
use units::Axis;

use crate::machine::moments::{Features, Moments};
use crate::machine::source::{Origin, Source};
use crate::machine::{Machine, moves};

/// Objects that are left out, at the machine's moments.
pub(crate) struct Feature;

impl<'c, P: Ports> Moments<Machine<'c, P>> for Feature {
    fn each_turn(machine: &mut Machine<'_, P>) {
        if machine.jobs.objects.is_cutting() || machine.cut.brakes {
            apart(|| leave_out::serve(machine));
        }
    }

    fn hold_moves_back(machine: &Machine<'_, P>) -> bool {
        // Lines behind moves that are being dropped wait until the drop is done.
        machine.jobs.objects.is_cutting()
    }

    fn block_begins(machine: &mut Machine<'_, P>, source: Source) {
        if machine.jobs.objects.are_known() || program::objects::is_apart(&machine.program) {
            begin_block(machine, source);
        }
    }

    fn leave_move_out(machine: &mut Machine<'_, P>, request: &Move) -> Result<bool, Failure> {
        if machine.cut.brakes {
            leave_out::wait(machine)?;
        }
        if program::objects::is_apart(&machine.program) { is_left_out(machine, request) } else { Ok(false) }
    }

    fn job_is_read(machine: &mut Machine<'_, P>) {
        end(machine);
    }
}

/// Lets a line count as the print's: a line of the file being printed, or of any session while there is none.
/// Nothing else is left out: an operator who jogs, or a script that parks, means it.
#[cold]
pub(crate) fn begin_block<P: Ports>(machine: &mut Machine<'_, P>, source: Source) {
    let prints = if machine.jobs.is_open() { Origin::Job } else { Origin::Session };
    machine.jobs.objects.counts(source.origin == prints);
    program::objects::counts(&mut machine.program, source.origin == prints);
}

/// Labels lines with an object, or leaves one out (M486).
pub(crate) fn label<P: Ports>(machine: &mut Machine<'_, P>, text: &str, to: Recipient) -> Outcome {
    let is_of_file = to == Recipient::Nobody && machine.tag != Tag::NONE;
    let by = if is_of_file {
        By::File
    } else {
        By::Person(machine.world.ports.motion(|motion| motion.part_now().unwrap_or(0)))
    };
    let Machine { jobs, program, world: World { sessions, .. }, .. } = machine;
    let labelled = jobs.objects.label(text, by, &mut Reply::new(sessions, to));
    program::objects::leave_out(program, jobs.objects.is_left_out());
    if jobs.objects.is_cutting() {
        leave_out::find_rest(machine);
    }
    if by != By::File {
        Features::<P>::objects_change(machine);
    }
    labelled.map(|()| Answer::Ok).map_err(|error| machine.world.texts.refused(format_args!("{error}")))
}

/// Ends leaving out at the end of a print: the program is where the machine is.
pub(crate) fn end<P: Ports>(machine: &mut Machine<'_, P>) {
    program::objects::leave_out(&mut machine.program, false);
    program::objects::stand_here(&mut machine.program);
}

/// Whether a move is left out with its object. Else the machine goes to its beginning first, as it is the
/// next to be made.
#[cold]
pub(crate) fn is_left_out<P: Ports>(machine: &mut Machine<'_, P>, request: &Move) -> Result<bool, Failure> {
    if program::objects::leaves_out(&mut machine.program, request) {
        return Ok(true);
    }
    if let Some(back) = program::objects::way_back(&mut machine.program, request) {
        leave_out::leaves_for_heights(machine, back.moves.iter().map(|step| step.target[Axis::Z]));
        // The way there is no part of an object.
        machine.jobs.objects.counts(false);
        for step in &back.moves {
            moves::go_along(machine, step)?;
        }
        machine.jobs.objects.counts(true);
        // Extruders count from here as the file does.
        machine.standstill()?;
        Features::<P>::extruders_count_anew(machine);
        let set = machine.world.ports.motion(|motion| motion.set_position(back.place));
        set.map_err(|refusal| machine.world.texts.alarm(format_args!("{refusal}")))?;
    }
    Ok(false)
}
