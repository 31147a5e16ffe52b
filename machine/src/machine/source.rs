//! Source of a line, recipient of its answers, and the dialect it is read in.

use base::Ports;
use base::sessions::Recipient;
use program::Dialect;

use crate::machine::Machine;

/// Kind of place that a line comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Origin {
    /// A session, which is answered.
    Session,
    /// The file being played.
    Job,
    /// An input switch, a button or the filament detector.
    Switch,
    /// A file of saved settings.
    Settings,
    /// A startup line.
    Startup(u8),
}

/// Facts about a line besides its text.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Source {
    pub origin: Origin,
    pub to: Recipient,
    pub dialect: Dialect,
}

impl Source {
    /// Finds the dialect: a session has its own, and so has a file; the configuration and saved settings are
    /// in the machine's own, whatever consoles speak.
    pub fn new<P: Ports>(machine: &Machine<'_, P>, to: Recipient, origin: Origin) -> Self {
        let dialect = match origin {
            Origin::Job => machine.jobs.dialect().unwrap_or_else(|| machine.world.config.general.usual_dialect()),
            Origin::Session => machine.world.sessions.dialect_of(to),
            Origin::Switch | Origin::Settings | Origin::Startup(_) => machine.world.config.general.own_dialect(),
        };
        Self { origin, to, dialect }
    }
}
