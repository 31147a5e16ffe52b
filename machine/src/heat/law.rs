//! Control laws: PID on error, PID on measurement, bang-bang.
//!
//! Symbols: e = target - reading in degrees, T the reading, dt the sample period in seconds, output 0 to 255.
//!
//! On error: I += Ki e dt, kept within 0 and i_max; output = Kp e + I - Kd dT/dt. On measurement: I += Ki e
//! dt - Kp dT, kept within 0 and the output limit; output = I - Kd dT/dt. The proportional part resists
//! change of the reading instead of pulling at the error, so a step of the target does not overshoot.

use units::{Celsius, Duty, Micros};

use super::settings::LawSettings;
use super::tuning::Relay;

/// Gains and limits of a PID law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PidGains {
    /// Output per degree.
    pub p: f32,
    /// Output per degree and second.
    pub i: f32,
    /// Output per degree per second.
    pub d: f32,
    /// Largest integral, in output units.
    pub i_max: f32,
    /// Proportional on measurement instead of on error.
    pub on_measurement: bool,
    /// Let the integral move only while the output is not at a limit.
    pub conditional_integral: bool,
}

/// A PID law and its memory.
#[derive(Clone, Copy, Debug)]
pub struct Pid {
    gains: PidGains,
    max: f32,
    integral: f32,
    last_reading: f32,
    last_output: f32,
}

/// An on/off law with hysteresis.
#[derive(Clone, Copy, Debug)]
pub struct BangBang {
    hysteresis: Celsius,
    max: Duty,
    on: bool,
}

/// The law of one heater.
#[derive(Clone, Copy, Debug)]
pub enum Law {
    /// Proportional, integral, derivative.
    Pid(Pid),
    /// On and off.
    BangBang(BangBang),
    /// Finding PID gains.
    Tuning(Relay),
}

impl Law {
    /// A law at rest.
    #[must_use]
    pub const fn new(settings: &LawSettings, max: Duty) -> Self {
        match settings {
            LawSettings::Pid(gains) => {
                let max = max.0 as f32;
                Self::Pid(Pid { gains: *gains, max, integral: 0.0, last_reading: 0.0, last_output: 0.0 })
            }
            LawSettings::BangBang { hysteresis } => {
                Self::BangBang(BangBang { hysteresis: *hysteresis, max, on: false })
            }
        }
    }

    /// Heating starts: forget the past, so that neither the integral nor the derivative jumps.
    pub fn start(&mut self, reading: Celsius, output: Duty) {
        match self {
            Self::Pid(pid) => {
                pid.last_reading = reading.0;
                pid.last_output = f32::from(output.0);
                pid.integral = pid.last_output.clamp(0.0, pid.gains.i_max.max(0.0));
            }
            Self::BangBang(law) => law.on = false,
            Self::Tuning(_) => {}
        }
    }

    /// One sample.
    pub fn update(&mut self, target: Celsius, reading: Celsius, period: Micros) -> Duty {
        match self {
            Self::Pid(pid) => pid.update(target.0, reading.0, period.seconds() as f32),
            Self::BangBang(law) => law.update(target, reading),
            Self::Tuning(relay) => relay.update(target, reading, period),
        }
    }
}

impl Pid {
    fn update(&mut self, target: f32, reading: f32, dt: f32) -> Duty {
        let gains = self.gains;
        let error = target - reading;
        let change = reading - self.last_reading;
        let derivative = if dt > 0.0 { change / dt } else { 0.0 };
        let saturated = self.last_output >= self.max || self.last_output <= 0.0;
        let output = if gains.on_measurement {
            self.integral = (self.integral + gains.i * error * dt - gains.p * change).clamp(0.0, self.max);
            self.integral - gains.d * derivative
        } else {
            if !(gains.conditional_integral && saturated) {
                self.integral = (self.integral + gains.i * error * dt).clamp(0.0, gains.i_max.max(0.0));
            }
            gains.p * error + self.integral - gains.d * derivative
        };
        self.last_reading = reading;
        self.last_output = output.clamp(0.0, self.max);
        Duty(self.last_output as u8)
    }
}

impl BangBang {
    fn update(&mut self, target: Celsius, reading: Celsius) -> Duty {
        if reading > target + self.hysteresis {
            self.on = false;
        } else if reading < target - self.hysteresis {
            self.on = true;
        }
        if self.on { self.max } else { Duty::OFF }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const GAINS: PidGains =
        PidGains { p: 10.0, i: 0.3, d: 200.0, i_max: 255.0, on_measurement: false, conditional_integral: false };
    const PERIOD: Micros = Micros::from_millis(50);

    /// A hotend: 4 C/s at full output, losses of 1/120 a second, a sensor that lags by 3 s. Without the lag
    /// the derivative would see the heater's own switching.
    fn settles_at(gains: PidGains, target: f32) -> f32 {
        let mut law = Law::new(&LawSettings::Pid(gains), Duty::FULL);
        let (mut block, mut sensor) = (20.0_f32, 20.0_f32);
        law.start(Celsius(sensor), Duty::OFF);
        for _ in 0..20 * 1_200 {
            let duty = law.update(Celsius(target), Celsius(sensor), PERIOD);
            block += (f32::from(duty.0) / 255.0 * 4.0 - (block - 20.0) / 120.0) * 0.05;
            sensor += (block - sensor) / 3.0 * 0.05;
        }
        sensor
    }

    #[test]
    fn both_pid_forms_settle_at_the_target() {
        for on_measurement in [false, true] {
            let settled = settles_at(PidGains { on_measurement, ..GAINS }, 200.0);
            assert!((settled - 200.0).abs() < 1.0, "on_measurement {on_measurement} settles at {settled}");
        }
    }

    #[test]
    fn bang_bang_switches_only_outside_its_band() {
        let mut law = Law::new(&LawSettings::BangBang { hysteresis: Celsius(2.0) }, Duty(200));
        let mut at = |reading| law.update(Celsius(60.0), Celsius(reading), PERIOD);
        assert_eq!(
            [57.0, 59.0, 61.0, 62.5, 61.0, 59.0, 57.5].map(&mut at),
            [Duty(200), Duty(200), Duty(200), Duty(0), Duty(0), Duty(0), Duty(200)]
        );
    }

    proptest! {
        /// Whatever the gains and readings, the output never exceeds its ceiling.
        #[test]
        fn output_stays_under_the_ceiling(
            p in 0.0..1e4_f32, i in 0.0..1e4_f32, d in 0.0..1e4_f32, ceiling in 0_u8..=255,
            on_measurement: bool, conditional_integral: bool,
            readings in proptest::collection::vec(-50.0..400.0_f32, 1..50),
        ) {
            let gains = PidGains { p, i, d, i_max: 255.0, on_measurement, conditional_integral };
            let mut law = Law::new(&LawSettings::Pid(gains), Duty(ceiling));
            for reading in readings {
                prop_assert!(law.update(Celsius(200.0), Celsius(reading), PERIOD) <= Duty(ceiling));
            }
        }
    }
}
