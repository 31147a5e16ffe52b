//! Replies to the session that asked.

use core::fmt;

use super::{Recipient, Rights, Sessions};

/// Reply to a recipient, handed along as an argument, so that no reply ever goes to another session that
/// asked last.
#[derive(Debug)]
pub struct Reply<'s> {
    sessions: &'s mut Sessions,
    to: Recipient,
}

impl<'s> Reply<'s> {
    /// Makes a reply to this recipient.
    pub const fn new(sessions: &'s mut Sessions, to: Recipient) -> Self {
        Self { sessions, to }
    }

    /// Returns the recipient of the reply.
    #[must_use]
    pub const fn to(&self) -> Recipient {
        self.to
    }

    /// Returns the rights of the recipient, who has asked.
    #[must_use]
    pub fn rights(&self) -> Rights {
        self.sessions.rights_of(self.to)
    }

    /// Sends a text to the recipient.
    pub fn say(&mut self, text: fmt::Arguments<'_>) {
        self.sessions.say(self.to, text);
    }

    /// Tells hosts about the job; the session that asked knows already.
    pub fn tell_hosts(&mut self, news: &str) {
        self.sessions.tell_hosts(news, self.to);
    }

    /// Sends a text to every session.
    pub fn announce(&mut self, text: fmt::Arguments<'_>) {
        self.sessions.say(Recipient::All, text);
    }
}

impl fmt::Write for Reply<'_> {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        self.say(format_args!("{text}"));
        Ok(())
    }
}
