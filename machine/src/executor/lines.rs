//! Lines: the turns of their sources, their wholeness, and their kind: codes, a command of the console, an O
//! word.

use base::failure::{Answer, Outcome};
use base::own_frame::apart;
use base::ports::Wake;
use base::reason::Reason;
use base::sessions::{LineBytes, Recipient, Reply, Rights, SessionId, Sessions};
use base::{Ports, World};
use config::ButtonWord;
use events::{Event, Text};
use gcode::{Line, Refusal};
use jobs::files::{Files, NotSaved};
use jobs::player::line_numbers::{decoder_expecting, tag_of};
use jobs::player::{Next, Scripts};
use motion::Tag;
use program::{Dialect, Interpreter, State, Waits};

use super::answers::{finish, pause_job, say_refusal};
use super::blocks::Start;
use super::named_commands::Named;
use super::{actions, blocks, named_commands, out_of_turn, program_flow, stack};
use crate::features::commands;
use crate::machine::frames::{Frame, NextCode, Rest};
use crate::machine::moments::{Features, JobBegins, JobStart, Moments as _};
use crate::machine::source::{Origin, Source};
use crate::machine::{
    Machine, card, fast_forward, ignored_codes, job_control, jogging, program_files, program_logs, suspend,
};

/// Runs the next line: of work that a line has started, of a session, of an input, of the file being played.
/// False when there was nothing.
pub(crate) fn run_next<P: Ports>(machine: &mut Machine<'_, P>) -> bool {
    if machine.urgent.ends() {
        out_of_turn::settle(machine);
    }
    // While the operator does something, sessions may act: he jogs, and touches off the tool.
    let operator_is_busy = machine.frames.wait_for_operator() && machine.jobs.waits_for_operator();
    if !machine.frames.is_empty() && !operator_is_busy {
        if machine.frames.fast_forward() && !machine.safety.is_halted() {
            read_over(machine);
        } else {
            stack::run_top(machine);
        }
        return true;
    }
    let path_is_full = machine.world.ports.motion(|motion| {
        let (used, size) = motion.queue_level();
        size > 0 && used >= size
    });
    let path_is_full = path_is_full || Features::<P>::hold_moves_back(machine);
    let had_line = run_session(machine, path_is_full);
    // Inputs come before the job, which may always have a line ready. At an M0 inputs may do what sessions
    // may.
    let may_run = machine.frames.is_empty() || operator_is_busy && machine.frames.wait_for_operator();
    if may_run && run_switch(machine) {
        return true;
    }
    // Sessions and the file take turns; a file is mostly moves, so it waits for room.
    if machine.frames.is_empty() && !path_is_full && machine.urgent.first().is_none() && run_job_line(machine) {
        return true;
    }
    had_line
}

fn run_session<P: Ports>(machine: &mut Machine<'_, P>, path_is_full: bool) -> bool {
    let Some(id) = out_of_turn::next_session(machine, path_is_full) else { return false };
    // A session that uploads a file waits for the card, and nobody else does.
    if machine.files.uploads_from(id) && !machine.world.ports.is_ready() {
        return false;
    }
    if path_is_full && rides(machine.world.sessions, &machine.files, &machine.program, id) {
        if let Some(session) = machine.world.sessions.get_mut(id) {
            session.wait_for_room();
        }
        return true;
    }
    let Some(line) = machine.world.sessions.get_mut(id).and_then(base::sessions::Session::take_line) else {
        return false;
    };
    if jogging::is_dropped(machine.world.sessions, id, &line) {
        machine.answered(id);
        return true;
    }
    machine.tag = if line.first() == Some(&b'N') { tag_of(&line) } else { Tag::NONE };
    run_session_line(machine, id, &line);
    true
}

/// Whether the session's line waits only for room in the look-ahead queue.
fn rides(sessions: &Sessions, files: &Files, program: &Interpreter, id: SessionId) -> bool {
    let Some((session, line)) = sessions.get(id).and_then(|session| Some((session, session.waiting()?))) else {
        return false;
    };
    if files.takes_lines_of(id) {
        return false;
    }
    // A copy, since the line is not read yet.
    let mut decoder = session.decoder;
    let Ok(Line::Code(mut blocks)) = decoder.decode(line) else { return false };
    let dialect = session.dialect;
    blocks
        .any(|block| block.is_ok_and(|block| program.row(&block, dialect).is_some_and(|row| row.waits == Waits::Path)))
}

