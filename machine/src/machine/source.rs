//! Source of a line, recipient of its answers, and the dialect it is read in.

use base::sessions::{Recipient, Sessions};
use config::MachineConfig;
use jobs::player::Jobs;
use program::Dialect;

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
    /// A line of a macro. False: names and codes mean what they mean without macros.
    Macro(bool),
}

/// Facts about a line besides its text.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Source {
    pub origin: Origin,
    pub to: Recipient,
    pub dialect: Dialect,
}

impl Source {
    /// Whether names and codes of the line may be those of macros.
    pub const fn looks_up_names(self) -> bool {
        !matches!(self.origin, Origin::Macro(false) | Origin::Settings)
    }

    /// Whether the line is a macro's.
    pub const fn is_macros(self) -> bool {
        matches!(self.origin, Origin::Macro(_))
    }

    /// Returns the source of a session's lines, which are in the dialect that it speaks.
    pub fn of_session(sessions: &Sessions, to: Recipient) -> Self {
        Self { origin: Origin::Session, to, dialect: sessions.dialect_of(to) }
    }

    /// Returns the source of the lines of the job, whose file may say its dialect. Nobody is answered.
    pub fn of_job(jobs: &Jobs, config: &MachineConfig) -> Self {
        let dialect = jobs.dialect().unwrap_or_else(|| config.general.usual_dialect());
        Self { origin: Origin::Job, to: Recipient::Nobody, dialect }
    }

    /// Returns the source of lines of the configuration and of saved settings, which are in the machine's own
    /// dialect, whatever consoles speak. Nobody is answered.
    pub fn of_machine(config: &MachineConfig, origin: Origin) -> Self {
        Self { origin, to: Recipient::Nobody, dialect: config.general.own_dialect() }
    }
}
