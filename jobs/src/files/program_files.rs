//! State that programs keep over a power cycle: their parameters in `parameters.var`, LinuxCNC's file of
//! parameters with a number and a value a line, and their tools in `tool.tbl`, its file of tools. A power cut
//! at any moment of writing leaves the old file or the new one.

use core::fmt::Write as _;

use base::ports::{FileHandle, OpenMode, Storage, StorageError};
use base::safe_file::{self, Draft, Replacing};
use gcode::{Gathered, LineBuffer};
use heapless::{String, Vec};
use program::{Interpreter, ToolEntry, ToolLineFlaw, ToolTable};

/// Path of the parameters' file.
pub const PARAMETERS: &str = "/sd/parameters.var";
/// Path of the tool table.
pub const TOOLS: &str = "/sd/tool.tbl";

/// Longest line of `tool.tbl` that is read, bytes; longer ones hold no tool.
const LINE: usize = 255;
/// Longest text of a tool, bytes: twelve words of at most 25 characters.
const TOOL_BYTES: usize = 300;
/// Bytes read at once: a block of the card.
const BLOCK: usize = 512;

/// Reads the parameters; returns the number of lines that are none.
///
/// # Errors
/// Errors of the card; a missing file is none.
pub fn load_parameters<S: Storage>(storage: &mut S, program: &mut Interpreter) -> Result<u32, StorageError> {
    let mut bad = 0;
    each_line(storage, PARAMETERS, |_, line| {
        let parameter = line.and_then(parse).map(|(number, value)| program.restore_parameter(number, value));
        let is_blank = line.is_some_and(|line| line.trim_ascii().is_empty());
        bad += u32::from(parameter != Some(true) && !is_blank);
    })?;
    Ok(bad)
}

fn parse(line: &[u8]) -> Option<(u16, f64)> {
    let mut words = core::str::from_utf8(line).ok()?.split_ascii_whitespace();
    let (number, value) = (words.next()?.parse().ok()?, gcode::read_f64(words.next()?)?);
    words.next().is_none().then_some((number, value))
}

/// Reads the tool table anew. Calls `flaw` for each line that holds no tool, with its number; `None` for one
/// that is too long or no text.
///
/// # Errors
/// Errors of the card; the table is as far then as it was read.
pub fn load_tools<S: Storage>(
    storage: &mut S,
    program: &mut Interpreter,
    mut flaw: impl FnMut(u32, Option<ToolLineFlaw>),
) -> Result<(), StorageError> {
    let table = program.tool_table();
    table.clear();
    each_line(storage, TOOLS, |number, line| {
        match line.and_then(|line| core::str::from_utf8(line).ok()).map(ToolEntry::read) {
            None => flaw(number, None),
            Some(None) => {}
            Some(Some(read)) => {
                if let Err(why) = read.and_then(|tool| table.add(tool)) {
                    flaw(number, Some(why));
                }
            }
        }
    })
}

/// Calls `take` for every line of a file with its number, from 1; none for one that is too long.
///
/// # Errors
/// Errors of the card.
pub fn each_line<S: Storage>(
    storage: &mut S,
    path: &str,
    mut take: impl FnMut(u32, Option<&[u8]>),
) -> Result<(), StorageError> {
    safe_file::settle(storage, path)?;
    let file = storage.open(path, OpenMode::Read)?;
    let (mut gathering, mut chunk, mut number) = (LineBuffer::new(), [0; BLOCK], 0);
    let mut take = |gathered: Gathered<'_>| {
        number += 1;
        take(number, if let Gathered::Line(line) = gathered { Some(line) } else { None });
    };
    let read = loop {
        match storage.read(file, &mut chunk) {
            Ok(0) => break Ok(()),
            Ok(count) => {
                for byte in chunk.get(..count).unwrap_or(&[]) {
                    if let Some(gathered) = gathering.push(*byte) {
                        take(gathered);
                    }
                }
            }
            Err(error) => break Err(error),
        }
    };
    if let Some(gathered) = gathering.finish() {
        take(gathered);
    }
    // A failing close loses nothing: the file was only read.
    let _ = storage.close(file);
    read
}

/// Progress of writing a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Progress {
    /// There is more to write: other work has a turn.
    More,
    /// The new file is in place.
    Done,
}

/// Writing of the parameters to the card.
#[derive(Debug)]
pub struct SavingParameters<S> {
    /// New content; none once it has become the file, or was given up.
    draft: Option<Draft<S>>,
    replacing: Option<Replacing>,
    place: usize,
}

