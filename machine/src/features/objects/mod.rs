//! Objects of a print that are left out: the choice of moves that are not made, and the way to the next move
//! that is.

pub(crate) mod leave_out;

use base::failure::{Answer, Failure, Outcome};
use base::own_frame::apart;
use base::ports::MotionPort as _;
use base::sessions::{Recipient, Reply};
use base::{Ports, World};
use jobs::player::{By, Jobs};
use motion::Tag;
use program::{Interpreter, Move};
use units::Axis;

use crate::machine::moments::{Features, Moments};
use crate::machine::move_dropping::Cut;
use crate::machine::source::{Origin, Source};
use crate::machine::work_hands::JobHands;
use crate::machine::{Machine, moves};

/// The machine for work on objects that are left out.
pub(crate) trait ObjectHands<'c>: JobHands<'c> {
    /// Returns the progress of dropping planned moves.
    fn cut(&mut self) -> &mut Cut;

    /// Whether the machine may brake to drop moves: no line waits behind them, and no tap is under way.
    fn may_brake(&self) -> bool;

    /// Whether moves of an object are being dropped.
    fn is_cutting(&self) -> bool;

    /// Returns planned moves and what they belong to: the jobs, the program, the world.
    fn planned(&mut self) -> (&mut Jobs, &mut Interpreter, &mut World<'c, Self::Ports>);

    /// Whether a recipient's line is one of a file.
    fn is_of_file(&self, to: Recipient) -> bool;

    /// Returns a move of the program in motion's terms, without its curve.
    fn in_motions_terms(&mut self, request: &Move) -> motion::Move;

    /// Makes a move of the program.
    ///
    /// # Errors
    /// For a move that is refused, and when the machine halts.
    fn go_along(&mut self, request: &Move) -> Result<(), Failure>;

    /// Has features know that a person leaves objects out, or takes them in again.
    fn objects_change(&mut self);
}

impl<'c, P: Ports> ObjectHands<'c> for Machine<'c, P> {
    fn cut(&mut self) -> &mut Cut {
        &mut self.cut
    }

    fn may_brake(&self) -> bool {
        !self.cut.has_line_behind && self.hold.acts()
    }

    fn is_cutting(&self) -> bool {
        self.jobs.objects.is_cutting()
    }

    fn planned(&mut self) -> (&mut Jobs, &mut Interpreter, &mut World<'c, P>) {
        (&mut self.jobs, &mut self.program, &mut self.world)
    }

    fn is_of_file(&self, to: Recipient) -> bool {
        to == Recipient::Nobody && self.tag != Tag::NONE
    }

    fn in_motions_terms(&mut self, request: &Move) -> motion::Move {
        moves::made_now(self, request)
    }

    fn go_along(&mut self, request: &Move) -> Result<(), Failure> {
        moves::go_along(self, request)
    }

    fn objects_change(&mut self) {
        Features::<P>::objects_change(self);
    }
}

/// Objects that are left out, at the machine's moments.
pub(crate) struct Feature;

impl<'c, M: ObjectHands<'c>> Moments<M> for Feature {
    fn each_turn(hands: &mut M) {
        if hands.is_cutting() || hands.cut().brakes {
            apart(|| leave_out::serve(hands));
        }
    }

    fn hold_moves_back(hands: &M) -> bool {
        // Lines behind moves that are being dropped wait until the drop is done.
        hands.is_cutting()
    }

    fn block_begins(hands: &mut M, source: Source) {
        if hands.jobs().objects.are_known() || program::objects::is_apart(hands.program()) {
            begin_block(hands, source);
        }
    }

    fn leave_move_out(hands: &mut M, request: &Move) -> Result<bool, Failure> {
        if hands.cut().brakes {
            leave_out::wait(hands)?;
        }
        if program::objects::is_apart(hands.program()) { is_left_out(hands, request) } else { Ok(false) }
    }

    fn job_is_read(hands: &mut M) {
        end(hands);
    }
}

/// Lets a line count as the print's: a line of the file being printed, or of any session while there is none.
/// Nothing else is left out: an operator who jogs, or a script that parks, means it.
#[cold]
pub(crate) fn begin_block<'c>(hands: &mut impl ObjectHands<'c>, source: Source) {
    let prints = if hands.jobs().is_open() { Origin::Job } else { Origin::Session };
    hands.jobs().objects.counts(source.origin == prints);
    program::objects::counts(hands.program(), source.origin == prints);
}

/// Labels lines with an object, or leaves one out (M486).
pub(crate) fn label<'c>(hands: &mut impl ObjectHands<'c>, text: &str, to: Recipient) -> Outcome {
    let by = if hands.is_of_file(to) {
        By::File
    } else {
        By::Person(hands.world().ports.motion(|motion| motion.part_now().unwrap_or(0)))
    };
    let (jobs, program, World { sessions, texts, .. }) = hands.planned();
    let texts = *texts;
    let labelled = jobs.objects.label(text, by, &mut Reply::new(sessions, to));
    program::objects::leave_out(program, jobs.objects.is_left_out());
    if hands.is_cutting() {
        leave_out::find_rest(hands);
    }
    if by != By::File {
        hands.objects_change();
    }
    labelled.map(|()| Answer::Ok).map_err(|error| texts.refused(format_args!("{error}")))
}

/// Ends leaving out at the end of a print: the program is where the machine is.
pub(crate) fn end<'c>(hands: &mut impl ObjectHands<'c>) {
    program::objects::leave_out(hands.program(), false);
    program::objects::stand_here(hands.program());
}

/// Whether a move is left out with its object. Else the machine goes to its beginning first, as it is the
/// next to be made.
#[cold]
pub(crate) fn is_left_out<'c>(hands: &mut impl ObjectHands<'c>, request: &Move) -> Result<bool, Failure> {
    if program::objects::leaves_out(hands.program(), request) {
        return Ok(true);
    }
    if let Some(back) = program::objects::way_back(hands.program(), request) {
        leave_out::leaves_for_heights(hands, back.moves.iter().map(|step| step.target[Axis::Z]));
        // The way there is no part of an object.
        hands.jobs().objects.counts(false);
        for step in &back.moves {
            hands.go_along(step)?;
        }
        hands.jobs().objects.counts(true);
        // Extruders count from here as the file does.
        hands.standstill()?;
        hands.extruders_count_anew();
        let set = hands.world().ports.motion(|motion| motion.set_position(back.place));
        set.map_err(|refusal| hands.world().texts.alarm(format_args!("{refusal}")))?;
    }
    Ok(false)
}
