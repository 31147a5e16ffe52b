//! `[led strip]`: strips of lights with a chip each, and lights of up to four colours on outputs.

use super::{MachineConfig, Name};
use crate::pin::PwmOutput;
use units::{Colour, ColourOrder};

/// What a strip shows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum StripShows {
    /// What codes say.
    #[default]
    Codes,
    /// How the machine is, while there is something to see; else what codes say.
    State,
}

/// A strip.
#[derive(Clone, Debug, Default)]
pub struct LedStripConfig {
    /// Its name.
    pub name: Name,
    /// Whether it exists.
    pub enable: bool,
    /// The number by which M150 knows it.
    pub number: u8,
    /// Its data line; none where it is switches.
    pub pin: Option<PwmOutput>,
    /// Lights in the chain.
    pub chain_count: u16,
    /// The order in which its chips take their colour; none when it was not understood.
    pub order: Option<ColourOrder>,
    /// Share of full brightness that 255 is, 0 to 1.
    pub brightness: f32,
    /// Its colour when the machine has started.
    pub initial: Colour,
    /// What it shows.
    pub shows: StripShows,
    /// Names of the switches that are its colours, as written: red, green, blue, white. Those that it has
    /// not are empty.
    pub switches: [Name; 4],
}

impl LedStripConfig {
    /// It is one light whose colours are outputs of switches.
    #[must_use]
    pub fn is_of_switches(&self) -> bool {
        self.switches.iter().any(|name| !name.is_empty())
    }

    /// Lights that it has.
    #[must_use]
    pub fn lights(&self) -> u16 {
        if self.is_of_switches() { 1 } else { self.chain_count }
    }
}

impl MachineConfig {
    /// The strip that a switch is a colour of.
    #[must_use]
    pub fn strip_of_switch(&self, switch: &str) -> Option<&LedStripConfig> {
        self.led_strips.iter().find(|strip| strip.enable && strip.switches.iter().any(|name| name == switch))
    }

    /// Whether the timer of PWM1 or PWM2 (1, 2) sends to strips, so that it can do nothing else.
    #[must_use]
    pub fn timer_sends(&self, timer: u8) -> bool {
        self.led_strips.iter().any(|strip| strip.enable && strip.pin.is_some_and(|pin| pin.timer == timer))
    }
}
