//! `ed`: a file edited line by line from a console, into another file.
//!
//! Until `%c` every line of that console is the editor's. The file that is read stays as it is; when the
//! console goes away before the end, the new one is deleted.

use super::answers::answered;
use super::{Hands, Machine};
use crate::failure::{Answer, Failure, Outcome, about_file, message};
use crate::files::editing::Editing;
use crate::files::editor::{Step, shown};
use crate::files::editor_commands::{Command, HELP, What, parse};
use crate::files::paths::words;
use crate::grbl::numbers::Error;
use crate::ports::{OpenMode, Ports, Storage, StorageError};
use crate::sessions::{Recipient, SessionId};

/// Bytes read at a time: a block of the card.
const BLOCK: usize = 512;

/// `ed in out`
///
/// # Errors
/// When another file is being edited, or one of both cannot be opened.
pub(super) fn begin<P: Ports>(machine: &mut Machine<'_, P>, arguments: &str, to: Recipient) -> Outcome {
    let Recipient::Session(id) = to else { return Err(Failure::refused("only a console can edit a file")) };
    let Machine { files, ports, .. } = machine;
    if files.editing.is_some() {
        return Err(Failure::refused("another file is being edited"));
    }
    let mut names = words(arguments);
    let (Some(from), Some(into), None) = (names.next(), names.next(), names.next()) else {
        return Err(Failure::refused("Need unique input file and output file"));
    };
    let (input, output) = (files.absolute(from), files.absolute(into));
    if input.eq_ignore_ascii_case(&output) {
        return Err(Failure::refused("Need unique input file and output file"));
    }
    let cannot = |name: &str, error: StorageError| Failure::Refused(about_file(name, error.text()));
    let source = ports.open(&input, OpenMode::Read).map_err(|error| cannot(from, error))?;
    let target = ports.open(&output, OpenMode::Write).map_err(|error| {
        // It was only opened to be read.
        let _ = Storage::close(ports, source);
        cannot(into, error)
    })?;
    files.editing = Some(Editing::new(id, source, target, output));
    ports.inbox(id).set_text(true);
    machine.say(to, format_args!("  type %h to get help, %c to save file and exit\n"));
    Ok(Answer::Ok)
}

/// A line of the console that edits.
pub(super) async fn run_line<P: Ports>(machine: &mut Machine<'_, P>, id: SessionId, line: &[u8]) {
    let to = Recipient::Session(id);
    let outcome = match core::str::from_utf8(line) {
        Ok(text) => edit(machine, text, to).await,
        Err(_) => Err(Failure::refused("text that is not UTF-8")),
    };
    match outcome {
        Ok(_) => machine.say(to, format_args!("ok\n")),
        Err(Failure::Refused(why) | Failure::Alarm(why)) => {
            machine.sessions.refuse(to, why.error, format_args!("{why}"));
        }
        Err(Failure::Halted) => machine.sessions.refuse(to, Error::Locked, format_args!("halted")),
    }
    answered(machine, id);
}

async fn edit<P: Ports>(machine: &mut Machine<'_, P>, line: &str, to: Recipient) -> Outcome {
    if wanted(machine) > 0 {
        return take_line(machine, line, to).await;
    }
    let Some(editing) = machine.files.editing.as_mut() else { return Ok(Answer::Ok) };
    match line.trim() {
        "%h" => {
            machine.say(to, format_args!("{HELP}"));
            return Ok(Answer::Ok);
        }
        "%c" => return end(machine, to).await,
        mode @ ("%q" | "%m" | "%f") => {
            (editing.says_line, editing.says_each) = (mode != "%q", mode == "%f");
            return Ok(Answer::Ok);
        }
        _ => {}
    }
    let (mut rest, mut has_said) = (line.trim(), false);
    while !rest.is_empty() {
        let (command, behind) = parse(rest)
            .map_err(|wrong| Failure::Refused(message(format_args!("what is {wrong}? %h lists commands"))))?;
        (rest, has_said) = (behind, command.what == What::Print);
        repeat(machine, &command, to).await?;
        if command.what == What::Get {
            return Ok(Answer::Ok);
        }
        if machine.files.editing.as_ref().is_some_and(|editing| editing.says_each) && !rest.is_empty() {
            say_line(machine, to);
        }
    }
    if !has_said && machine.files.editing.as_ref().is_some_and(|editing| editing.says_line) {
        // The line may still have to be read.
        let _ = look(machine, to).await;
        say_line(machine, to);
    }
    Ok(Answer::Ok)
}

/// Lines that G still takes.
fn wanted<P: Ports>(machine: &Machine<'_, P>) -> u32 {
    machine.files.editing.as_ref().map_or(0, |editing| editing.lines_to_get)
}

/// One of the lines that G takes.
async fn take_line<P: Ports>(machine: &mut Machine<'_, P>, line: &str, to: Recipient) -> Outcome {
    loop {
        let Some(editing) = machine.files.editing.as_mut() else { return Ok(Answer::Ok) };
        if line == ":" {
            editing.lines_to_get = 0;
            return Ok(Answer::Ok);
        }
        if editing.editor.insert_line(line.as_bytes()) == Step::Done {
            editing.lines_to_get -= 1;
            return Ok(Answer::Ok);
        }
        make_room(machine)?;
        Hands::new(machine, to).pause_anyway().await;
    }
}

