//! Outcomes of commands: answers, failures, and the texts of failures.

use core::cell::{Cell, RefCell};
use core::fmt::{self, Arguments, Display, Write};

use crate::reason::{Alarm, Reason};

/// Greatest length of a text, bytes.
const TEXT_BYTES: usize = 112;
/// Texts kept at a time. Steps on the way from a failure to its answer (a probe is stowed, slaves are slaves
/// again) may fail as well, and write further texts.
const TEXTS: usize = 8;

/// A text for a person, cut to fit.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ShortText(heapless::String<TEXT_BYTES, u8>);

impl ShortText {
    /// Text without any words.
    pub const NONE: Self = Self(heapless::String::new());

    /// Returns the greatest length of a text, bytes.
    #[must_use]
    pub const fn capacity() -> usize {
        TEXT_BYTES
    }

    /// Returns the text as a string.
    #[must_use]
    pub fn as_str(&self) -> &str {
        &self.0
    }
}

impl Write for ShortText {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        let fits = text.floor_char_boundary(TEXT_BYTES.saturating_sub(self.0.len()));
        let fitting = text.get(..fits).unwrap_or("");
        self.0.push_str(fitting).map_err(|_| fmt::Error)?;
        if fits < text.len() { Err(fmt::Error) } else { Ok(()) }
    }
}

impl Display for ShortText {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

/// Writes a text, cut to fit: its beginning says what is wrong.
#[must_use]
pub fn short(text: Arguments<'_>) -> ShortText {
    let mut short = ShortText::NONE;
    let _ = short.write_fmt(text);
    short
}

/// Says what is wrong with a file, cut to fit. A long path loses its beginning: the reason must be read
/// whole.
#[must_use]
pub fn about_file(path: &str, why: &str) -> ShortText {
    const CUT: &str = "...";
    let room = ShortText::capacity().saturating_sub(": ".len() + why.len());
    if path.len() <= room {
        return short(format_args!("{path}: {why}"));
    }
    let longest = room.saturating_sub(CUT.len());
    let ends = path.char_indices().map(|(at, _)| path.get(at..).unwrap_or("")).find(|end| end.len() <= longest);
    short(format_args!("{CUT}{}: {why}", ends.unwrap_or("")))
}

/// Consequence of a failure for the machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FailureKind {
    /// The machine was halted meanwhile, by something that has already been said.
    Halted,
    /// The command asks for what must not happen: the machine halts.
    Alarm,
    /// The command cannot be done; the machine goes on.
    Refused,
}

/// Reason why a command was not carried out. Two machine words; the text, unless it is a fixed one, is with
/// [`Texts`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Failure {
    /// Text that is always the same.
    fixed: Option<&'static &'static str>,
    /// Number of the failure's text in [`Texts`], without a fixed one.
    number: u8,
    /// Reason of the refusal, where a line is refused with this failure.
    pub reason: Reason,
    /// Reason of the halt, where the machine halts with this failure.
    pub alarm: Alarm,
    /// Consequence for the machine.
    pub kind: FailureKind,
}

impl Failure {
    /// Failure of a command because the machine was halted meanwhile.
    pub const HALTED: Self = Self::fixed(FailureKind::Halted, &"");

    const fn fixed(kind: FailureKind, text: &'static &'static str) -> Self {
        Self { fixed: Some(text), number: 0, reason: Reason::Unsupported, alarm: Alarm::Abort, kind }
    }

    /// Makes a refusal with a text that is always the same.
    #[must_use]
    pub const fn refused(text: &'static &'static str) -> Self {
        Self::fixed(FailureKind::Refused, text)
    }

    /// Makes an alarm with a text that is always the same.
    #[must_use]
    pub const fn alarm(text: &'static &'static str) -> Self {
        Self::fixed(FailureKind::Alarm, text)
    }

    /// Returns the same failure with this reason.
    #[must_use]
    pub const fn with_reason(self, reason: Reason) -> Self {
        Self { reason, ..self }
    }

