//! The work that lines have started: scripts and files of saved settings, line by line, and their sequels.

use base::failure::{Answer, Failure, FailureKind, Outcome, ShortText, Texts, short};
use base::own_frame::apart;
use base::ports::{Storage, StorageError};
use base::sessions::{LineBytes, Recipient};
use base::{Ports, World};
use gcode::{Blocks, Gathered};
use procedures::probing::{stow_after, touch_cartesian_grid};
use program::{Interpreter, LeftHole, ScriptModes};

use super::blocks::Start;
use super::{actions, answers, blocks, bore_retract, tool_change};
use crate::machine::Machine;
use crate::machine::frames::{Frame, Frames, Replay, Script, Then};
use crate::machine::hands::MachineHands;
use crate::machine::moments::{Featured, Features, Moments as _};
use crate::machine::source::{Origin, Source};
use crate::machine::suspend::{self, start_script};

/// Does the next step of the frame that was started last.
pub(crate) fn run_top<P: Ports>(machine: &mut Machine<'_, P>) {
    if machine.safety.is_halted() {
        return fail(machine, Failure::HALTED);
    }
    let done = match machine.frames.top() {
        Some(Frame::Replay(_)) => return replay_next(machine),
        Some(Frame::Script(_)) => script_next(machine),
        _ => match machine.frames.pop() {
            Some(Frame::Rest(rest)) => return blocks::run_rest(machine, rest),
            Some(Frame::Operator(modes)) => {
                match machine.jobs.is_open() {
                    true => modes.end(&mut machine.program),
                    // The job, and its line with it, was aborted meanwhile.
                    false => drop_all(&mut machine.frames, &mut machine.program),
                }
                Ok(())
            }
            Some(Frame::ToolChange(tool)) => {
                tool_change::put_in(&mut MachineHands::new(machine, Recipient::Nobody), tool)
            }
            Some(Frame::Hole(left)) => go_on_drilling(machine, &left),
            Some(Frame::Startup(number)) => return run_startup(machine, number),
            // Much is called from there, and little of the stack is to be below it.
            Some(Frame::Then(Then::Step(step))) => P::go_on(machine, step),
            Some(Frame::Then(then)) => apart(|| go_on(machine, then)),
            _ => Ok(()),
        },
    };
    if let Err(failure) = done {
        fail(machine, failure);
    }
}

/// Drops all frames that were started.
fn drop_all<S>(frames: &mut Frames<'_, S>, program: &mut Interpreter) {
    while let Some(frame) = frames.pop() {
        if let Frame::Script(script) = frame {
            end_script(program, &script);
        }
    }
}

/// Gives the modes back to the program at the end of a script, or before.
fn end_script(program: &mut Interpreter, script: &Script<'_>) {
    if let Some(modes) = &script.modes {
        modes.end(program);
    }
}

/// Goes on with a drilling cycle, as the tool was drawn out of a hole.
fn go_on_drilling<P: Ports>(machine: &mut Machine<'_, P>, left: &LeftHole) -> Result<(), Failure> {
    machine.standstill()?;
    bore_retract::take_up(&mut MachineHands::new(machine, Recipient::Nobody), left)?;
    actions::what_returned(machine, Recipient::Nobody).map(drop)
}

/// Runs a startup line, and then those behind it. None begins in an alarm.
fn run_startup<P: Ports>(machine: &mut Machine<'_, P>, number: u8) {
    let Some(text) = Features::<P>::startup_line(machine, number) else { return };
    // The frame that was taken left room for this one.
    let _ = machine.frames.push(Frame::Startup(number + 1));
    if !text.is_empty() {
        machine.tag = motion::Tag::NONE;
        let source = Source::of_machine(machine.world.config, Origin::Startup(number));
        blocks::run_line(machine, Blocks::new(text.as_bytes()), Start::Line, source);
    }
}

