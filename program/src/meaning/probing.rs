//! G30 and G38: from words to probing moves.

use units::{Axis, MmPerSecond, PerAxis};

use crate::action::{Action, Contact, ProbeAlong, ProbeDown};
use crate::context::{Context, Meaning, NOTHING};
use crate::fault::{Fault, Problem};
use crate::interpreter::Interpreter;
use crate::meaning::moves;
use crate::state::modal::{FeedMode, MotionMode};
use crate::words::Words;
use gcode::Dialect;

/// G30: probes for the bed and returns to the start; with Z or L stays at the contact, and Z makes that
/// height read as given.
pub(crate) fn probe_down<'b>(program: &mut Interpreter, context: &Context<'b>) -> Result<Meaning<'b>, Fault> {
    let words = &context.words;
    if let Some(instead) = means_more(context) {
        return Err(Problem::ProbesOtherwise(instead).refused(0));
    }
    Ok(Meaning::Action(Action::ProbeDown(ProbeDown {
        rate: probing_rate(program, words)?,
        reversed: words.get('R') == Some(1.0),
        stays: words.has('Z') || words.has('L'),
        reads: words.get('Z'),
    })))
}

/// Returns the codes to write instead of another firmware's G30, if that does more than probe below the
/// nozzle. Sources: Marlin's G30.cpp; RepRapFirmware's "G30: Single Z-Probe".
fn means_more(context: &Context<'_>) -> Option<&'static str> {
    /// Bound of Z below which RepRapFirmware measures a point.
    const MEASURES: f64 = -9_999.0;
    let words = &context.words;
    let has = |letters: &str| letters.chars().any(|letter| words.has(letter));
    match context.dialect {
        _ if words.get('Z').is_some_and(|mm| mm <= MEASURES) => Some("a point of the bed is measured by G29 or G32"),
        Dialect::Marlin if has("XY") => Some("it probes where the machine is: go there first, with G0 X Y"),
        Dialect::RepRapFirmware if has("PXY") => Some("a point of the bed is measured by G29 or G32"),
        Dialect::RepRapFirmware if words.get('S') == Some(-1.0) => None,
        Dialect::RepRapFirmware if !has("Z") => Some("to set Z write Z too, the height at which the probe triggers"),
        _ => None,
    }
}

/// Probes along a line: G38.2 to G38.5, and words without a code behind one of them.
pub(crate) fn probe_along<'b>(program: &mut Interpreter, context: &Context<'b>) -> Result<Meaning<'b>, Fault> {
    let subcode = context.words.code().subcode;
    if context.words.has_code() { search(program, context, subcode) } else { search_on(program, context, subcode) }
}

/// Reads words while a probing code is the motion code in force; a rate alone does not probe.
fn search_on<'b>(program: &mut Interpreter, context: &Context<'b>, subcode: u8) -> Result<Meaning<'b>, Fault> {
    moves::take_rates(program, context)?;
    if "XYZ".chars().any(|letter| context.words.has(letter)) { search(program, context, subcode) } else { NOTHING }
}

/// Probes along the line that the words describe. In GRBL's dialect the code becomes the motion code, and its
/// F applies to later moves too, as in RS-274.
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

/// Returns the end of a G38. In GRBL's dialect the words are read as in any move; otherwise the words are
/// distances, whatever the distance mode, as in Smoothieware.
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

/// Returns the F word, which applies to this probing move alone.
fn probing_rate(program: &Interpreter, words: &Words<'_>) -> Result<Option<MmPerSecond>, Fault> {
    match words.get('F') {
        Some(_) if program.modal.feed_mode != FeedMode::PerMinute => {
            Err(Problem::NeedsFeedPerMinute.refused(words.column_of('F')))
        }
        Some(rate) if rate <= 0.0 => Err(Problem::ProbeRate.refused(words.column_of('F'))),
        rate => Ok(rate.map(MmPerSecond)),
    }
}
