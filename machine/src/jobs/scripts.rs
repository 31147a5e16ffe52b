//! The scripts of the configuration around a job: which of them are still to be run.

/// Scripts that are still to be run.
#[derive(Clone, Copy, Debug)]
pub struct Scripts {
    before: bool,
    after: bool,
}

impl Default for Scripts {
    /// Returns all scripts as still to be run.
    fn default() -> Self {
        Self { before: true, after: true }
    }
}

impl Scripts {
    /// Whether the one before the job is to be run; asked once.
    pub fn take_before(&mut self) -> bool {
        core::mem::take(&mut self.before)
    }

    /// Whether the one behind it is to be run; asked once.
    pub fn take_after(&mut self) -> bool {
        core::mem::take(&mut self.after)
    }
}
