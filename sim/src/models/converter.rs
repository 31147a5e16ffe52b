//! Converter chips of temperature sensors, as their SPI shows them: MAX31855, MAX31856 and MAX31865.
//!
//! A frame is what happens between select and deselect; bytes travel with their most significant bit first.
//! Which edges of the clock count is the bus's affair.

mod max31855;
mod max31856;
mod max31865;

use super::thermistor::{Curve, Wiring};
pub use max31855::Max31855;
pub use max31856::{Max31856, Thermocouple};
pub use max31865::Max31865;

/// What is at the terminals of a chip, and around it.
#[derive(Clone, Copy, Debug)]
pub struct Terminals {
    /// The sensor's temperature, degrees Celsius.
    pub sensor_c: f64,
    /// What is wrong with its wires.
    pub wiring: Wiring,
    /// What is wrong with single leads of a platinum sensor of four wires.
    pub leads: Leads,
    /// The chip's own temperature: the cold junction's, degrees Celsius.
    pub chip_c: f64,
}

/// What is wrong with single leads of a platinum sensor of four wires: what only the chip's fault detection
/// cycle finds, or tells apart.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Leads {
    /// Nothing.
    #[default]
    Sound,
    /// A wire that brings the current is open.
    ForceOpen,
    /// RTDIN- is at ground.
    MinusToGround,
    /// RTDIN+ is at ground.
    PlusToGround,
}

/// Which chip there is, and what is soldered to it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kind {
    /// For thermocouples of the one type it is made for.
    Max31855,
    /// For thermocouples of all types.
    Max31856 {
        /// The one that is connected.
        thermocouple: Thermocouple,
    },
    /// For platinum sensors.
    Max31865 {
        /// The one that is connected.
        sensor: Curve,
        /// The reference resistor, ohms.
        reference_ohms: f64,
    },
}

/// What drives the data line.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum DataLine {
    /// The chip.
    #[default]
    Sound,
    /// Nothing: the processor's pull-up.
    Silent,
    /// Ground, or a chip without supply.
    Low,
}

#[derive(Clone, Debug)]
enum Chip {
    Max31855(Max31855),
    Max31856(Max31856),
    Max31865(Max31865),
}

/// A chip and its data line.
#[derive(Clone, Debug)]
pub struct Converter {
    kind: Kind,
    chip: Chip,
    /// What is wrong with its data line.
    pub data: DataLine,
}

impl Converter {
    /// A chip whose supply comes up now.
    #[must_use]
    pub fn new(kind: Kind, at_ns: u64) -> Self {
        let chip = match kind {
            Kind::Max31855 => Chip::Max31855(Max31855::new(at_ns)),
            Kind::Max31856 { thermocouple } => Chip::Max31856(Max31856::new(thermocouple)),
            Kind::Max31865 { sensor, reference_ohms } => Chip::Max31865(Max31865::new(sensor, reference_ohms)),
        };
        Self { kind, chip, data: DataLine::Sound }
    }

    /// Its supply fails and comes back now.
    pub fn reset(&mut self, at_ns: u64) {
        self.chip = Self::new(self.kind, at_ns).chip;
    }

    /// Its select goes low.
    pub fn select(&mut self, at_ns: u64, terminals: &Terminals) {
        match &mut self.chip {
            Chip::Max31855(chip) => chip.select(at_ns, terminals),
            Chip::Max31856(chip) => chip.select(at_ns, terminals),
            Chip::Max31865(chip) => chip.select(at_ns, terminals),
        }
    }

    /// A byte each way.
    pub fn transfer(&mut self, mosi: u8) -> u8 {
        let miso = match &mut self.chip {
            Chip::Max31855(chip) => chip.transfer(),
            Chip::Max31856(chip) => chip.transfer(mosi),
            Chip::Max31865(chip) => chip.transfer(mosi),
        };
        match self.data {
            DataLine::Sound => miso,
            DataLine::Silent => 0xFF,
            DataLine::Low => 0,
        }
    }

    /// Its select goes high.
    pub fn deselect(&mut self, at_ns: u64) {
        match &mut self.chip {
            Chip::Max31855(_) => {}
            Chip::Max31856(chip) => chip.deselect(at_ns),
            Chip::Max31865(chip) => chip.deselect(at_ns),
        }
    }

    /// Its registers; a MAX31855 has none.
    #[must_use]
    pub fn registers(&self) -> &[u8] {
        match &self.chip {
            Chip::Max31855(_) => &[],
            Chip::Max31856(chip) => chip.registers(),
            Chip::Max31865(chip) => chip.registers(),
        }
    }
}

/// Where a frame with an address is: both chips count their address on with every byte (MAX31856 data sheet,
/// "Serial Interface"; MAX31865 data sheet, "Serial Interface").
#[derive(Clone, Copy, Debug, Default)]
struct Cursor {
    at: Option<u8>,
    writes: bool,
}

impl Cursor {
    /// Before the address.
    fn select(&mut self) {
        *self = Self::default();
    }

    /// The next byte. It goes to a register, or it is the address, or there is one to give.
    fn next(&mut self, mosi: u8, registers: u8) -> Access {
        let Some(at) = self.at else {
            (self.at, self.writes) = (Some((mosi & 0x7F) % registers), mosi & 0x80 != 0);
            return Access::Address;
        };
        self.at = Some((at + 1) % registers);
        if self.writes { Access::Write(usize::from(at)) } else { Access::Read(usize::from(at)) }
    }
}

/// What a byte of a frame is.
enum Access {
    Address,
    Write(usize),
    Read(usize),
}

#[cfg(test)]
mod tests;
