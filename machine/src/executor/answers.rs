//! Answers to lines that have come to their end: ok, error, alarm, resend.

use base::failure::{Answer, Failure, FailureKind, Outcome};
use base::reason::Reason;
use base::sessions::{Recipient, Reply, SessionId, Sessions};
use base::{Ports, World};
use gcode::{Code, Refusal, SyntaxError};
use jobs::player::Jobs;
use jobs::player::line_numbers::tag_of;
use motion::Tag;

use super::stack;
use crate::machine::Machine;
use crate::machine::end_requests::Asked;
use crate::machine::fast_forward_record::Passed;
use crate::machine::moments::{Features, Moments as _};
use crate::machine::source::{Origin, Source};
use crate::machine::work_hands::HaltHands;

/// The work that a line belongs to.
pub(crate) struct InWork<'m, 'c, P> {
    /// Record of the lines that a fast-forward reads over.
    passed: &'m mut Option<Passed>,
    /// Requests that do not wait for the line in work.
    urgent: &'m Asked,
    jobs: &'m mut Jobs,
    world: &'m mut World<'c, P>,
}

/// The machine for the ends of lines.
pub(crate) trait LineHands<'c>: HaltHands<'c> {
    /// Returns the work that a line belongs to.
    fn in_work(&mut self) -> InWork<'_, 'c, Self::Ports>;

    /// Whether the work in progress is to end.
    fn is_ended(&self) -> bool;

    /// Notes that a line of a session has been answered.
    fn answered(&mut self, id: SessionId);

    /// Whether a feature stops the job at this line, and says so itself.
    fn explains_stop(&self) -> bool;
}

impl<'c, P: Ports> LineHands<'c> for Machine<'c, P> {
    fn in_work(&mut self) -> InWork<'_, 'c, P> {
        let Self { passed, urgent, jobs, world, .. } = self;
        InWork { passed, urgent, jobs, world }
    }

    fn is_ended(&self) -> bool {
        self.urgent.ends()
    }

    fn answered(&mut self, id: SessionId) {
        self.answered(id);
    }

    fn explains_stop(&self) -> bool {
        Features::<P>::explains_stop(self)
    }
}

/// Answers a line that has come to its end.
#[inline]
pub(crate) fn finish<P: Ports>(machine: &mut Machine<'_, P>, outcome: Outcome, last: Option<Code>, source: Source) {
    // Most lines of a file end so.
    if outcome.is_ok() && (source.origin, source.to) == (Origin::Job, Recipient::Nobody) {
        return;
    }
    answer(machine, outcome, last, source);
}

#[inline(never)]
fn answer<P: Ports>(machine: &mut Machine<'_, P>, outcome: Outcome, last: Option<Code>, source: Source) {
    match source.origin {
        Origin::Settings => {
            match stack::settings_problem(machine.world.texts, outcome) {
                Ok(problem) => machine.polls.settings_problem = problem,
                Err(failure) => stack::fail(machine, failure),
            }
            return;
        }
        Origin::Startup(number) => Features::<P>::startup_line_ended(machine, number, &outcome),
        Origin::Macro(_) => return end_macro_line(machine, outcome, last),
        _ => {}
    }
    let carried_out = outcome.is_ok();
    // A console connected since the line was sent has asked for nothing, and counts its own answers.
    let is_for_him = source.origin != Origin::Session || !machine.world.sessions.has_left(source.to);
    if !is_for_him && matches!(outcome, Ok(_) | Err(Failure { kind: FailureKind::Refused, .. })) {
        return done(machine, carried_out, source);
    }
    match outcome {
        Err(failure) if failure.is_alarm() => alarm(machine, failure, source.to),
        outcome => say_answer(&mut machine.world, machine.urgent.ends(), outcome, last, source.to),
    }
    done(machine, carried_out, source);
}

/// Ends a line of a macro: nobody is answered, and a failure ends the macro with the line that has called it.
#[cold]
fn end_macro_line<P: Ports>(machine: &mut Machine<'_, P>, outcome: Outcome, last: Option<Code>) {
    match (outcome, last) {
        (Err(failure), _) => stack::fail(machine, failure),
        (Ok(Answer::Unknown), Some(code)) => {
            machine.announce(format_args!("// WARNING {code} is not known here and was passed over\n"));
        }
        (Ok(Answer::Said), _) => machine.frames.was_answered(),
        (Ok(Answer::Ok | Answer::PassedOver | Answer::Unknown), _) => {}
    }
}

/// Fails a line that has been answered already: a sender must not count a second answer.
pub(crate) fn fail_late<'c>(hands: &mut impl LineHands<'c>, failure: Failure, source: Source) {
    match (failure.kind, source.origin) {
        (FailureKind::Refused, Origin::Session) => {
            let text = hands.world().texts.of(failure);
            hands.announce(format_args!("// WARNING {text}\n"));
        }
        (FailureKind::Alarm, Origin::Session) => alarm(hands, failure, Recipient::All),
        (FailureKind::Halted, Origin::Session) => {}
        (FailureKind::Alarm, _) => alarm(hands, failure, source.to),
        _ => {
            let is_ended = hands.is_ended();
            say_answer(hands.world(), is_ended, Err(failure), None, source.to);
        }
    }
    done(hands, false, source);
}

