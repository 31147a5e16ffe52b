//! The codes of a line: their order, whether each may run now, its meaning, and its execution.

use base::failure::{Answer, Failure, Outcome};
use base::needs::needs;
use base::sessions::{LineBytes, Recipient};
use base::taken_codes::TakenCodes;
use base::{Ports, World};
use gcode::{Block, Blocks, Code, Letter, WholeLine};
use jobs::player::{Jobs, Name};
use program::{Action, Effect, Interpreter, LineParts, Meaning, State, States};

use super::actions;
use super::answers::{bad_line, finish};
use crate::machine::frames::{Frame, Frames, NextCode, Rest};
use crate::machine::moments::{Features, Moments};
use crate::machine::source::{Origin, Source};
use crate::machine::{Machine, effects, ignored_codes, moves, operator_pauses};

/// Part of a line that is to be run.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Start {
    /// The line from its beginning.
    Line,
    /// The codes behind this one in written order, and the answer to this one.
    Rest(Option<Code>, Answer),
}

/// Runs the rest of a line that has waited.
pub(crate) fn run_rest<P: Ports>(machine: &mut Machine<'_, P>, rest: Rest) {
    let Rest { line, next, source, last, answer } = rest;
    match next {
        NextCode::At(column) => {
            run_line(machine, Blocks::starting_at(&line, column), Start::Rest(last, answer), source);
        }
        NextCode::Ordered { begins, place } => {
            let blocks = Blocks::starting_at(&line, begins);
            let is_read = run_in_order(machine, &blocks, place, answer, source);
            debug_assert!(is_read, "it was read so before");
        }
    }
}

/// Runs the codes of a line, and answers it, unless one of them starts something: then the rest waits for its
/// end.
pub(crate) fn run_line<P: Ports>(machine: &mut Machine<'_, P>, mut blocks: Blocks<'_>, start: Start, source: Source) {
    let mut is_first = matches!(start, Start::Line);
    let (mut last, mut answer) = match start {
        Start::Rest(last, answer) => (last, answer),
        Start::Line => {
            if source.dialect.orders_lines() && run_in_order(machine, &blocks, 0, Answer::Ok, source) {
                return;
            }
            (None, Answer::Ok)
        }
    };
    blocks.set_stops_say(source.dialect.stops_say());
    let mut block = Block::new(None, 0);
    let failed = loop {
        let read = blocks.read(&mut block, &mut machine.program);
        if let Some(comment) = blocks.take_remark()
            && let Err(failure) = operator_pauses::remark(machine, comment)
        {
            machine.program.drop_line();
            break Some(failure);
        }
        match read {
            Ok(true) => {}
            Ok(false) => break machine.program.end_line().err().map(|fault| actions::failed_by(machine, &fault)),
            Err(error) => {
                machine.program.drop_line();
                let Some(why) = bad_line(machine, error, blocks.place().0, source) else { return };
                break Some(why);
            }
        }
        last = block.code;
        let height = machine.frames.len();
        let outcome = match begin(machine, &block, source) {
            // Nearly every line of a program ends so.
            Begun::Done => {
                (answer, is_first) = (Answer::Ok, false);
                continue;
            }
            begun => {
                let is_move = matches!(&begun, Begun::Means(Meaning::Action(Action::Move(_))));
                let is_whole = !is_move && is_first && source.origin == Origin::Job && machine.frames.is_empty();
                machine.urgent.begin_line(is_whole && is_last(&blocks));
                run_begun(machine, begun, &block, source)
            }
        };
        is_first = false;
        match settled(outcome, &machine.world, &mut machine.jobs, &machine.program, &block, source) {
            Ok(now) => answer = now,
            Err(failure) => {
                machine.frames.drop_down_to(height);
                break Some(failure);
            }
        }
        if machine.frames.len() > height {
            let (line, column) = blocks.place();
            let waits = wait(&mut machine.frames, height, line, NextCode::At(column), source, (last, answer));
            let Err(failure) = waits else { return };
            break Some(failure);
        }
    };
    finish(machine, failed.map_or(Ok(answer), Err), last, source);
}

