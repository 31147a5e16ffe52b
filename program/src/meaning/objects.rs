//! Objects that are left out of a print: the program goes through their lines, the machine stays.

use units::PerAxis;

use crate::action::{Move, Shape};
use crate::interpreter::Interpreter;
pub use crate::state::left_out_objects::WayBack;
use crate::state::left_out_objects::{Manner, Stay};

/// Begins or ends leaving out the program's moves.
pub fn leave_out(program: &mut Interpreter, yes: bool) {
    if yes || program.left_out.is_some() {
        program.left_out.get_or_insert_default().lasts(yes);
    }
    forget_if_done(program);
}

fn forget_if_done(program: &mut Interpreter) {
    program.left_out = program.left_out.take().filter(|left_out| !left_out.is_done());
}

/// Sets whether the next block belongs to the print; any other block begins at the machine's position.
pub fn counts(program: &mut Interpreter, yes: bool) {
    if let Some(left_out) = &mut program.left_out {
        left_out.counts(yes);
        if !yes {
            stand_here(program);
        }
    }
}

/// Whether moves are left out, or the machine has not gone on since.
#[must_use]
#[inline]
pub const fn is_apart(program: &Interpreter) -> bool {
    program.left_out.is_some()
}

/// Sets the program's position to the machine's, because somebody else moves the machine or the print ends.
#[cold]
pub fn stand_here(program: &mut Interpreter) {
    if let Some(place) = program.left_out.as_mut().and_then(crate::state::left_out_objects::LeftOut::take_place) {
        program.position = place;
    }
    forget_if_done(program);
}

/// Whether this move, which the program has made, is left out.
#[cold]
pub fn leaves_out(program: &mut Interpreter, request: &Move) -> bool {
    let (from, extruders) = (program.before(), program.tools.axes());
    program.left_out.as_mut().is_some_and(|left_out| left_out.follow(from, &request.target, &extruders))
}

/// Returns the way to the first move that is made again, which the program has made already. `None` when
/// nothing was left out.
#[cold]
pub fn way_back(program: &mut Interpreter, request: &Move) -> Option<WayBack> {
    let left_out = program.left_out.take_if(|left_out| left_out.has_ended())?;
    // Position before this move, in the file's count.
    let place: PerAxis<f64> = program.before();
    let next = (&request.target, matches!(request.shape, Shape::Line { .. }));
    let must_arrive = !program.is_last_action();
    left_out.stays().map(|stay| with_manner(program, |manner| stay.way_back(&place, next, must_arrive, manner)))
}

fn with_manner<R>(program: &Interpreter, f: impl FnOnce(&Manner<'_>) -> R) -> R {
    let pulls = program.tools.active().map(|tool| (tool.settings.axis, tool.settings.retract_rate));
    f(&Manner { extruders: &program.tools.axes(), pulls, travel: program.modal.seek_rate })
}

/// Sequence of moves that the program has made, and that are cancelled after all.
#[derive(Clone, Debug)]
pub struct TakenOut(Stay);

impl TakenOut {
    /// Starts at the machine's position, where the first cancelled move goes on or begins.
    #[must_use]
    pub fn from(at: PerAxis<f64>) -> Self {
        Self(Stay::new(at))
    }

    /// Adds a move that leads to this position.
    pub fn follow(&mut self, program: &Interpreter, to: &PerAxis<f64>) {
        self.0.follow(to, &program.tools.axes());
    }
}

/// Cancels these moves when no other moves are planned behind them.
#[cold]
pub fn stay(program: &mut Interpreter, taken_out: TakenOut) {
    program.left_out.get_or_insert_default().stay(taken_out.0);
}

/// Returns the way round the cancelled moves to the next planned move, which leads to `target` and may be
/// straight.
#[cold]
#[must_use]
pub fn way_round(program: &Interpreter, taken_out: &TakenOut, next: (&PerAxis<f64>, bool)) -> WayBack {
    let stay = &taken_out.0;
    with_manner(program, |manner| stay.way_back(stay.believed(), next, false, manner))
}
