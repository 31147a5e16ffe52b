//! One line: whose turn is it, is it whole, what does it ask, how is it answered.

use core::pin::pin;

use gcode::{Block, Blocks, Code, Letter, Line, Refusal, WholeLine};
use motion::Tag;
use program::{Action, Dialect, Meaning, State, Waits};

use super::frames::{Frame, Origin, Rest};
use super::line_numbers::{decoder_expecting, tag_of};
use super::named::Named;
use super::{Machine, actions, commands, flow, grbl, named, operator, parameters, passed_over, shapes, stack};
use crate::failure::{Answer, Failure, Message, Outcome, message};
use crate::grbl::numbers::Error;
use crate::jobs::Next;
use crate::needs::needs;
use crate::ports::Ports;
use crate::sessions::{LineBytes, Recipient, Reply, Rights, SessionId};

/// Runs what is next: what a line has started, a line of a session, a line of the file being played, the
/// command of a switch. False when there was nothing.
pub(super) async fn run_next<P: Ports>(machine: &mut Machine<'_, P>) -> bool {
    if !machine.frames.is_empty() {
        stack::run_top(machine).await;
        return true;
    }
    let path_is_full = machine.ports.motion(|motion| {
        let (used, size) = motion.queue_level();
        size > 0 && used >= size
    });
    let had_line = run_session(machine, path_is_full).await;
    // Sessions and the file take turns; a file is mostly moves, so it waits for room.
    if machine.frames.is_empty() && !path_is_full && pin!(run_job_line(machine)).await {
        return true;
    }
    had_line || run_switch(machine).await
}

async fn run_session<P: Ports>(machine: &mut Machine<'_, P>, path_is_full: bool) -> bool {
    let Some(id) = machine.sessions.next_ready(path_is_full) else { return false };
    if path_is_full && rides(machine, id) {
        if let Some(session) = machine.sessions.get_mut(id) {
            session.wait_for_room();
        }
        return true;
    }
    let Some(line) = machine.sessions.get_mut(id).and_then(crate::sessions::Session::take_line) else { return false };
    machine.tag = if line.first() == Some(&b'N') { tag_of(&line) } else { Tag::NONE };
    pin!(run_session_line(machine, id, &line)).await;
    true
}

/// Whether the line that waits is one that only waits for room in the look-ahead queue.
fn rides<P: Ports>(machine: &Machine<'_, P>, id: SessionId) -> bool {
    let Some((session, line)) = machine.sessions.get(id).and_then(|session| Some((session, session.waiting()?))) else {
        return false;
    };
    if machine.files.uploads_from(id) {
        return false;
    }
    // A copy: the line is not read yet.
    let mut decoder = session.decoder;
    let Ok(Line::Code(mut blocks)) = decoder.decode(line) else { return false };
    let dialect = session.dialect;
    blocks.any(|block| {
        block.is_ok_and(|block| machine.program.row(&block, dialect).is_some_and(|row| row.waits == Waits::Path))
    })
}

async fn run_session_line<P: Ports>(machine: &mut Machine<'_, P>, id: SessionId, line: &LineBytes) {
    let to = Recipient::Session(id);
    let Some(session) = machine.sessions.get_mut(id) else { return };
    let may_operate = session.rights == Rights::Operate;
    match session.decoder.decode(line) {
        Ok(_) if !may_operate => {
            let text = format_args!("this session may ask, and stop the machine, no more");
            machine.sessions.refuse(to, Error::Locked, text);
            answered(machine, id);
        }
        Ok(decoded) if machine.files.uploads_from(id) && !matches!(decoded, Line::Console(_)) => {
            let Machine { files, ports, sessions, .. } = machine;
            files.upload_line(line, &decoded, ports, &mut Reply::new(sessions, to));
            answered(machine, id);
        }
        Ok(Line::Code(_)) if grbl::jogs(machine, to) => {
            machine.sessions.refuse(to, Error::Locked, format_args!("a jog is under way: 0x85 ends it"));
            answered(machine, id);
        }
        Ok(decoded) => pin!(run_decoded(machine, decoded, to, Origin::Session)).await,
        Err(refusal) => {
            say_refusal(machine, refusal, line, to);
            answered(machine, id);
        }
    }
}

