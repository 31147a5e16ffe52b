//! What has been asked for that does not wait for the line in work: see [`super::urgent`].

use program::{Action, Function};

use crate::sessions::SessionId;

/// What ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Ends {
    /// Whatever is in work, and what it has started.
    Everything,
    /// A wait that begins anew when the job goes on.
    Wait,
}

/// What has been asked for.
#[derive(Debug, Default)]
pub(super) struct Asked {
    /// The line of this session comes before all others, and what it ends.
    pub asked: Option<(SessionId, Ends)>,
    pub ends: Option<Ends>,
    /// What is in work is a wait, and the whole line of the job.
    may_be_left: bool,
    /// A line of a session waits for the operator (M0).
    pub awaits_operator: bool,
    /// M108 has come since a wait began.
    wait_is_over: bool,
}

impl Asked {
    /// What is in work ends, all of it.
    pub const fn ends_everything(&self) -> bool {
        matches!(self.ends, Some(Ends::Everything))
    }

    /// What is in work ends, or is left.
    pub const fn ends(&self) -> bool {
        self.ends.is_some()
    }

    /// Whose line comes before all others.
    pub fn first(&self) -> Option<SessionId> {
        self.asked.map(|(id, _)| id)
    }

    /// A block of the job's line begins, which is the whole line.
    pub const fn begin_line(&mut self, is_whole: bool) {
        self.may_be_left = is_whole;
    }

    /// It has turned out to mean this.
    pub const fn means(&mut self, action: &Action<'_>) {
        self.may_be_left &= matches!(
            action,
            Action::HeatAndWait { .. } | Action::Dwell(_) | Action::Function(Function::WaitForHeaters, _)
        );
    }

    /// Whether the wait in work is left now, for a pause.
    pub fn leaves_wait(&mut self) -> bool {
        let leaves = self.may_be_left && matches!(self.asked, Some((_, Ends::Wait)));
        if leaves {
            self.ends = Some(Ends::Wait);
        }
        leaves
    }

    /// A wait begins that M108 ends.
    pub const fn begin_wait(&mut self) {
        self.wait_is_over = false;
    }

    /// M108.
    pub const fn end_wait(&mut self) {
        self.wait_is_over = true;
    }

    /// Whether M108 has come since then.
    pub const fn wait_is_over(&self) -> bool {
        self.wait_is_over
    }
}
