//! `ed`: a file edited line by line from a console, into another file.
//!
//! Until `%c` every line of that console is the editor's. The file that is read stays as it is; when the
//! console goes away before the end, the new one is deleted.

use base::failure::{Answer, Failure, Outcome};
use base::hands::Hands as _;
use base::own_frame::apart;
use base::paths::words;
use base::ports::{OpenMode, Storage, StorageError, Wake};
use base::reason::Reason;
use base::sessions::{LineBytes, Recipient, SessionId};
use base::{Ports, World};
use jobs::files::editing::Editing;
use jobs::files::editor::{Step, shown};
use jobs::files::editor_commands::{Command, HELP, What, parse};

use crate::machine::Machine;
use crate::machine::card;
use crate::machine::hands::MachineHands;
use crate::machine::moments::Moments;

/// Bytes read at a time, a block of the card.
const BLOCK: usize = 512;
const TOO_LONG: Trouble = "the line is too long to be edited";

/// The editor at the machine's moments.
pub(crate) struct Feature;

impl<P: Ports> Moments<P> for Feature {
    fn take_session_line(machine: &mut Machine<'_, P>, id: SessionId, line: &LineBytes) -> bool {
        let edits = machine.files.edits_from(id);
        if edits {
            apart(|| run_line(machine, id, line));
        }
        edits
    }
}

/// Begins to edit a file: `ed in out`.
///
/// # Errors
/// When another file is being edited, or one of both cannot be opened.
pub(crate) fn begin<P: Ports>(machine: &mut Machine<'_, P>, arguments: &str, to: Recipient) -> Outcome {
    let Recipient::Session(id) = to else { return Err(Failure::refused(&"only a console can edit a file")) };
    let Machine { files, world: World { ports, .. }, .. } = machine;
    if files.editing.is_some() {
        return Err(Failure::refused(&"another file is being edited"));
    }
    let mut names = words(arguments);
    let (Some(from), Some(into), None) = (names.next(), names.next(), names.next()) else {
        return Err(Failure::refused(&"Need unique input file and output file"));
    };
    let (input, output) = (files.absolute(from), files.absolute(into));
    if input.eq_ignore_ascii_case(&output) {
        return Err(Failure::refused(&"Need unique input file and output file"));
    }
    let cannot = |name: &str, error: StorageError| machine.world.texts.about_file(name, error.text());
    let source = ports.open(&input, OpenMode::Read).map_err(|error| cannot(from, error))?;
    let target = ports.open(&output, OpenMode::Write).map_err(|error| {
        // The source was only opened to be read.
        let _ = Storage::close(ports, source);
        cannot(into, error)
    })?;
    files.editing = Some(Editing::new(id, source, target, output));
    ports.inbox(id).set_text(true);
    machine.say(to, format_args!("  type %h to get help, %c to save file and exit\n"));
    Ok(Answer::Ok)
}

/// Reason why a command of the editor was not carried out.
type Trouble = &'static str;

/// Runs a line of the console that edits.
pub(crate) fn run_line<P: Ports>(machine: &mut Machine<'_, P>, id: SessionId, line: &[u8]) {
    let to = Recipient::Session(id);
    let text = core::str::from_utf8(line).map_err(|_| "text that is not UTF-8");
    let outcome = match text {
        Ok(text) if text == "%c" && wanted(machine) == 0 => end(machine),
        Ok(text) => edit(machine, text, to),
        Err(why) => Err(why),
    };
    match outcome {
        Ok(()) => machine.say(to, format_args!("ok\n")),
        Err(why) => machine.world.sessions.refuse(to, Reason::default(), format_args!("{why}")),
    }
    machine.answered(id);
}

/// Carries out the editor's own commands; false for those that act on the file.
fn is_told<P: Ports>(machine: &mut Machine<'_, P>, line: &str, to: Recipient) -> bool {
    let Some(editing) = machine.files.editing.as_mut() else { return true };
    match line {
        "%h" => machine.say(to, format_args!("{HELP}")),
        "%q" | "%m" | "%f" => (editing.says_line, editing.says_each) = (line != "%q", line == "%f"),
        _ => return false,
    }
    true
}

fn edit<P: Ports>(machine: &mut Machine<'_, P>, line: &str, to: Recipient) -> Result<(), Trouble> {
    if wanted(machine) > 0 {
        return take_line(machine, line);
    }
    if is_told(machine, line, to) {
        return Ok(());
    }
    let (mut rest, mut last) = (line.trim(), None);
    while !rest.is_empty() {
        let (command, behind) = parse(rest).map_err(|_| "that is no command: %h lists them")?;
        repeat(machine, &command, to)?;
        (rest, last) = (behind, Some(command.what));
        if command.what == What::Get {
            return Ok(());
        }
        if machine.files.editing.as_ref().is_some_and(|editing| editing.says_each) && !rest.is_empty() {
            say_line(machine, to);
        }
    }
    if last != Some(What::Print) && machine.files.editing.as_ref().is_some_and(|editing| editing.says_line) {
        // The line may still have to be read.
        once(machine, &LOOK, to)?;
        say_line(machine, to);
    }
    Ok(())
}

/// Command that does nothing but have the line read where commands act.
const LOOK: Command<'_> = Command { what: What::Print, lines: 1, text: "", times: 1 };

/// Returns the number of lines that G still takes.
fn wanted<P: Ports>(machine: &Machine<'_, P>) -> u32 {
    machine.files.editing.as_ref().map_or(0, |editing| editing.lines_to_get)
}

