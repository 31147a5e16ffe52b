//! Sensors that a converter chip reads: the chips' side of the SPI buses.

use super::World;
use crate::models::converter::{Converter, Terminals};

/// Excess of the chips' temperature over the air's, kelvin.
const CHIP_WARMTH_K: f64 = 3.0;

impl World {
    /// Lowers the select of the chip of a heater's sensor.
    pub fn converter_select(&mut self, at_ns: u64, heater: usize) {
        self.advance(at_ns);
        let terminals = Terminals {
            sensor_c: self.felt_c(heater),
            wiring: self.heaters[heater].wiring,
            leads: self.heaters[heater].leads,
            chip_c: self.config.air_c + CHIP_WARMTH_K,
        };
        if let Some(converter) = &mut self.heaters[heater].converter {
            converter.select(at_ns, &terminals);
        }
    }

    /// Exchanges a byte in each direction; without a chip nothing drives the line.
    pub fn converter_transfer(&mut self, heater: usize, mosi: u8) -> u8 {
        self.heaters[heater].converter.as_mut().map_or(0xFF, |converter| converter.transfer(mosi))
    }

    /// Raises the select of the chip of a heater's sensor.
    pub fn converter_deselect(&mut self, at_ns: u64, heater: usize) {
        if let Some(converter) = &mut self.heaters[heater].converter {
            converter.deselect(at_ns);
        }
    }

    /// Returns the registers of the chip of a heater's sensor; empty if there are none.
    #[must_use]
    pub fn converter_registers(&self, heater: usize) -> &[u8] {
        self.heaters[heater].converter.as_ref().map_or(&[], Converter::registers)
    }
}
