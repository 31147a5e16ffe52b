//! `ed`: a file edited line by line from a console, into another file.
//!
//! Until `%c` every line of that console is the editor's. The file that is read stays as it is; when the
//! console goes away before the end, the new one is deleted.

use base::failure::{Answer, Failure, Outcome};
use base::hands::Hands;
use base::own_frame::apart;
use base::paths::words;
use base::ports::{OpenMode, Storage, StorageError, Wake};
use base::reason::Reason;
use base::secrets::open_to_show;
use base::sessions::{Consoles as _, LineBytes, Recipient, SessionId};
use base::{Ports, World};
use jobs::files::Files;
use jobs::files::editing::Editing;
use jobs::files::editor::{Step, shown};
use jobs::files::editor_commands::{Command, HELP, What, parse};

use crate::machine::Machine;
use crate::machine::hands::MachineHands;
use crate::machine::moments::Moments;
use crate::machine::work_hands::WorldHands;

/// Bytes read at a time, a block of the card.
const BLOCK: usize = 512;
const TOO_LONG: Trouble = "the line is too long to be edited";

/// The machine for lines of a console that edits a file.
pub(crate) trait EditorHands<'c>: WorldHands<'c> {
    /// Whether a file is edited from this session.
    fn edits_from(&self, id: SessionId) -> bool;

    /// Returns hands for the editor of this recipient.
    fn edit_sequence(&mut self, to: Recipient) -> impl EditHands<'c>;

    /// Notes that a line of a session has been answered.
    fn answered(&mut self, id: SessionId);
}

impl<'c, P: Ports> EditorHands<'c> for Machine<'c, P> {
    fn edits_from(&self, id: SessionId) -> bool {
        self.files.edits_from(id)
    }

    fn edit_sequence(&mut self, to: Recipient) -> impl EditHands<'c> {
        MachineHands::new(self, to)
    }

    fn answered(&mut self, id: SessionId) {
        self.answered(id);
    }
}

/// The editor at the machine's moments.
pub(crate) struct Feature;

impl<'c, M: EditorHands<'c>> Moments<M> for Feature {
    fn take_session_line(hands: &mut M, id: SessionId, line: &LineBytes) -> bool {
        let edits = hands.edits_from(id);
        if edits {
            match apart(|| run_line(&mut hands.edit_sequence(Recipient::Session(id)), line)) {
                Ok(()) => hands.say(Recipient::Session(id), format_args!("ok\n")),
                Err(why) => {
                    hands.world().sessions.refuse(Recipient::Session(id), Reason::default(), format_args!("{why}"));
                }
            }
            hands.answered(id);
        }
        edits
    }
}

/// The machine as the editor uses it.
pub(crate) trait EditHands<'c>: Hands<'c> {
    /// Returns the file being edited, and the card.
    fn editing(&mut self) -> (Option<&mut Editing>, &mut Self::Ports);

    /// Takes the file that was edited, at its end.
    fn take_editing(&mut self) -> Option<Editing>;
}

impl<'c, P: Ports> EditHands<'c> for MachineHands<'_, 'c, P> {
    fn editing(&mut self) -> (Option<&mut Editing>, &mut P) {
        (self.machine.files.editing.as_mut(), &mut self.machine.world.ports)
    }

    fn take_editing(&mut self) -> Option<Editing> {
        self.machine.files.editing.take()
    }
}

/// Begins to edit a file: `ed in out`.
///
/// # Errors
/// When another file is being edited, or one of both cannot be opened.
pub(crate) fn begin<P: Ports>(files: &mut Files, world: &mut World<'_, P>, arguments: &str, to: Recipient) -> Outcome {
    let Recipient::Session(id) = to else { return Err(Failure::refused(&"only a console can edit a file")) };
    world.sends_alone(to)?;
    let World { ports, texts, .. } = world;
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
    let cannot = |name: &str, error: StorageError| texts.about_file(name, error.text());
    let source = open_to_show(ports, &input, OpenMode::Read).map_err(|error| cannot(from, error))?;
    let target = ports.open(&output, OpenMode::Write).map_err(|error| {
        // The source was only opened to be read.
        let _ = Storage::close(ports, source);
        cannot(into, error)
    })?;
    files.editing = Some(Editing::new(id, source, target, output));
    ports.inbox(id).set_text(true);
    world.say(to, format_args!("  type %h to get help, %c to save file and exit\n"));
    Ok(Answer::Ok)
}

/// Reason why a command of the editor was not carried out.
type Trouble = &'static str;

/// Runs a line of the console that edits.
fn run_line<'c>(hands: &mut impl EditHands<'c>, line: &[u8]) -> Result<(), Trouble> {
    let text = core::str::from_utf8(line).map_err(|_| "text that is not UTF-8")?;
    if text == "%c" && wanted(hands) == 0 { end(hands) } else { edit(hands, text) }
}

/// Carries out the editor's own commands; false for those that act on the file.
fn is_told<'c>(hands: &mut impl EditHands<'c>, line: &str) -> bool {
    let Some(editing) = hands.editing().0 else { return true };
    match line {
        "%h" => hands.say(format_args!("{HELP}")),
        "%q" | "%m" | "%f" => (editing.says_line, editing.says_each) = (line != "%q", line == "%f"),
        _ => return false,
    }
    true
}

