//! Files over consoles: M20, M21, M28, M29, M30, and the file commands of the shell.

use gcode::{Block, Line};
use heapless::{String, Vec};

use crate::console::Target;
use crate::controller::Controller;
use crate::failure::{Answer, Failure, Outcome};
use crate::ports::{DirectoryEntry, FileHandle, LIST_CHUNK, OpenMode, PATH_BYTES, Ports, StorageError};

/// An absolute path.
pub type Path = String<PATH_BYTES>;
/// Where the card is, and the directory that names start from at boot.
pub(crate) const CARD: &str = "/sd";

/// A file being uploaded (M28). Until its M29 nothing that its console sends is carried out, whatever became of the file.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Upload {
    /// The console it comes from.
    from: u8,
    /// None when it could not be opened, or was lost to a halt.
    file: Option<FileHandle>,
}

/// A name relative to a directory, made absolute. There is nothing but the card: `/x` is its file x, as `/sd/x` is. One that
/// does not fit becomes empty, which no file has.
fn absolute(directory: &str, name: &str) -> Path {
    let name = name.trim().trim_matches('"');
    let mut path = Path::new();
    let base = if name.starts_with('/') { "" } else { directory };
    for part in base.split('/').chain(name.split('/')) {
        let fits = match part {
            "" | "." => true,
            ".." => {
                let end = path.rfind('/').unwrap_or(0);
                path.truncate(end);
                true
            }
            part => {
                let is_card = !path.is_empty() || part.eq_ignore_ascii_case(CARD.trim_start_matches('/'));
                let on_card = is_card || path.push_str(CARD).is_ok();
                on_card && path.push('/').is_ok() && path.push_str(part).is_ok()
            }
        };
        if !fits {
            return Path::new();
        }
    }
    if path.is_empty() {
        // Three characters fit.
        let _ = path.push_str(CARD);
    }
    path
}

/// The words of a command, divided by blanks. What stands in quotes is one word: names may have blanks.
fn words(arguments: &str) -> impl Iterator<Item = &str> {
    let mut rest = arguments;
    core::iter::from_fn(move || {
        rest = rest.trim_ascii_start();
        let (word, behind) = match rest.strip_prefix('"') {
            Some(quoted) => quoted.split_once('"').unwrap_or((quoted, "")),
            None => rest.split_once([' ', '\t']).unwrap_or((rest, "")),
        };
        let is_word = !rest.is_empty();
        rest = behind;
        is_word.then_some(word)
    })
}

impl<P: Ports> Controller<P> {
    /// A name relative to the current directory, made absolute. One that does not fit becomes empty, which no file has.
    pub(crate) fn absolute(&self, name: &str) -> Path {
        absolute(&self.directory, name)
    }

    /// M20, M21, M23 to M29, M32.
    pub(crate) async fn file_code(&mut self, number: u16, block: &Block<'_>) -> Outcome {
        match number {
            20 if self.config.general.grbl_mode => Ok(Answer::Unknown),
            20 => {
                self.say(format_args!("Begin file list\n"));
                self.list("/sd", true).await?;
                self.say(format_args!("End file list\n"));
                Ok(Answer::Ok)
            }
            21 => {
                self.ports.mount().map_err(|error| Failure::refused(error.text()))?;
                self.say(format_args!("SD card ok\n"));
                Ok(Answer::Ok)
            }
            28 => self.begin_upload(block.text.unwrap_or("")),
            29 => Ok(Answer::Ok),
            22 => Ok(Answer::Unknown),
            _ => self.play_code(number, block.text),
        }
    }

    fn begin_upload(&mut self, name: &str) -> Outcome {
        let Target::Console(console) = self.target else {
            return Err(Failure::refused("only a console can upload a file"));
        };
        if self.upload.is_some() {
            return Err(Failure::refused("another file is being uploaded"));
        }
        let path = self.absolute(name);
        let file = if name.is_empty() { Err(StorageError::BadPath) } else { self.ports.open(&path, OpenMode::Write) };
        match file {
            Ok(_) => self.say(format_args!("Writing to file: {name}\n")),
            Err(error) => self.say(format_args!(
                "open failed, File: {name}.\n// WARNING {}: everything up to M29 is discarded\n",
                error.text()
            )),
        }
        self.upload = Some(Upload { from: console, file: file.ok() });
        Ok(Answer::Ok)
    }