/// Runs a line of a session. Kept out of the code that every line of a file passes through.
#[inline(never)]
fn run_session_line<P: Ports>(machine: &mut Machine<'_, P>, id: SessionId, line: &LineBytes) {
    let to = Recipient::Session(id);
    if Features::<P>::take_session_line(machine, id, line) {
        return;
    }
    let Some(session) = machine.world.sessions.get_mut(id) else { return };
    let may_operate = session.rights >= Rights::Operate;
    session.decoder.counts_from_before = session.dialect == Dialect::Smoothie;
    match session.decoder.decode(line) {
        Ok(_) if !may_operate => {
            let text = format_args!("this session may ask, and stop the machine, no more");
            machine.world.sessions.refuse(to, Reason::Locked, text);
            machine.answered(id);
        }
        Ok(decoded) if machine.files.uploads_from(id) && !matches!(decoded, Line::Console(_)) => {
            if let Some(closed) = machine.files.end_upload(&decoded, &mut machine.world.ports) {
                let kept = card::kept(machine).map_err(NotSaved::Card);
                let Machine { files, world: World { sessions, .. }, .. } = machine;
                files.upload_ended(closed.and(kept), &mut Reply::new(sessions, to));
            } else {
                let Machine { files, world: World { ports, sessions, .. }, .. } = machine;
                let is_stored = files.upload_line(line, ports, &mut Reply::new(sessions, to));
                if is_stored && !Features::<P>::answer_in_upload(machine, &decoded, to) {
                    machine.say(to, format_args!("ok\n"));
                }
            }
            machine.answered(id);
        }
        Ok(Line::Code(_)) if Features::<P>::refuse_codes(machine, to) => machine.answered(id),
        Ok(decoded) => {
            Features::<P>::session_line_begins(machine);
            let source = Source::of_session(machine.world.sessions, to);
            run_decoded(machine, decoded, source);
            Features::<P>::session_line_ends(machine);
        }
        Err(refusal) => {
            say_refusal(machine.world.sessions, refusal, line, to);
            machine.answered(id);
        }
    }
}

/// Runs the next line of the file being played. False when there is none.
fn run_job_line<P: Ports>(machine: &mut Machine<'_, P>) -> bool {
    machine.jobs.open_boot_file(machine.world.texts, machine.world.config, &mut machine.world.ports);
    if !machine.jobs.is_playing() || !matches!(machine.safety.state(), State::Idle | State::Run | State::Check) {
        return false;
    }
    let to = machine.jobs.echo();
    if !machine.world.sessions.have_taken_most(to) {
        return false;
    }
    let has_begun = machine.jobs.begun() > 0 || machine.safety.state() == State::Check;
    if !has_begun && !Features::<P>::job_may_begin(machine) {
        return false;
    }
    if machine.jobs.scripts().is_some_and(Scripts::take_before)
        && suspend::start_unless_empty(&mut machine.frames, &machine.world.config.player.before_job_gcode)
    {
        return true;
    }
    if machine.jobs.take_new() {
        match start_job(machine, JobBegins::Whole) {
            // The start of the job may have taken a while.
            JobStart::Now if !machine.jobs.is_playing() => return true,
            JobStart::Now => {}
            JobStart::Later => return false,
            JobStart::Never => return true,
        }
    }
    // A log about to fill its block needs the card.
    if machine.logs.are_nearly_full() && !machine.world.ports.is_ready() {
        return false;
    }
    let mut line = LineBytes::new();
    match machine.jobs.next_line(&mut machine.world.ports, &mut line) {
        Next::Line => {
            if let Some((command, source)) = job_control::due_before(machine, &line) {
                run_own_line(machine, command.as_bytes(), source);
                return true;
            }
            if to != Recipient::Nobody
                && let Ok(text) = core::str::from_utf8(&line)
            {
                machine.say(to, format_args!("{text}\n"));
            }
            run_line_of_job(machine, &line);
        }
        Next::Nothing => {}
        Next::NotYet => return false,
        Next::Dialect(dialect) => {
            machine.announce(format_args!("// NOTE the file is read as {}'s, as it says\n", dialect.name()));
        }
        Next::TooLong => pause_job(machine, "is too long"),
        Next::End => return apart(|| end_job(machine)),
        Next::Failed(why) => {
            Features::<P>::job_is_unreadable(machine);
            machine.record(&Event::CardFailed(Text::new(format_args!("reading the job failed: {why}"))));
            machine.announce(format_args!(
                "error:paused, reading the file being played failed: {why}: M24 goes on once its card is back, abort ends it\n"
            ));
        }
    }
    true
}