/// Tells the sender of a line, a session or the job, that the line has ended.
fn done<'c>(hands: &mut impl LineHands<'c>, carried_out: bool, source: Source) {
    match (source.origin, source.to) {
        (Origin::Session, Recipient::Session(id)) => hands.answered(id),
        (Origin::Job, _) if !carried_out => pause_job(hands, "was not carried out"),
        _ => {}
    }
}

/// Says the answer to a line that halts nothing; `is_ended`: the work in progress was to end.
#[inline]
fn say_answer<P: Ports>(world: &mut World<'_, P>, is_ended: bool, outcome: Outcome, last: Option<Code>, to: Recipient) {
    match (outcome, last) {
        (Ok(Answer::Ok | Answer::PassedOver), _) | (Ok(Answer::Unknown), None) => world.say(to, format_args!("ok\n")),
        (Ok(Answer::Said), _) => {}
        (Ok(Answer::Unknown), Some(code)) => world.say(to, format_args!("ok - {code} ignored\n")),
        (Err(failure), _) => match failure.kind {
            FailureKind::Halted if is_ended => world.say(to, format_args!("// NOTE ended\nok\n")),
            FailureKind::Halted if world.sessions.numbers_refusals(to) => {
                world.sessions.refuse(to, Reason::Locked, format_args!("'$H'|'$X' to unlock"));
            }
            FailureKind::Halted => world.say(to, format_args!("!!\n")),
            // The refusal stands for ok: a line has one answer.
            FailureKind::Refused | FailureKind::Alarm => world.refuse(to, failure),
        },
    }
}

/// Halts because a command asked for something forbidden.
pub(crate) fn alarm<'c>(hands: &mut impl HaltHands<'c>, why: Failure, to: Recipient) {
    let text = hands.world().texts.of(why);
    if hands.world().sessions.numbers_refusals(to) {
        hands.halt(why.alarm, format_args!("Entering Alarm/Halt state\n"));
        return hands.world().sessions.refuse(to, why.reason, format_args!("{text}"));
    }
    // Other sessions must learn why the machine stands.
    let to = if to == Recipient::Nobody { Recipient::All } else { to };
    hands.say(to, format_args!("Error: {text}\n"));
    hands.halt(why.alarm, format_args!("Entering Alarm/Halt state\n"));
}

/// Answers a line that cannot be read.
pub(crate) fn say_refusal(sessions: &mut Sessions, refusal: Refusal, line: &[u8], to: Recipient) {
    let text = core::str::from_utf8(line).unwrap_or("(not text)");
    if sessions.numbers_refusals(to) {
        let error = Reason::of_refusal(&refusal);
        return sessions.refuse(to, error, format_args!("{refusal} - {text}"));
    }
    if let Refusal::Resend { .. } = refusal {
        return sessions.say(to, format_args!("{refusal}\n"));
    }
    // The line arrived whole, so a resend is of no use; lines after it count on it.
    let session = to.session().and_then(|id| sessions.get(id)).filter(|session| session.decoder.can_resend());
    if session.is_some() && tag_of(line) != Tag::NONE {
        return sessions.refuse(to, Reason::of_refusal(&refusal), format_args!("{refusal} - {text}"));
    }
    let heard_by = if to == Recipient::Nobody { Recipient::All } else { to };
    sessions.say(heard_by, format_args!("// WARNING gcode parse failed {refusal} - {text}\n"));
    sessions.say(to, format_args!("ok\n"));
}

/// Pauses the job at a line that cannot be carried out: lines after it count on it, so it waits for a person.
pub(crate) fn pause_job<'c>(hands: &mut impl LineHands<'c>, why: &str) {
    let InWork { passed, urgent, jobs, world } = hands.in_work();
    if let Some(passed) = passed {
        // A fast-forward only reads the line; in the job somebody went on with the next line here.
        passed.refused = passed.refused.saturating_add(1);
        return;
    }
    if urgent.ends_everything() || urgent.ends() && jobs.wait_again(&mut world.ports).is_ok() {
        // The job ends, or reads the line again when it goes on.
        return;
    }
    if hands.explains_stop() {
        return;
    }
    let InWork { jobs, world: World { sessions, .. }, .. } = hands.in_work();
    if jobs.is_open() {
        jobs.pause_at_this_line(why, &mut Reply::new(sessions, Recipient::All));
        sessions.tell_hosts("paused", Recipient::Nobody);
    }
}

/// Answers a line that cannot be read to its end. Returns the failure of one that nobody waits for: a
/// macro's.
pub(crate) fn bad_line<'c>(
    hands: &mut impl LineHands<'c>,
    error: SyntaxError,
    line: &[u8],
    source: Source,
) -> Option<Failure> {
    let text = core::str::from_utf8(line).unwrap_or("(not text)");
    match source.origin {
        Origin::Macro(_) => return Some(hands.world().texts.refused(format_args!("{error}: {text}"))),
        Origin::Settings => hands.announce(format_args!("// WARNING: not a saved setting, left out: {text}\n")),
        Origin::Session | Origin::Job | Origin::Switch | Origin::Startup(_) => {
            say_refusal(hands.world().sessions, Refusal::Syntax(error), line, source.to);
            done(hands, false, source);
        }
    }
    None
}
