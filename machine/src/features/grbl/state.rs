//! State of GRBL's dialect, and what it accepts.

use base::sessions::MAX_SESSIONS;
use gcode::{Code, Letter};

use super::last_report;
use crate::machine::moments::StartupLine;

/// Answer to `$` alone.
pub const HELP: &str = "[HLP:$$ $# $G $I $N $x=val $Nx=line $J=line $SLP $C $X $H ~ ! ? ctrl-x]\n";

/// Number of startup lines (`$N0`, `$N1`).
pub(crate) const STARTUP_LINES: usize = 2;
/// Startup line, or the build's text.
pub(crate) type Text = StartupLine;

/// Returns whether a code without effect here is accepted all the same, as GRBL does: codes that ask for the
/// state that always holds, and codes for a spindle or coolant that nothing here switches.
#[must_use]
pub fn accepts(code: Code) -> bool {
    match code.letter {
        Letter::G => matches!((code.number, code.subcode), (40 | 49 | 61 | 80 | 94, 0) | (91, 1)),
        Letter::M => matches!((code.number, code.subcode), (3..=5 | 7..=9, 0)),
        Letter::T => true,
    }
}

/// State that the dialect has beside the machine's own settings, and keeps on the card in a file of its own.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Own {
    /// Setting `$10`: bit 0 machine position, else work position; bit 1 room in the buffers.
    pub report_mask: u8,
    /// Setting `$13`: reports are in inches.
    pub inches: bool,
    /// Startup lines of `$N`.
    pub startup: [Text; STARTUP_LINES],
    /// Text of the build, `$I=`.
    pub build: Text,
}

impl Default for Own {
    fn default() -> Self {
        Self { report_mask: 1, inches: false, startup: [const { Text::new() }; STARTUP_LINES], build: Text::new() }
    }
}

/// State of GRBL's dialect.
#[derive(Clone, Debug, Default)]
pub(crate) struct Grbl {
    /// Part that is stored on the card.
    pub own: Own,
    /// Contents of each session's last reports.
    pub told: [last_report::Told; MAX_SESSIONS],
}
