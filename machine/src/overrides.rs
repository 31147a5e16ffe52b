//! M500 to M504: settings changed at run time, kept as G-code in `/sd/config-override`.

use core::fmt::Write as _;

use drivers::fat::{is_legal_name, stripped};
use gcode::{Block, Gathered, Letter, Line, LineBuffer};

use crate::console::Target;
use crate::controller::Controller;
use crate::failure::{Answer, Failure, Outcome, about_file};
use crate::files::{CARD, Path};
use crate::overrides_text::PARTS;
use crate::ports::{FileHandle, OpenMode, Ports, StorageError};
use crate::safe_file::{self, Draft};
use crate::wait::yield_once;

/// Where saved settings are.
pub const OVERRIDE_PATH: &str = "/sd/config-override";
/// Bytes read at a time.
const CHUNK: usize = 128;

/// What the controller knows of saved settings.
#[derive(Debug, Default)]
pub struct Overrides {
    loading: Option<Loading>,
    /// A file was loaded since boot.
    loaded: bool,
}

/// A file of settings that is being replayed.
#[derive(Debug)]
struct Loading {
    file: FileHandle,
    path: Path,
    /// Who asked, and hears of the end.
    asked: Target,
    /// The program counts in inches; the file never does.
    inches: bool,
}

impl Overrides {
    /// Whether a file waits to be replayed.
    pub(crate) const fn is_loading(&self) -> bool {
        self.loading.is_some()
    }
}

impl<P: Ports> Controller<P> {
    /// M500 and M504 save, M502 deletes what was saved, M503 shows what M500 would save, M501 replays.
    pub(crate) async fn override_code(&mut self, number: u16, block: &Block<'_>) -> Outcome {
        match number {
            500 => self.save_command(None).await,
            504 => self.save_command(block.text).await,
            502 => self.forget_settings(),
            503 => self.show_settings().await,
            _ => {
                let path = override_path(block.text)?;
                match self.begin_load(&path) {
                    Ok(()) => Ok(Answer::Said),
                    Err(error) => {
                        self.say(format_args!("failed to load configuration override {path}: {}\n", error.text()));
                        Ok(Answer::Ok)
                    }
                }
            }
        }
    }

    async fn save_command(&mut self, name: Option<&str>) -> Outcome {
        let path = override_path(name)?;
        self.save_settings(&path).await.map_err(|error| failed(&path, error))?;
        if path == OVERRIDE_PATH && !self.config.general.config_override {
            self.say(format_args!("WARNING: override will NOT be loaded on boot\n"));
        }
        self.say(format_args!("Settings Stored to {path}\n"));
        Ok(Answer::Ok)
    }

    /// Whatever moment the power goes, the file is the old one or the new one.
    async fn save_settings(&mut self, path: &str) -> Result<(), StorageError> {
        let mut draft = Draft::begin(&mut self.ports, path)?;
        for part in 0..PARTS {
            let written = match self.override_part(part) {
                Ok(text) => draft.write(&mut self.ports, text.as_bytes()),
                Err(_) => Err(StorageError::Full),
            };
            if let Err(error) = written {
                draft.give_up(&mut self.ports);
                return Err(error);
            }
            self.serve();
            yield_once().await;
        }
        draft.finish(&mut self.ports)
    }

    fn forget_settings(&mut self) -> Outcome {
        safe_file::remove(&mut self.ports, OVERRIDE_PATH).map_err(|error| failed(OVERRIDE_PATH, error))?;
        self.say(format_args!("{OVERRIDE_PATH} deleted\n"));
        Ok(Answer::Ok)
    }

    async fn show_settings(&mut self) -> Outcome {
        let loaded = if self.overrides.loaded { "config override loaded" } else { "No config override loaded" };
        self.say(format_args!("// NOTE: {loaded}\n"));
        for part in 0..PARTS {
            let text = self.override_part(part).map_err(|_| Failure::refused("the settings are too many to show"))?;
            self.say(format_args!("{text}"));
            self.drain().await;
        }
        Ok(Answer::Ok)
    }

    /// Saved settings are replayed once the machine listens. There need not be any.
    pub(crate) async fn load_at_boot(&mut self) {
        if !self.config.general.config_override {
            return;
        }
        match self.begin_load(OVERRIDE_PATH) {
            Ok(()) | Err(StorageError::NotFound) => {}
            Err(error) => self.say(format_args!("ERROR: {OVERRIDE_PATH}: {}\n", error.text())),
        }
    }

