//! Section `[button box]`: buttons that send lines.

use super::{Command, Name};
use crate::pin::Pin;
use units::Micros;

/// Settings of one button.
#[derive(Clone, Debug, Default)]
pub struct ButtonConfig {
    /// Name of the button in the file.
    pub name: Name,
    /// Whether the button is in use.
    pub enable: bool,
    /// Input of the button.
    pub pin: Option<Pin>,
    /// Whether the button is on a panel, which reports it, and has no pin of the board (`pin = external`).
    pub is_external: bool,
    /// Line sent by a press.
    pub press: Command,
    /// Line sent by the release; empty for none.
    pub release: Command,
    /// Line sent by a long press; empty for none.
    pub long_press: Command,
    /// Least duration of a long press.
    pub long_press_time: Micros,
}

/// Button commands that are carried out at once, without waiting in line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ButtonWord {
    /// Halt the machine at once.
    Kill,
    /// Suspend the job, or resume the suspended one.
    Suspend,
    /// End the jog that a button began.
    StopJog,
}

impl ButtonWord {
    /// Parses a line as such a command; none for a line of G-code.
    #[must_use]
    pub fn of(line: &str) -> Option<Self> {
        match line.trim() {
            "KILL" => Some(Self::Kill),
            "SUSPEND" => Some(Self::Suspend),
            "$J STOP" => Some(Self::StopJog),
            _ => None,
        }
    }
}