fn answered<P: Ports>(machine: &mut Machine<'_, P>, id: SessionId) {
    if let Some(session) = machine.sessions.get_mut(id) {
        session.answered();
    }
}

/// The next line of the file being played. False when there is none.
async fn run_job_line<P: Ports>(machine: &mut Machine<'_, P>) -> bool {
    machine.jobs.open_boot_file(machine.config, &mut machine.ports);
    if !machine.jobs.is_playing() || !matches!(machine.safety.state(), State::Idle | State::Run | State::Check) {
        return false;
    }
    let to = machine.jobs.echo();
    if !machine.sessions.have_taken_most(to) {
        return false;
    }
    let mut line = LineBytes::new();
    match machine.jobs.next_line(&mut machine.ports, &mut line) {
        Next::Line => {
            machine.tag = machine.jobs.begin_line();
            if to != Recipient::Nobody {
                echo(machine, &line, to);
            }
            if machine.program.flow().passes_over() {
                run_passed_over(machine, &line, to);
            } else {
                pin!(run_own_line(machine, &line, to, Origin::Job)).await;
            }
        }
        Next::Nothing => {}
        Next::Dialect(dialect) => {
            machine.announce(format_args!("// NOTE the file is read as {}'s, as it says\n", dialect.name()));
        }
        Next::TooLong => pause_job(machine, "is too long"),
        Next::End => return end_job(machine).await,
        Next::Failed(why) => {
            let text = message(format_args!("reading the file being played failed: {why}"));
            alarm(machine, &text, Recipient::Nobody);
        }
    }
    true
}

/// A line that is passed over: only an O word counts in it.
fn run_passed_over<P: Ports>(machine: &mut Machine<'_, P>, line: &[u8], to: Recipient) {
    if let Ok(Line::Flow(line)) = decoder_expecting(line).decode(line) {
        let outcome = flow::run_line(machine, &line, to, Origin::Job);
        finish(machine, outcome, None, to, Origin::Job);
    }
}

fn echo<P: Ports>(machine: &mut Machine<'_, P>, line: &[u8], to: Recipient) {
    if let Ok(text) = core::str::from_utf8(line) {
        machine.say(to, format_args!("{text}\n"));
    }
}

/// The file has been read; it is done when its last moves are. False while they go on, so that sessions are
/// heard.
async fn end_job<P: Ports>(machine: &mut Machine<'_, P>) -> bool {
    machine.ports.motion(motion::Motion::flush);
    if !machine.ports.motion(|motion| motion.is_idle()) {
        return false;
    }
    if let Err(fault) = machine.program.end_file() {
        machine.announce(format_args!("error:the file has ended, and {fault}\n"));
    }
    parameters::save(machine).await;
    let to = machine.jobs.tells_end();
    passed_over::say(machine);
    machine.jobs.close(&mut machine.ports);
    machine.say(to, format_args!("Done printing file\n"));
    true
}

/// The line just read cannot be carried out: what comes after it counts on it, so it waits for a person.
fn pause_job<P: Ports>(machine: &mut Machine<'_, P>, why: &str) {
    let Machine { jobs, sessions, .. } = machine;
    jobs.pause_at_this_line(why, &mut Reply::new(sessions, Recipient::All));
}

/// The command of an input switch that changed. False when there is none.
async fn run_switch<P: Ports>(machine: &mut Machine<'_, P>) -> bool {
    let Some(command) = machine.outputs.take_command(machine.config) else { return false };
    machine.tag = Tag::NONE;
    run_own_line(machine, command.as_bytes(), Recipient::Nobody, Origin::Switch).await;
    true
}

