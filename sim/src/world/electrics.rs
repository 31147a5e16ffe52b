//! Supplies, the switches between them and the loads, and the analog inputs.

use super::{AnalogInput, World};
use crate::models::thermistor::REFERENCE_VOLTS;

/// Both supply monitors divide by 11 (100 kOhm over 10 kOhm).
const SUPPLY_DIVIDER: f64 = 11.0;
/// Full scale of a 16-bit conversion.
const FULL_SCALE_COUNTS: f64 = 65_535.0;
/// ADC3 input of the heater and fan supply (PF8).
pub const VFET_INPUT: AnalogInput = AnalogInput { converter: 3, channel: 7 };
/// ADC3 input of the motor supply (PH5).
pub const VMOTOR_INPUT: AnalogInput = AnalogInput { converter: 3, channel: 16 };

impl World {
    /// The level of the output buffer's enable (PF14): low enables, and it floats high.
    pub fn fet_buffer_pin(&mut self, at_ns: u64, high: bool) {
        self.advance(at_ns);
        self.fet_buffer_on = !high;
    }

    /// The level of the load switch of heaters and fans (PD7): high switches on.
    pub fn fet_power_pin(&mut self, at_ns: u64, high: bool) {
        self.advance(at_ns);
        self.fet_power_on = high;
    }

    /// The load switch of heaters and fans conducts.
    pub(super) const fn fets_supplied(&self) -> bool {
        self.fet_power_on || self.fet_switch_stuck_on
    }

    /// A timer output (PWM1_1 is timer 0, channel 0) has this duty, 0 to 1, from now on. Laser modules and spindle drives
    /// hang on these; they filter, so the mean is all they see.
    pub fn pwm(&mut self, timer: usize, channel: usize, duty: f64) {
        self.pwm[timer][channel] = duty;
    }

    /// Duty of a timer output, 0 to 1.
    #[must_use]
    pub const fn pwm_duty(&self, timer: usize, channel: usize) -> f64 {
        self.pwm[timer][channel]
    }

    /// A timer runs at this frequency, hertz, from now on.
    pub fn pwm_rate(&mut self, timer: usize, hertz: f64) {
        self.pwm_hz[timer] = hertz;
    }

    /// Frequency of a timer, hertz; zero while it stands.
    #[must_use]
    pub const fn pwm_hz(&self, timer: usize) -> f64 {
        self.pwm_hz[timer]
    }

    pub(super) fn set_motor_supply(&mut self, volts: f64) {
        self.vmotor_v = volts;
        self.drivers.iter_mut().for_each(|driver| driver.set_supply(volts));
    }

    /// Motor supply, volts.
    #[must_use]
    pub const fn vmotor_v(&self) -> f64 {
        self.vmotor_v
    }

    /// Supply at the heaters and fans, volts: zero while the load switch is off.
    #[must_use]
    pub const fn vfet_v(&self) -> f64 {
        if self.fets_supplied() { self.vfet_v } else { 0.0 }
    }

    /// Voltage on an analog input; `None` when nothing is connected to it.
    #[must_use]
    pub fn analog_volts(&self, input: AnalogInput) -> Option<f64> {
        if input == VFET_INPUT {
            return Some(self.vfet_v() / SUPPLY_DIVIDER);
        }
        if input == VMOTOR_INPUT {
            return Some(self.vmotor_v / SUPPLY_DIVIDER);
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
