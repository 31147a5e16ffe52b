//! `[button box]`: buttons that send lines.

use super::{Command, Name};
use crate::pin::Pin;
use units::Micros;

/// A button.
#[derive(Clone, Debug, Default)]
pub struct ButtonConfig {
    /// Its name.
    pub name: Name,
    /// Whether it is in use.
    pub enable: bool,
    /// Its input.
    pub pin: Option<Pin>,
    /// `pin = external`: the button is on a panel, which reports it, and has no pin of the board.
    pub is_external: bool,
    /// Line that a press sends.
    pub press: Command,
    /// Line that its release sends; empty for none.
    pub release: Command,
    /// Line that a long press sends; empty for none.
    pub long_press: Command,
    /// How long that is.
    pub long_press_time: Micros,
}

/// What a button's line asks for that is done at once.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ButtonWord {
    /// Halt.
    Kill,
    /// Suspend the job, or go on with the suspended one.
    Suspend,
    /// End the jog that a button began.
    StopJog,
}

impl ButtonWord {
    /// The word that a line is; none for a line to carry out.
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
