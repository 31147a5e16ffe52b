//! `[button box]`.

use super::build::{bool, integer, new_name, number, pin, text};
use super::{CannotCreate, Docs, Form, Instances, PinRole, Section};
use crate::machine::{ButtonConfig, Command, MAX_BUTTONS};
use crate::pin::PinName;
use units::Micros;

/// `|button, value| ...` on the button at the instance's place.
macro_rules! button {
    (|$button:ident, $value:ident| $body:expr) => {
        |c, i, $value| {
            if let Some($button) = c.buttons.get_mut(i) {
                $body;
            }
        }
    };
}

/// The line as it is written: a file's name may have underscores.
fn line(text: &str) -> Command {
    // The schema limits the text to the length of a Command.
    Command::try_from(text).unwrap_or_default()
}

pub const BUTTON_BOX: Section = Section {
    name: "button box",
    store: None,
    docs: Docs::new(
        "Buttons that send lines. KILL halts at once, SUSPEND suspends the job or goes on with it, $J STOP ends a \
              jog that a button began with $J -c.",
    ),
    form: Form::Named(Instances {
        noun: "button",
        find: |c, name| c.buttons.iter().position(|button| button.name == name),
        create: |c, name| {
            let button = ButtonConfig { name: new_name(name)?, ..ButtonConfig::default() };
            c.buttons.push(button).map_err(|_| CannotCreate::Full(MAX_BUTTONS))?;
            Ok(c.buttons.len() - 1)
        },
        name: |c, i| c.buttons.get(i).map_or("", |button| button.name.as_str()),
        is_live: |c, i| c.buttons.get(i).is_some_and(|button| button.enable),
    }),
    settings: &[
        integer(
            "poll_frequency_hz",
            "20",
            &(0, 65_535),
            |c, _, v| c.button_poll_hz = v as u16,
            "How often buttons are looked at. Contacts may bounce as long as the time between two looks.",
        )
        .limited(&(1.0, 100.0))
        .unit("Hz")
        .common(),
        bool(
            "enable",
            "true",
            button!(|b, v| b.enable = v),
            "The button is in use; the only enable that is true by itself.",
        ),
        pin(
            "pin",
            "nc",
            PinRole::Button,
            button!(|b, v| {
                b.pin = v.and_then(PinName::digital);
                b.is_external = v == Some(PinName::External);
            }),
            "Its input, on while it is pressed: ! where that is low. external: a key of a panel, none of which is \
             supported yet.",
        ),
        text(
            "press",
            "",
            96,
            button!(|b, v| b.press = line(v)),
            "Line sent on a press. KILL, SUSPEND and $J STOP act at once.",
        ),
        text("release", "", 96, button!(|b, v| b.release = line(v)), "Line sent on its release."),
        text(
            "long_press",
            "",
            96,
            button!(|b, v| b.long_press = line(v)),
            "Line sent when it has been held for long_press_time; the line of a press is then sent on a shorter press, \
             when it ends.",
        )
        .velvet(),
        number(
            "long_press_time",
            "1",
            &(0.2, 60.0),
            button!(|b, v| b.long_press_time = Micros((v * 1e6) as u64)),
            "How long a long press is.",
        )
        .unit("s")
        .velvet(),
    ],
};
