//! Supplies, and the switches between them and the loads.

use super::World;
use super::parts::Path;

/// Supply for which heater power is stated, volts.
pub(super) const NOMINAL_VOLTS: f64 = 24.0;

impl World {
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

    /// Sets the motor supply, volts.
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
            Path::Relay | Path::Header => NOMINAL_VOLTS,
        }
    }

    /// Returns whether the level on an output's pin reaches the loads on its path.
    pub(super) const fn passes(&self, path: Path) -> bool {
        matches!(path, Path::Header) || self.fet_buffer_on
    }
}
