//! What the executor has open for a forecast.

use heapless::Vec;
use units::Micros;

use crate::files::Path;
use crate::jobs::{FileLines, Lookup, MOST_CALLERS};
use crate::ports::{FileHandle, Storage};

/// The files that a forecast reads, and what it is to the job.
#[derive(Debug, Default)]
pub(crate) struct Ahead {
    pub path: Path,
    pub file: Option<FileHandle>,
    pub size: u32,
    /// Files that have called subroutines in files of their own.
    pub callers: Vec<FileLines, MOST_CALLERS>,
    /// What it is written in is still looked for.
    pub lookup: Option<Lookup>,
    /// Which job it is for.
    pub job: u32,
    /// What stops the job has been said, so often.
    pub warned: u32,
    /// The job waits for its end.
    pub holds: bool,
    /// While it waited, a line was found with which nothing of the job is to be made: why.
    pub spoilt: Option<&'static str>,
    /// When the job began to wait, and when it was said last how far the look is.
    pub waits_since: Micros,
    pub told_at: Micros,
    /// Lines of the job that have been made, and since when.
    pub made: (u32, Micros),
}

impl Ahead {
    /// Something is open.
    pub const fn is_open(&self) -> bool {
        self.file.is_some()
    }

    pub fn close(&mut self, storage: &mut impl Storage) {
        let callers = core::mem::take(&mut self.callers);
        for file in callers.iter().map(FileLines::file).chain(self.file.take()) {
            // It was only read.
            let _ = storage.close(file);
        }
        self.lookup = None;
    }
}
