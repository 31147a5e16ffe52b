//! `config-get`, `config-set`, `load`: the configuration file over a console. Changes take effect at the next reset.

use config::edit::{Edit, Editor, Ending, Verdict, check_edit};
use heapless::Vec;

use crate::boot::CONFIG_PATH;
use crate::controller::Controller;
use crate::failure::{Answer, Failure, about_file};
use crate::ports::{FileHandle, OpenMode, Ports, StorageError};
use crate::safe_file::Draft;
use crate::wait::yield_once;

const CHUNK: usize = 512;
/// Settings are shorter than this; what a line has more is comment.
const LINE: usize = 320;

/// A text file, line by line.
struct Lines {
    file: FileHandle,
    chunk: Vec<u8, CHUNK>,
    next: usize,
}

/// What was put into the buffer.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Piece {
    /// The rest of a line, without its end.
    Line,
    /// As much as fits; the line goes on.
    Part,
    /// The rest of the file, which has no line end.
    Last,
}

impl Lines {
    const fn new(file: FileHandle) -> Self {
        Self { file, chunk: Vec::new(), next: 0 }
    }

    fn next<P: Ports>(&mut self, ports: &mut P, line: &mut Vec<u8, LINE>) -> Result<Piece, StorageError> {
        line.clear();
        loop {
            while let Some(byte) = self.chunk.get(self.next).copied() {
                if byte == b'\n' {
                    self.next += 1;
                    return Ok(Piece::Line);
                }
                if line.push(byte).is_err() {
                    return Ok(Piece::Part);
                }
                self.next += 1;
            }
            let mut bytes = [0; CHUNK];
            let count = ports.read(self.file, &mut bytes)?;
            if count == 0 {
                return Ok(Piece::Last);
            }
            self.next = 0;
            self.chunk.clear();
            // A chunk fits a chunk.
            let _ = self.chunk.extend_from_slice(bytes.get(..count).unwrap_or(&[]));
        }
    }
}

impl<P: Ports> Controller<P> {
    /// `config-get`, `config-set`, `load`, `config-load`
    pub(crate) async fn settings_command(&mut self, command: &str, arguments: &str) -> Result<Option<Answer>, Failure> {
        match command {
            "config-get" => {
                let (section, _) = quoted(arguments);
                self.config_get(section).await.map_err(failed)?;
            }
            "config-set" => self.config_set(arguments).await?,
            _ => {
                let path = self.absolute(arguments);
                if let Err(error) = self.begin_load(&path) {
                    return Err(Failure::Refused(about_file(&path, error.text())));
                }
            }
        }
        Ok(Some(Answer::Said))
    }

    async fn config_get(&mut self, section: &str) -> Result<(), StorageError> {
        let file = self.ports.open(CONFIG_PATH, OpenMode::Read)?;
        let shown = self.show_section(file, section).await;
        self.ports.close(file)?;
        shown
    }

    async fn show_section(&mut self, file: FileHandle, section: &str) -> Result<(), StorageError> {
        let (mut lines, mut line, mut inside, mut starts) = (Lines::new(file), Vec::new(), false, true);
        loop {
            let piece = lines.next(&mut self.ports, &mut line)?;
            let text = core::str::from_utf8(&line).unwrap_or("");
            let content = text.split_once('#').map_or(text, |(content, _)| content).trim();
            if let Some(header) = content.strip_prefix('[').filter(|_| starts) {
                inside = header.split_once(']').is_some_and(|(name, _)| name == section);
            } else if let Some((key, value)) = content.split_once('=').filter(|_| inside && starts) {
                self.say(format_args!("{} = {}\n", key.trim(), value.trim()));
                self.drain().await;
            }
            starts = piece == Piece::Line;
            if piece == Piece::Last {
                return Ok(());
            }
        }
    }

    /// `config-set "section" key [=] value`; without a value the line goes.
    async fn config_set(&mut self, arguments: &str) -> Result<(), Failure> {
        let (section, rest) = quoted(arguments);
        let (key, value) = rest.split_once([' ', '\t', '=']).unwrap_or((rest, ""));
        let value = value.trim_start_matches([' ', '\t']).trim_start_matches('=').trim();
        if section.is_empty() || key.is_empty() || value.contains('#') {
            return Err(Failure::refused("write config-set \"section\" key value; a value has no #"));
        }
        let edit = Edit { section, key, value: (!value.is_empty()).then_some(value) };
        if let Err(why) = check_edit(&edit) {
            self.say(format_args!("error:{why}\n"));
            return Ok(());
        }
        self.change_config(edit).await.map_err(failed)?;
        match edit.value {
            Some(value) => self.say(format_args!("set config: [{section}] {key} = {value}\n")),
            None => self.say(format_args!("deleted config: [{section}] {key}\n")),
        }
        Ok(())
    }

