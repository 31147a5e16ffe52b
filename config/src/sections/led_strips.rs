//! `[led strip]`: strips of lights with a chip each, and lights of up to four colours on outputs.

use crate::names::Name;
use crate::pin::{PinName, PwmOutput};
use crate::setting::PinRole;
use crate::setting::build::{bool, integer, number, pin, text, word};
use crate::setting::declare::{settings, words};
use units::{Colour, ColourOrder};

/// Greatest number of LED strips.
pub const MAX_STRIPS: usize = 4;
/// Greatest number of lights on all strips.
pub const MOST_LIGHTS: u16 = 256;

words! {
    /// Source of a strip's colours.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
    pub enum StripShows {
        /// Colours that codes set.
        #[default]
        Codes = "codes",
        /// State of the machine, while there is something to show; otherwise the colours that codes set.
        State = "state",
    }
}

settings! {
    /// Lights of any colour: strips of WS2812, SK6812 and the like, each light with its own colour, on a
    /// timer's pin; or one light whose colours are outputs of [switch]. M150 and SET_LED set them.
    #[derive(Clone, Debug, Default)]
    pub struct LedStripConfig {
        /// Name of the strip in the file.
        name: Name;
        /// There is such a strip.
        enable: bool = bool("false").velvet();
        /// Its data line, PWM1_1 to PWM2_4. The timer of that pin then sends to strips alone, up to four of
        /// them; the other timer stays free.
        pin: Option<PwmOutput> = pin("nc", PinRole::Pwm)
            .klipper("[neopixel <name>] pin").velvet()
            => |v: Option<PinName>| match v { Some(PinName::Pwm(output)) => Some(output), _ => None, };
        /// Lights in the chain.
        chain_count: u16 = integer("1", &(1, MOST_LIGHTS as i64)).klipper("[neopixel <name>] chain_count").velvet();
        /// The order in which its chips take their colours: GRB of WS2812, GRBW of SK6812 with white, RGB and
        /// so on.
        "color_order" order: Option<ColourOrder> = text("GRB", 4)
            .klipper("[neopixel <name>] color_order").velvet() => ColourOrder::parse;
        /// S of M150 that means it.
        number: u8 = integer("-1", &(-1, 15)).derived("0, 1, 2 in the order of their names").velvet();
        /// How bright full brightness is. A light at full white takes up to 60 mA: keep it below what the
        /// supply gives.
        brightness: f32 = number("100", &(0.0, 100.0)).unit("%").velvet() => |v: f64| (v / 100.0) as f32;
        /// Colour at the start of the machine.
        initial: Colour;
        /// Red when the machine has started.
        "initial_red" initial.red = number("0", SHARE)
            .unit("ratio").klipper("[neopixel <name>] initial_RED").velvet() => steps;
        /// The same for green.
        "initial_green" initial.green = number("0", SHARE)
            .unit("ratio").klipper("[neopixel <name>] initial_GREEN").velvet() => steps;
        /// The same for blue.
        "initial_blue" initial.blue = number("0", SHARE)
            .unit("ratio").klipper("[neopixel <name>] initial_BLUE").velvet() => steps;
        /// The same for white.
        "initial_white" initial.white = number("0", SHARE)
            .unit("ratio").klipper("[neopixel <name>] initial_WHITE").velvet() => steps;
        /// codes: what M150 and SET_LED say. state: the same, but while the machine heats how far it is
        /// (orange), while it makes a file how far that is (green), while it waits for a person yellow, and
        /// halted blinking red.
        shows: StripShows = word("codes", StripShows::WORDS).velvet();
        /// Names of the switches for red, green, blue and white, as written; empty for colours the strip does
        /// not have.
        switches: [Name; 4];
        /// Instead of a pin: the [switch] that is its red.
        "red_switch" switches[0] = text("", 24).klipper("[led <name>] red_pin").velvet();
        /// The same for green.
        "green_switch" switches[1] = text("", 24).klipper("[led <name>] green_pin").velvet();
        /// The same for blue.
        "blue_switch" switches[2] = text("", 24).klipper("[led <name>] blue_pin").velvet();
        /// The same for white.
        "white_switch" switches[3] = text("", 24).klipper("[led <name>] white_pin").velvet();
    }
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

/// 255 steps of a share.
const fn steps(share: f64) -> u8 {
    (share * 255.0 + 0.5) as u8
}

const SHARE: &(f64, f64) = &(0.0, 1.0);
