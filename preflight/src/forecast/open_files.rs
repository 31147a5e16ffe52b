//! Files that the executor has open for a forecast.

use base::paths::Path;
use base::ports::{FileHandle, Storage};
use heapless::Vec;
use jobs::player::{FileLines, Lookup, MOST_CALLERS};
use units::Micros;

/// Files that a forecast reads, and its relation to the job.
#[derive(Debug, Default)]
pub struct ForecastFiles {
    /// Path of the file.
    pub path: Path,
    /// The file, while it is open.
    pub file: Option<FileHandle>,
    /// Size of the file, bytes.
    pub size: u32,
    /// Files that have called subroutines in files of their own.
    pub callers: Vec<FileLines, MOST_CALLERS>,
    /// Search for the file's dialect, while that goes on.
    pub lookup: Option<Lookup>,
    /// Number of the job that the forecast is for.
    pub job: u32,
    /// Number of findings told that stop the job.
    pub warned: u32,
    /// The job waits for the forecast's end.
    pub holds: bool,
    /// Reason why nothing of the job is to be made, found while it waited.
    pub spoilt: Option<&'static str>,
    /// Time at which the job began to wait.
    pub waits_since: Micros,
    /// Time at which the look's progress was told last.
    pub told_at: Micros,
    /// Number of the job's lines that have been made, and since when.
    pub made: (u32, Micros),
}

impl ForecastFiles {
    /// Whether a file is open.
    pub const fn is_open(&self) -> bool {
        self.file.is_some()
    }

    /// Closes the file and those that have called it.
    pub fn close(&mut self, storage: &mut impl Storage) {
        let callers = core::mem::take(&mut self.callers);
        for file in callers.iter().map(FileLines::file).chain(self.file.take()) {
            // The file was only read.
            let _ = storage.close(file);
        }
        self.lookup = None;
    }
}