    /// Keeps the old file as `previous-config.ini`, and replaces it such that no power cut loses both.
    async fn change_config(&mut self, edit: Edit<'_>) -> Result<(), StorageError> {
        let mut draft = Draft::begin(&mut self.ports, CONFIG_PATH)?;
        match self.edited_into(&mut draft, edit).await {
            Ok(()) => draft.finish(&mut self.ports),
            Err(error) => {
                draft.give_up(&mut self.ports);
                Err(error)
            }
        }
    }

    async fn edited_into(&mut self, draft: &mut Draft<P>, edit: Edit<'_>) -> Result<(), StorageError> {
        let file = self.ports.open(CONFIG_PATH, OpenMode::Read)?;
        let edited = self.edit_into(file, draft, edit).await;
        edited.and(self.ports.close(file))
    }

    async fn edit_into(&mut self, file: FileHandle, draft: &mut Draft<P>, edit: Edit<'_>) -> Result<(), StorageError> {
        let (mut lines, mut line, mut editor) = (Lines::new(file), Vec::<u8, LINE>::new(), Editor::new(edit));
        let (mut starts, mut verdict) = (true, Verdict::Keep);
        let mut ends_line = true;
        loop {
            let piece = lines.next(&mut self.ports, &mut line)?;
            let end: &[u8] = if piece == Piece::Line { b"\n" } else { b"" };
            if starts {
                // What is not text is no line of ours to change.
                let text = core::str::from_utf8(&line).unwrap_or("");
                verdict = editor.line(text.trim_end_matches('\r'));
                match verdict {
                    Verdict::Replace(comment) => {
                        self.put_setting(draft, edit)?;
                        for part in [if comment.is_empty() { "" } else { "  " }, comment] {
                            draft.write(&mut self.ports, part.as_bytes())?;
                        }
                    }
                    Verdict::Precede => {
                        self.put_setting(draft, edit)?;
                        draft.write(&mut self.ports, b"\n\n")?;
                    }
                    Verdict::Keep | Verdict::Delete => {}
                }
            }
            let goes = verdict == Verdict::Delete;
            let is_written = starts && matches!(verdict, Verdict::Replace(_));
            let rest: &[u8] = if goes || is_written { b"" } else { &line };
            let end: &[u8] = if goes { b"" } else { end };
            if !rest.is_empty() || !end.is_empty() || is_written {
                ends_line = !end.is_empty();
            }
            let block_written = draft.write(&mut self.ports, rest)? | draft.write(&mut self.ports, end)?;
            // The comment has been written; a verdict must not outlive the buffer it points into.
            verdict = if goes { Verdict::Delete } else { Verdict::Keep };
            starts = piece == Piece::Line;
            if piece == Piece::Last {
                break;
            }
            if block_written {
                self.serve();
                yield_once().await;
            }
        }
        self.append(draft, editor.end(), edit, ends_line)
    }

    fn append(
        &mut self,
        draft: &mut Draft<P>,
        ending: Ending,
        edit: Edit<'_>,
        ends_line: bool,
    ) -> Result<(), StorageError> {
        if ending == Ending::Nothing {
            return Ok(());
        }
        let header = ["\n[", edit.section, "]\n"];
        let section = header.into_iter().filter(|_| ending == Ending::Section);
        for text in (!ends_line).then_some("\n").into_iter().chain(section) {
            draft.write(&mut self.ports, text.as_bytes())?;
        }
        self.put_setting(draft, edit)?;
        draft.write(&mut self.ports, b"\n").map(drop)
    }

    fn put_setting(&mut self, draft: &mut Draft<P>, edit: Edit<'_>) -> Result<(), StorageError> {
        for text in [edit.key, " = ", edit.value.unwrap_or("")] {
            draft.write(&mut self.ports, text.as_bytes())?;
        }
        Ok(())
    }
}

fn failed(error: StorageError) -> Failure {
    Failure::Refused(about_file(CONFIG_PATH, error.text()))
}

/// `"motion control" rest` or `planner rest`.
fn quoted(text: &str) -> (&str, &str) {
    let text = text.trim();
    let split = match text.strip_prefix('"') {
        Some(rest) => rest.split_once('"'),
        None => text.split_once([' ', '\t']),
    };
    let (first, rest) = split.unwrap_or((text, ""));
    (first, rest.trim())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_section_with_a_blank_is_quoted() {
        assert_eq!(quoted("\"motion control\" max_speed = 3"), ("motion control", "max_speed = 3"));
        assert_eq!(quoted("planner planner_queue_size 64"), ("planner", "planner_queue_size 64"));
        assert_eq!(quoted("  player "), ("player", ""));
    }
}
