//! A reply on its way to whoever asked.

use core::fmt;

use super::{Recipient, Sessions};

/// Says things to one recipient, who is handed along as an argument: no reply ever goes to whoever asked
/// last.
#[derive(Debug)]
pub struct Reply<'s> {
    sessions: &'s mut Sessions,
    to: Recipient,
}

impl<'s> Reply<'s> {
    /// To this recipient.
    pub const fn new(sessions: &'s mut Sessions, to: Recipient) -> Self {
        Self { sessions, to }
    }

    /// Whom it goes to.
    #[must_use]
    pub const fn to(&self) -> Recipient {
        self.to
    }

    /// Says something.
    pub fn say(&mut self, text: fmt::Arguments<'_>) {
        self.sessions.say(self.to, text);
    }

    /// Tells hosts what has become of the job; who asked for it knows.
    pub fn tell_hosts(&mut self, news: &str) {
        self.sessions.tell_hosts(news, self.to);
    }

    /// Says something to every session.
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
