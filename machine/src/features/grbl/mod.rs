//! GRBL 1.1, as its senders expect it: its commands, its settings, its reports. Its numbers of errors and
//! alarms, and its one answer for each line, are where text meets a sender: [`base::grbl`].
//!
//! The modules here know no executor: lines are read and written. `executor/grbl.rs` carries the commands
//! out. Facts: Grbl 1.1's interface, configuration, jogging and real-time pages (github.com/gnea/grbl,
//! `doc/markdown`).

use base::sessions::MAX_SESSIONS;
use gcode::{Code, Letter};

pub(crate) mod commands;
pub(crate) mod hal;
pub(crate) mod jog;
pub(crate) mod last_report;
pub(crate) mod numbered_settings;
pub(crate) mod overrides;
pub(crate) mod reports;
pub(crate) mod status;
pub(crate) mod stored;

/// Answer to `$` alone.
pub const HELP: &str = "[HLP:$$ $# $G $I $N $x=val $Nx=line $J=line $SLP $C $X $H ~ ! ? ctrl-x]\n";

/// Number of startup lines (`$N0`, `$N1`).
pub(crate) const STARTUP_LINES: usize = 2;
/// Startup line, or the build's text: as long as a line of GRBL's may be.
pub(crate) type Text = heapless::String<80>;

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