    /// Opens a file of settings; the main loop replays it before it does anything else.
    pub(crate) fn begin_load(&mut self, path: &str) -> Result<(), StorageError> {
        safe_file::settle(&mut self.ports, path)?;
        let file = self.ports.open(path, OpenMode::Read)?;
        let path = Path::try_from(path).unwrap_or_default();
        let (asked, inches) = (self.target, core::mem::take(&mut self.modal.inches));
        self.overrides.loading = Some(Loading { file, path, asked, inches });
        Ok(())
    }

    /// Replays the whole file, if one is to be.
    pub(crate) async fn replay_settings(&mut self) {
        let Some(loading) = self.overrides.loading.take() else { return };
        // Replies of single lines would only confuse who waits for one `ok`.
        self.target = Target::Nobody;
        let replayed = self.replay(loading.file).await;
        // It was only read: a failing close loses nothing.
        let _ = self.ports.close(loading.file);
        self.modal.inches = loading.inches;
        self.target = loading.asked;
        let path = loading.path;
        match replayed {
            Ok(()) => {
                self.overrides.loaded = true;
                self.say(format_args!("configuration override {path} loaded\n"));
            }
            Err(why) => self.say(format_args!("failed to load configuration override {path}: {why}\n")),
        }
        if self.target != Target::All {
            self.say(format_args!("ok\n"));
        }
        self.drain().await;
    }

    async fn replay(&mut self, file: FileHandle) -> Result<(), &'static str> {
        let (mut gathering, mut chunk) = (LineBuffer::new(), [0; CHUNK]);
        loop {
            let count = self.ports.read(file, &mut chunk).map_err(StorageError::text)?;
            for byte in chunk.get(..count).unwrap_or(&[]) {
                match gathering.push(*byte) {
                    Some(Gathered::Line(line)) => {
                        let line = crate::console::LineBytes::from_slice(line).unwrap_or_default();
                        self.replay_line(&line).await?;
                    }
                    Some(Gathered::TooLong) => return Err("a line is too long"),
                    None => {}
                }
            }
            if count == 0 {
                break;
            }
            self.serve();
            yield_once().await;
        }
        if let Some(Gathered::Line(line)) = gathering.finish() {
            let line = crate::console::LineBytes::from_slice(line).unwrap_or_default();
            self.replay_line(&line).await?;
        }
        Ok(())
    }

    /// One saved line. What cannot be done is said, and the rest goes on.
    async fn replay_line(&mut self, line: &[u8]) -> Result<(), &'static str> {
        let text = core::str::from_utf8(line).unwrap_or("(not text)");
        let blocks = match gcode::Decoder::new().decode(line) {
            Ok(Line::Code(blocks)) => blocks,
            Ok(Line::Blank) => return Ok(()),
            _ => {
                self.announce(format_args!("// WARNING: not a saved setting, left out: {text}\n"));
                return Ok(());
            }
        };
        for block in blocks {
            let Ok(block) = block else {
                self.announce(format_args!("// WARNING: not a saved setting, left out: {text}\n"));
                return Ok(());
            };
            // A file that saves or loads settings would never end.
            if block.code.is_some_and(|code| code.letter != Letter::T && (500..=504).contains(&code.number)) {
                continue;
            }
            match self.run_block(&block).await {
                Ok(Answer::Unknown) => {
                    self.announce(format_args!("// WARNING: nobody knows the saved setting: {text}\n"));
                }
                Ok(_) => {}
                Err(Failure::Refused(why)) => self.announce(format_args!("// WARNING: {why}: {text}\n")),
                Err(Failure::Alarm(why)) => {
                    self.alarm(&why);
                    return Err("the machine is halted");
                }
                Err(Failure::Halted) => return Err("the machine is halted"),
            }
        }
        Ok(())
    }
}

fn failed(path: &str, error: StorageError) -> Failure {
    Failure::Refused(about_file(path, error.text()))
}

/// `/sd/config-override`, or `/sd/config-override.abc` for a set of settings with a name.
fn override_path(set: Option<&str>) -> Result<Path, Failure> {
    let set = set.map_or("", str::trim);
    // Periods at the end do not count in a name: with them, one set would be another.
    if !set.is_empty() && (!is_legal_name(set) || stripped(set) != set) {
        return Err(Failure::refused("a set of settings cannot have this name: no file can"));
    }
    let mut path = Path::new();
    let point = if set.is_empty() { "" } else { "." };
    write!(path, "{OVERRIDE_PATH}{point}{set}").map_err(|_| failed(CARD, StorageError::BadPath))?;
    Ok(path)
}
