//! How a command can end other than well.

use core::fmt::{self, Arguments, Write};
use core::ops::{Deref, DerefMut};

use crate::grbl::numbers::{Alarm, Error};

/// Bytes of a message.
const MESSAGE_BYTES: usize = 112;

/// A message for a person, cut to fit, with the numbers that senders of GRBL's dialect go by.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Message {
    text: heapless::String<MESSAGE_BYTES, u8>,
    /// The number where a line is refused with it.
    pub error: Error,
    /// The number where the machine halts with it.
    pub alarm: Alarm,
}

impl Message {
    /// Without words.
    #[must_use]
    pub const fn new() -> Self {
        Self { text: heapless::String::new(), error: Error::Unsupported, alarm: Alarm::Abort }
    }

    /// The same, of this number.
    #[must_use]
    pub const fn numbered(mut self, error: Error) -> Self {
        self.error = error;
        self
    }

    /// The same, of this number where the machine halts with it.
    #[must_use]
    pub const fn alarming(mut self, alarm: Alarm) -> Self {
        self.alarm = alarm;
        self
    }
}

impl Deref for Message {
    type Target = heapless::String<MESSAGE_BYTES, u8>;

    fn deref(&self) -> &Self::Target {
        &self.text
    }
}

impl DerefMut for Message {
    fn deref_mut(&mut self) -> &mut Self::Target {
        &mut self.text
    }
}

impl Write for Message {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        self.text.write_str(text)
    }
}

impl fmt::Display for Message {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)
    }
}

/// Formats a message, cut to fit.
#[must_use]
pub fn message(text: Arguments<'_>) -> Message {
    let mut message = Message::new();
    // A message that does not fit is cut; its beginning says what is wrong.
    let _ = message.write_fmt(text);
    message
}

/// What is wrong with a file, cut to fit. Of a long path it is the beginning that goes: the reason must be
/// read whole.
#[must_use]
pub fn about_file(path: &str, why: &str) -> Message {
    const CUT: &str = "...";
    let room = Message::new().capacity().saturating_sub(": ".len() + why.len());
    if path.len() <= room {
        return message(format_args!("{path}: {why}"));
    }
    let longest = room.saturating_sub(CUT.len());
    let ends = path.char_indices().map(|(at, _)| path.get(at..).unwrap_or("")).find(|end| end.len() <= longest);
    message(format_args!("{CUT}{}: {why}", ends.unwrap_or("")))
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

    /// A refusal of this number.
    #[must_use]
    pub fn numbered(error: Error, text: &str) -> Self {
        Self::Refused(message(format_args!("{text}")).numbered(error))
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
    /// It has answered completely, or will.
    Said,
    /// With `ok`: it is accepted, and not carried out.
    PassedOver,
    /// Nobody knows this code.
    Unknown,
}

/// What a command returns.
pub type Outcome = Result<Answer, Failure>;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_long_path_does_not_hide_what_is_wrong() {
        let why = "the file is in use: wait until it is closed, or end the job";
        assert_eq!(about_file("/sd/x.g", why).as_str(), format!("/sd/x.g: {why}"));
        for letter in ["x", "\u{e4}"] {
            let path = format!("/sd/{}.g", letter.repeat(120));
            let text = about_file(&path, why);
            assert!(text.starts_with("...") && text.ends_with(&format!("{letter}.g: {why}")), "{text}");
            assert!(text.len() >= text.capacity() - 1, "{text}");
        }
    }
}