impl<S: Storage> SavingParameters<S> {
    /// Begins to write the parameters.
    ///
    /// # Errors
    /// Errors of the card.
    pub fn begin(storage: &mut S) -> Result<Self, StorageError> {
        Ok(Self { draft: Some(Draft::begin(storage, PARAMETERS)?), replacing: None, place: 0 })
    }

    /// Writes the next parameter, or puts the file in place.
    ///
    /// # Errors
    /// Errors of the card; the file is the old one then.
    pub fn step(&mut self, storage: &mut S, program: &Interpreter) -> Result<Progress, StorageError> {
        let parameter = program.kept_parameter(self.place);
        self.place += 1;
        step((&mut self.draft, &mut self.replacing), storage, |draft, storage| {
            let Some((number, value)) = parameter else { return Ok(Progress::Done) };
            let mut line = String::<64>::new();
            writeln!(line, "{number}\t{value}").map_err(|_| StorageError::Full)?;
            draft.write(storage, line.as_bytes()).map(|_| Progress::More)
        })
    }
}

/// Writes more of a draft, and puts it in place at the end. After an error the draft is given up.
fn step<S: Storage>(
    (draft, replacing): (&mut Option<Draft<S>>, &mut Option<Replacing>),
    storage: &mut S,
    write: impl FnOnce(&mut Draft<S>, &mut S) -> Result<Progress, StorageError>,
) -> Result<Progress, StorageError> {
    if let Some(replacing) = replacing {
        return replacing.step(storage).map(|is_done| if is_done { Progress::Done } else { Progress::More });
    }
    let written = draft.as_mut().map_or(Ok(Progress::Done), |draft| write(draft, storage));
    let ended = match written {
        Ok(Progress::More) => return written,
        _ => draft.take(),
    };
    match (ended, written) {
        (Some(draft), Ok(_)) => {
            *replacing = Some(draft.close(storage)?);
            Ok(Progress::More)
        }
        (Some(draft), Err(error)) => {
            draft.give_up(storage);
            Err(error)
        }
        (None, written) => written,
    }
}

/// Writing of the tool table to the card: the file as it is, but for the lines of tools that have changed,
/// and behind it the new tools. Comments stay, and so do lines without a tool.
#[derive(Debug)]
pub struct SavingTools<S> {
    /// New content; none once it has become the file, or was given up.
    draft: Option<Draft<S>>,
    replacing: Option<Replacing>,
    rest: Rest,
}

/// Part of the tool table still to be written.
#[derive(Debug)]
struct Rest {
    /// Old file, while there is more of it.
    old: Option<FileHandle>,
    line: Vec<u8, LINE>,
    /// Whether the line has been too long for a tool, and so is copied.
    copies: bool,
    /// Tools still to be written, by their places in the table.
    left: u64,
}

impl<S: Storage> SavingTools<S> {
    /// Begins to write the tool table.
    ///
    /// # Errors
    /// Errors of the card.
    pub fn begin(storage: &mut S, program: &Interpreter) -> Result<Self, StorageError> {
        let draft = Draft::begin(storage, TOOLS)?;
        let old = match storage.open(TOOLS, OpenMode::Read) {
            Ok(file) => Some(file),
            Err(StorageError::NotFound) => None,
            Err(error) => {
                draft.give_up(storage);
                return Err(error);
            }
        };
        let left = program.tools().table().unsaved();
        Ok(Self { draft: Some(draft), replacing: None, rest: Rest { old, line: Vec::new(), copies: false, left } })
    }

    /// Writes a block more, or puts the file in place.
    ///
    /// # Errors
    /// Errors of the card; the file is the old one then.
    pub fn step(&mut self, storage: &mut S, program: &Interpreter) -> Result<Progress, StorageError> {
        let (rest, tools) = (&mut self.rest, program.tools().table());
        step((&mut self.draft, &mut self.replacing), storage, |draft, storage| {
            let advanced = rest.advance(draft, storage, tools);
            if let Some(file) = rest.old.take_if(|_| advanced.is_err()) {
                // Errors are ignored: the file was only read.
                let _ = storage.close(file);
            }
            advanced
        })
    }
}

