//! Jobs: files played from the card.
//!
//! A job gives one line at a time, between the lines of sessions; a full look-ahead queue holds it back.
//!
//! A line that cannot be carried out pauses the file: later lines count on it, and a tool that goes on from
//! the wrong place breaks what it meets. Nothing is lost: `M24` goes on with the next line.

mod commands;
mod flavour;
mod heater_hours;
mod ignored_codes;
mod layers;
pub mod line_numbers;
mod lines;
mod objects;
mod outline;
mod pauses;
mod progress;
mod queue;
mod scripts;
mod starter;
mod statistics;
mod suspended;
mod tags;
mod tower;
mod view;

use base::failure::{Failure, Texts};
use base::paths::Path;
use base::ports::{Clock, OpenMode, Storage, StorageError};
use base::secrets::open_to_show;
use base::sessions::{LineBytes, Recipient, Reply, Rights, SessionId};
use config::{Command, MachineConfig};
use heapless::Vec;
use motion::Tag;
use program::{Dialect, Place};
use units::Micros;

use base::slicer::SlicerTimes;
pub use flavour::of_text;
pub use flavour::{Lookup, Step};
pub use ignored_codes::{Name, Noted};
pub use layers::Layers;
pub use lines::Next;
pub use lines::{FileLines, MOST_CALLERS, TOO_DEEP, is_comment, sub_path};
use objects::Objects;
pub use objects::{By, ObjectShown};
use pauses::{Pauses, Reached};
pub use pauses::{Place as PausePlace, parse as parse_pause};
pub use progress::{Planned, TimeLeft};
use queue::Queue;
pub use scripts::Scripts;
pub use starter::Starter;
pub use statistics::{Duration, HeaterTime, PATH as STATISTICS_PATH, Statistics, Sums};
pub use suspended::{StalledJob, Suspended};
use tags::Tags;
pub use tower::Tower;

const PRINTING: &str = "Currently printing, abort print first";

/// A file that is open to be played.
#[derive(Debug)]
struct Job {
    path: Path,
    size: u32,
    /// Date of writing, as the directory has it.
    written: u32,
    lines: FileLines,
    started: Micros,
    starter: Starter,
    paused: bool,
    /// The job is paused until the operator has done something (M0, M6).
    waits_for_operator: bool,
    /// The line that was read last is a comment.
    in_comment: bool,
    /// Scripts around the job that have not been run: before it, and behind it.
    scripts: Scripts,
    /// A line with a `%` has begun the program.
    has_begun: bool,
    /// No line of the file has been read.
    is_new: bool,
    /// The job begins whatever a look at its file says.
    is_forced: bool,
    /// The card does not answer: the job goes on from `here` once it does.
    is_lost: bool,
    /// Place at which the line read last begins.
    here: Place,
    /// Files that have called subroutines in files of their own, and wait for their ends.
    callers: Vec<FileLines, MOST_CALLERS>,
    layers: Layers,
    /// Times that the slicer has stated.
    slicer: SlicerTimes,
    /// Search for the file's dialect, while that goes on.
    lookup: Option<Lookup>,
    noted: Noted,
}

/// The job, and the state for resuming a suspended one.
#[derive(Debug, Default)]
pub struct Jobs {
    job: Option<Job>,
    /// Objects of the file, or of a host's lines.
    pub objects: Objects,
    /// Places at which the job is to pause.
    pub pauses: Pauses,
    /// Setting that changes with the height.
    pub tower: Option<Tower>,
    /// Files that are played next.
    pub queue: Queue,
    /// Totals over all jobs.
    pub statistics: Statistics,
    suspended: Option<Suspended>,
    /// Number of jobs since boot.
    opened: u32,
    tags: Tags,
    /// Tag for the moves of the line begun last.
    tag: Tag,
    /// Line that the motors make, and the offset of its end; `None` while they rest.
    place: Option<(u32, u32)>,
    /// The job's line waits for a temperature.
    is_heating: bool,
    boot_file_is_due: bool,
    /// Dialect of the file; `None`: the one that the machine is configured for.
    dialect: Option<Dialect>,
    /// Dialect of every file; `None`: the one that the file states.
    forced: Option<Dialect>,
}

impl Jobs {
    /// Makes the state without a job. Every file is in the `forced` dialect, whatever it says.
    #[must_use]
    pub fn new(forced: Option<Dialect>) -> Self {
        Self { forced, ..Self::default() }
    }

