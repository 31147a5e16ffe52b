//! Control laws: PID on error, PID on measurement, a model of the heater, bang-bang.
//!
//! Symbols: e = target - reading in degrees, T the reading, dt the sample period in seconds, output 0 to 255.
//!
//! On error: I += Ki e dt, kept within 0 and i_max; output = Kp e + I - Kd dT/dt. On measurement: I += Ki e
//! dt - Kp dT, kept within 0 and the output limit; output = I - Kd dT/dt. The proportional part resists
//! change of the reading instead of pulling at the error, so a step of the target does not overshoot.
//!
//! The derivative goes through a filter of first order: without it, noise of 0.15 C between two samples 50 ms
//! apart is 3 C/s, which times a usual gain is more than full output. The derivative is that of the reading
//! and not of the error, so that a new target does not kick.
//!
//! Anti-windup is by conditional integration (K. J. Astrom and T. Hagglund, "Advanced PID Control", 2006,
//! section 3.5): at a limit of the output the integral does not move further towards it. So after a heat-up
//! at full output it holds what it held before, and what is missing comes in near the target.

use config::{LawSettings, PidGains};
use units::{Celsius, Duty, Micros};

use crate::model::{Model, Surroundings};
use crate::step_test::StepTest;

/// A PID law and its memory.
#[derive(Clone, Copy, Debug)]
pub struct Pid {
    gains: PidGains,
    max: f32,
    integral: f32,
    last_reading: f32,
    last_output: f32,
    /// Filtered slope of the reading, degrees a second.
    slope: f32,
    steps: Steps,
}

/// An on/off law with hysteresis.
#[derive(Clone, Copy, Debug)]
pub struct BangBang {
    hysteresis: Celsius,
    max: Duty,
    on: bool,
}

/// Control law of a single heater.
#[derive(Clone, Copy, Debug)]
pub enum Law {
    /// PID: proportional, integral, derivative.
    Pid(Pid),
    /// Control by a model of the heater.
    Model(Model),
    /// Bang-bang: on and off.
    BangBang(BangBang),
    /// Step test of the heater's response.
    Tuning(StepTest),
}

/// Dithers an output into whole steps whose mean is the wanted fraction: rounding errors come with the next
/// samples. A step of 255 of a strong heater is two degrees.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Steps {
    left_out: f32,
}

impl Steps {
    /// Returns the next output; `wanted` is 0 to 255.
    pub(super) fn next(&mut self, wanted: f32) -> Duty {
        let whole = (wanted + self.left_out) as u8;
        self.left_out = units::within(wanted + self.left_out - f32::from(whole), 0.0, 1.0);
        Duty(whole)
    }
}

impl Law {
    /// Creates a law at rest.
    #[must_use]
    pub fn new(settings: &LawSettings, max: Duty) -> Self {
        match settings {
            LawSettings::Pid(gains) => Self::Pid(Pid::new(*gains, max)),
            LawSettings::Model(settings) => Self::Model(Model::new(*settings, max)),
            LawSettings::BangBang { hysteresis } => {
                Self::BangBang(BangBang { hysteresis: *hysteresis, max, on: false })
            }
        }
    }

    /// Forgets the past when heating starts, so that neither the integral nor the derivative jumps.
    pub fn start(&mut self, reading: Celsius, output: Duty) {
        match self {
            Self::Pid(pid) => pid.start(reading.0, f32::from(output.0)),
            Self::Model(model) => model.start(reading),
            Self::BangBang(law) => law.on = false,
            Self::Tuning(_) => {}
        }
    }

    /// Takes a sample and returns the duty.
    pub fn update(&mut self, target: Celsius, reading: Celsius, period: Micros, around: Surroundings) -> Duty {
        match self {
            Self::Pid(pid) => pid.update(target.0, reading.0, period.seconds() as f32),
            Self::Model(model) => model.update(target.0, reading.0, period.seconds() as f32, around),
            Self::BangBang(law) => law.update(target, reading),
            Self::Tuning(test) => test.update(target, reading, period),
        }
    }

    /// Returns the power beyond what the model explains, as a share of the explained; `None` without a model.
    pub(super) fn surplus(&self) -> Option<f32> {
        match self {
            Self::Model(model) => model.surplus(),
            _ => None,
        }
    }
}

impl Pid {
    fn new(gains: PidGains, max: Duty) -> Self {
        let max = f32::from(max.0);
        let steps = Steps::default();
        Self { gains, max, integral: 0.0, last_reading: 0.0, last_output: 0.0, slope: 0.0, steps }
    }

    fn start(&mut self, reading: f32, output: f32) {
        let integral = units::within(output, 0.0, self.gains.i_max.max(0.0));
        let (last_reading, last_output) = (reading, output);
        *self = Self { integral, last_reading, last_output, slope: 0.0, steps: Steps::default(), ..*self };
    }