/// Runs the codes of a line in RS-274's order, from this place of that order on, and answers the line. False
/// when the line is not read in that order.
fn run_in_order<P: Ports>(
    machine: &mut Machine<'_, P>,
    blocks: &Blocks<'_>,
    from: usize,
    answer: Answer,
    source: Source,
) -> bool {
    let (mut ahead, mut whole) = (blocks.clone(), WholeLine::default());
    let read = ahead.read_whole(&mut whole, &mut machine.program);
    let Some(parts) = read.ok().and_then(|()| program::arrange(&whole)) else {
        machine.program.drop_line();
        return false;
    };
    let remark = ahead.take_remark().filter(|_| from == 0);
    let remarked = remark.map_or(Ok(()), |comment| operator_pauses::remark(machine, comment));
    // Offset of the codes behind the line's number.
    let line = blocks.place();
    let (last, outcome) = match parts {
        _ if remarked.is_err() => (None, remarked.map(|()| Answer::Ok)),
        Ok(parts) => match run_parts(machine, &mut whole, &parts, (from, answer), line, source) {
            Some(ended) => ended,
            None => return true,
        },
        Err(fault) => (None, Err(actions::failed_by(machine, &fault))),
    };
    let outcome = match outcome {
        Ok(answer) => machine.program.end_line().map(|()| answer).map_err(|fault| actions::failed_by(machine, &fault)),
        Err(failure) => {
            machine.program.drop_line();
            Err(failure)
        }
    };
    finish(machine, outcome, last, source);
    true
}

/// Runs the codes of a line that has been put in order. Returns the code that ended it, and how; `None` when
/// the rest of the line waits for work that a code has started.
fn run_parts<P: Ports>(
    machine: &mut Machine<'_, P>,
    whole: &mut WholeLine<'_>,
    parts: &LineParts,
    (from, mut answer): (usize, Answer),
    (line, begins): (&[u8], usize),
    source: Source,
) -> Option<(Option<Code>, Outcome)> {
    let mut last = None;
    for (place, part) in parts.iter().enumerate().skip(from) {
        last = part.code;
        let height = machine.frames.len();
        let block = whole.part(part.code, part.letters);
        let outcome = run_block(machine, block, source);
        let outcome = settled(outcome, &machine.world, &mut machine.jobs, &machine.program, block, source);
        match outcome {
            Ok(now) => answer = now,
            Err(failure) => {
                machine.frames.drop_down_to(height);
                return Some((last, Err(failure)));
            }
        }
        if machine.frames.len() > height {
            // The line is read again after the wait, and sets its parameters at its end.
            machine.program.drop_line();
            match wait(
                &mut machine.frames,
                height,
                line,
                NextCode::Ordered { begins, place: place + 1 },
                source,
                (last, answer),
            ) {
                Ok(()) => return None,
                Err(failure) => return Some((last, Err(failure))),
            }
        }
    }
    Some((last, Ok(answer)))
}

/// Has the rest of a line wait for the work started since the stack had this height.
fn wait<S>(
    frames: &mut Frames<'_, S>,
    height: usize,
    line: &[u8],
    next: NextCode,
    source: Source,
    (last, answer): (Option<Code>, Answer),
) -> Result<(), Failure> {
    let line = LineBytes::from_slice(line).unwrap_or_default();
    if frames.push_below(height, Frame::Rest(Rest { line, next, source, last, answer })) {
        return Ok(());
    }
    frames.drop_down_to(height);
    Err(Failure::refused(&"scripts start each other without end"))
}

/// Returns the outcome of a code. One of a file that the machine does not carry out is looked at once more.
fn settled<P>(
    outcome: Outcome,
    world: &World<'_, P>,
    jobs: &mut Jobs,
    program: &Interpreter,
    block: &Block<'_>,
    source: Source,
) -> Outcome {
    match (outcome, source.origin) {
        (Ok(Answer::Unknown | Answer::PassedOver), Origin::Job) => {
            ignored_codes::settle(world.texts, jobs, program, block, source.dialect)
        }
        (outcome, _) => outcome,
    }
}

/// Progress of a command that has not waited yet.
enum Begun<'b> {
    /// The command is done already.
    Done,
    /// Something else must come to its end before the command may begin.
    Waits(States),
    /// The meaning that is left to be carried out.
    Means(Meaning<'b>),
    /// The command has ended with this outcome.
    Ended(Outcome),
}

/// Runs one command: checks whether it may run now, finds its meaning and carries that out.
pub(crate) fn run_block<P: Ports>(machine: &mut Machine<'_, P>, block: &Block<'_>, source: Source) -> Outcome {
    let begun = begin(machine, block, source);
    run_begun(machine, begun, block, source)
}

