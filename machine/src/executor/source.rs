//! Where a line comes from, who hears what is answered to it, and in which dialect it is read.

use program::Dialect;

use super::Machine;
use crate::ports::Ports;
use crate::sessions::Recipient;

/// Where a line comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Origin {
    /// A session, which is answered.
    Session,
    /// The file being played.
    Job,
    /// An input switch.
    Switch,
    /// A file of saved settings.
    Settings,
    /// A startup line of GRBL's dialect.
    Startup(u8),
}

/// What is to be known of a line besides what it says.
#[derive(Clone, Copy, Debug)]
pub(super) struct Source {
    pub origin: Origin,
    pub to: Recipient,
    pub dialect: Dialect,
}

impl Source {
    /// The dialect of a file is what the file says, else that of whoever hears its lines; the configuration
    /// and what nobody listens to are written for the machine.
    pub fn new<P: Ports>(machine: &Machine<'_, P>, to: Recipient, origin: Origin) -> Self {
        let said = if origin == Origin::Job { machine.jobs.dialect() } else { None };
        let dialect = match (said, to) {
            (Some(dialect), _) => dialect,
            (None, Recipient::Nobody) => crate::program_setup::dialect(machine.config),
            (None, to) => machine.sessions.dialect_of(to),
        };
        Self { origin, to, dialect }
    }
}