    /// Whether a file is being played and not paused.
    #[must_use]
    pub fn is_playing(&self) -> bool {
        self.job.as_ref().is_some_and(|job| !job.paused)
    }

    /// Returns the recipient of the job's lines and of the answers to them.
    #[must_use]
    pub fn echo(&self) -> Recipient {
        self.job.as_ref().map_or(Recipient::Nobody, |job| job.starter.echo)
    }

    /// Returns the recipient of the message at the job's end.
    #[must_use]
    pub fn tells_end(&self) -> Recipient {
        self.job.as_ref().map_or(Recipient::Nobody, |job| job.starter.tells_end)
    }

    /// Returns the rights of the job's lines; all without a job.
    #[must_use]
    pub fn rights(&self) -> Rights {
        self.job.as_ref().map_or(Rights::Own, |job| job.starter.rights)
    }

    /// Lowers the rights of the job's lines to those of somebody who adds to them.
    pub fn lower_rights(&mut self, rights: Rights) {
        if let Some(job) = &mut self.job {
            job.starter.rights = job.starter.rights.min(rights);
        }
    }

    /// Sets whether the job's line waits for a temperature.
    pub const fn set_heating(&mut self, is_heating: bool) {
        self.is_heating = is_heating;
    }

    /// Pauses or goes on; false when there is no job.
    pub fn set_paused(&mut self, paused: bool) -> bool {
        let Some(job) = &mut self.job else { return false };
        (job.paused, job.waits_for_operator) = (paused, false);
        true
    }

    /// Pauses the job until the operator has done something.
    pub const fn wait_for_operator(&mut self) {
        if let Some(job) = &mut self.job {
            (job.paused, job.waits_for_operator) = (true, true);
        }
    }

    /// Whether the job is paused until the operator has done something.
    #[must_use]
    pub fn waits_for_operator(&self) -> bool {
        self.job.as_ref().is_some_and(|job| job.waits_for_operator)
    }

    /// Whether a file is open to be played, paused or not.
    #[must_use]
    pub const fn is_open(&self) -> bool {
        self.job.is_some()
    }

    /// Goes on with a job that waited for the operator. False when it did not wait.
    pub const fn operator_is_done(&mut self) -> bool {
        let Some(job) = &mut self.job else { return false };
        let waited = job.waits_for_operator;
        if waited {
            (job.paused, job.waits_for_operator) = (false, false);
        }
        waited
    }

    /// Forgets a listener that has gone: the next visitor of its session has not asked for this job.
    pub fn session_ended(&mut self, session: SessionId) {
        let Some(job) = &mut self.job else { return };
        for listener in [&mut job.starter.echo, &mut job.starter.tells_end] {
            if *listener == Recipient::Session(session) {
                *listener = Recipient::Nobody;
            }
        }
    }

    // --- opening and closing ---

    /// Opens a file to be played from its beginning, and returns its size in bytes.
    ///
    /// # Errors
    /// While another one is open, or when it cannot be read.
    pub fn open(
        &mut self,
        texts: &Texts,
        path: &str,
        starter: Starter,
        storage: &mut impl Storage,
        now: Micros,
    ) -> Result<u32, Failure> {
        if self.job.is_some() {
            return Err(Failure::refused(&PRINTING));
        }
        let failed = |error: StorageError| texts.about_file(path, error.text());
        let file = open_to_show(storage, path, OpenMode::Read).map_err(failed)?;
        let size = storage.size(file).map_err(|error| {
            // The file is of no use: a failing close changes nothing.
            let _ = storage.close(file);
            failed(error)
        })?;
        let path = Path::try_from(path).unwrap_or_default();
        // Without a date the file's size and its contents are all there is to go by.
        let written = crate::journal::written(&path, storage).unwrap_or(0);
        self.job = Some(Job {
            path,
            size,
            written,
            lines: FileLines::played(file, storage),
            started: now,
            starter,
            paused: false,
            waits_for_operator: false,
            in_comment: false,
            scripts: Scripts::default(),
            has_begun: false,
            is_new: true,
            is_forced: false,
            is_lost: false,
            here: Place::default(),
            callers: Vec::new(),
            layers: Layers::default(),
            slicer: SlicerTimes::default(),
            lookup: self.forced.is_none().then(|| Lookup::new(size)),
            noted: Noted::default(),
        });
        self.opened = self.opened.wrapping_add(1);
        self.dialect = self.forced;
        self.objects = Objects::default();
        self.is_heating = false;
        self.forget_places();
        Ok(size)
    }

