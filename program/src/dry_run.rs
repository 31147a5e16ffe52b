//! Dry runs: what an action leaves behind when nothing moves, heats or waits.
//!
//! Preflight, check mode (`$C`) and a fast-forward to a place of a file each keep something else of a
//! program. Which actions leave what is decided here, once for all of them.

use units::{AxisSet, Celsius, HeaterId, Micros, PerAxis};

use crate::action::{Action, Effect, Move};
use crate::function::Function;
use crate::words::Words;

/// Keeper of what the actions of a dry run leave behind.
pub trait DryRun {
    /// Outcome of an action.
    type Outcome;

    /// Returns the outcome of an action that leaves nothing.
    fn nothing(&mut self) -> Self::Outcome;

    /// Notes a move.
    fn moves(&mut self, request: &Move) -> Self::Outcome;

    /// Follows the change of an output.
    fn changes(&mut self, effect: Effect) -> Self::Outcome;

    /// Notes a target that is waited for.
    fn heats(&mut self, heater: HeaterId, target: Celsius) -> Self::Outcome;

    /// Counts a wait of known length.
    fn waits(&mut self, _time: Micros) {}

    /// Stands where homing ends.
    fn homes(&mut self, axes: AxisSet);

    /// Stands at a place that the program names; axes without a value stay.
    fn stands_at(&mut self, to: &PerAxis<Option<f64>>, homed: bool);

    /// Marks axes as not homed.
    fn forgets_homing(&mut self, _axes: AxisSet) {}

    /// Notes that the program has asked for a result that only the machine has: of a probe or an input.
    fn asks(&mut self);

    /// Sets the acceleration of later moves, mm/s2.
    fn accelerates(&mut self, value: f64) -> Self::Outcome;

    /// Enables or disables overrides of feed, of spindle, and feed hold.
    fn overrides(&mut self, _feed: bool, _spindle: bool, _hold: bool) -> Self::Outcome {
        self.nothing()
    }

    /// Carries out those functions that count in this dry run.
    fn runs(&mut self, function: Function, words: &Words<'_>) -> Self::Outcome;

    /// Calls a subroutine by its number.
    fn calls(&mut self, number: u32, times: u32) -> Self::Outcome;

    /// Returns from a subroutine.
    fn returns(&mut self) -> Self::Outcome;

    /// Ends the program.
    fn ends(&mut self) -> Self::Outcome;

    /// Stops the machine.
    fn halts(&mut self) -> Self::Outcome;

    /// Tells a remark about the line.
    fn notes(&mut self, _text: &'static str) {}
}

/// Carries out an action in a dry run.
pub fn carry_out<D: DryRun>(run: &mut D, action: &Action<'_>) -> D::Outcome {
    match *action {
        Action::Move(ref request) => return run.moves(request),
        Action::Effect(effect) => return run.changes(effect),
        Action::HeatAndWait { heater, target, .. } => return run.heats(heater, target),
        Action::Dwell(time) | Action::Pause { time: Some(time), .. } => run.waits(time),
        Action::Home(axes) => run.homes(axes),
        Action::SetPosition { ref to, homed } => run.stands_at(to, homed),
        Action::ForgetHoming(axes) => run.forgets_homing(axes),
        Action::ProbeDown(_) | Action::ProbeAlong(_) | Action::AwaitInput(_) => run.asks(),
        Action::Acceleration(value) => return run.accelerates(value),
        Action::Overrides { feed, spindle, hold } => return run.overrides(feed, spindle, hold),
        Action::Function(function, ref words) => return run.runs(function, words),
        Action::Call { number, times } => return run.calls(number, times),
        Action::Return => return run.returns(),
        Action::EndProgram => return run.ends(),
        Action::Halt => return run.halts(),
        Action::Note(text) => run.notes(text),
        // Nothing of these lasts, or the operator decides what does.
        Action::Finish | Action::Release | Action::Resume | Action::Message(_) => {}
        Action::Pause { time: None, .. } | Action::Suspend { .. } | Action::ChangeTool(_) => {}
        Action::RetractByHand | Action::RigidTap { .. } | Action::Orient { .. } | Action::SurfaceSpeed(_) => {}
        Action::ReadTools | Action::Keep => {}
    }
    run.nothing()
}
