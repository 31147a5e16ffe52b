//! Analog inputs: supplies, sensors of heaters, the sensor of the filament.

use board_facts::wiring::{self, SUPPLY_DIVIDER};

use super::World;
use super::config::AnalogInput;
use crate::models::thermistor::REFERENCE_VOLTS;

/// Full scale of a 16-bit conversion.
const FULL_SCALE_COUNTS: f64 = 65_535.0;
/// Input of the heaters' and fans' supply.
pub const VFET_INPUT: AnalogInput = AnalogInput::of(&wiring::HEATER_SUPPLY);
/// Input of the motor supply.
pub const VMOTOR_INPUT: AnalogInput = AnalogInput::of(&wiring::MOTOR_SUPPLY);

impl World {
    /// Voltage on an analog input; `None` when nothing is connected to it.
    #[must_use]
    pub fn analog_volts(&self, input: AnalogInput) -> Option<f64> {
        if input == VFET_INPUT {
            // The supply is measured before the load switch.
            return Some(self.vfet_v / SUPPLY_DIVIDER);
        }
        if input == VMOTOR_INPUT {
            return Some(self.vmotor_v / SUPPLY_DIVIDER);
        }
        if let Some(volts) = self.filament_volts(input) {
            return Some(volts);
        }
        let heater = self.config.heaters.iter().position(|heater| heater.sensor == Some(input))?;
        Some(self.sensor_volts(heater))
    }

    /// A 16-bit conversion of an analog input; an unconnected one reads the 3.3 V of its divider's pull-up.
    #[must_use]
    pub fn adc_counts(&self, input: AnalogInput) -> u16 {
        let volts = self.analog_volts(input).unwrap_or(REFERENCE_VOLTS);
        (volts / REFERENCE_VOLTS * FULL_SCALE_COUNTS).clamp(0.0, FULL_SCALE_COUNTS).round() as u16
    }
}
