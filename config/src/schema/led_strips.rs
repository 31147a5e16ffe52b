//! `[led strip]`.

use super::build::{bool, integer, new_name, number, pin, text, word};
use super::{CannotCreate, Docs, Form, Instances, PinRole, Section, Words};
use crate::machine::{LedStripConfig, MAX_STRIPS, MOST_LIGHTS, StripShows};
use crate::pin::PinName;
use units::ColourOrder;

/// `|strip, value| ...` on the strip at the instance's place.
macro_rules! strip {
    (|$strip:ident, $value:ident| $body:expr) => {
        |c, i, $value| {
            if let Some($strip) = c.led_strips.get_mut(i) {
                $body;
            }
        }
    };
}

/// 255 steps of a share.
const fn steps(share: f64) -> u8 {
    (share * 255.0 + 0.5) as u8
}

const SHARE: &(f64, f64) = &(0.0, 1.0);

pub const LED_STRIP: Section = Section {
    name: "led strip",
    store: None,
    docs: Docs::new("Lights of any colour: strips of WS2812, SK6812 and the like, each light with its own colour, on a timer's \
              pin; or one light whose colours are outputs of [switch]. M150 and SET_LED set them."),
    form: Form::Named(Instances {
        noun: "strip",
        find: |c, name| c.led_strips.iter().position(|strip| strip.name == name),
        create: |c, name| {
            let strip = LedStripConfig { name: new_name(name)?, ..LedStripConfig::default() };
            c.led_strips.push(strip).map_err(|_| CannotCreate::Full(MAX_STRIPS))?;
            Ok(c.led_strips.len() - 1)
        },
        name: |c, i| c.led_strips.get(i).map_or("", |strip| strip.name.as_str()),
        is_live: |c, i| c.led_strips.get(i).is_some_and(|strip| strip.enable),
    }),
    settings: &[
        bool("enable", "false", strip!(|s, v| s.enable = v), "There is such a strip.").velvet(),
        pin(
            "pin",
            "nc",
            PinRole::Pwm,
            strip!(|s, v| s.pin = match v {
                Some(PinName::Pwm(output)) => Some(output),
                _ => None,
            }),
            "Its data line, PWM1_1 to PWM2_4. The timer of that pin then sends to strips alone, up to four of them; the \
             other timer stays free.",
        )
        .klipper("[neopixel <name>] pin")
        .velvet(),
        integer(
            "chain_count",
            "1",
            &(1, MOST_LIGHTS as i64),
            strip!(|s, v| s.chain_count = v as u16),
            "Lights in the chain.",
        )
        .klipper("[neopixel <name>] chain_count")
        .velvet(),
        text(
            "color_order",
            "GRB",
            4,
            strip!(|s, v| s.order = ColourOrder::parse(v)),
            "The order in which its chips take their colours: GRB of WS2812, GRBW of SK6812 with white, RGB and so on.",
        )
        .klipper("[neopixel <name>] color_order")
        .velvet(),
        integer("number", "-1", &(-1, 15), strip!(|s, v| s.number = v as u8), "S of M150 that means it.")
            .derived("0, 1, 2 in the order of their names")
            .velvet(),
        number(
            "brightness",
            "100",
            &(0.0, 100.0),
            strip!(|s, v| s.brightness = (v / 100.0) as f32),
            "How bright full brightness is. A light at full white takes up to 60 mA: keep it below what the supply gives.",
        )
        .unit("%")
        .velvet(),
        number("initial_red", "0", SHARE, strip!(|s, v| s.initial.red = steps(v)), "Red when the machine has started.")
            .unit("ratio")
            .klipper("[neopixel <name>] initial_RED")
            .velvet(),
        number("initial_green", "0", SHARE, strip!(|s, v| s.initial.green = steps(v)), "The same for green.")
            .unit("ratio")
            .klipper("[neopixel <name>] initial_GREEN")
            .velvet(),
        number("initial_blue", "0", SHARE, strip!(|s, v| s.initial.blue = steps(v)), "The same for blue.")
            .unit("ratio")
            .klipper("[neopixel <name>] initial_BLUE")
            .velvet(),
        number("initial_white", "0", SHARE, strip!(|s, v| s.initial.white = steps(v)), "The same for white.")
            .unit("ratio")
            .klipper("[neopixel <name>] initial_WHITE")
            .velvet(),
        word(
            "shows",
            "codes",
            &Words(&["codes", "state"]),
            strip!(|s, v| s.shows = if v == 1 { StripShows::State } else { StripShows::Codes }),
            "codes: what M150 and SET_LED say. state: the same, but while the machine heats how far it is (orange), while \
             it makes a file how far that is (green), while it waits for a person yellow, and halted blinking red.",
        )
        .velvet(),
        text(
            "red_switch",
            "",
            24,
            strip!(|s, v| s.switches[0] = v.try_into().unwrap_or_default()),
            "Instead of a pin: the [switch] that is its red.",
        )
        .klipper("[led <name>] red_pin")
        .velvet(),
        text(
            "green_switch",
            "",
            24,
            strip!(|s, v| s.switches[1] = v.try_into().unwrap_or_default()),
            "The same for green.",
        )
        .klipper("[led <name>] green_pin")
        .velvet(),
        text(
            "blue_switch",
            "",
            24,
            strip!(|s, v| s.switches[2] = v.try_into().unwrap_or_default()),
            "The same for blue.",
        )
        .klipper("[led <name>] blue_pin")
        .velvet(),
        text(
            "white_switch",
            "",
            24,
            strip!(|s, v| s.switches[3] = v.try_into().unwrap_or_default()),
            "The same for white.",
        )
        .klipper("[led <name>] white_pin")
        .velvet(),
    ],
};