/// Takes one of the lines that G inserts.
fn take_line<P: Ports>(machine: &mut Machine<'_, P>, line: &str) -> Result<(), Trouble> {
    loop {
        let Some(editing) = machine.files.editing.as_mut() else { return Ok(()) };
        if line == ":" {
            editing.lines_to_get = 0;
            return Ok(());
        }
        if editing.editor.insert_line(line.as_bytes()) == Step::Done {
            editing.lines_to_get -= 1;
            return Ok(());
        }
        make_room(machine)?;
    }
}

/// Carries out a command as often as it says; 0, as often as it goes, ends well.
fn repeat<P: Ports>(machine: &mut Machine<'_, P>, command: &Command<'_>, to: Recipient) -> Result<(), Trouble> {
    if command.what == What::Get {
        if let Some(editing) = machine.files.editing.as_mut() {
            editing.lines_to_get = if command.times == 0 { u32::MAX } else { command.times };
        }
        return Ok(());
    }
    let prints = command.what == What::Print;
    let next = Command { what: What::Next, ..LOOK };
    let mut done = 0;
    while command.times == 0 || done < command.times {
        // Lines to be printed, but the first, need a step to the next line.
        let step = if prints && done > 0 { &next } else { command };
        let goes = once(machine, step, to)?;
        if goes && prints {
            once(machine, &LOOK, to)?;
        }
        if !goes || prints && is_at_end(machine) {
            return if command.times == 0 { Ok(()) } else { Err("there is none") };
        }
        if prints {
            say_line(machine, to);
        }
        done += 1;
    }
    Ok(())
}

fn is_at_end<P: Ports>(machine: &Machine<'_, P>) -> bool {
    machine.files.editing.as_ref().is_none_or(|editing| editing.editor.line().is_none())
}

/// Carries out a command once. False when it does not go.
fn once<P: Ports>(machine: &mut Machine<'_, P>, command: &Command<'_>, to: Recipient) -> Result<bool, Trouble> {
    loop {
        let Some(editing) = machine.files.editing.as_mut() else { return Ok(false) };
        match editing.editor.run(command) {
            Step::Done => break,
            Step::Failed => return Ok(false),
            Step::Full => make_room(machine)?,
            Step::More if editing.editor.room() < BLOCK => make_room(machine)?,
            Step::More => read_more(machine)?,
        }
        machine.wait(Wake::Any).whatever_happens();
    }
    if MachineHands::new(machine, to).stop_requested() { Err("stopped") } else { Ok(true) }
}

fn read_more<P: Ports>(machine: &mut Machine<'_, P>) -> Result<(), Trouble> {
    let Machine { files, world: World { ports, .. }, .. } = machine;
    let Some(editing) = files.editing.as_mut() else { return Ok(()) };
    let mut block = [0; BLOCK];
    let count = ports.read(editing.input, &mut block).map_err(StorageError::text)?;
    let fits = editing.editor.append(block.get(..count).unwrap_or(&[]));
    if fits { Ok(()) } else { Err(TOO_LONG) }
}

/// Writes the beginning of the piece, which then cannot be gone back to.
#[inline(never)]
fn make_room<P: Ports>(machine: &mut Machine<'_, P>) -> Result<(), Trouble> {
    let Machine { files, world: World { ports, .. }, .. } = machine;
    let Some(editing) = files.editing.as_mut() else { return Ok(()) };
    let beginning = editing.editor.beginning();
    let count = beginning.len();
    if count == 0 {
        return Err(TOO_LONG);
    }
    Storage::write(ports, editing.output, beginning).map_err(StorageError::text)?;
    editing.editor.forget(count);
    Ok(())
}

#[inline(never)]
fn say_line<P: Ports>(machine: &mut Machine<'_, P>, to: Recipient) {
    if let Some(editing) = machine.files.editing.as_ref() {
        let line = shown(editing.editor.line());
        machine.say(to, format_args!("{line}\n"));
    }
}

/// Saves and ends the edit (`%c`): the rest of the file follows, and the new file is complete.
fn end<P: Ports>(machine: &mut Machine<'_, P>) -> Result<(), Trouble> {
    let mut copied = Ok(true);
    while matches!(copied, Ok(true)) {
        card::at_rest(machine);
        copied = copy_on(machine);
        machine.wait(Wake::Any).whatever_happens();
    }
    let Machine { files, world: World { ports, .. }, .. } = machine;
    let Some(editing) = files.editing.take() else { return Ok(()) };
    ports.inbox(editing.from).set_text(false);
    editing.close(ports, copied.map(drop)).map_err(StorageError::text)
}

/// Writes the editor's text, and has the editor read on. False at the end of the file.
fn copy_on<P: Ports>(machine: &mut Machine<'_, P>) -> Result<bool, StorageError> {
    let Machine { files, world: World { ports, .. }, .. } = machine;
    let Some(editing) = files.editing.as_mut() else { return Ok(false) };
    let text = editing.editor.rest();
    let count = text.len();
    Storage::write(ports, editing.output, text)?;
    editing.editor.forget(count);
    let mut block = [0; BLOCK];
    let count = ports.read(editing.input, &mut block)?;
    // There is room, since the editor is empty.
    let _ = editing.editor.append(block.get(..count).unwrap_or(&[]));
    Ok(count > 0)
}
