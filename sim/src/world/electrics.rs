//! Supplies, the switches between them and the loads, and the analog inputs.

use board_facts::wiring::{self, Feed, SUPPLY_DIVIDER};

use super::{AnalogInput, Pin, World};
use crate::models::thermistor::REFERENCE_VOLTS;

/// Full scale of a 16-bit conversion.
const FULL_SCALE_COUNTS: f64 = 65_535.0;
/// Input of the heaters' and fans' supply.
pub const VFET_INPUT: AnalogInput = AnalogInput::of(&wiring::HEATER_SUPPLY);
/// Input of the motor supply.
pub const VMOTOR_INPUT: AnalogInput = AnalogInput::of(&wiring::MOTOR_SUPPLY);

/// Path from an output's pin to the current through its load.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Path {
    /// The buffer, the output's own MOSFET, and the load switch.
    Switched,
    /// The buffer and the output's own MOSFETs: the bed.
    Direct,
    /// The buffer and a relay with a supply of its own.
    Relay,
    /// A header pin that leads to something with a supply of its own.
    Header,
}

impl Path {
    /// Returns the path of the output on this pin.
    pub fn of(pin: Option<Pin>) -> Self {
        let output = pin.and_then(|pin| wiring::power_output(&pin.to_string()));
        match output.map(|output| output.feed) {
            Some(Feed::Switched) => Self::Switched,
            Some(Feed::Direct) => Self::Direct,
            Some(Feed::FiveVolts) => Self::Relay,
            None => Self::Header,
        }
    }
}

impl World {
    /// Sets the level of the output buffer's enable (PF14): low enables, and it floats high.
    pub fn fet_buffer_pin(&mut self, at_ns: u64, high: bool) {
        self.advance(at_ns);
        self.fet_buffer_on = !high;
    }

    /// Sets the level of the load switch of heaters and fans (PD7): high switches on.
    pub fn fet_power_pin(&mut self, at_ns: u64, high: bool) {
        self.advance(at_ns);
        self.fet_power_on = high;
    }

    /// Returns whether the load switch of heaters and fans conducts.
    pub(super) const fn fets_supplied(&self) -> bool {
        self.fet_power_on || self.fet_switch_stuck_on
    }

    /// Sets the duty of a timer output (PWM1_1 is timer 0, channel 0), 0 to 1, from now on. Laser modules
    /// and spindle drives hang on these; they filter, so the mean is all they see.
    pub fn pwm(&mut self, timer: usize, channel: usize, duty: f64) {
        self.pwm[timer][channel] = duty;
    }

    /// Duty of a timer output, 0 to 1.
    #[must_use]
    pub const fn pwm_duty(&self, timer: usize, channel: usize) -> f64 {
        self.pwm[timer][channel]
    }

    /// Sets the frequency of a timer, hertz, from now on.
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

    /// Returns the motor supply, volts.
    #[must_use]
    pub const fn vmotor_v(&self) -> f64 {
        self.vmotor_v
    }

    /// Returns the supply at hot ends and fans, volts: zero while the load switch is off.
    #[must_use]
    pub const fn vfet_v(&self) -> f64 {
        if self.fets_supplied() { self.vfet_v } else { 0.0 }
    }

    /// Returns the voltage that drives current through a load on this path when its MOSFET conducts.
    pub(super) const fn load_volts(&self, path: Path) -> f64 {
        match path {
            Path::Switched => self.vfet_v(),
            Path::Direct => self.vfet_v,
            Path::Relay | Path::Header => super::heat::NOMINAL_VOLTS,
        }
    }

    /// Returns whether the level on an output's pin reaches the loads on its path.
    pub(super) const fn passes(&self, path: Path) -> bool {
        matches!(path, Path::Header) || self.fet_buffer_on
    }

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