/// Carries a command out as often as it says; as often as it goes ends well.
async fn repeat<P: Ports>(machine: &mut Machine<'_, P>, command: &Command<'_>, to: Recipient) -> Result<(), Failure> {
    if command.what == What::Get {
        if let Some(editing) = machine.files.editing.as_mut() {
            editing.lines_to_get = if command.times == 0 { u32::MAX } else { command.times };
        }
        return Ok(());
    }
    let mut done = 0;
    while command.times == 0 || done < command.times {
        let prints = command.what == What::Print;
        let is_done = match command {
            // Lines but the first are moved to.
            _ if prints && done > 0 => {
                once(machine, &Command { what: What::Next, ..*command }, to).await? && !is_at_end(machine)
            }
            _ => once(machine, command, to).await?,
        };
        if !is_done {
            return if command.times == 0 { Ok(()) } else { Err(Failure::refused("there is none")) };
        }
        if prints {
            look(machine, to).await?;
            say_line(machine, to);
        }
        done += 1;
        if Hands::new(machine, to).stop_requested() {
            return Err(Failure::refused("stopped"));
        }
    }
    Ok(())
}

fn is_at_end<P: Ports>(machine: &Machine<'_, P>) -> bool {
    machine.files.editing.as_ref().is_none_or(|editing| editing.editor.has_line() && editing.editor.line().is_none())
}

/// Has the line read where commands act.
async fn look<P: Ports>(machine: &mut Machine<'_, P>, to: Recipient) -> Result<(), Failure> {
    let nothing = Command { what: What::Print, lines: 1, text: "", times: 1 };
    once(machine, &nothing, to).await.map(drop)
}

/// Carries a command out once. False when it does not go.
async fn once<P: Ports>(machine: &mut Machine<'_, P>, command: &Command<'_>, to: Recipient) -> Result<bool, Failure> {
    loop {
        let Some(editing) = machine.files.editing.as_mut() else { return Ok(false) };
        match editing.editor.run(command) {
            Step::Done => return Ok(true),
            Step::Failed => return Ok(false),
            Step::Full => make_room(machine)?,
            Step::More if editing.editor.room() < BLOCK => make_room(machine)?,
            Step::More => read_more(machine)?,
        }
        if Hands::new(machine, to).stop_requested() {
            return Err(Failure::refused("stopped"));
        }
        Hands::new(machine, to).pause_anyway().await;
    }
}

fn read_more<P: Ports>(machine: &mut Machine<'_, P>) -> Result<(), Failure> {
    let Machine { files, ports, .. } = machine;
    let Some(editing) = files.editing.as_mut() else { return Ok(()) };
    let mut block = [0; BLOCK];
    let count = ports.read(editing.input, &mut block).map_err(failed)?;
    let fits = editing.editor.append(block.get(..count).unwrap_or(&[]));
    if fits { Ok(()) } else { Err(Failure::refused("the line is too long to be edited")) }
}

/// Writes the beginning of the piece, which cannot be gone back to any more.
fn make_room<P: Ports>(machine: &mut Machine<'_, P>) -> Result<(), Failure> {
    let Machine { files, ports, .. } = machine;
    let Some(editing) = files.editing.as_mut() else { return Ok(()) };
    let beginning = editing.editor.beginning();
    let count = beginning.len();
    if count == 0 {
        return Err(Failure::refused("the line is too long to be edited"));
    }
    Storage::write(ports, editing.output, beginning).map_err(failed)?;
    editing.editor.forget(count);
    Ok(())
}

fn failed(error: StorageError) -> Failure {
    Failure::Refused(message(format_args!("{}", error.text())))
}

fn say_line<P: Ports>(machine: &mut Machine<'_, P>, to: Recipient) {
    if let Some(editing) = machine.files.editing.as_ref() {
        let line = shown(editing.editor.line());
        machine.say(to, format_args!("{line}\n"));
    }
}

/// `%c`: the rest of the file follows, and the new one is complete.
async fn end<P: Ports>(machine: &mut Machine<'_, P>, to: Recipient) -> Outcome {
    let copied = copy_rest(machine, to).await;
    let Some(editing) = machine.files.editing.take() else { return Ok(Answer::Ok) };
    machine.ports.inbox(editing.from).set_text(false);
    editing.close(&mut machine.ports, copied).map(|()| Answer::Ok).map_err(failed)
}

async fn copy_rest<P: Ports>(machine: &mut Machine<'_, P>, to: Recipient) -> Result<(), StorageError> {
    let Machine { files, ports, .. } = machine;
    let Some(editing) = files.editing.as_mut() else { return Ok(()) };
    Storage::write(ports, editing.output, editing.editor.rest())?;
    let (input, output) = (editing.input, editing.output);
    loop {
        let mut block = [0; BLOCK];
        let count = machine.ports.read(input, &mut block)?;
        if count == 0 {
            return Ok(());
        }
        Storage::write(&mut machine.ports, output, block.get(..count).unwrap_or(&[]))?;
        Hands::new(machine, to).pause_anyway().await;
    }
}