    /// Forgets tags: moves submitted so far are no progress of the lines that come now.
    const fn forget_places(&mut self) {
        self.place = None;
        self.tags.forget();
        self.tag = Tag::NONE;
    }

    /// Closes the file being played; false when there is none.
    pub fn close(&mut self, storage: &mut impl Storage) -> bool {
        let Some(job) = self.job.take() else { return false };
        self.pauses.clear();
        self.tower = None;
        for lines in job.callers.iter().chain([&job.lines]) {
            // The file was only read: a failing close loses nothing.
            let _ = storage.close(lines.file());
        }
        true
    }

    /// Has the boot file, if there is to be one, played once the machine listens.
    pub fn queue_boot_file(&mut self, config: &MachineConfig) {
        self.boot_file_is_due = config.player.on_boot_gcode_enable && !config.player.on_boot_gcode.is_empty();
    }

    /// Opens the boot file when it is due.
    pub fn open_boot_file(&mut self, texts: &Texts, config: &MachineConfig, ports: &mut (impl Storage + Clock)) {
        if self.job.is_none() && core::mem::take(&mut self.boot_file_is_due) {
            let now = ports.now();
            // There need not be such a file.
            let _ = self.open(texts, &config.player.on_boot_gcode, Starter::default(), ports, now);
        }
    }

    /// Whether nothing of the file has been read, once.
    #[inline]
    pub fn take_new(&mut self) -> bool {
        self.job.as_mut().is_some_and(|job| core::mem::take(&mut job.is_new))
    }

    // --- its dialect ---

    /// Returns the dialect of the file; `None`: the one that the machine is configured for.
    #[must_use]
    pub const fn dialect(&self) -> Option<Dialect> {
        self.dialect
    }

    /// Reads the file in this dialect, whatever it says.
    pub fn read_as(&mut self, dialect: Dialect) {
        if let Some(job) = &mut self.job {
            (self.dialect, job.lookup) = (Some(dialect), None);
        }
    }

    // --- its lines ---

    /// Returns the scripts around the job that are still to be run.
    pub fn scripts(&mut self) -> Option<&mut Scripts> {
        self.job.as_mut().map(|job| &mut job.scripts)
    }

    /// Returns the notes about the job.
    pub fn noted(&mut self) -> Option<&mut Noted> {
        self.job.as_mut().map(|job| &mut job.noted)
    }

    /// Reads the next line of the file. After the end it returns `End` again and again, until
    /// [`Self::close`].
    pub fn next_line(&mut self, storage: &mut impl Storage, line: &mut LineBytes) -> Next {
        let Some(job) = &mut self.job else { return Next::End };
        if job.lookup.is_some() {
            let next = flavour::look(&mut job.lookup, &mut self.dialect, &mut job.slicer, &mut job.lines, storage);
            if let Next::Failed(_) = next {
                (job.is_lost, job.paused) = (true, true);
            }
            return next;
        }
        job.here = job.lines.place();
        let next = job.lines.next(storage, line);
        if let Next::Failed(_) = next {
            (job.is_lost, job.paused) = (true, true);
        }
        job.in_comment = matches!(next, Next::Line) && is_comment(line);
        if job.in_comment && line.trim_ascii_start().first() == Some(&b'%') {
            // The first `%` begins the program, the second ends it (NIST RS-274/NGC, 3.3).
            if core::mem::replace(&mut job.has_begun, true) {
                job.lines.end();
            }
        }
        if matches!(next, Next::Line) && matches!(line.first(), Some(b';' | b'S' | b's' | b' ' | b'M')) {
            marked(job, line);
        }
        next
    }

    /// Returns the layer of the line that was read last, and the number of layers.
    #[must_use]
    pub fn layers(&self) -> Layers {
        self.job.as_ref().map(|job| job.layers).unwrap_or_default()
    }

    /// Returns the tower's command before the line just read, which is read again afterwards.
    pub fn take_tower(&mut self, text: &[u8], height: f64, storage: &mut impl Storage) -> Option<Command> {
        let job = self.job.as_mut().filter(|job| !job.in_comment)?;
        let command = self.tower.as_mut()?.command_before(text, height)?;
        job.lines.go_to(job.here, storage).is_ok().then_some(command)
    }