/// Begins a command: checks whether it may run now, and finds its meaning. The commonest move is done at
/// once.
fn begin<'b, P: Ports>(machine: &mut Machine<'_, P>, block: &'b Block<'b>, source: Source) -> Begun<'b> {
    let row = machine.program.row(block, source.dialect);
    let allowed = row.map_or(States::WORKING, |row| row.states);
    if machine.safety.release_is_pending() {
        return Begun::Waits(allowed);
    }
    match machine.safety.state() {
        State::Door if allowed.has(State::Door) && !allowed.has(State::Alarm) => return Begun::Waits(allowed),
        state if allowed.has(state) => {}
        State::Invalid => {
            let text = "the configuration has errors: mend config.ini and reset";
            return Begun::Ended(Err(machine.world.texts.because(text)));
        }
        _ => return Begun::Ended(Err(Failure::HALTED)),
    }
    if machine.taken_codes != TakenCodes::None
        && let Some(outcome) = run_taken(machine, block, source)
    {
        return Begun::Ended(outcome);
    }
    let Some(row) = row else { return Begun::Ended(unknown(&machine.world, block.code, source.to)) };
    // A file that saves or loads settings would never end.
    let is_about_settings = row.code.letter != Letter::T && (500..=504).contains(&row.code.number);
    if source.origin == Origin::Settings && is_about_settings {
        return Begun::Done;
    }
    if let Some(part) = row.part
        && let Err(failure) = needs(machine.world.texts, machine.world.config, part, machine.jobs.is_playing())
    {
        return Begun::Ended(Err(failure));
    }
    if row.levels
        && source.origin == Origin::Job
        && ignored_codes::goes_on_unleveled(machine.world.config, &mut machine.jobs, row)
    {
        return Begun::Done;
    }
    Features::<P>::block_begins(machine, source);
    let facts = machine.facts();
    match machine.program.run(block, row, facts, source.dialect) {
        Ok(Meaning::Action(Action::Move(request)))
            if !machine.program.has_more() && moves::take_at_once(machine, &request) =>
        {
            Begun::Done
        }
        Ok(meaning) => Begun::Means(meaning),
        Err(fault) => Begun::Ended(Err(actions::failed_by(machine, &fault))),
    }
}

/// Has a feature carry out a code that it has taken for its own. Kept out of the code that every line passes
/// through.
#[cold]
#[inline(never)]
fn run_taken<P: Ports>(machine: &mut Machine<'_, P>, block: &Block<'_>, source: Source) -> Option<Outcome> {
    block.code.filter(|code| machine.taken_codes.may_have(*code) && source.looks_up_names())?;
    Features::<P>::run_code(machine, block, source)
}

/// Brings a command that has been begun to its end.
fn run_begun<'b, P: Ports>(
    machine: &mut Machine<'_, P>,
    mut begun: Begun<'b>,
    block: &'b Block<'b>,
    source: Source,
) -> Outcome {
    while let Begun::Waits(allowed) = begun {
        machine.wait_release();
        if machine.safety.state() == State::Door {
            machine.wait_for_door(allowed)?;
        }
        begun = begin(machine, block, source);
    }
    let meaning = match begun {
        Begun::Means(meaning) => meaning,
        Begun::Ended(outcome) => return outcome,
        Begun::Done | Begun::Waits(_) => return Ok(Answer::Ok),
    };
    while let Some(effect) = machine.program.next_effect() {
        match effect {
            Effect::Ignored { code, letter } if source.origin == Origin::Job => {
                ignored_codes::count(&mut machine.jobs, Name::Word(code, letter));
            }
            effect => effects::change(machine, effect)?,
        }
    }
    match &meaning {
        Meaning::Nothing => Ok(Answer::Ok),
        Meaning::PassedOver => Ok(Answer::PassedOver),
        Meaning::Unknown => unknown(&machine.world, block.code, source.to),
        Meaning::Action(action) => {
            // Only a wait can be left, and read again.
            machine.urgent.means(action);
            let done = actions::carry_out_all(machine, action, source.to);
            machine.urgent.begin_line(false);
            match done {
                Ok(Answer::Unknown) => without_its_part(&machine.world, block.code, source.to),
                outcome => outcome,
            }
        }
    }
}

/// Whether only a comment is left of a line.
fn is_last(blocks: &Blocks<'_>) -> bool {
    let (line, column) = blocks.place();
    let rest = line.get(column..).unwrap_or_default().trim_ascii_start();
    matches!(rest.first(), None | Some(b';' | b'('))
}

/// Handles a code whose part of the machine is not configured: a sender for mills counts on its lines.
#[cold]
fn without_its_part<P: Ports>(world: &World<'_, P>, code: Option<Code>, to: Recipient) -> Outcome {
    match code {
        Some(code) if world.sessions.numbers_refusals(to) => {
            Err(world.texts.refused(format_args!("{code}: what it needs is not configured here")))
        }
        _ => Ok(Answer::Unknown),
    }
}

/// Handles a code that nobody knows: an error for sessions in GRBL's dialect.
#[cold]
fn unknown<P: Ports>(world: &World<'_, P>, code: Option<Code>, to: Recipient) -> Outcome {
    match code {
        Some(code)
            if world.sessions.numbers_refusals(to) && <Features<P> as Moments<Machine<'_, P>>>::accepts(code) =>
        {
            Ok(Answer::Ok)
        }
        Some(code) if world.sessions.numbers_refusals(to) => {
            Err(world.texts.refused(format_args!("{code} is not known here")))
        }
        _ => Ok(Answer::Unknown),
    }
}