/// Runs a line that comes from the machine itself.
async fn run_own_line<P: Ports>(machine: &mut Machine<'_, P>, line: &[u8], to: Recipient, origin: Origin) {
    match decoder_expecting(line).decode(line) {
        Ok(decoded) => return pin!(run_decoded(machine, decoded, to, origin)).await,
        Err(Refusal::Resend { .. }) => {
            // Its checksum is wrong: the file is damaged.
            let text = core::str::from_utf8(line).unwrap_or("(not text)");
            let text = message(format_args!("checksum does not match: {text}"));
            alarm(machine, &text, to);
        }
        Err(refusal) => say_refusal(machine, refusal, line, to),
    }
    if origin == Origin::Job {
        pause_job(machine, "was not carried out");
    }
}

async fn run_decoded<P: Ports>(machine: &mut Machine<'_, P>, decoded: Line<'_>, to: Recipient, origin: Origin) {
    match decoded {
        Line::Blank => finish(machine, Ok(Answer::Ok), None, to, origin),
        // In place: what it waits in is large, and would be copied for every line.
        Line::Code(blocks) => pin!(run_blocks(machine, blocks, None, to, origin)).await,
        Line::Flow(line) => {
            let outcome = flow::run_line(machine, &line, to, origin);
            finish(machine, outcome, None, to, origin);
        }
        line => match named::command_of(machine, &line, to, origin) {
            Named::Console(command) => commands::run_line(machine, command, to, origin).await,
            Named::Codes => {}
            Named::Ended(outcome) => finish(machine, outcome, None, to, origin),
        },
    }
}

/// Runs the commands of a line in turn, and answers it, unless one of them starts something: then the rest
/// waits for its end.
pub(super) async fn run_blocks<P: Ports>(
    machine: &mut Machine<'_, P>,
    mut blocks: Blocks<'_>,
    mut last: Option<Code>,
    to: Recipient,
    origin: Origin,
) {
    if dialect_for(machine, to, origin).orders_lines() && pin!(run_in_order(machine, &blocks, to, origin)).await {
        return;
    }
    let mut answer = Answer::Ok;
    let mut block = Block::new(None, 0);
    let failed = loop {
        let read = blocks.read(&mut block, &mut machine.program);
        if let Some(comment) = blocks.take_remark() {
            operator::remark(machine, comment);
        }
        match read {
            Ok(true) => {}
            Ok(false) => break machine.program.end_line().err().map(|fault| actions::failed_by(machine, &fault)),
            Err(error) => {
                machine.program.drop_line();
                let (line, _) = blocks.place();
                return bad_line(machine, Refusal::Syntax(error), line, to, origin);
            }
        }
        last = block.code;
        let height = machine.frames.len();
        let outcome = pin!(run_block(machine, &block, to, origin)).await;
        match outcome {
            Ok(now @ (Answer::Ok | Answer::Said)) => answer = now,
            Ok(now) if origin != Origin::Job => answer = now,
            Ok(_) => match passed_over::settle(machine, &block, dialect_for(machine, to, Origin::Job)) {
                Ok(now) => answer = now,
                Err(failure) => break Some(failure),
            },
            Err(failure) => {
                machine.frames.drop_down_to(height);
                break Some(failure);
            }
        }
        if machine.frames.len() > height {
            let (line, at) = blocks.place();
            let line = LineBytes::from_slice(line).unwrap_or_default();
            let rest = Rest { line, at, to, origin, last };
            if machine.frames.push_below(height, Frame::Rest(rest)) {
                return;
            }
            machine.frames.drop_down_to(height);
            break Some(Failure::refused("scripts start each other without end"));
        }
    };
    finish(machine, failed.map_or(Ok(answer), Err), last, to, origin);
}