    /// Returns the place at which the job is to pause before the line just read, and the command for that.
    /// The line is read again afterwards.
    pub fn take_pause(
        &mut self,
        text: &[u8],
        height: f64,
        storage: &mut impl Storage,
    ) -> Option<(PausePlace, Command)> {
        let due = self.pass_pause(text, height)?;
        let job = self.job.as_mut()?;
        job.lines.go_to(job.here, storage).is_ok().then_some(due)
    }

    /// Takes a pause out where the line is only read over: nobody pauses there, and not later either.
    pub fn pass_pause(&mut self, text: &[u8], height: f64) -> Option<(PausePlace, Command)> {
        let job = self.job.as_ref()?;
        // Lines are counted in the job's own file.
        if self.pauses.is_empty() || job.in_comment || !job.callers.is_empty() {
            return None;
        }
        let reached = Reached { layer: job.layers.current, line: job.lines.number(), height, text };
        self.pauses.take(&reached)
    }

    /// Begins the line just read, and returns the tag for its moves.
    pub fn begin_line(&mut self) -> Tag {
        // A comment makes no move, and needs no tag: comments come by hundreds, and tags are few.
        if let Some(job) = self.job.as_ref().filter(|job| !job.in_comment) {
            self.tag = self.tags.begin_line(job.lines.number(), job.lines.read());
        }
        self.tag
    }

    /// Pauses at the line just read, which cannot be carried out, unless it has ended the job already.
    pub fn pause_at_this_line(&mut self, why: &str, reply: &mut Reply<'_>) {
        let Some(job) = &mut self.job else { return };
        job.paused = true;
        let (number, path) = (job.lines.number(), &job.path);
        reply.say(format_args!(
            "error:paused, line {number} of {path} {why}: M24 goes on with the next line, abort ends the job\n"
        ));
    }

    // --- subroutines and loops ---

    /// Returns the number of the line that was read last, from 1; 0 without a job.
    #[must_use]
    pub fn line(&self) -> u32 {
        self.job.as_ref().map_or(0, |job| job.lines.number())
    }

    /// Returns the places at which the line read last and the next line begin.
    #[must_use]
    pub fn places(&self) -> (Place, Place) {
        self.job.as_ref().map_or_else(Default::default, |job| (job.here, job.lines.place()))
    }

    /// Goes on from a place of the file that is read.
    ///
    /// # Errors
    /// When the card does not answer.
    pub fn go_to(&mut self, place: Place, storage: &mut impl Storage) -> Result<(), StorageError> {
        self.job.as_mut().map_or(Ok(()), |job| job.lines.go_to(place, storage))
    }

    /// Goes on with the file of a subroutine, which stands beside the job's own file: `name.ngc`. False when
    /// there is none.
    ///
    /// # Errors
    /// When files call each other too deep.
    pub fn call_file(&mut self, name: &str, storage: &mut impl Storage) -> Result<bool, Failure> {
        let Some(job) = &mut self.job else { return Ok(false) };
        let folder = job.path.rfind('/').and_then(|end| job.path.get(..end)).unwrap_or_default();
        let Ok(file) = storage.open(&sub_path(folder, name), OpenMode::Read) else { return Ok(false) };
        if job.callers.is_full() {
            // The file was only opened: a failing close loses nothing.
            let _ = storage.close(file);
            return Err(Failure::refused(&TOO_DEEP));
        }
        let caller = core::mem::replace(&mut job.lines, FileLines::played(file, storage));
        let _there_is_room = job.callers.push(caller);
        Ok(true)
    }

    /// Goes on with the file that called the subroutine that has ended. False when none did.
    pub fn return_from_file(&mut self, storage: &mut impl Storage) -> bool {
        let Some(job) = &mut self.job else { return false };
        let Some(caller) = job.callers.pop() else { return false };
        storage.read_ahead(caller.file());
        let done = core::mem::replace(&mut job.lines, caller);
        // The file was only read: a failing close loses nothing.
        let _ = storage.close(done.file());
        true
    }

    fn return_all(&mut self, storage: &mut impl Storage) {
        while self.return_from_file(storage) {}
    }

    /// Ends the program: nothing more is read.
    pub fn end_program(&mut self, storage: &mut impl Storage) {
        self.return_all(storage);
        if let Some(job) = &mut self.job {
            job.lines.end();
        }
    }
}

/// Follows a line that may tell the job's progress: seldom.
#[cold]
fn marked(job: &mut Job, line: &[u8]) {
    job.layers.read(line);
    job.slicer.read(line);
}

#[cfg(test)]
mod tests;