impl Rest {
    fn advance<S: Storage>(
        &mut self,
        draft: &mut Draft<S>,
        storage: &mut S,
        tools: &ToolTable,
    ) -> Result<Progress, StorageError> {
        let Some(file) = self.old else {
            let place = self.left.trailing_zeros() as usize;
            let Some(tool) = tools.all().get(place) else { return Ok(Progress::Done) };
            self.left &= self.left - 1;
            return write_tool(draft, storage, tool, "").map(|()| Progress::More);
        };
        let mut chunk = [0; BLOCK];
        let count = storage.read(file, &mut chunk)?;
        for byte in chunk.get(..count).unwrap_or(&[]) {
            self.take(draft, storage, tools, *byte)?;
        }
        if count == 0 {
            if !self.line.is_empty() || self.copies {
                self.take(draft, storage, tools, b'\n')?;
            }
            self.old = None;
            // Errors are ignored: the file was only read.
            let _ = storage.close(file);
        }
        Ok(Progress::More)
    }

    fn take<S: Storage>(
        &mut self,
        draft: &mut Draft<S>,
        storage: &mut S,
        tools: &ToolTable,
        byte: u8,
    ) -> Result<(), StorageError> {
        let ends = byte == b'\n';
        if !ends && !self.copies && self.line.push(byte).is_ok() {
            return Ok(());
        }
        let line = core::mem::take(&mut self.line);
        if ends && !self.copies {
            return self.write_line(draft, storage, tools, &line);
        }
        // The line is too long for a tool.
        draft.write(storage, &line)?;
        self.copies = !ends;
        draft.write(storage, &[byte]).map(|_| ())
    }

    /// Writes a line of the file, or the new text of its tool.
    fn write_line<S: Storage>(
        &mut self,
        draft: &mut Draft<S>,
        storage: &mut S,
        tools: &ToolTable,
        line: &[u8],
    ) -> Result<(), StorageError> {
        let text = core::str::from_utf8(line).ok();
        let number = text.and_then(ToolEntry::read).and_then(Result::ok).map(|tool| tool.number);
        let place = number.and_then(|number| tools.place_of(number)).filter(|place| self.left & 1 << place != 0);
        let (Some(text), Some(place)) = (text, place) else {
            draft.write(storage, line)?;
            return draft.write(storage, b"\n").map(|_| ());
        };
        self.left &= !(1 << place);
        let comment = text.find(';').and_then(|begin| text.get(begin..)).unwrap_or("");
        tools.all().get(place).map_or(Ok(()), |tool| write_tool(draft, storage, tool, comment.trim_end()))
    }
}

