//! Report of the pins that could not be bound, with their names and those of their owners.

use core::fmt::{Display, Write};

use bsp_prime::pins::{PinSpec, Pull};
use config::Pin;
use heapless::String;

/// Collects what could not be bound.
pub struct Report<'a> {
    print: &'a mut dyn FnMut(&str),
    pub clean: bool,
}

impl<'a> Report<'a> {
    /// Creates a report whose lines go to `print`.
    pub fn new(print: &'a mut dyn FnMut(&str)) -> Self {
        Self { print, clean: true }
    }

    /// Reports a line.
    pub fn trouble(&mut self, what: impl Display) {
        let mut line = String::<160>::new();
        // A line that does not fit is cut.
        let _cut = write!(line, "{what}");
        (self.print)(&line);
        self.clean = false;
    }

    /// Returns the value, or reports its error as a line.
    pub fn take<T, E: Display>(&mut self, result: Result<T, E>) -> Option<T> {
        result.map_err(|error| self.trouble(error)).ok()
    }
}

/// Returns the name of a pin's owner for messages: section, instance, key.
pub fn owner(section: &str, instance: &str, key: &str) -> String<64> {
    let mut name = String::new();
    // Long instance names are cut; the message stays readable.
    let _cut = write!(name, "{section}.{instance}.{key}");
    name
}

/// Converts the configuration's pin to that of the board package.
pub fn spec(pin: Pin) -> PinSpec {
    let name = bsp_prime::pins::PinName::new(pin.port_letter(), pin.number);
    let pull = match pin.pull {
        config::Pull::Default | config::Pull::Up => Pull::Up,
        config::Pull::Down => Pull::Down,
        config::Pull::None => Pull::Floating,
    };
    PinSpec { pin: name, inverted: pin.inverted, open_drain: pin.open_drain, pull }
}
