//! G30 and G38: from words to searches.

use units::{Axis, MmPerSecond, PerAxis};

use crate::action::{Action, Contact, ProbeAlong, ProbeDown};
use crate::context::{Context, Meaning, NOTHING};
use crate::dialect::Dialect;
use crate::fault::{Fault, Problem};
use crate::interpreter::Interpreter;
use crate::meaning::moves;
use crate::modal::{FeedMode, MotionMode};
use crate::words::Words;

/// G30: searches for the bed and returns to where it began; with Z or L it stays where the contact was,
/// and Z makes that height read as given.
pub(crate) fn probe_down<'b>(program: &mut Interpreter, context: &Context<'b>) -> Result<Meaning<'b>, Fault> {
    let words = &context.words;
    Ok(Meaning::Action(Action::ProbeDown(ProbeDown {
        rate: probing_rate(program, words)?,
        reversed: words.get('R') == Some(1.0),
        stays: words.has('Z') || words.has('L'),
        reads: words.get('Z'),
    })))
}

/// G38.2 to G38.5, and words without a code behind one of them.
pub(crate) fn probe_along<'b>(program: &mut Interpreter, context: &Context<'b>) -> Result<Meaning<'b>, Fault> {
    let subcode = context.words.code().subcode;
    if context.words.has_code() { search(program, context, subcode) } else { search_on(program, context, subcode) }
}

/// Words while a search is the motion code in force: a rate alone searches nothing.
fn search_on<'b>(program: &mut Interpreter, context: &Context<'b>, subcode: u8) -> Result<Meaning<'b>, Fault> {
    moves::take_rates(program, context)?;
    if "XYZ".chars().any(|letter| context.words.has(letter)) { search(program, context, subcode) } else { NOTHING }
}

/// Searches along the line that the words describe. In GRBL's dialect it is the motion code from now on, and
/// its F is that of later moves too, as in RS-274.
fn search<'b>(program: &mut Interpreter, context: &Context<'b>, subcode: u8) -> Result<Meaning<'b>, Fault> {
    let words = &context.words;
    let (until, must_find) = match subcode {
        2 => (Contact::Closes, true),
        3 => (Contact::Closes, false),
        4 => (Contact::Opens, true),
        5 => (Contact::Opens, false),
        _ => return Err(Problem::ProbeSubcode.refused(words.column())),
    };
    let rate = probing_rate(program, words)?;
    let target = probing_target(program, words, context.dialect);
    program.modal.machine_next = false;
    let target = target?;
    if context.dialect.probes_by_distance_mode() {
        program.modal.motion = MotionMode::Search(subcode);
        program.modal.feed_rate = rate.unwrap_or(program.modal.feed_rate);
    }
    Ok(Meaning::Action(Action::ProbeAlong(ProbeAlong { target, rate, until, must_find })))
}

/// The words of G38. In GRBL's dialect they are read as those of any move; else they are distances,
/// whatever the distance mode, as in Smoothieware.
fn probing_target(program: &Interpreter, words: &Words<'_>, dialect: Dialect) -> Result<PerAxis<f64>, Fault> {
    let by_mode = dialect.probes_by_distance_mode();
    let mut target = program.position;
    for axis in Axis::PRIMARY {
        if let Some(mm) = words.axis(axis) {
            let now = program.position[axis];
            target[axis] = if by_mode { program.modal.machine(axis, mm, now) } else { now + mm };
        }
    }
    if by_mode && program.modal.rotations.any() {
        moves::turned(program, words, &mut target);
    }
    let has = |letter: char| words.has(letter);
    if let Some(letter) = "ABCE".chars().find(|letter| has(*letter)) {
        return Err(Problem::ProbeAxis.refused(words.column_of(letter)));
    }
    if !"XYZ".chars().any(has) {
        return Err(Problem::ProbeNothing.refused(words.column()));
    }
    if !by_mode && has('Z') && (has('X') || has('Y')) {
        return Err(Problem::ProbeZWithXy.refused(words.column_of('Z')));
    }
    if target == program.position {
        return Err(Problem::ProbeNoWay.refused(words.column()));
    }
    Ok(target)
}

/// F, for this search alone.
fn probing_rate(program: &Interpreter, words: &Words<'_>) -> Result<Option<MmPerSecond>, Fault> {
    match words.get('F') {
        Some(_) if program.modal.feed_mode != FeedMode::PerMinute => {
            Err(Problem::NeedsFeedPerMinute.refused(words.column_of('F')))
        }
        Some(rate) if rate <= 0.0 => Err(Problem::ProbeRate.refused(words.column_of('F'))),
        rate => Ok(rate.map(MmPerSecond)),
    }
}