    /// Returns the same failure with this alarm.
    #[must_use]
    pub const fn with_alarm(self, alarm: Alarm) -> Self {
        Self { alarm, ..self }
    }

    /// Returns the same failure with another consequence.
    #[must_use]
    pub const fn meaning(self, kind: FailureKind) -> Self {
        Self { kind, ..self }
    }

    /// Returns whether the machine goes on.
    #[must_use]
    pub const fn is_refusal(&self) -> bool {
        matches!(self.kind, FailureKind::Refused)
    }

    /// Returns whether there is anything to say: a machine that was halted meanwhile has said why.
    #[must_use]
    pub const fn has_text(&self) -> bool {
        !matches!(self.kind, FailureKind::Halted)
    }

    /// Returns whether the machine is to halt with this failure.
    #[must_use]
    pub const fn is_alarm(&self) -> bool {
        matches!(self.kind, FailureKind::Alarm)
    }
}

/// Failure with its text, for an answer that comes later than the line after next.
#[derive(Clone, Debug)]
pub struct KeptFailure {
    failure: Failure,
    text: ShortText,
}

/// Texts of failures, from where a failure is found to where it is answered. Only the last few are held: a
/// failure is answered, told or forgotten before its line has ended.
#[derive(Debug)]
pub struct Texts {
    texts: RefCell<[(u8, ShortText); TEXTS]>,
    last: Cell<u8>,
}

impl Default for Texts {
    fn default() -> Self {
        Self::new()
    }
}

impl Texts {
    /// Starts without any text.
    #[must_use]
    pub const fn new() -> Self {
        Self { texts: RefCell::new([const { (0, ShortText::NONE) }; TEXTS]), last: Cell::new(0) }
    }

    /// Makes a refusal with the text of an error.
    #[must_use]
    pub fn refusal(&self, error: impl Display) -> Failure {
        self.refused(format_args!("{error}"))
    }

    /// Makes a refusal with this text.
    pub fn refused(&self, text: Arguments<'_>) -> Failure {
        self.keep(FailureKind::Refused, &short(text))
    }

    /// Makes a refusal for this reason.
    pub fn because(&self, why: &str) -> Failure {
        self.refused(format_args!("{why}"))
    }

    /// Makes an alarm with this text.
    pub fn alarm(&self, text: Arguments<'_>) -> Failure {
        self.keep(FailureKind::Alarm, &short(text))
    }

    /// Makes a refusal for what is wrong with a file, see [`about_file`].
    pub fn about_file(&self, path: &str, why: &str) -> Failure {
        self.keep(FailureKind::Refused, &about_file(path, why))
    }

    /// Makes a failure with a text that was kept somewhere else.
    #[inline(never)]
    pub fn keep(&self, kind: FailureKind, text: &ShortText) -> Failure {
        let number = self.last.get().wrapping_add(1);
        self.last.set(number);
        if let Ok(mut texts) = self.texts.try_borrow_mut()
            && let Some(place) = texts.get_mut(usize::from(number) % TEXTS)
        {
            place.0 = number;
            place.1.clone_from(text);
        }
        Failure { fixed: None, number, ..Failure::fixed(kind, &"") }
    }

    /// Returns the text of a failure, to be displayed.
    pub const fn of(&self, failure: Failure) -> Said<'_> {
        Said { texts: self, failure }
    }

    /// Copies a failure with its text, to be answered with later.
    pub fn kept(&self, failure: Failure) -> KeptFailure {
        KeptFailure { failure, text: self.copy_of(failure) }
    }

    /// Returns the failure that was kept, with its text in [`Texts`] again.
    pub fn taken_up(&self, kept: &KeptFailure) -> Failure {
        let KeptFailure { failure: Failure { reason, alarm, kind, .. }, text } = kept;
        self.keep(*kind, text).with_reason(*reason).with_alarm(*alarm)
    }

    /// Copies the text of a failure, to be kept for longer.
    #[must_use]
    pub fn copy_of(&self, failure: Failure) -> ShortText {
        short(format_args!("{}", self.of(failure)))
    }
}

