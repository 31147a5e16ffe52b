//! `config-set`: changes one setting of the configuration file, with effect from the next reset.

use base::failure::Failure;
use base::hands::Hands;
use base::paths::{CONFIG_PATH, quoted};
use base::ports::{FileHandle, OpenMode, Storage, StorageError, Wake};
use base::safe_file::Draft;
use config::edit::{Edit, Editor, Ending, Verdict, check_edit};
use heapless::Vec;

/// Number of bytes read at a time.
const CHUNK: usize = 512;
/// Longest setting, bytes; the rest of a longer line is comment.
const LINE: usize = 320;
/// Longest character of UTF-8, bytes.
const CHARACTER: usize = 4;

/// Reader of a text file, line by line.
struct Lines {
    file: FileHandle,
    chunk: Vec<u8, CHUNK>,
    next: usize,
}

/// Part of the file that was put into the buffer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Piece {
    /// Rest of a line, without its end.
    Line,
    /// As many characters as fit; the line goes on.
    Part,
    /// Rest of the file, which has no line end.
    Last,
}

impl Lines {
    const fn new(file: FileHandle) -> Self {
        Self { file, chunk: Vec::new(), next: 0 }
    }

    fn next(&mut self, storage: &mut impl Storage, line: &mut Vec<u8, LINE>) -> Result<Piece, StorageError> {
        line.clear();
        loop {
            while let Some(byte) = self.chunk.get(self.next).copied() {
                if byte == b'\n' {
                    self.next += 1;
                    return Ok(Piece::Line);
                }
                // A part ends at the end of a character.
                let begins_character = byte & 0b1100_0000 != 0b1000_0000;
                let is_part = begins_character && line.len() > LINE - CHARACTER;
                if is_part || line.push(byte).is_err() {
                    return Ok(Piece::Part);
                }
                self.next += 1;
            }
            let mut bytes = [0; CHUNK];
            let count = storage.read(self.file, &mut bytes)?;
            if count == 0 {
                return Ok(Piece::Last);
            }
            self.next = 0;
            self.chunk.clear();
            // The buffer is as long as a chunk, so it fits.
            let _ = self.chunk.extend_from_slice(bytes.get(..count).unwrap_or(&[]));
        }
    }
}

/// `config-set [--check] "section" key [=] value`: changes or adds a setting; without a value deletes its
/// line. `--check` only says what is wrong with the change.
///
/// # Errors
/// When the command cannot be understood, or the file cannot be written; the file is as it was.
pub fn config_set<'c>(hands: &mut impl Hands<'c>, arguments: &str) -> Result<(), Failure> {
    let checked = arguments.trim_start().strip_prefix("--check ");
    let (section, rest) = quoted(checked.unwrap_or(arguments));
    let (key, value) = rest.split_once([' ', '\t', '=']).unwrap_or((rest, ""));
    let value = value.trim_start_matches([' ', '\t']).trim_start_matches('=').trim();
    if section.is_empty() || key.is_empty() {
        hands.say(format_args!("Usage: config-set section key [value]\n"));
        return Ok(());
    }
    if value.contains('#') {
        return Err(Failure::refused(&"a value has no #: what follows it is a comment"));
    }
    let edit = Edit { section, key, value: (!value.is_empty()).then_some(value) };
    if let Err(why) = check_edit(&edit) {
        hands.say(format_args!("error:{why}\n"));
        return Ok(());
    }
    if checked.is_some() {
        return Ok(());
    }
    let changed = change_config(hands, edit);
    changed.map_err(|error| hands.texts().about_file(CONFIG_PATH, error.text()))?;
    match edit.value {
        Some(value) => hands.say(format_args!("set config: [{section}] {key} = {value}\n")),
        None => hands.say(format_args!("deleted config: [{section}] {key}\n")),
    }
    Ok(())
}

/// Keeps the old file as `previous-config.ini`, and replaces it such that no power cut loses both.
fn change_config<'c>(hands: &mut impl Hands<'c>, edit: Edit<'_>) -> Result<(), StorageError> {
    let mut rewrite = Rewrite::begin(hands.storage(), edit)?;
    loop {
        hands.card_at_rest();
        match rewrite.go_on(hands.storage()) {
            Ok(true) => hands.wait(Wake::Any).whatever_happens(),
            Ok(false) => {
                let draft = rewrite.end(hands.storage())?;
                return hands.put_in_place(draft);
            }
            Err(error) => {
                rewrite.give_up(hands.storage());
                return Err(error);
            }
        }
    }
}

/// Rewriting of the file, from the old one to the new one.
struct Rewrite<'e, S> {
    edit: Edit<'e>,
    editor: Editor<'e>,
    lines: Lines,
    draft: Draft<S>,
    /// Whether the next text begins a line.
    starts: bool,
    /// Whether the line whose part was read last is deleted.
    deletes: bool,
    /// Whether the last written text ends a line.
    ends_line: bool,
}

impl<'e, S: Storage> Rewrite<'e, S> {
    fn begin(storage: &mut S, edit: Edit<'e>) -> Result<Self, StorageError> {
        let draft = Draft::begin(storage, CONFIG_PATH)?;
        let file = match storage.open(CONFIG_PATH, OpenMode::Read) {
            Ok(file) => file,
            Err(error) => {
                draft.give_up(storage);
                return Err(error);
            }
        };
        let (editor, lines) = (Editor::new(edit), Lines::new(file));
        Ok(Self { edit, editor, lines, draft, starts: true, deletes: false, ends_line: true })
    }

