//! Thermal compensation of Z. A frame grows with its temperature, and the tool comes nearer to the bed or
//! farther from it; by the reading of a sensor on the frame Z is shifted by so much for each degree since Z
//! was homed.
//!
//! The shift takes effect with the next move that names Z, so it rides on moves and never makes one: within a
//! layer nothing changes. The size of the shift is limited to `max_adjust`, whatever the sensor reads.

use core::fmt::{self, Write};

use base::failure::{Answer, Failure, Outcome};
use base::sessions::Reply;
use config::MachineConfig;
use program::Words;
use units::HeaterId;

/// Least change of the offset, mm: a lesser change is a fraction of a step.
const LEAST_CHANGE: f64 = 0.001;

/// State of the thermal compensation.
#[derive(Clone, Copy, Debug, Default)]
pub struct Thermal {
    /// Sensor on the frame.
    sensor: Option<HeaterId>,
    /// Whether M290.1 S has it on.
    enabled: bool,
    /// Coefficient, mm for a degree, M290.1 K.
    coefficient: f64,
    smooth_s: f64,
    /// Greatest offset either way, mm.
    max_adjust: f64,
    /// Smoothed temperature of the frame, degrees Celsius.
    celsius: Option<f64>,
    /// Temperature of the frame when Z was homed, degrees Celsius.
    reference: Option<f64>,
    /// Offset in force, mm.
    offset: f64,
}

impl Thermal {
    /// Takes the settings from the configuration.
    pub fn new(config: &MachineConfig) -> Self {
        let settings = &config.z_thermal;
        let named =
            config.heaters().find(|(_, control)| !settings.sensor.is_empty() && control.name == settings.sensor);
        Self {
            sensor: named.map(|(id, _)| id),
            enabled: true,
            coefficient: settings.coefficient,
            smooth_s: settings.smooth_s,
            max_adjust: settings.max_adjust.0,
            ..Self::default()
        }
    }

    /// Returns the sensor on the frame, if there is one.
    pub const fn sensor(&self) -> Option<HeaterId> {
        self.sensor
    }

    /// Returns whether there is anything to compensate.
    fn is_on(&self) -> bool {
        self.enabled && self.coefficient != 0.0
    }

    /// Notes that Z was homed, and so is right at this temperature, without compensation.
    pub const fn homed(&mut self) {
        self.reference = self.celsius;
        self.offset = 0.0;
    }

    /// Returns the temperature of the frame at which Z is right, degrees Celsius.
    pub const fn reference(&self) -> Option<f64> {
        self.reference
    }

    /// Sets the temperature at which Z is right, as it was before the power went. Returns the present offset,
    /// mm.
    pub fn refer_to(&mut self, reference: Option<f64>) -> f64 {
        self.reference = reference.or(self.reference);
        self.offset = self.wanted();
        self.offset
    }

    /// Returns the offset in force, mm.
    pub const fn offset(&self) -> f64 {
        self.offset
    }

    /// Takes a reading so long after the one before, s; none where the sensor does not say. Returns the
    /// offset where it has changed, mm.
    pub fn read(&mut self, celsius: Option<f64>, seconds: f64, is_homed: bool) -> Option<f64> {
        let celsius = celsius.filter(|celsius| celsius.is_finite())?;
        let share = units::within(seconds / self.smooth_s.max(seconds), 0.0, 1.0);
        let smoothed = self.celsius.map_or(celsius, |before| before + share * (celsius - before));
        self.celsius = Some(smoothed);
        if self.reference.is_none() && is_homed {
            self.reference = Some(smoothed);
        }
        let wanted = self.wanted();
        if wanted == self.offset || libm::fabs(wanted - self.offset) < LEAST_CHANGE && wanted != 0.0 {
            return None;
        }
        self.offset = wanted;
        Some(wanted)
    }

    /// Returns the offset for the present temperature, mm.
    fn wanted(&self) -> f64 {
        let (Some(now), Some(then)) = (self.celsius, self.reference.filter(|_| self.is_on())) else { return 0.0 };
        let most = self.max_adjust;
        units::within(-self.coefficient * (now - then), -most, most)
    }

