//! GRBL 1.1, as its senders expect it: its numbers for what goes wrong, its lines, its settings, its reports.
//!
//! What is here knows no executor: lines are read and written, numbers translated. `executor/grbl.rs` carries
//! the commands out. Facts: Grbl 1.1's interface, configuration, jogging and real-time pages
//! (github.com/gnea/grbl, `doc/markdown`).

use gcode::{Code, Letter};

pub mod framing;
pub(crate) mod jog;
pub mod numbers;

/// What a session of this dialect is told first, and after each reset: senders wait for it.
pub const BANNER: &str = "Grbl 1.1f ['$' for help]\n";
/// What follows it while the machine is halted.
pub const LOCKED: &str = "[MSG:'$H'|'$X' to unlock]\n";
/// The answer to `$`.
pub const HELP: &str = "[HLP:$$ $# $G $I $N $x=val $Nx=line $J=line $SLP $C $X $H ~ ! ? ctrl-x]\n";

/// Whether a code that has nothing to do here is accepted all the same, as GRBL does: those that ask for what
/// is so anyway, and those for a spindle or coolant that nothing here switches.
#[must_use]
pub fn accepts(code: Code) -> bool {
    match code.letter {
        Letter::G => matches!((code.number, code.subcode), (40 | 49 | 61 | 80 | 94, 0) | (91, 1)),
        Letter::M => matches!((code.number, code.subcode), (3..=5 | 7..=9, 0)),
        Letter::T => true,
    }
}

/// What the dialect has beside the machine's own settings.
#[derive(Clone, Debug, Default)]
pub(crate) struct Grbl {}