/// Runs the codes of a line in RS-274's order, and answers it. False when that is not how this line is read.
async fn run_in_order<P: Ports>(
    machine: &mut Machine<'_, P>,
    blocks: &Blocks<'_>,
    to: Recipient,
    origin: Origin,
) -> bool {
    let (mut ahead, mut whole) = (blocks.clone(), WholeLine::default());
    let read = ahead.read_whole(&mut whole, &mut machine.program);
    let parts = match read.ok().and_then(|()| program::arrange(&whole)) {
        None => {
            machine.program.drop_line();
            return false;
        }
        Some(parts) => parts,
    };
    if let Some(comment) = ahead.take_remark() {
        operator::remark(machine, comment);
    }
    let (mut last, mut outcome) = (None, Ok(Answer::Ok));
    match parts {
        Ok(parts) => {
            for part in &parts {
                last = part.code;
                let block = whole.part(part.code, |letter| part.takes(letter));
                outcome = pin!(run_block(machine, block, to, origin)).await;
                if origin == Origin::Job && matches!(outcome, Ok(Answer::Unknown | Answer::PassedOver)) {
                    outcome = passed_over::settle(machine, block, dialect_for(machine, to, Origin::Job));
                }
                if outcome.is_err() {
                    break;
                }
            }
        }
        Err(fault) => outcome = Err(actions::failed_by(machine, &fault)),
    }
    if outcome.is_ok() {
        outcome = machine.program.end_line().map(|()| Answer::Ok).map_err(|fault| actions::failed_by(machine, &fault));
    } else {
        machine.program.drop_line();
    }
    finish(machine, outcome, last, to, origin);
    true
}

fn bad_line<P: Ports>(machine: &mut Machine<'_, P>, refusal: Refusal, line: &[u8], to: Recipient, origin: Origin) {
    if origin == Origin::Settings {
        let text = core::str::from_utf8(line).unwrap_or("(not text)");
        return machine.announce(format_args!("// WARNING: not a saved setting, left out: {text}\n"));
    }
    say_refusal(machine, refusal, line, to);
    done(machine, false, to, origin);
}

/// One command: may it run now, what does it mean, do it.
pub(super) async fn run_block<P: Ports>(
    machine: &mut Machine<'_, P>,
    block: &Block<'_>,
    to: Recipient,
    origin: Origin,
) -> Outcome {
    machine.wait_release().await;
    let state = machine.safety.state();
    let dialect = dialect_for(machine, to, origin);
    let row = machine.program.row(block, dialect);
    let allowed = row.map_or(program::States::WORKING, |row| row.states);
    if !allowed.has(state) {
        return Err(match state {
            State::Invalid => Failure::refused("the configuration has errors: mend config.ini and reset"),
            _ => Failure::Halted,
        });
    }
    if state == State::Door {
        machine.wait_for_door(allowed).await?;
    }
    let Some(row) = row else { return unknown(machine, block.code, to) };
    // A file that saves or loads settings would never end.
    let is_about_settings = row.code.letter != Letter::T && (500..=504).contains(&row.code.number);
    if origin == Origin::Settings && is_about_settings {
        return Ok(Answer::Ok);
    }
    if let Some(part) = row.part {
        needs(machine.config, part, machine.jobs.is_playing())?;
    }
    let facts = machine.facts();
    let meaning = match machine.program.run(block, row, facts, dialect) {
        Ok(meaning) => meaning,
        Err(fault) => return Err(actions::failed_by(machine, &fault)),
    };
    while let Some(effect) = machine.program.next_effect() {
        actions::effect(machine, effect).await?;
    }
    match &meaning {
        Meaning::Nothing => Ok(Answer::Ok),
        Meaning::PassedOver => Ok(Answer::PassedOver),
        Meaning::Unknown => unknown(machine, block.code, to),
        Meaning::Action(Action::Move(request))
            if machine.program.is_last_action() && shapes::take_at_once(machine, request) =>
        {
            Ok(Answer::Ok)
        }
        Meaning::Action(action) => actions::carry_out_all(machine, action, to).await,
    }
}

/// A code that nobody knows: for whoever speaks GRBL's dialect an error.
#[cold]
fn unknown<P: Ports>(machine: &Machine<'_, P>, code: Option<Code>, to: Recipient) -> Outcome {
    match code {
        Some(code) if is_grbl(machine, to) && crate::grbl::accepts(code) => Ok(Answer::Ok),
        Some(code) if is_grbl(machine, to) => Err(Failure::Refused(message(format_args!("{code} is not known here")))),
        _ => Ok(Answer::Unknown),
    }
}

