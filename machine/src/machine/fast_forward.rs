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
use base::ports::MotionPort as _;
use base::safety::Event;
use motion::MotionConfig;
use program::{Effect, LightChange};

use crate::machine::Machine;
use crate::machine::fast_forward_record::{Passed, Until};
use crate::machine::frames::Frame;
use crate::machine::moments::{Features, Moments as _};
use crate::machine::work_hands::JobHands;

/// The machine for work that reads lines of a job over.
pub(crate) trait ReadOverHands<'c>: JobHands<'c> {
    /// Returns the record of lines read over, until somebody takes it.
    fn passed(&mut self) -> &mut Option<Passed>;

    /// Returns limits, steps and filters as they were before a file was read over, until its job goes on.
    fn set_before(&mut self) -> &mut Option<MotionConfig>;

    /// Arms a rule that switches an output by temperature, or disarms it.
    fn arm(&mut self, rule: u8, armed: bool);

    /// Notes a change of lights that is read over.
    fn pass_light(&mut self, change: &LightChange);
}

impl<'c, P: Ports> ReadOverHands<'c> for Machine<'c, P> {
    fn passed(&mut self) -> &mut Option<Passed> {
        &mut self.passed
    }

    fn set_before(&mut self) -> &mut Option<MotionConfig> {
        &mut self.set_before
    }

    fn arm(&mut self, rule: u8, armed: bool) {
        Features::<P>::arm(self, rule, armed);
    }

    fn pass_light(&mut self, change: &LightChange) {
        Features::<P>::pass_light(self, change);
    }
}

/// Reads the job's lines up to a place, once this frame's turn comes. The frame below finds the result by
/// [`take`].
///
/// # Errors
/// While the machine moves, is suspended or halted.
pub(crate) fn begin<'c>(hands: &mut impl ReadOverHands<'c>, until: Until) -> Result<(), Failure> {
    if !hands.apply(Event::CheckBegins) {
        return Err(Failure::refused(&"the machine has to stand, without a suspended job, for lines to be read over"));
    }
    if !hands.frames().push(Frame::FastForward) {
        hands.apply(Event::CheckEnds);
        return Err(Failure::refused(&"scripts start each other without end"));
    }
    let here = *hands.program().position();
    *hands.passed() = Some(Passed::new(until, here));
    Ok(())
}

/// Keeps settings of motion that a file may change while it is read over, in case the job does not go on.
pub(crate) fn keep<'c>(hands: &mut impl ReadOverHands<'c>) {
    let config = hands.world().ports.motion(|motion| motion.config().copied());
    *hands.set_before() = config;
}

/// Puts limits, steps and filters back as before the file was read over: the job does not go on.
pub(crate) fn put_back<'c>(hands: &mut impl ReadOverHands<'c>) {
    if let Some(before) = hands.set_before().take() {
        // The old values were in force, so neither is refused. A halted machine's steps are not configured.
        let _ = hands.world().ports.motion(|motion| motion.set_limits(before.limits));
        if !hands.is_halted() {
            let _ = hands.world().ports.motion(|motion| motion.configure(before));
        }
    }
}

/// Returns whether the fast-forward has come to its place, and ends it then.
pub(crate) fn is_there<'c>(hands: &mut impl ReadOverHands<'c>) -> bool {
    let jobs = hands.jobs();
    let (begun, (_, next), layer) = (jobs.begun(), jobs.places(), jobs.layers().current);
    let is_there =
        hands.passed().as_ref().is_none_or(|passed| passed.until.is_reached(begun, next, layer, passed.seconds));
    if is_there {
        end(hands, true);
    }
    is_there
}

/// Ends the fast-forward at this line.
pub(crate) fn end<'c>(hands: &mut impl ReadOverHands<'c>, has_arrived: bool) {
    if let Some(passed) = hands.passed() {
        passed.has_arrived = has_arrived;
    }
    hands.frames().drop_top();
    hands.apply(Event::CheckEnds);
}

/// Follows a line that is about to be read over.
pub(crate) fn at_line<'c>(hands: &mut impl ReadOverHands<'c>) {
    let here = *hands.program().position();
    if let Some(passed) = hands.passed() {
        passed.line_began_at = here;
    }
}

/// Follows an effect in check mode, or reads it over.
#[cold]
pub(crate) fn follow<'c>(hands: &mut impl ReadOverHands<'c>, effect: Effect) {
    let Some(passed) = hands.passed() else { return };
    match effect {
        Effect::Target { heater, target } => passed.note_target(heater, target),
        Effect::Switch { switch, on, value } => passed.note_switch(switch, on, value),
        // Rules act later, when a temperature passes their threshold, and lights harm nobody: both are set as
        // they are read.
        Effect::Arm { rule, armed } => hands.arm(rule, armed),
        Effect::Light(change) => hands.pass_light(&change),
        Effect::Ignored { .. } => {}
    }
}