    /// M290.1: K is the coefficient, mm for a degree; S0 switches the compensation off, S1 on; R is the
    /// temperature at which Z is right. Prints the settings.
    pub fn command(&mut self, words: &Words<'_>, reply: &mut Reply<'_>) -> Outcome {
        if self.sensor.is_none() {
            return Err(Failure::refused(
                &"M290.1 needs to know which sensor the frame has: [z thermal adjust] sensor",
            ));
        }
        if let Some(on) = words.get('S') {
            self.enabled = on != 0.0;
        }
        self.coefficient = words.get('K').unwrap_or(self.coefficient);
        if let Some(reference) = words.get('R') {
            self.reference = Some(reference);
        }
        let state = if self.is_on() { "on" } else { "off" };
        let (coefficient, most) = (self.coefficient, self.max_adjust);
        reply.say(format_args!("Z by temperature: {state}, {coefficient:.6} mm for a degree, {most} mm at most\n"));
        match (self.celsius, self.reference) {
            (Some(now), Some(then)) => {
                let offset = self.offset;
                reply
                    .say(format_args!("{now:.2} C now, {then:.2} C as Z was homed: Z is shifted by {offset:+.4} mm\n"));
            }
            (Some(now), None) => reply.say(format_args!("{now:.2} C now; Z is not homed\n")),
            _ => reply.say(format_args!("the sensor has not said anything yet\n")),
        }
        Ok(Answer::Ok)
    }

    /// Writes the line that M500 saves of the compensation.
    pub fn write(&self, text: &mut impl Write, config: &MachineConfig) -> fmt::Result {
        if self.sensor.is_none() || self.enabled && self.coefficient == config.z_thermal.coefficient {
            return Ok(());
        }
        let (on, coefficient) = (u8::from(self.enabled), self.coefficient);
        writeln!(text, ";Z by temperature (mm for a degree):\nM290.1 S{on} K{coefficient:.8}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn thermal(coefficient: f64) -> Thermal {
        let sensor = HeaterId::all().next();
        Thermal { sensor, enabled: true, coefficient, smooth_s: 2.0, max_adjust: 0.3, ..Thermal::default() }
    }

    proptest! {
        /// After long enough the offset is what the formula says, and on the way it never jumps by more than
        /// a smoothed reading does.
        #[test]
        fn it_comes_to_what_the_temperature_asks_for(coefficient in -0.01..0.01_f64, from in 10.0..40.0_f64, rise in -10.0..30.0_f64) {
            let mut thermal = thermal(coefficient);
            thermal.read(Some(from), 0.1, true);
            let mut offset = 0.0;
            for _ in 0..400 {
                if let Some(next) = thermal.read(Some(from + rise), 0.1, true) {
                    prop_assert!((next - offset).abs() <= (coefficient * rise).abs() * 0.06 + LEAST_CHANGE, "{offset} {next}");
                    offset = next;
                }
            }
            let wanted = (-coefficient * rise).clamp(-0.3, 0.3);
            prop_assert!((offset - wanted).abs() <= LEAST_CHANGE, "{offset} for {wanted}");
        }
    }

    #[test]
    fn nothing_is_made_up_for_before_homing_or_without_a_reading() {
        let mut thermal = thermal(-0.01);
        assert_eq!(thermal.read(Some(20.0), 1.0, false), None);
        assert_eq!(thermal.read(Some(40.0), 10.0, false), None);
        assert_eq!(thermal.read(None, 1.0, true), None);
        assert_eq!(thermal.read(Some(40.0), 1.0, true), None, "homed at this temperature");
        assert_eq!(thermal.read(Some(50.0), 10.0, true), Some(0.1));
        thermal.homed();
        assert_eq!(thermal.read(Some(50.0), 10.0, true), None, "at once, not with the next reading");
        assert_eq!(thermal.read(Some(f64::NAN), 1.0, true), None);
        assert_eq!(thermal.read(Some(150.0), 1_000.0, true), Some(0.3), "no more than max_adjust");
    }

    #[test]
    fn after_a_power_loss_z_is_right_where_it_was_right_before() {
        let mut thermal = thermal(-0.01);
        thermal.read(Some(30.0), 0.1, false);
        assert!((thermal.refer_to(Some(20.0)) - 0.1).abs() < 1e-12 && (thermal.offset() - 0.1).abs() < 1e-12);
        assert!((thermal.refer_to(None) - 0.1).abs() < 1e-12, "nothing was kept");
        assert_eq!(thermal.reference(), Some(20.0));
        assert_eq!(thermal.refer_to(Some(-90.0)), 0.3, "no further than allowed");
        thermal.homed();
        assert_eq!((thermal.reference(), thermal.offset()), (Some(30.0), 0.0));
    }
}
