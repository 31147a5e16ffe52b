//! Requests to end the line in work, kept until it has ended: `abort`, M524, M410, M108 and pauses.
//! `executor/out_of_turn.rs` makes them, and brings the work to its end.

use base::sessions::SessionId;
use program::{Action, Function, Sequence};

/// Extent of the work in progress that a request ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Ends {
    /// The line in work and everything it has started.
    Everything,
    /// A wait of the job for heat or a dwell, which is read again when the job resumes.
    Wait,
}

/// Sender of a line that comes before all others.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Requester {
    /// A session, by its number.
    Session(SessionId),
    /// An input switch, a button or the filament detector.
    Input,
}

/// The requests that are still to be carried out.
#[derive(Debug, Default)]
pub(crate) struct Asked {
    /// Requester whose line comes before all others, and the extent of the work that the line ends.
    pub asked: Option<(Requester, Ends)>,
    pub ends: Option<Ends>,
    /// The line in work belongs to the job and is nothing but a wait: a pause may leave it.
    may_be_left: bool,
    /// A line of a session waits for the operator (M0).
    pub awaits_operator: bool,
    /// M108 has come since a wait began.
    wait_is_over: bool,
}

impl Asked {
    /// Whether the line in work and all it has started must end.
    pub const fn ends_everything(&self) -> bool {
        matches!(self.ends, Some(Ends::Everything))
    }

    /// Whether the line in work must end, or leave its wait.
    pub const fn ends(&self) -> bool {
        self.ends.is_some()
    }

    /// Returns the requester whose line comes before all others.
    pub fn first(&self) -> Option<Requester> {
        self.asked.map(|(id, _)| id)
    }

    /// Begins a block of the job's line; `is_whole`: the block is the only one of the line.
    pub const fn begin_line(&mut self, is_whole: bool) {
        self.may_be_left = is_whole;
    }

    /// Notes that the block has been interpreted as this action.
    pub const fn means(&mut self, action: &Action<'_>) {
        self.may_be_left &= matches!(
            action,
            Action::HeatAndWait { .. }
                | Action::Dwell(_)
                | Action::Function(Function::Sequence(Sequence::WaitForHeaters), _)
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

    /// Begins a wait that M108 ends.
    pub const fn begin_wait(&mut self) {
        self.wait_is_over = false;
    }

    /// Ends the wait in progress (M108).
    pub const fn end_wait(&mut self) {
        self.wait_is_over = true;
    }

    /// Whether M108 has come since the wait began.
    pub const fn wait_is_over(&self) -> bool {
        self.wait_is_over
    }
}
