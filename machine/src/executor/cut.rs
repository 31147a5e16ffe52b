//! How far leaving out moves that are planned has come, and when it has to wait.

/// Of moves that are planned and are to be left out.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Cut {
    /// The machine brakes on their way, or stands on it, because of it.
    pub brakes: bool,
    /// The moves of a line wait for room behind them, one after the other: where they begin must stay.
    pub has_line_behind: bool,
}