fn dialect_for<P: Ports>(machine: &Machine<'_, P>, to: Recipient, origin: Origin) -> Dialect {
    let said = if origin == Origin::Job { machine.jobs.dialect() } else { None };
    match (said, to) {
        (Some(dialect), _) => dialect,
        // A file is written for the machine, and so is the configuration.
        (None, Recipient::Nobody) => crate::program_setup::dialect(machine.config),
        (None, to) => machine.sessions.dialect_of(to),
    }
}

/// Answers a line that has come to its end.
pub(super) fn finish<P: Ports>(
    machine: &mut Machine<'_, P>,
    outcome: Outcome,
    last: Option<Code>,
    to: Recipient,
    origin: Origin,
) {
    match origin {
        Origin::Settings => return stack::settings_line_ended(machine, outcome),
        Origin::Startup(number) => grbl::startup_ended(machine, number, &outcome),
        _ => {}
    }
    let carried_out = outcome.is_ok();
    say_answer(machine, outcome, last, to);
    done(machine, carried_out, to, origin);
}

fn done<P: Ports>(machine: &mut Machine<'_, P>, carried_out: bool, to: Recipient, origin: Origin) {
    match (origin, to) {
        (Origin::Session, Recipient::Session(id)) => answered(machine, id),
        (Origin::Job, _) if !carried_out => pause_job(machine, "was not carried out"),
        _ => {}
    }
}

fn say_answer<P: Ports>(machine: &mut Machine<'_, P>, outcome: Outcome, last: Option<Code>, to: Recipient) {
    match (outcome, last) {
        (Ok(Answer::Ok | Answer::PassedOver), _) | (Ok(Answer::Unknown), None) => machine.say(to, format_args!("ok\n")),
        (Ok(Answer::Said), _) => {}
        (Ok(Answer::Unknown), Some(code)) => machine.say(to, format_args!("ok - {code} ignored\n")),
        (Err(Failure::Halted), _) => say_locked(machine, to),
        (Err(Failure::Alarm(text)), _) => alarm(machine, &text, to),
        (Err(Failure::Refused(text)), _) => {
            // One line, one answer: it stands for ok.
            machine.sessions.refuse(to, text.error, format_args!("{text}"));
        }
    }
}

fn is_grbl<P: Ports>(machine: &Machine<'_, P>, to: Recipient) -> bool {
    to.session().is_some() && machine.sessions.dialect_of(to) == Dialect::Grbl
}

/// The answer to commands while halted.
pub(super) fn say_locked<P: Ports>(machine: &mut Machine<'_, P>, to: Recipient) {
    if is_grbl(machine, to) {
        return machine.sessions.refuse(to, Error::Locked, format_args!("'$H'|'$X' to unlock"));
    }
    machine.say(to, format_args!("!!\n"));
}

/// Halts because a command asked for what must not be.
pub(super) fn alarm<P: Ports>(machine: &mut Machine<'_, P>, text: &Message, to: Recipient) {
    if is_grbl(machine, to) {
        machine.halt(text.alarm, format_args!("Entering Alarm/Halt state\n"));
        return machine.sessions.refuse(to, text.error, format_args!("{text}"));
    }
    // Others must learn why the machine stands.
    let to = if to == Recipient::Nobody { Recipient::All } else { to };
    machine.say(to, format_args!("Error: {text}\n"));
    machine.halt(text.alarm, format_args!("Entering Alarm/Halt state\n"));
}

fn say_refusal<P: Ports>(machine: &mut Machine<'_, P>, refusal: Refusal, line: &[u8], to: Recipient) {
    let text = core::str::from_utf8(line).unwrap_or("(not text)");
    if is_grbl(machine, to) {
        let error = Error::of_refusal(&refusal);
        return machine.sessions.refuse(to, error, format_args!("{refusal} - {text}"));
    }
    if let Refusal::Resend { .. } = refusal {
        return machine.say(to, format_args!("{refusal}\n"));
    }
    let heard_by = if to == Recipient::Nobody { Recipient::All } else { to };
    machine.say(heard_by, format_args!("// WARNING gcode parse failed {refusal} - {text}\n"));
    machine.say(to, format_args!("ok\n"));
}
