//! Files that programs write: `(LOGOPEN, name)` and `(LOG, text)`, `(PROBEOPEN name)`.
//!
//! Lines gather in a block, and a full one goes to the card at once, as a block of an upload does. An
//! incomplete block is written when the file is closed, by the program or at its end.

use base::paths::{CARD, Path};
use base::ports::{FileHandle, OpenMode, Storage, StorageError};
use heapless::Vec;

/// Bytes written at once: a block of the card.
const BLOCK: usize = 512;
/// Longest line of a log, bytes.
const LONGEST_LINE: usize = 257;
/// Greatest length of a file, bytes: an endless loop must not fill the card.
const MOST_BYTES: u32 = 64 << 20;
/// Files of the machine itself, which no program may write, and the beginnings of their companions' names.
const OWN: [&str; 9] = [
    "config.ini",
    "config-override",
    "parameters.var",
    "tool.tbl",
    "grbl-settings",
    "firmware.bin",
    "flashme.bin",
    "netpass",
    "netkeys",
];
const COMPANIONS: [&str; 3] = ["draft-", "new-", "previous-"];

/// Reason why a line was not written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LogFlaw {
    /// No file can have this name, or the machine needs it.
    OwnFile,
    /// The file is as long as it may become.
    TooLong,
    /// The card refuses to write.
    Card(StorageError),
}

impl LogFlaw {
    /// Returns the reason in words.
    #[must_use]
    pub const fn text(self) -> &'static str {
        match self {
            Self::OwnFile => "this file is the machine's own",
            Self::TooLong => "it has reached 64 MiB",
            Self::Card(error) => error.text(),
        }
    }
}

impl From<StorageError> for LogFlaw {
    fn from(error: StorageError) -> Self {
        Self::Card(error)
    }
}

/// File that a program writes.
#[derive(Debug, Default)]
pub struct Log {
    file: Option<FileHandle>,
    block: Vec<u8, BLOCK>,
    /// Length of the file including the block, bytes.
    length: u32,
}

fn is_own(path: &str) -> bool {
    let Some(name) = path.strip_prefix(CARD).and_then(|name| name.strip_prefix('/')) else { return true };
    let starts = |name: &str, with: &str| name.get(..with.len()).is_some_and(|start| start.eq_ignore_ascii_case(with));
    let name =
        COMPANIONS.iter().find(|with| starts(name, with)).and_then(|with| name.get(with.len()..)).unwrap_or(name);
    // Named sets of settings have a period behind the name.
    OWN.iter().any(|own| starts(name, own) && matches!(name.as_bytes().get(own.len()), None | Some(b'.')))
}

impl Log {
    /// Returns whether a file is open.
    #[must_use]
    pub const fn is_open(&self) -> bool {
        self.file.is_some()
    }

    /// Returns whether the next line may fill the block.
    fn is_nearly_full(&self) -> bool {
        self.is_open() && self.block.len() + LONGEST_LINE > BLOCK
    }

    /// Opens a file, and empties it unless lines are to be added. The former file is closed.
    ///
    /// # Errors
    /// When no program may write this file, or the card refuses.
    pub fn open(&mut self, path: &Path, appends: bool, storage: &mut impl Storage) -> Result<(), LogFlaw> {
        self.close(storage)?;
        if is_own(path) {
            return Err(LogFlaw::OwnFile);
        }
        let file = storage.open(path, if appends { OpenMode::Append } else { OpenMode::Write })?;
        self.length = storage.size(file).unwrap_or_default();
        self.file = Some(file);
        Ok(())
    }

    /// Writes a line. Without a file there is nothing to do, as in LinuxCNC. After an error the file is
    /// closed.
    ///
    /// # Errors
    /// When the card refuses, or the file is too long.
    pub fn write_line(&mut self, line: &str, storage: &mut impl Storage) -> Result<(), LogFlaw> {
        let Some(file) = self.file else { return Ok(()) };
        let written = self.write(file, line, storage);
        if written.is_err() {
            // The first error is the one to report.
            let _ = self.close(storage);
        }
        written
    }