/// Text of a failure, see [`Texts::of`].
#[derive(Clone, Copy, Debug)]
pub struct Said<'t> {
    texts: &'t Texts,
    failure: Failure,
}

impl Display for Said<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(text) = self.failure.fixed {
            return f.write_str(text);
        }
        let number = self.failure.number;
        let texts = self.texts.texts.try_borrow().ok();
        let text = texts.as_ref().and_then(|texts| texts.get(usize::from(number) % TEXTS));
        match text {
            Some((of, text)) if *of == number => f.write_str(text.as_str()),
            // Overwritten since: a failure answered so late should have been kept as a [`KeptFailure`].
            _ => f.write_str("it failed, and so did much else since then"),
        }
    }
}

/// Answer to a command that was carried out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Answer {
    /// The command is answered with `ok`.
    Ok,
    /// Answered completely by the command itself, now or later.
    Said,
    /// Answered with `ok`: the command is accepted, and not carried out.
    PassedOver,
    /// Code that nobody knows.
    Unknown,
}

/// Result of a command.
pub type Outcome = Result<Answer, Failure>;

const _: () = assert!(size_of::<Outcome>() <= 2 * size_of::<usize>(), "it is handed up through every command");

/// Refusal of a move that feeds more filament than this extruder may without X, Y and Z.
pub struct TooLong<'c>(pub &'c config::ExtruderConfig);

impl Display for TooLong<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let config::ExtruderConfig { max_extrude_only_distance: most, name, .. } = self.0;
        write!(f, "an extruder alone moves at most {most} mm: [extruder] {name}.max_extrude_only_distance")
    }
}

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
            let text = text.as_str();
            assert!(text.starts_with("...") && text.ends_with(&format!("{letter}.g: {why}")), "{text}");
            assert!(text.len() >= ShortText::capacity() - 1, "{text}");
        }
    }

    #[test]
    fn a_text_that_is_too_long_is_cut_where_it_ends_and_not_before() {
        let long = "\u{e4}".repeat(TEXT_BYTES);
        let text = short(format_args!("x: {long}"));
        assert_eq!(text.as_str(), format!("x: {}", "\u{e4}".repeat((TEXT_BYTES - 3) / 2)));
    }

    #[test]
    fn a_failure_says_its_own_text_while_a_few_others_are_found() {
        let texts = Texts::new();
        let first = texts.refused(format_args!("the first of {}", 9));
        let others: Vec<Failure> = (1..TEXTS).map(|n| texts.alarm(format_args!("number {n}"))).collect();
        assert_eq!(texts.of(first).to_string(), "the first of 9");
        assert!(others.iter().zip(1..).all(|(other, n)| texts.of(*other).to_string() == format!("number {n}")));
        assert_eq!(texts.of(Failure::refused(&"always")).to_string(), "always");
        let kept = texts.copy_of(first);
        let _ninth = texts.refused(format_args!("one more"));
        assert!(texts.of(first).to_string().starts_with("it failed"), "{}", texts.of(first));
        assert_eq!(kept.as_str(), "the first of 9");
    }

    #[test]
    fn a_failure_that_is_kept_is_the_same_when_it_is_taken_up() {
        let texts = Texts::new();
        let kept = texts.kept(texts.alarm(format_args!("a {}", "text")).with_reason(Reason::Target));
        for n in 0..2 * TEXTS {
            let _other = texts.refused(format_args!("number {n}"));
        }
        let failure = texts.taken_up(&kept);
        assert_eq!(texts.of(failure).to_string(), "a text");
        assert_eq!((failure.kind, failure.reason), (FailureKind::Alarm, Reason::Target));
    }
}
