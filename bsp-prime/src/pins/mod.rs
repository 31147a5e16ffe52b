//! Claims of pins by name: the owner of each pin, and handles to the pins.
//!
//! A configuration names pins; two settings that name the same one are a mistake that this table finds and
//! reports. Pins with one fixed use on this board are refused with that use.

mod gpio;
mod name;
pub mod table;

use core::fmt;

use heapless::{String, Vec};

pub use gpio::{FastPin, Input, Line, Mode, Output, Speed};
pub(crate) use gpio::{configure, enable_ports};
pub use name::{PinName, PinSpec, Pull};

/// Longest owner name kept, in bytes; longer ones are cut.
const OWNER_BYTES: usize = 40;
/// Most pins that can be owned at once: all that the headers and sockets offer.
const CLAIMS: usize = 112;

/// Owner of a pin: the configuration key, or a part of the board.
pub type Owner = String<OWNER_BYTES>;

/// Refusal of a pin.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum PinError {
    /// Another setting has it already.
    Taken {
        /// Name of the pin.
        pin: PinName,
        /// Present owner of the pin.
        owner: Owner,
        /// Refused claimant of the pin.
        wanted_by: Owner,
    },
    /// The pin has one fixed use on this board.
    Reserved {
        /// Name of the pin.
        pin: PinName,
        /// Fixed use of the pin.
        usage: &'static str,
        /// Refused claimant of the pin.
        wanted_by: Owner,
    },
    /// More pins than the board has; cannot happen with distinct pins.
    TableFull,
}

impl fmt::Display for PinError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Taken { pin, owner, wanted_by } => {
                write!(f, "{pin} is wanted by {wanted_by}, but {owner} has it already; give one of them another pin")
            }
            Self::Reserved { pin, usage, wanted_by } => {
                write!(f, "{pin} is wanted by {wanted_by}, but on this board it belongs to {usage}; choose another pin")
            }
            Self::TableFull => f.write_str("more pins are claimed than the board has"),
        }
    }
}

/// Table of claimed pins.
#[derive(Debug, Default)]
pub struct Pins {
    claims: Vec<(PinName, Owner), CLAIMS>,
}

fn owner_named(name: &str) -> Owner {
    let mut owner = Owner::new();
    for letter in name.chars() {
        if owner.push(letter).is_err() {
            break;
        }
    }
    owner
}

impl Pins {
    /// A table without claims.
    #[must_use]
    pub const fn new() -> Self {
        Self { claims: Vec::new() }
    }

    /// Returns the owner of a pin.
    #[must_use]
    pub fn owner(&self, pin: PinName) -> Option<&str> {
        self.claims.iter().find(|(claimed, _)| *claimed == pin).map(|(_, owner)| owner.as_str())
    }

    /// Notes that `owner` has `pin`.
    ///
    /// # Errors
    /// [`PinError`] naming both sides.
    pub fn claim(&mut self, pin: PinName, owner: &str) -> Result<(), PinError> {
        if let Some((_, usage)) = table::RESERVED.iter().find(|(reserved, _)| *reserved == pin) {
            return Err(PinError::Reserved { pin, usage, wanted_by: owner_named(owner) });
        }
        if let Some((_, present)) = self.claims.iter().find(|(claimed, _)| *claimed == pin) {
            return Err(PinError::Taken { pin, owner: present.clone(), wanted_by: owner_named(owner) });
        }
        self.claims.push((pin, owner_named(owner))).map_err(|_| PinError::TableFull)
    }

    /// Gives up every claim of `owner`; its pins may be claimed again.
    pub fn release(&mut self, owner: &str) {
        self.claims.retain(|(_, present)| present.as_str() != owner);
    }

    /// Claims a pin as an output that is off.
    ///
    /// # Errors
    /// [`PinError`] naming both sides.
    pub fn output(&mut self, spec: PinSpec, owner: &str) -> Result<Output, PinError> {
        self.claim(spec.pin, owner)?;
        Ok(Output::off(spec))
    }

    /// Claims a pin as an input.
    ///
    /// # Errors
    /// [`PinError`] naming both sides.
    pub fn input(&mut self, spec: PinSpec, owner: &str) -> Result<Input, PinError> {
        self.claim(spec.pin, owner)?;
        Ok(Input::new(spec))
    }

    /// Claims a pin as an open-drain line with the resistor of `spec`, let go of.
    ///
    /// # Errors
    /// [`PinError`] naming both sides.
    pub fn line(&mut self, spec: PinSpec, owner: &str) -> Result<Line, PinError> {
        self.claim(spec.pin, owner)?;
        Ok(Line::new(spec))
    }

    /// Claims a pin as an output for the step interrupt, off.
    ///
    /// # Errors
    /// [`PinError`] naming both sides.
    pub fn fast_output(&mut self, spec: PinSpec, owner: &str) -> Result<FastPin, PinError> {
        self.claim(spec.pin, owner)?;
        Ok(FastPin::off(spec))
    }

    /// Gives a pin back that was claimed for a while: it is as after a reset, an analog input without a
    /// resistor (RM0399 section 12.4.1, reset value of GPIOx_MODER).
    pub fn give_back(&mut self, pin: PinName, owner: &str) {
        if self.owner(pin) == Some(owner) {
            configure(pin, Mode::Analog, Pull::Floating, false);
            self.claims.retain(|(claimed, _)| *claimed != pin);
        }
    }

    /// Claims a pin as an analog input.
    ///
    /// # Errors
    /// [`PinError`] naming both sides.
    pub fn analog(&mut self, pin: PinName, owner: &str) -> Result<(), PinError> {
        self.claim(pin, owner)?;
        configure(pin, Mode::Analog, Pull::Floating, false);
        Ok(())
    }

    /// Claims a pin for a peripheral whose output changes less than a million times a second.
    ///
    /// # Errors
    /// [`PinError`] naming both sides.
    #[inline(never)]
    pub fn alternate(&mut self, spec: PinSpec, function: u8, owner: &str) -> Result<(), PinError> {
        self.claim(spec.pin, owner)?;
        configure(spec.pin, Mode::Alternate(function, Speed::Low), spec.pull, spec.open_drain);
        Ok(())
    }
}