    fn write(&mut self, file: FileHandle, line: &str, storage: &mut impl Storage) -> Result<(), LogFlaw> {
        self.length = self.length.saturating_add(line.len() as u32 + 1);
        if self.length > MOST_BYTES {
            return Err(LogFlaw::TooLong);
        }
        for byte in line.bytes().chain([b'\n']) {
            if self.block.push(byte).is_err() {
                let block = core::mem::take(&mut self.block);
                storage.write(file, &block)?;
                // An empty block has room.
                let _ = self.block.push(byte);
            }
        }
        Ok(())
    }

    /// Writes the rest of the block, and closes the file.
    ///
    /// # Errors
    /// When the card refuses; the file is closed all the same.
    pub fn close(&mut self, storage: &mut impl Storage) -> Result<(), LogFlaw> {
        let Some(file) = self.file.take() else { return Ok(()) };
        let block = core::mem::take(&mut self.block);
        let written = if block.is_empty() { Ok(()) } else { storage.write(file, &block) };
        written.and(storage.close(file)).map_err(LogFlaw::Card)
    }
}

/// Files that a program has open.
#[derive(Debug, Default)]
pub struct Logs {
    /// File of `(LOG, ...)` lines.
    pub text: Log,
    /// File with a line for each contact that G38 finds.
    pub contacts: Log,
}

impl Logs {
    /// Returns whether the next line may bring a block to the card.
    #[must_use]
    pub fn are_nearly_full(&self) -> bool {
        self.text.is_nearly_full() || self.contacts.is_nearly_full()
    }

    /// Closes both files at the end of the program.
    ///
    /// # Errors
    /// When the card refuses; both files are closed all the same.
    pub fn close(&mut self, storage: &mut impl Storage) -> Result<(), LogFlaw> {
        let text = self.text.close(storage);
        self.contacts.close(storage).and(text)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use base::bench::Card;
    use base::paths::absolute;
    use std::string::String;

    #[test]
    fn files_of_the_machine_itself_are_no_program_s() {
        for own in
            ["/sd/config.ini", "/sd/CONFIG-override", "/sd/config-override.mine", "/sd/new-tool.tbl", "/ram/x", ""]
        {
            assert!(is_own(own), "{own}");
        }
        for other in ["/sd/a.txt", "/sd/logs/config.ini", "/sd/config.ini-old", "/sd/new-part.txt"] {
            assert!(!is_own(other), "{other}");
        }
    }

    #[test]
    fn a_log_holds_its_lines_in_order_when_it_is_closed() {
        let mut card = Card::with(&[("/sd/a.txt", "before\n")]);
        for (appends, beginning) in [(true, "before\n"), (false, "")] {
            let mut log = Log::default();
            log.open(&absolute("/sd", "a.txt"), appends, &mut card).unwrap();
            assert!(log.is_open());
            let lines: std::vec::Vec<String> = (0..200).map(|line| format!("X{line} Y{}", 2 * line)).collect();
            lines.iter().for_each(|line| log.write_line(line, &mut card).unwrap());
            log.close(&mut card).unwrap();
            let text: String = lines.iter().map(|line| format!("{line}\n")).collect();
            assert_eq!((card.text("/sd/a.txt"), card.open_files()), (format!("{beginning}{text}").as_str(), 0));
            card.put("/sd/a.txt", b"before\n");
        }
    }

    #[test]
    fn a_card_that_refuses_closes_the_log_and_lines_without_a_log_are_nothing() {
        let mut card = Card::default();
        let mut log = Log::default();
        assert!(log.write_line("x", &mut card).is_ok() && !log.is_open());
        log.open(&absolute("/sd", "a.txt"), false, &mut card).unwrap();
        card.is_full = true;
        let refused = (0..200).find(|_| log.write_line("0123456789", &mut card).is_err());
        assert!(refused.is_some_and(|line| line > 40), "a block is gathered first: {refused:?}");
        assert_eq!((log.is_open(), card.open_files()), (false, 0));
    }
}