    fn update(&mut self, target: f32, reading: f32, dt: f32) -> Duty {
        let gains = self.gains;
        let error = target - reading;
        let change = reading - self.last_reading;
        if dt > 0.0 {
            self.slope += (change / dt - self.slope) * dt / (gains.d_filter_s.max(0.0) + dt);
        }
        let is_limited = self.last_output >= self.max && error > 0.0 || self.last_output <= 0.0 && error < 0.0;
        let output = if gains.on_measurement {
            self.integral = units::within(self.integral + gains.i * error * dt - gains.p * change, 0.0, self.max);
            self.integral - gains.d * self.slope
        } else {
            if !(gains.conditional_integral && is_limited) {
                self.integral = units::within(self.integral + gains.i * error * dt, 0.0, gains.i_max.max(0.0));
            }
            gains.p * error + self.integral - gains.d * self.slope
        };
        self.last_reading = reading;
        self.last_output = units::within(output, 0.0, self.max);
        self.steps.next(self.last_output)
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
    use std::vec::Vec;

    const GAINS: PidGains = PidGains {
        p: 10.0,
        i: 0.3,
        d: 200.0,
        i_max: 255.0,
        d_filter_s: 0.5,
        on_measurement: false,
        conditional_integral: true,
    };
    const PERIOD: Micros = Micros::from_millis(50);

    /// A hotend: 4 C/s at full output, losses of 1/120 a second, a sensor that lags by 3 s. Without the lag
    /// the derivative would see the heater's own switching.
    fn settles_at(gains: PidGains, target: f32) -> f32 {
        let mut law = Law::new(&LawSettings::Pid(gains), Duty::FULL);
        let (mut block, mut sensor) = (20.0_f32, 20.0_f32);
        law.start(Celsius(sensor), Duty::OFF);
        for _ in 0..20 * 1_200 {
            let duty = law.update(Celsius(target), Celsius(sensor), PERIOD, Surroundings::default());
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
        let mut at = |reading| law.update(Celsius(60.0), Celsius(reading), PERIOD, Surroundings::default());
        assert_eq!(
            [57.0, 59.0, 61.0, 62.5, 61.0, 59.0, 57.5].map(&mut at),
            [Duty(200), Duty(200), Duty(200), Duty(0), Duty(0), Duty(0), Duty(200)]
        );
    }

    /// Returns the duties of a law that holds a reading which is noisy by 0.15 C and never changes otherwise.
    fn noisy(d_filter_s: f32) -> Vec<u8> {
        let gains = PidGains { p: 34.0, i: 0.7, d: 200.0, d_filter_s, ..GAINS };
        let mut law = Law::new(&LawSettings::Pid(gains), Duty::FULL);
        law.start(Celsius(80.0), Duty(100));
        let mut noise = 1_u32;
        let mut duty = || {
            noise = noise.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            let reading = 80.0 + ((noise >> 8) as f32 / (1 << 24) as f32 - 0.5) * 0.3;
            law.update(Celsius(80.0), Celsius(reading), PERIOD, Surroundings::default()).0
        };
        (0..20 * 60).map(|_| duty()).collect()
    }

    #[test]
    fn noise_does_not_drive_the_output_to_its_limits() {
        let limits = |duties: &[u8]| duties.iter().filter(|duty| [0, 255].contains(*duty)).count();
        assert!(limits(&noisy(0.0)) > 300, "without a filter a quarter of the samples and more");
        let filtered = noisy(GAINS.d_filter_s);
        assert!(limits(&filtered) == 0, "{} of {}", limits(&filtered), filtered.len());
    }

    #[test]
    fn what_rounding_leaves_out_comes_later() {
        for wanted in [0.0, 0.25, 17.6, 254.5, 255.0_f32] {
            let mut steps = Steps::default();
            let sum: u32 = (0..1_000).map(|_| u32::from(steps.next(wanted).0)).sum();
            assert!((sum as f32 - wanted * 1_000.0).abs() <= 1.0, "{sum} of {wanted}");
        }
    }

    #[test]
    fn the_integral_waits_while_the_output_is_at_its_limit() {
        let mut pid = Pid::new(GAINS, Duty::FULL);
        pid.start(60.0, 0.0);
        for _ in 0..1_000 {
            pid.update(200.0, 60.0, 0.05);
        }
        assert!(pid.integral < 5.0, "{}", pid.integral);
        // At the other limit the integral still falls.
        pid.integral = 100.0;
        pid.update(60.0, 61.0, 0.05);
        pid.update(60.0, 61.0, 0.05);
        assert!(pid.integral < 100.0);
    }

    proptest! {
        /// The output never exceeds its ceiling, for any gains and readings.
        #[test]
        fn output_stays_under_the_ceiling(
            p in 0.0..1e4_f32, i in 0.0..1e4_f32, d in 0.0..1e4_f32, ceiling in 0_u8..=255,
            on_measurement: bool, conditional_integral: bool, d_filter_s in 0.0..5.0_f32,
            readings in proptest::collection::vec(-50.0..400.0_f32, 1..50),
        ) {
            let gains = PidGains { p, i, d, d_filter_s, on_measurement, conditional_integral, ..GAINS };
            let mut law = Law::new(&LawSettings::Pid(gains), Duty(ceiling));
            for reading in readings {
                let duty = law.update(Celsius(200.0), Celsius(reading), PERIOD, Surroundings::default());
                prop_assert!(duty <= Duty(ceiling));
            }
        }
    }
}
