//! Whoever starts a job.

use base::sessions::{Recipient, Reply, Rights};

/// Facts about whoever starts a job: what it hears of, and what it may do.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Starter {
    /// Recipient of the lines and of the answers to them.
    pub echo: Recipient,
    /// Recipient of the message at the end.
    pub tells_end: Recipient,
    /// Whether that message has the date.
    pub tells_date: bool,
    /// Rights that the job's lines have, whoever sends lines beside them.
    pub rights: Rights,
}

impl Starter {
    /// Returns the starter that a reply goes to, who hears of the end.
    #[must_use]
    pub fn of(reply: &Reply<'_>) -> Self {
        Self { tells_end: reply.to(), rights: reply.rights(), ..Self::default() }
    }
}
