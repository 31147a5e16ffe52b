//! `[button box]`: buttons that send lines.

use crate::names::{Command, Name};
use crate::pin::{Pin, PinName};
use crate::setting::PinRole;
use crate::setting::build::{bool, integer, number, pin, text};
use crate::setting::declare::settings;
use units::Micros;

/// Greatest number of buttons in `[button box]`.
pub const MAX_BUTTONS: usize = 12;

settings! {
    /// Buttons that send lines. KILL halts at once, SUSPEND suspends the job or goes on with it, $J STOP ends
    /// a jog that a button began with $J -c.
    #[derive(Clone, Debug, Default)]
    pub struct ButtonConfig {
        /// Name of the button in the file.
        name: Name;
        /// The button is in use; the only enable that is true by itself.
        enable: bool = bool("true");
        /// Its input, on while it is pressed: ! where that is low. external: a key of a panel, none of which
        /// is supported yet.
        "pin" = pin("nc", PinRole::Button) => ButtonConfig::set_pin;
        /// Line sent on a press. KILL, SUSPEND and $J STOP act at once.
        press: Command = text("", 96);
        /// Line sent on its release.
        release: Command = text("", 96);
        /// Line sent when it has been held for long_press_time; the line of a press is then sent on a shorter
        /// press, when it ends.
        long_press: Command = text("", 96).velvet();
        /// How long a long press is.
        long_press_time: Micros = number("1", &(0.2, 60.0)).unit("s").velvet();
        /// Input of the button.
        pin: Option<Pin>;
        /// Whether the button is on a panel, which reports it, and has no pin of the board (`pin =
        /// external`).
        is_external: bool;
    }
}

impl ButtonConfig {
    fn set_pin(&mut self, pin: Option<PinName>) {
        self.pin = pin.and_then(PinName::digital);
        self.is_external = pin == Some(PinName::External);
    }
}

/// Polling rate of the buttons, Hz.
type PollRate = u16;

settings! {
    /// Settings that all buttons share.
    rows ButtonBox of PollRate {
        /// How often buttons are looked at. Contacts may bounce as long as the time between two looks.
        "poll_frequency_hz" = integer("20", &(0, 65_535))
            .limited(&(1.0, 100.0)).unit("Hz").common() => |rate: &mut PollRate, hertz: i64| *rate = hertz as u16;
    }
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