/// Starts a new job, unless that has to wait, or to be left.
fn start_job<P: Ports>(machine: &mut Machine<'_, P>, from: JobBegins) -> JobStart {
    let start = Features::<P>::job_may_start(machine);
    match start {
        JobStart::Now => {
            let path = machine.jobs.path().map_or("", |path| path.as_str());
            machine.record(&Event::JobBegan(Text::from(path)));
            Features::<P>::job_begins(machine, from);
        }
        JobStart::Later => machine.jobs.is_new_again(),
        JobStart::Never => {}
    }
    start
}

/// Runs a line of the job. Only an O word counts in a line that is passed over. Answers go to nobody: only
/// faults are told.
fn run_line_of_job<P: Ports>(machine: &mut Machine<'_, P>, line: &[u8]) {
    machine.tag = machine.jobs.begin_line();
    machine.program.at_line(machine.jobs.line());
    let source = Source::of_job(&machine.jobs, machine.world.config);
    if !machine.program.flow().passes_over() {
        run_own_line(machine, line, source);
    } else if let Ok(Line::Flow(line)) = decoder_expecting(line).decode(line) {
        let outcome = program_flow::run_line(machine, &line, source);
        finish(machine, outcome, None, source);
    }
}

/// Reads the next line of the file without carrying it out: see [`fast_forward`].
#[cold]
fn read_over<P: Ports>(machine: &mut Machine<'_, P>) {
    // The forecast begins with the file, as the program does.
    if machine.jobs.take_new() {
        match start_job(machine, JobBegins::FurtherOn) {
            JobStart::Now => {}
            JobStart::Later => return machine.wait(Wake::Any).whatever_happens(),
            JobStart::Never => return fast_forward::end(machine, false),
        }
    }
    if fast_forward::is_there(machine) {
        return;
    }
    let mut line = LineBytes::new();
    match machine.jobs.next_line(&mut machine.world.ports, &mut line) {
        Next::Line => {
            fast_forward::at_line(machine);
            let height = machine.program.modal().work(machine.program.position())[units::Axis::Z];
            let _passed = machine.jobs.pass_pause(&line, height);
            run_line_of_job(machine, &line);
        }
        Next::Nothing | Next::Dialect(_) => {}
        Next::NotYet => {
            machine.wait(Wake::Any).whatever_happens();
        }
        Next::TooLong => pause_job(machine, "is too long"),
        Next::End | Next::Failed(_) => fast_forward::end(machine, false),
    }
}

/// Ends a job whose file has been read, once its last moves are made. False while they go on, so that
/// sessions are heard.
fn end_job<P: Ports>(machine: &mut Machine<'_, P>) -> bool {
    machine.world.ports.motion(motion::Motion::flush);
    if !machine.world.ports.motion(|motion| motion.is_idle()) {
        return false;
    }
    if machine.jobs.scripts().is_some_and(Scripts::take_after)
        && suspend::start_unless_empty(&mut machine.frames, &machine.world.config.player.after_job_gcode)
    {
        return true;
    }
    Features::<P>::job_is_read(machine);
    if let Err(fault) = machine.program.end_file() {
        machine.announce(format_args!("error:the file has ended, and {fault}\n"));
    }
    program_files::save(machine);
    card::at_rest(machine);
    let (to, tells_date) = (machine.jobs.tells_end(), machine.jobs.tells_date());
    ignored_codes::say(&mut machine.jobs, machine.world.sessions);
    program_logs::close(&mut machine.logs, &mut machine.world);
    Features::<P>::job_ends(machine, true, if tells_date { to } else { Recipient::Nobody });
    machine.jobs.close(&mut machine.world.ports);
    machine.say(to, format_args!("Done printing file\n"));
    if tells_date {
        let date = machine.world.ports.date();
        machine.say(to, format_args!("Print stopped at: {date}\n"));
    }
    job_control::after_job(&mut machine.jobs, &mut machine.world);
    true
}