/// Runs the next command of a script.
fn script_next<P: Ports>(machine: &mut Machine<'_, P>) -> Result<(), Failure> {
    let Machine { frames, program, .. } = machine;
    let Some(Frame::Script(script)) = frames.top() else { return Ok(()) };
    let text = script.text;
    let modes = script.modes.get_or_insert_with(|| ScriptModes::begin(program));
    let bytes = text.as_bytes();
    // Smoothieware v1 separates the lines of a script so.
    let end = bytes.iter().skip(script.next).position(|byte| *byte == b'|').map(|length| script.next + length);
    let line = end.and_then(|end| bytes.get(..end)).unwrap_or(bytes);
    let mut blocks = Blocks::starting_at(line, script.next);
    let block = blocks.next();
    (_, script.next) = blocks.place();
    let Some(block) = block else {
        if let Some(end) = end {
            script.next = end + 1;
            return Ok(());
        }
        modes.end(program);
        frames.pop();
        return Ok(());
    };
    if block.is_err() {
        script.next = line.len();
    }
    let source = Source::of_machine(machine.world.config, Origin::Switch);
    match block {
        // A suspension within a suspension has no meaning.
        Ok(block) if matches!(block.code, Some(code) if matches!(code.number, 600..=602)) => Ok(()),
        Ok(block) => {
            let outcome = blocks::run_block(machine, &block, source);
            if let (Ok(Answer::Unknown), Some(code)) = (&outcome, block.code) {
                machine.announce(format_args!("// WARNING {code} is not known here and was passed over: {text}\n"));
            }
            outcome.map(drop)
        }
        // A slip in its script must not lose a job that is to be suspended or resumed.
        Err(error) if machine.frames.is_around_suspension() => {
            machine.announce(format_args!("// WARNING {text}: {error}: passed over\n"));
            Ok(())
        }
        Err(error) => Err(machine.world.texts.refused(format_args!("{text}: {error}"))),
    }
}

/// Does the work that follows a script.
fn go_on<P: Ports>(machine: &mut Machine<'_, P>, then: Then<<P as Featured>::Step>) -> Result<(), Failure> {
    match then {
        Then::TouchGrid(plan, to) => {
            machine.standstill()?;
            let hands = &mut MachineHands::new(machine, to);
            let leveled = touch_cartesian_grid(hands, &plan);
            let leveled = stow_after(hands, leveled).map(|_| ());
            machine.resynchronise_if_still();
            if let Err(failure) = leveled
                && !failure.is_refusal()
            {
                return Err(failure);
            }
            // The second script undoes the first one's work, however leveling ended.
            let [_, after] = &machine.world.config.probe_gcode;
            let ended = leveled.map_err(|failure| machine.world.texts.kept(failure));
            start_script(&mut machine.frames, after, Then::Ended(ended))?;
        }
        Then::Ended(how) => {
            machine.standstill()?;
            return how.map_err(|kept| machine.world.texts.taken_up(&kept));
        }
        Then::Suspended => {
            machine.standstill()?;
            machine.announce(format_args!("// Print Suspended, enter resume to continue printing\n"));
        }
        Then::Step(step) => return P::go_on(machine, step),
        Then::Resumed => return suspend::go_back(machine),
    }
    Ok(())
}

/// Ends everything that was started and cannot go on, and answers the line that started it.
pub(crate) fn fail<P: Ports>(machine: &mut Machine<'_, P>, failure: Failure) {
    machine.passed = None;
    while let Some(frame) = machine.frames.pop() {
        match frame {
            // The macro ends with the line that has called it.
            Frame::Rest(rest) if rest.source.is_macros() => {}
            Frame::Rest(rest) if rest.answer == Answer::Said => {
                return answers::fail_late(machine, failure, rest.source);
            }
            Frame::Rest(rest) => {
                return answers::finish(machine, Err(failure), rest.last, rest.source);
            }
            Frame::Replay(replay) => {
                if failure.is_alarm() {
                    answers::alarm(machine, failure, replay.asked);
                }
                end_replay(&mut machine.world, &mut machine.program, replay, Err("the machine is halted"));
            }
            Frame::Then(Then::Step(step)) => P::give_up(machine, step, failure),
            Frame::Script(script) => end_script(&mut machine.program, &script),
            Frame::Then(_)
            | Frame::Startup(_)
            | Frame::Operator(_)
            | Frame::FastForward
            | Frame::Hole(_)
            | Frame::ToolChange(_) => {}
        }
    }
    // A script around a job: no line waits for its end.
    match failure.kind {
        FailureKind::Refused => machine.refuse(Recipient::All, failure),
        FailureKind::Alarm => answers::alarm(machine, failure, Recipient::All),
        FailureKind::Halted => {}
    }
    if machine.jobs.begun() == 0 && machine.jobs.is_playing() {
        machine.jobs.set_paused(true);
        machine.announce(format_args!("// the job has not begun: M24 begins it all the same, abort ends it\n"));
    }
}