fn edit<'c>(hands: &mut impl EditHands<'c>, line: &str) -> Result<(), Trouble> {
    if wanted(hands) > 0 {
        return take_line(hands, line);
    }
    if is_told(hands, line) {
        return Ok(());
    }
    let (mut rest, mut last) = (line.trim(), None);
    while !rest.is_empty() {
        let (command, behind) = parse(rest).map_err(|_| "that is no command: %h lists them")?;
        repeat(hands, &command)?;
        (rest, last) = (behind, Some(command.what));
        if command.what == What::Get {
            return Ok(());
        }
        if hands.editing().0.is_some_and(|editing| editing.says_each) && !rest.is_empty() {
            say_line(hands);
        }
    }
    if last != Some(What::Print) && hands.editing().0.is_some_and(|editing| editing.says_line) {
        // The line may still have to be read.
        once(hands, &LOOK)?;
        say_line(hands);
    }
    Ok(())
}

/// Command that does nothing but have the line read where commands act.
const LOOK: Command<'_> = Command { what: What::Print, lines: 1, text: "", times: 1 };

/// Returns the number of lines that G still takes.
fn wanted<'c>(hands: &mut impl EditHands<'c>) -> u32 {
    hands.editing().0.map_or(0, |editing| editing.lines_to_get)
}

/// Takes one of the lines that G inserts.
fn take_line<'c>(hands: &mut impl EditHands<'c>, line: &str) -> Result<(), Trouble> {
    loop {
        let Some(editing) = hands.editing().0 else { return Ok(()) };
        if line == ":" {
            editing.lines_to_get = 0;
            return Ok(());
        }
        if editing.editor.insert_line(line.as_bytes()) == Step::Done {
            editing.lines_to_get -= 1;
            return Ok(());
        }
        make_room(hands)?;
    }
}

/// Carries out a command as often as it says; 0, as often as it goes, ends well.
fn repeat<'c>(hands: &mut impl EditHands<'c>, command: &Command<'_>) -> Result<(), Trouble> {
    if command.what == What::Get {
        if let Some(editing) = hands.editing().0 {
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
        let goes = once(hands, step)?;
        if goes && prints {
            once(hands, &LOOK)?;
        }
        if !goes || prints && is_at_end(hands) {
            return if command.times == 0 { Ok(()) } else { Err("there is none") };
        }
        if prints {
            say_line(hands);
        }
        done += 1;
    }
    Ok(())
}

fn is_at_end<'c>(hands: &mut impl EditHands<'c>) -> bool {
    hands.editing().0.is_none_or(|editing| editing.editor.line().is_none())
}

/// Carries out a command once. False when it does not go.
fn once<'c>(hands: &mut impl EditHands<'c>, command: &Command<'_>) -> Result<bool, Trouble> {
    loop {
        let Some(editing) = hands.editing().0 else { return Ok(false) };
        match editing.editor.run(command) {
            Step::Done => break,
            Step::Failed => return Ok(false),
            Step::Full => make_room(hands)?,
            Step::More if editing.editor.room() < BLOCK => make_room(hands)?,
            Step::More => read_more(hands)?,
        }
        hands.wait(Wake::Any).whatever_happens();
    }
    if hands.stop_requested() { Err("stopped") } else { Ok(true) }
}

fn read_more<'c>(hands: &mut impl EditHands<'c>) -> Result<(), Trouble> {
    let (editing, ports) = hands.editing();
    let Some(editing) = editing else { return Ok(()) };
    let mut block = [0; BLOCK];
    let count = ports.read(editing.input, &mut block).map_err(StorageError::text)?;
    let fits = editing.editor.append(block.get(..count).unwrap_or(&[]));
    if fits { Ok(()) } else { Err(TOO_LONG) }
}

/// Writes the beginning of the piece, which then cannot be gone back to.
#[inline(never)]
fn make_room<'c>(hands: &mut impl EditHands<'c>) -> Result<(), Trouble> {
    let (editing, ports) = hands.editing();
    let Some(editing) = editing else { return Ok(()) };
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
fn say_line<'c>(hands: &mut impl EditHands<'c>) {
    if let Some(editing) = hands.editing().0 {
        let line = shown(editing.editor.line());
        hands.say(format_args!("{line}\n"));
    }
}

/// Saves and ends the edit (`%c`): the rest of the file follows, and the new file is complete.
fn end<'c>(hands: &mut impl EditHands<'c>) -> Result<(), Trouble> {
    let mut copied = Ok(true);
    while matches!(copied, Ok(true)) {
        hands.card_at_rest();
        copied = copy_on(hands);
        hands.wait(Wake::Any).whatever_happens();
    }
    let Some(editing) = hands.take_editing() else { return Ok(()) };
    let ports = hands.storage();
    ports.inbox(editing.from).set_text(false);
    editing.close(ports, copied.map(drop)).map_err(StorageError::text)
}

/// Writes the editor's text, and has the editor read on. False at the end of the file.
fn copy_on<'c>(hands: &mut impl EditHands<'c>) -> Result<bool, StorageError> {
    let (editing, ports) = hands.editing();
    let Some(editing) = editing else { return Ok(false) };
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