/// Runs the command of an input switch that changed. False when there is none.
fn run_switch<P: Ports>(machine: &mut Machine<'_, P>) -> bool {
    let Machine { outputs, world: World { config, .. }, .. } = machine;
    let command = outputs.take_command(config);
    let Some(line) = command.or_else(|| Features::<P>::take_line(machine)) else {
        let Some(line) = machine.buttons.take_line(machine.world.config) else { return false };
        run_button(machine, &line);
        return true;
    };
    machine.tag = Tag::NONE;
    let source = Source::of_machine(machine.world.config, Origin::Switch);
    run_own_line(machine, line.as_bytes(), source);
    true
}

/// Runs the line of a button. A jog that it begins can be ended by a button.
fn run_button<P: Ports>(machine: &mut Machine<'_, P>, line: &str) {
    machine.tag = Tag::NONE;
    let line = match ButtonWord::of(line) {
        Some(ButtonWord::Suspend) if machine.jobs.is_suspended() => "M602",
        Some(ButtonWord::Suspend) => "M600",
        _ => line,
    };
    let source = Source::of_machine(machine.world.config, Origin::Switch);
    machine.world.sessions.button_stop = Some(false);
    run_own_line(machine, line.as_bytes(), source);
    machine.world.sessions.button_stop = None;
}

/// Runs a line that comes from the machine itself.
pub(crate) fn run_own_line<P: Ports>(machine: &mut Machine<'_, P>, line: &[u8], source: Source) {
    match decoder_expecting(line).decode(line) {
        Ok(decoded) => return run_decoded(machine, decoded, source),
        Err(refusal) if source.is_macros() => {
            let text = core::str::from_utf8(line).unwrap_or("(not text)");
            let why = machine.world.texts.refused(format_args!("{refusal}: {text}"));
            return finish(machine, Err(why), None, source);
        }
        Err(Refusal::Resend { .. }) => {
            // A wrong checksum means a damaged file.
            let text = core::str::from_utf8(line).unwrap_or("(not text)");
            let why = machine.world.texts.refused(format_args!("checksum does not match: {text}"));
            machine.refuse(source.to, why);
        }
        Err(refusal) => say_refusal(machine.world.sessions, refusal, line, source.to),
    }
    if source.origin == Origin::Job {
        pause_job(machine, "was not carried out");
    }
}

fn run_decoded<P: Ports>(machine: &mut Machine<'_, P>, decoded: Line<'_>, source: Source) {
    match decoded {
        Line::Blank => finish(machine, Ok(Answer::Ok), None, source),
        // In place: the state that waits is large, and would be copied for every line.
        Line::Code(blocks) => blocks::run_line(machine, blocks, Start::Line, source),
        Line::Flow(line) => {
            let mut outcome = program_flow::run_line(machine, &line, source);
            if outcome.is_ok() && machine.program.has_more() {
                outcome = actions::what_returned(machine, source.to);
            }
            finish(machine, outcome, None, source);
        }
        line => {
            let height = machine.frames.len();
            if let Some(text) = named_commands::text_of(&line).filter(|_| source.origin != Origin::Settings)
                && let Some(outcome) = apart(|| Features::<P>::run_named(machine, text, source))
            {
                return when_ended(machine, height, outcome, source);
            }
            let Machine { frames, jobs, world: World { config, texts, .. }, .. } = machine;
            match named_commands::command_of(frames, jobs, (config, texts), &line, source) {
                Named::Console(command) => run_command(machine, command, source),
                Named::Codes => {}
                Named::Ended(outcome) => finish(machine, outcome, None, source),
            }
        }
    }
}

/// Runs the line of a command and answers it.
fn run_command<P: Ports>(machine: &mut Machine<'_, P>, line: &str, source: Source) {
    let height = machine.frames.len();
    let outcome = commands::run(machine, line, source.to);
    when_ended(machine, height, outcome, source);
}

/// Answers a command, once the frames have ended that it has started since the stack had this height.
fn when_ended<P: Ports>(machine: &mut Machine<'_, P>, height: usize, outcome: Outcome, source: Source) {
    if outcome.is_ok() && machine.frames.len() > height {
        // The command is answered when the frames it started have ended.
        let answer = outcome.unwrap_or(Answer::Ok);
        let rest = Rest { line: LineBytes::new(), next: NextCode::At(0), source, last: None, answer };
        if machine.frames.push_below(height, Frame::Rest(rest)) {
            return;
        }
        machine.frames.drop_down_to(height);
        return finish(machine, Ok(answer), None, source);
    }
    finish(machine, outcome, None, source);
}