    /// Whether what this console sends belongs to a file.
    pub(crate) fn uploads_from(&self, console: u8) -> bool {
        self.upload.is_some_and(|upload| upload.from == console)
    }

    /// The file is lost. Its sender does not know, and goes on sending what must not be carried out.
    pub(crate) fn spoil_upload(&mut self) {
        if let Some(file) = self.upload.as_mut().and_then(|upload| upload.file.take()) {
            // The upload is lost anyway; a failing close changes nothing.
            let _ = self.ports.close(file);
        }
    }

    /// A line while a file is being uploaded: stored as it is, until M29.
    pub(crate) fn upload_line(&mut self, line: &[u8], decoded: &Line<'_>) {
        let Some(Upload { file, .. }) = self.upload else { return };
        let ends = matches!(decoded, Line::Code(blocks) if blocks.clone().next().is_some_and(|block| {
            block.is_ok_and(|block| block.is(gcode::Code::m(29)) && block.is_bare())
        }));
        if ends {
            self.upload = None;
            match file.map(|file| self.ports.close(file)) {
                Some(Ok(())) => self.say(format_args!("Done saving file.\nok\n")),
                Some(Err(error)) => self.say(format_args!("Error:error writing to file: {}\nok\n", error.text())),
                None => self.say(format_args!("error:nothing was saved\nok\n")),
            }
            return;
        }
        let Some(file) = file else { return self.say(format_args!("ok\n")) };
        let written = self.ports.write(file, line).and_then(|()| self.ports.write(file, b"\n"));
        match written {
            Ok(()) => self.say(format_args!("ok\n")),
            Err(error) => self.say(format_args!("Error:error writing to file: {}\n", error.text())),
        }
    }

    pub(crate) fn remove_file(&mut self, name: &str) -> Outcome {
        let path = self.absolute(name);
        match self.ports.remove(&path) {
            Ok(()) => self.say(format_args!("deleted {name}\n")),
            Err(error) => self.say(format_args!("Could not delete {name}: {}\n", error.text())),
        }
        Ok(Answer::Ok)
    }

    /// `ls [-1] [path]`
    pub(crate) async fn list_command(&mut self, arguments: &str) {
        let names_only = words(arguments).any(|word| word == "-1");
        let place = words(arguments).find(|word| !word.starts_with('-')).unwrap_or("");
        let path = self.absolute(place);
        if let Err(Failure::Refused(why)) = self.list(&path, names_only).await {
            self.say(format_args!("Could not open directory {path} ({why})\n"));
        }
    }

    async fn list(&mut self, path: &str, names_only: bool) -> Result<(), Failure> {
        let mut entries: Vec<DirectoryEntry, LIST_CHUNK> = Vec::new();
        let (mut seen, mut files, mut directories, mut bytes) = (0, 0_u32, 0_u32, 0_u64);
        loop {
            entries.clear();
            self.ports.list(path, seen, &mut entries).map_err(|error| Failure::refused(error.text()))?;
            if entries.is_empty() {
                break;
            }
            seen += entries.len();
            for entry in &entries {
                let slash = if entry.is_directory { "/" } else { "" };
                if entry.is_directory {
                    directories += 1
                } else {
                    files += 1
                }
                bytes += u64::from(entry.size_bytes);
                if names_only {
                    self.say(format_args!("{}{slash}\n", entry.name));
                } else {
                    self.say(format_args!("{:>10}  {}{slash}\n", entry.size_bytes, entry.name));
                }
            }
            self.drain().await;
            if self.stop_requested() {
                return Ok(());
            }
        }
        if !names_only {
            self.say(format_args!("{files} file(s), {bytes} bytes total, {directories} dir(s)\n"));
        }
        Ok(())
    }

    /// `cat file [lines]`
    pub(crate) async fn cat_command(&mut self, arguments: &str) {
        let mut words = words(arguments);
        let path = self.absolute(words.next().unwrap_or(""));
        let mut lines = words.next().and_then(|word| word.parse::<u32>().ok()).unwrap_or(u32::MAX);
        if let Err(error) = self.cat(&path, &mut lines).await {
            self.say(format_args!("Could not read {path}: {}\n", error.text()));
        }
    }

