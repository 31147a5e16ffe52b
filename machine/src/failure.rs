//! How a command can end other than well.

use core::fmt::{Arguments, Write};

/// A message for a person, cut to fit.
pub type Message = heapless::String<112>;

/// Formats a message, cut to fit.
#[must_use]
pub fn message(text: Arguments<'_>) -> Message {
    let mut message = Message::new();
    // A message that does not fit is cut; its beginning says what is wrong.
    let _ = message.write_fmt(text);
    message
}

/// Why a command was not carried out.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Failure {
    /// The machine was halted meanwhile, by something that has already been said.
    Halted,
    /// The command asks for what must not happen: the machine halts, with this message.
    Alarm(Message),
    /// The command cannot be done; the machine goes on, with this message.
    Refused(Message),
}

impl Failure {
    /// A refusal.
    #[must_use]
    pub fn refused(text: &str) -> Self {
        Self::Refused(message(format_args!("{text}")))
    }

    /// An alarm.
    #[must_use]
    pub fn alarm(text: &str) -> Self {
        Self::Alarm(message(format_args!("{text}")))
    }
}

/// How a command that was carried out is answered.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Answer {
    /// With `ok`.
    Ok,
    /// It has answered completely.
    Said,
    /// Nobody knows this code.
    Unknown,
}

/// What a command returns.
pub type Outcome = Result<Answer, Failure>;
