//! `[led strip]`: strips of lights with a chip each, and lights of up to four colours on outputs.

use super::{MachineConfig, Name};
use crate::pin::PwmOutput;
use units::{Colour, ColourOrder};

/// Source of a strip's colours.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum StripShows {
    /// Colours that codes set.
    #[default]
    Codes,
    /// State of the machine, while there is something to show; otherwise the colours that codes set.
    State,
}

/// Settings of one LED strip.
#[derive(Clone, Debug, Default)]
pub struct LedStripConfig {
    /// Name of the strip in the file.
    pub name: Name,
    /// Whether the strip is in use.
    pub enable: bool,
    /// Number of the strip in M150.
    pub number: u8,
    /// Data output; none for a light made of switches.
    pub pin: Option<PwmOutput>,
    /// Number of lights in the chain.
    pub chain_count: u16,
    /// Order in which the chips take their colours; none when it was not understood.
    pub order: Option<ColourOrder>,
    /// Share of full brightness for the value 255, 0 to 1.
    pub brightness: f32,
    /// Colour at the start of the machine.
    pub initial: Colour,
    /// Source of the strip's colours.
    pub shows: StripShows,
    /// Names of the switches for red, green, blue and white, as written; empty for colours the strip does not
    /// have.
    pub switches: [Name; 4],
}

impl LedStripConfig {
    /// Returns whether the strip is one light whose colours are outputs of switches.
    #[must_use]
    pub fn is_of_switches(&self) -> bool {
        self.switches.iter().any(|name| !name.is_empty())
    }

    /// Returns the number of lights.
    #[must_use]
    pub fn lights(&self) -> u16 {
        if self.is_of_switches() { 1 } else { self.chain_count }
    }
}

impl MachineConfig {
    /// Returns the strip that has the switch as a colour.
    #[must_use]
    pub fn strip_of_switch(&self, switch: &str) -> Option<&LedStripConfig> {
        self.led_strips.iter().find(|strip| strip.enable && strip.switches.iter().any(|name| name == switch))
    }

    /// Returns whether the timer of PWM1 or PWM2 (1, 2) sends data to strips and so can do nothing else.
    #[must_use]
    pub fn timer_sends(&self, timer: u8) -> bool {
        self.led_strips.iter().any(|strip| strip.enable && strip.pin.is_some_and(|pin| pin.timer == timer))
    }
}