    async fn cat(&mut self, path: &str, lines: &mut u32) -> Result<(), StorageError> {
        let file = self.ports.open(path, OpenMode::Read)?;
        let mut carried = 0;
        let mut chunk = [0; 128];
        let result = loop {
            let free = chunk.get_mut(carried..).unwrap_or(&mut []);
            let count = match self.ports.read(file, free) {
                Ok(count) => carried + count,
                Err(error) => break Err(error),
            };
            let bytes = chunk.get(..count).unwrap_or(&[]);
            // A character cut by the end of the piece goes with the next one; what is no text at all shows as dots.
            let text = match core::str::from_utf8(bytes) {
                Ok(text) => text,
                Err(error) => core::str::from_utf8(bytes.get(..error.valid_up_to()).unwrap_or(&[])).unwrap_or(""),
            };
            for line in text.split_inclusive('\n').take(*lines as usize) {
                self.say(format_args!("{line}"));
                *lines = lines.saturating_sub(u32::from(line.ends_with('\n')));
            }
            let shown = text.len();
            if count == carried || *lines == 0 || self.stop_requested() {
                break Ok(());
            }
            carried = count - shown;
            if carried >= 4 {
                self.say(format_args!("."));
                carried -= 1;
                chunk.copy_within(shown + 1..count, 0);
            } else {
                chunk.copy_within(shown..count, 0);
            }
            self.drain().await;
        };
        self.ports.close(file)?;
        result
    }

    /// `rm a b ...`
    pub(crate) fn remove_command(&mut self, arguments: &str) {
        for name in words(arguments) {
            // It says itself whether it worked.
            let _ = self.remove_file(name);
        }
    }

    /// `mv from to`, `mkdir name`, `cd name`
    pub(crate) fn directory_command(&mut self, command: &str, arguments: &str) {
        let mut words = words(arguments);
        let first = match words.next() {
            None if command == "cd" => self.absolute("/"),
            name => self.absolute(name.unwrap_or("")),
        };
        let done = match command {
            "mv" => {
                let to = self.absolute(words.next().unwrap_or(""));
                self.ports.rename(&first, &to)
            }
            "mkdir" => self.ports.make_directory(&first),
            _ => self.change_directory(first.clone()),
        };
        if let Err(error) = done {
            self.say(format_args!("error:{command}: {first}: {}\n", error.text()));
        }
    }

    fn change_directory(&mut self, path: Path) -> Result<(), StorageError> {
        self.ports.list(&path, 0, &mut Vec::new())?;
        self.directory = path;
        Ok(())
    }

    /// Ctrl-Y on the console whose command is running.
    pub(crate) fn stop_requested(&mut self) -> bool {
        match self.target {
            crate::console::Target::Console(console) => {
                self.consoles.get_mut(console).is_some_and(|console| core::mem::take(&mut console.stop_requested))
            }
            _ => false,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quotes_hold_a_name_together() {
        let of = |text| words(text).collect::<std::vec::Vec<_>>();
        assert_eq!(of(" a.g  \"with space.g\" b.g "), ["a.g", "with space.g", "b.g"]);
        assert_eq!(of("\"never closed.g"), ["never closed.g"]);
        assert_eq!(of("\"\" x"), ["", "x"]);
        assert!(of("  ").is_empty());
    }

    #[test]
    fn every_path_is_on_the_card() {
        for (directory, name, expected) in [
            ("/sd", "x.g", "/sd/x.g"),
            ("/sd", "/x.g", "/sd/x.g"),
            ("/sd", "/sd/x.g", "/sd/x.g"),
            ("/sd", "/SD/x.g", "/SD/x.g"),
            ("/sd", "", "/sd"),
            ("/sd", "/", "/sd"),
            ("/sd", "..", "/sd"),
            ("/sd/parts", "../x.g", "/sd/x.g"),
            ("/sd/parts", "../../../x.g", "/sd/x.g"),
            ("/sd", "\"with space.g\"", "/sd/with space.g"),
            ("/sd", "sd/x.g", "/sd/sd/x.g"),
        ] {
            assert_eq!(absolute(directory, name), expected, "{name} in {directory}");
        }
        assert_eq!(absolute("/sd", &"x".repeat(PATH_BYTES - 4)).len(), PATH_BYTES);
        assert_eq!(absolute("/sd", &"x".repeat(PATH_BYTES - 3)), "", "cut, it would be another file's name");
    }
}
