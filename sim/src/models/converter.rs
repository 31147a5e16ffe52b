//! Converter chips of temperature sensors, as their SPI shows them: MAX31855, MAX31856 and MAX31865.
//!
//! A frame lasts from select to deselect; bytes travel with their most significant bit first. The bus
//! decides which edges of the clock count.

mod max31855;
mod max31856;
mod max31865;

use super::thermistor::{Curve, Wiring};
pub use max31855::Max31855;
pub use max31856::{Max31856, Thermocouple};
pub use max31865::Max31865;

/// Sensor and surroundings at the terminals of a chip.
#[derive(Clone, Copy, Debug)]
pub struct Terminals {
    /// The sensor's temperature, degrees Celsius.
    pub sensor_c: f64,
    /// Fault of the sensor's wires.
    pub wiring: Wiring,
    /// Fault of single leads of a platinum sensor of four wires.
    pub leads: Leads,
    /// The chip's own temperature: the cold junction's, degrees Celsius.
    pub chip_c: f64,
}

/// Fault of single leads of a platinum sensor of four wires, which only the chip's fault detection cycle
/// finds or tells apart.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Leads {
    /// No fault of the leads.
    #[default]
    Sound,
    /// A wire that brings the current is open.
    ForceOpen,
    /// RTDIN- is at ground.
    MinusToGround,
    /// RTDIN+ is at ground.
    PlusToGround,
}

/// Model of the chip, and the sensor soldered to it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kind {
    /// For thermocouples of the single type the chip is made for.
    Max31855,
    /// For thermocouples of all types.
    Max31856 {
        /// Type of the connected thermocouple.
        thermocouple: Thermocouple,
    },
    /// For platinum resistance sensors.
    Max31865 {
        /// Curve of the connected sensor.
        sensor: Curve,
        /// The reference resistor, ohms.
        reference_ohms: f64,
    },
}

/// Driver of the data line.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum DataLine {
    /// Line driven by the chip.
    #[default]
    Sound,
    /// Line driven by nothing but the processor's pull-up.
    Silent,
    /// Line held at ground, or by a chip without supply.
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
    /// Fault of the chip's data line.
    pub data: DataLine,
}

impl Converter {
    /// Makes a chip whose supply comes up now.
    #[must_use]
    pub fn new(kind: Kind, at_ns: u64) -> Self {
        let chip = match kind {
            Kind::Max31855 => Chip::Max31855(Max31855::new(at_ns)),
            Kind::Max31856 { thermocouple } => Chip::Max31856(Max31856::new(thermocouple)),
            Kind::Max31865 { sensor, reference_ohms } => Chip::Max31865(Max31865::new(sensor, reference_ohms)),
        };
        Self { kind, chip, data: DataLine::Sound }
    }

    /// Lets the chip's supply fail and come back now.
    pub fn reset(&mut self, at_ns: u64) {
        self.chip = Self::new(self.kind, at_ns).chip;
    }

    /// Lowers the chip's select line.
    pub fn select(&mut self, at_ns: u64, terminals: &Terminals) {
        match &mut self.chip {
            Chip::Max31855(chip) => chip.select(at_ns, terminals),
            Chip::Max31856(chip) => chip.select(at_ns, terminals),
            Chip::Max31865(chip) => chip.select(at_ns, terminals),
        }
    }

    /// Exchanges a byte in each direction.
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

    /// Raises the chip's select line.
    pub fn deselect(&mut self, at_ns: u64) {
        match &mut self.chip {
            Chip::Max31855(_) => {}
            Chip::Max31856(chip) => chip.deselect(at_ns),
            Chip::Max31865(chip) => chip.deselect(at_ns),
        }
    }

    /// Returns the chip's registers; a MAX31855 has none.
    #[must_use]
    pub fn registers(&self) -> &[u8] {
        match &self.chip {
            Chip::Max31855(_) => &[],
            Chip::Max31856(chip) => chip.registers(),
            Chip::Max31865(chip) => chip.registers(),
        }
    }
}

/// Position within a frame with an address: both chips count their address on with every byte (MAX31856
/// data sheet, "Serial Interface"; MAX31865 data sheet, "Serial Interface").
#[derive(Clone, Copy, Debug, Default)]
struct Cursor {
    at: Option<u8>,
    writes: bool,
}

impl Cursor {
    /// Resets the cursor to before the address.
    fn select(&mut self) {
        *self = Self::default();
    }

    /// Takes the next byte: an address, a byte for a register, or the clocks for a byte to read.
    fn next(&mut self, mosi: u8, registers: u8) -> Access {
        let Some(at) = self.at else {
            (self.at, self.writes) = (Some((mosi & 0x7F) % registers), mosi & 0x80 != 0);
            return Access::Address;
        };
        self.at = Some((at + 1) % registers);
        if self.writes { Access::Write(usize::from(at)) } else { Access::Read(usize::from(at)) }
    }
}

/// Meaning of a byte of a frame.
enum Access {
    Address,
    Write(usize),
    Read(usize),
}

#[cfg(test)]
mod tests;
