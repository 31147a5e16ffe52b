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
    /// Takes whether the script before the job is to be run; asked once.
    pub fn take_before(&mut self) -> bool {
        core::mem::take(&mut self.before)
    }

    /// Takes whether the script behind the job is to be run; asked once.
    pub fn take_after(&mut self) -> bool {
        core::mem::take(&mut self.after)
    }
}