    /// Copies lines until a block has been written, so that others have a turn. False when the end has been
    /// reached.
    fn go_on(&mut self, storage: &mut S) -> Result<bool, StorageError> {
        let mut line = Vec::new();
        loop {
            let piece = self.lines.next(storage, &mut line)?;
            let block_written = self.take_over(storage, &line, piece == Piece::Line)?;
            self.starts = piece == Piece::Line;
            if piece == Piece::Last {
                self.append(storage)?;
                return Ok(false);
            }
            if block_written {
                return Ok(true);
            }
        }
    }

    /// Writes the new form of a piece of a line; true when a block went to the card.
    fn take_over(&mut self, storage: &mut S, line: &[u8], ended: bool) -> Result<bool, StorageError> {
        let mut is_replaced = false;
        let mut written = false;
        if self.starts {
            // Bytes that are not text are no line that can be changed.
            let text = core::str::from_utf8(line).unwrap_or("");
            let verdict = self.editor.line(text.trim_end_matches('\r'));
            self.deletes = verdict == Verdict::Delete;
            match verdict {
                Verdict::Replace(comment) => {
                    is_replaced = true;
                    written |= self.put_setting(storage)?;
                    for part in [if comment.is_empty() { "" } else { "  " }, comment] {
                        written |= self.draft.write(storage, part.as_bytes())?;
                    }
                }
                Verdict::Precede => {
                    written |= self.put_setting(storage)?;
                    written |= self.draft.write(storage, b"\n\n")?;
                }
                Verdict::Keep | Verdict::Delete => {}
            }
        }
        let rest: &[u8] = if self.deletes || is_replaced { b"" } else { line };
        let end: &[u8] = if ended && !self.deletes { b"\n" } else { b"" };
        if !rest.is_empty() || !end.is_empty() || is_replaced {
            self.ends_line = !end.is_empty();
        }
        written |= self.draft.write(storage, rest)?;
        written |= self.draft.write(storage, end)?;
        Ok(written)
    }

    /// Writes the setting, and its section if needed, at the end when the file did not have it.
    fn append(&mut self, storage: &mut S) -> Result<(), StorageError> {
        let ending = self.editor.end();
        if ending == Ending::Nothing {
            return Ok(());
        }
        let header = ["\n[", self.edit.section, "]\n"];
        let section = header.into_iter().filter(|_| ending == Ending::Section);
        for text in (!self.ends_line).then_some("\n").into_iter().chain(section) {
            self.draft.write(storage, text.as_bytes())?;
        }
        self.put_setting(storage)?;
        self.draft.write(storage, b"\n").map(drop)
    }

    fn put_setting(&mut self, storage: &mut S) -> Result<bool, StorageError> {
        let mut written = false;
        for text in [self.edit.key, " = ", self.edit.value.unwrap_or("")] {
            written |= self.draft.write(storage, text.as_bytes())?;
        }
        Ok(written)
    }

    /// Closes the old file and returns the complete new one.
    fn end(self, storage: &mut S) -> Result<Draft<S>, StorageError> {
        if let Err(error) = storage.close(self.lines.file) {
            self.draft.give_up(storage);
            return Err(error);
        }
        Ok(self.draft)
    }

    fn give_up(self, storage: &mut S) {
        // A failing close loses nothing: the file was only read.
        let _ = storage.close(self.lines.file);
        self.draft.give_up(storage);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use base::bench::Card;

    fn edited(config: &str, section: &str, key: &str, value: Option<&str>) -> String {
        let mut card = Card::with(&[(CONFIG_PATH, config)]);
        let mut rewrite = Rewrite::begin(&mut card, Edit { section, key, value }).unwrap();
        while rewrite.go_on(&mut card).unwrap() {}
        rewrite.end(&mut card).and_then(|draft| draft.finish(&mut card)).unwrap();
        assert_eq!(card.open_files(), 0);
        assert_eq!(card.text("/sd/previous-config.ini"), config);
        card.text(CONFIG_PATH).to_owned()
    }

    #[test]
    fn one_line_changes_and_nothing_else() {
        let config = "[one]\na = 1 # first\nb = 2\r\n[two]\na = 3";
        assert_eq!(edited(config, "one", "a", Some("9")), "[one]\na = 9  # first\nb = 2\r\n[two]\na = 3");
        assert_eq!(edited(config, "one", "b", None), "[one]\na = 1 # first\n[two]\na = 3");
        assert_eq!(edited(config, "two", "b", Some("4")), format!("{config}\nb = 4\n"));
        assert_eq!(edited(config, "three", "b", Some("4")), format!("{config}\n\n[three]\nb = 4\n"));
        assert_eq!(edited(config, "one", "c", Some("5")), config.replace("[two]", "c = 5\n\n[two]"));
    }

    #[test]
    fn a_long_comment_stays_whole_wherever_the_buffer_cuts_it() {
        for length in 290..330 {
            let comment = format!("# {}\u{20ac}\u{1f600}{}", "x".repeat(length), "\u{e4}".repeat(400));
            let config = format!("[one]\na = 1 {comment}\nb = 2\n");
            assert_eq!(edited(&config, "one", "a", Some("1")), format!("[one]\na = 1  {comment}\nb = 2\n"), "{length}");
            assert_eq!(edited(&config, "one", "a", None), "[one]\nb = 2\n", "{length}");
            assert_eq!(edited(&config, "one", "b", Some("3")), config.replace("b = 2", "b = 3"), "{length}");
        }
    }

    #[test]
    fn what_cannot_be_read_stays_as_it_was() {
        let mut card = Card::with(&[(CONFIG_PATH, "[one]\na = 1\n")]);
        let mut rewrite = Rewrite::begin(&mut card, Edit { section: "one", key: "a", value: None }).unwrap();
        card.fails = true;
        assert_eq!(rewrite.go_on(&mut card), Err(StorageError::Device));
        rewrite.give_up(&mut card);
        assert_eq!((card.text(CONFIG_PATH), card.open_files()), ("[one]\na = 1\n", 0));
    }
}
