//! Progress of dropping planned moves, and its reasons to wait.

/// State of dropping planned moves that are to be left out.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Cut {
    /// The machine brakes on the moves to drop, or stands on them, because of the drop.
    pub brakes: bool,
    /// Moves of one line wait one after the other for room behind the dropped ones: their starting point must
    /// stay.
    pub has_line_behind: bool,
}