// --- saved settings ---

/// Next part of a file of settings.
#[expect(clippy::large_enum_variant, reason = "it is taken apart at once")]
enum Piece {
    Line(LineBytes),
    TooLong,
    End,
    Failed(StorageError),
}

/// Reads the next line of the file of settings.
fn next_line<S>(frames: &mut Frames<'_, S>, ports: &mut impl Storage) -> Piece {
    let Some(Frame::Replay(replay)) = frames.top() else { return Piece::End };
    let whole = |line: &[u8]| LineBytes::from_slice(line).map_or(Piece::TooLong, Piece::Line);
    while !replay.at_end {
        while let Some(byte) = replay.chunk.get(replay.next).copied() {
            replay.next += 1;
            match replay.gathering.push(byte) {
                Some(Gathered::Line(line)) => return whole(line),
                Some(Gathered::TooLong) => return Piece::TooLong,
                None => {}
            }
        }
        let mut chunk = [0; 128];
        match ports.read(replay.file, &mut chunk) {
            Ok(0) => replay.at_end = true,
            Ok(count) => {
                replay.next = 0;
                replay.chunk.clear();
                // A chunk fits into a chunk.
                let _ = replay.chunk.extend_from_slice(chunk.get(..count).unwrap_or(&[]));
            }
            Err(error) => return Piece::Failed(error),
        }
    }
    match replay.gathering.finish() {
        Some(Gathered::Line(line)) => whole(line),
        Some(Gathered::TooLong) => Piece::TooLong,
        None => Piece::End,
    }
}

/// Carries out the next line of a file of settings. Lines that are refused are told, and the rest goes on.
fn replay_next<P: Ports>(machine: &mut Machine<'_, P>) {
    let ended = match next_line(&mut machine.frames, &mut machine.world.ports) {
        Piece::Line(line) => {
            let text = core::str::from_utf8(&line).unwrap_or("(not text)");
            match gcode::Decoder::new().decode(&line) {
                Ok(gcode::Line::Blank) => {}
                Ok(gcode::Line::Code(blocks)) => {
                    machine.tag = motion::Tag::NONE;
                    let source = Source::of_machine(machine.world.config, Origin::Settings);
                    blocks::run_line(machine, blocks, Start::Line, source);
                    if let Some(why) = machine.polls.settings_problem.take() {
                        machine.announce(format_args!("// WARNING: {why}: {text}\n"));
                    }
                }
                _ => machine.announce(format_args!("// WARNING: not a saved setting, left out: {text}\n")),
            }
            return;
        }
        Piece::TooLong => Err("a line is too long"),
        Piece::End => Ok(()),
        Piece::Failed(error) => Err(error.text()),
    };
    if let Some(Frame::Replay(replay)) = machine.frames.pop() {
        machine.settings_loaded |= ended.is_ok();
        end_replay(&mut machine.world, &mut machine.program, replay, ended);
    }
}

/// Returns the problem of a line of settings that has ended, to be told with the line.
///
/// # Errors
/// When the line has failed for another reason than itself.
pub(crate) fn settings_problem(texts: &Texts, outcome: Outcome) -> Result<Option<ShortText>, Failure> {
    match outcome {
        Ok(Answer::Unknown) => Ok(Some(short(format_args!("nobody knows the saved setting")))),
        Err(why) if why.is_refusal() => Ok(Some(texts.copy_of(why))),
        outcome => outcome.map(|_| None),
    }
}

fn end_replay<P: Ports>(world: &mut World<'_, P>, program: &mut Interpreter, replay: Replay, ended: Result<(), &str>) {
    // The file was only read: a failing close loses nothing.
    let _ = world.ports.close(replay.file);
    program.count_in_inches(replay.inches);
    let (path, to) = (replay.path, replay.asked);
    match ended {
        Ok(()) => match replay.by_load {
            true => world.say(to, format_args!("loaded config override file {path}\n")),
            false => world.say(to, format_args!("configuration override {path} loaded\n")),
        },
        Err(why) => world.say(to, format_args!("failed to load configuration override {path}: {why}\n")),
    }
}