fn write_tool<S: Storage>(
    draft: &mut Draft<S>,
    storage: &mut S,
    tool: &ToolEntry,
    comment: &str,
) -> Result<(), StorageError> {
    let mut line = String::<TOOL_BYTES>::new();
    write!(line, "{tool}").map_err(|_| StorageError::Full)?;
    for part in [line.as_str(), if comment.is_empty() { "" } else { " " }, comment, "\n"] {
        draft.write(storage, part.as_bytes())?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use base::bench::Card;
    use std::string::{String, ToString};
    use std::vec::Vec;

    fn program() -> Interpreter {
        Interpreter::new(program::Setup::default())
    }

    fn save_parameters(card: &mut Card, program: &Interpreter) -> Result<(), StorageError> {
        let mut saving = SavingParameters::begin(card)?;
        while saving.step(card, program)? == Progress::More {}
        Ok(())
    }

    fn save_tools(card: &mut Card, program: &Interpreter) -> Result<(), StorageError> {
        let mut saving = SavingTools::begin(card, program)?;
        while saving.step(card, program)? == Progress::More {}
        Ok(())
    }

    fn load(card: &mut Card) -> (Interpreter, Vec<(u32, bool)>) {
        let (mut program, mut flaws) = (program(), Vec::new());
        load_tools(card, &mut program, |line, why| flaws.push((line, why.is_some()))).unwrap();
        (program, flaws)
    }

    #[test]
    fn parameters_that_are_saved_are_there_again() {
        let keeping = || Interpreter::new(program::Setup { keeps_offsets: true, ..program::Setup::default() });
        let (mut card, mut before) = (Card::default(), keeping());
        for (number, value) in [(500, 1.5), (5161, -20.0), (600, 1e-9)] {
            assert!(before.restore_parameter(number, value), "{number}");
        }
        save_parameters(&mut card, &before).unwrap();
        let mut after = keeping();
        assert_eq!(load_parameters(&mut card, &mut after), Ok(0));
        let all = |program: &Interpreter| -> Vec<(u16, f64)> {
            (0..).map_while(|place| program.kept_parameter(place)).collect()
        };
        assert_eq!(all(&after), all(&before));
        assert!(all(&after).contains(&(5161, -20.0)) && card.open_files() == 0);
    }

    #[test]
    fn lines_that_are_no_parameters_are_counted_and_blank_ones_are_not() {
        let text = "500\t1.5\n\n  \n501 2 3\nx 1\n1 5\n502 nan\n5161\n503 4";
        let (mut card, mut program) = (Card::with(&[(PARAMETERS, text)]), program());
        assert_eq!(load_parameters(&mut card, &mut program), Ok(5));
        let kept: Vec<_> = (0..).map_while(|place| program.kept_parameter(place)).collect();
        assert!(kept.contains(&(500, 1.5)) && kept.contains(&(503, 4.0)), "{kept:?}");
    }

    #[test]
    fn a_line_that_holds_no_tool_is_told_by_its_number() {
        let long = "x".repeat(2_000);
        let text = std::format!("; tools\nT1 P1 Z10 ; a mill\nT0\n\nT2 Zlong\n{long}\nT1 Z5\nT3 Z7");
        let (program, flaws) = load(&mut Card::with(&[(TOOLS, &text)]));
        let numbers: Vec<u16> = program.tools().table().all().iter().map(|tool| tool.number).collect();
        assert_eq!(numbers, [1, 3]);
        assert_eq!(flaws, [(3, true), (5, true), (6, false), (7, true)]);
    }

    /// Sets tools as a program does, by G10 L1.
    fn set_tools(program: &mut Interpreter, lines: &[&str]) {
        for line in lines {
            let mut block = gcode::Block::new(None, 0);
            assert_eq!(gcode::Blocks::new(line.as_bytes()).read(&mut block, program), Ok(true));
            let row = program.row(&block, program::Dialect::Smoothie).expect("a code");
            let done = program.run(&block, row, program::Facts::default(), program::Dialect::Smoothie);
            assert!(done.is_ok(), "{line}: {done:?}");
        }
    }

    #[test]
    fn a_saved_table_keeps_its_comments_and_ends_with_new_tools() {
        let long = std::format!("; {}", "y".repeat(400));
        let text = std::format!("; my tools\nT1 P1 Z10 ; a mill\nno tool\n{long}\nT2 Z3");
        let mut card = Card::with(&[(TOOLS, &text)]);
        let (mut program, _) = load(&mut card);
        set_tools(&mut program, &["G10 L1 P1 Z11.5", "G10 L1 P5 Z2"]);
        save_tools(&mut card, &program).unwrap();
        let lines: Vec<String> = card.text(TOOLS).lines().map(ToString::to_string).collect();
        assert_eq!(lines.len(), 6, "{lines:?}");
        assert_eq!([&lines[0], &lines[2], &lines[3], &lines[4]], ["; my tools", "no tool", &long, "T2 Z3"]);
        assert!(lines[1].starts_with("T1 ") && lines[1].contains("Z11.5") && lines[1].ends_with(" ; a mill"));
        assert!(lines[5].starts_with("T5 ") && lines[5].contains("Z2"), "{}", lines[5]);
        assert_eq!(card.open_files(), 0);
    }

    #[test]
    fn a_table_is_made_where_there_was_none() {
        let (mut card, mut program) = (Card::default(), program());
        set_tools(&mut program, &["G10 L1 P7 Z1"]);
        save_tools(&mut card, &program).unwrap();
        let (read, flaws) = load(&mut card);
        assert!(flaws.is_empty());
        assert_eq!(read.tools().table().all()[0].number, 7);
    }

    #[test]
    fn a_card_that_fails_keeps_the_old_files_and_none_open() {
        let mut card = Card::with(&[(TOOLS, "T1 Z10\n"), (PARAMETERS, "500\t1\n")]);
        let (mut program, _) = load(&mut card);
        set_tools(&mut program, &["G10 L1 P1 Z20"]);
        card.is_full = true;
        assert_eq!(save_tools(&mut card, &program), Err(StorageError::Full));
        assert_eq!(save_parameters(&mut card, &program), Err(StorageError::Full));
        assert_eq!((card.text(TOOLS), card.text(PARAMETERS)), ("T1 Z10\n", "500\t1\n"));
        assert_eq!(card.open_files(), 0);
    }
}
