//! Finds PID gains by the relay method (K. J. Astrom and T. Hagglund, Automatica 20, 1984).
//!
//! The heater is switched fully on below and off above the target, so the temperature swings around it. With
//! relay amplitude d (half the output range) and swing amplitude a (half of peak to peak), the ultimate gain
//! is Ku = 4 d / (pi a) and the ultimate period Tu that of the swing. Gains by Ziegler and Nichols (1942): Kp
//! = 0.6 Ku, Ki = 1.2 Ku / Tu, Kd = 0.075 Ku Tu.

use units::{Celsius, Duty, Micros};

/// Half width of the band without switching, degrees: above the noise of a thermistor.
const BAND: f32 = 0.5;
/// Swings before the first counted one: the heat-up and what follows from it.
const SETTLING: u8 = 2;

/// A relay around the target, and what it has measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Relay {
    max: Duty,
    on: bool,
    /// Swings to count.
    wanted: u8,
    /// Swings seen, settling included.
    seen: u8,
    high: f32,
    low: f32,
    seconds: f32,
    /// Sums over the counted swings.
    peak_to_peak: f32,
    period_s: f32,
}

/// Gains found, in Smoothieware's units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gains {
    /// Proportional.
    pub p: f32,
    /// Integral, per second.
    pub i: f32,
    /// Derivative, seconds.
    pub d: f32,
}

impl Relay {
    /// A relay that counts this many swings.
    #[must_use]
    pub const fn new(max: Duty, swings: u8) -> Self {
        let (seen, high, low) = (0, f32::MIN, f32::MAX);
        Self { max, on: true, wanted: swings, seen, high, low, seconds: 0.0, peak_to_peak: 0.0, period_s: 0.0 }
    }

    /// Swings counted and wanted.
    #[must_use]
    pub const fn progress(&self) -> (u8, u8) {
        (self.seen.saturating_sub(SETTLING), self.wanted)
    }

    /// The gains, once enough swings were counted.
    #[must_use]
    pub fn gains(&self) -> Option<Gains> {
        let (counted, wanted) = self.progress();
        if counted < wanted || self.peak_to_peak <= 0.0 || self.period_s <= 0.0 {
            return None;
        }
        let swing = self.peak_to_peak / f32::from(counted) / 2.0;
        let period = self.period_s / f32::from(counted);
        let ultimate = 4.0 * (f32::from(self.max.0) / 2.0) / (core::f32::consts::PI * swing);
        Some(Gains { p: 0.6 * ultimate, i: 1.2 * ultimate / period, d: 0.075 * ultimate * period })
    }

    pub(super) fn update(&mut self, target: Celsius, reading: Celsius, period: Micros) -> Duty {
        let reading = reading.0;
        self.seconds += period.seconds() as f32;
        self.high = if reading > self.high { reading } else { self.high };
        self.low = if reading < self.low { reading } else { self.low };
        if self.on && reading > target.0 + BAND {
            self.on = false;
        } else if !self.on && reading < target.0 - BAND {
            self.on = true;
            self.count_swing(reading);
        }
        if self.on { self.max } else { Duty::OFF }
    }

    /// A swing ends where the heater goes on again.
    fn count_swing(&mut self, reading: f32) {
        let counted = self.progress().0;
        if self.seen >= SETTLING && counted < self.wanted {
            self.peak_to_peak += self.high - self.low;
            self.period_s += self.seconds;
        }
        self.seen = self.seen.saturating_add(if counted < self.wanted { 1 } else { 0 });
        (self.high, self.low, self.seconds) = (reading, reading, 0.0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::heat::{Law, LawSettings, PidGains};

    const PERIOD: Micros = Micros::from_millis(50);

    /// A hotend: 4 C/s at full output, losses of 1/120 a second, a sensor 3 s late.
    fn step(block: &mut f32, sensor: &mut f32, duty: Duty) {
        *block += (f32::from(duty.0) / 255.0 * 4.0 - (*block - 20.0) / 120.0) * 0.05;
        *sensor += (*block - *sensor) / 3.0 * 0.05;
    }

    #[test]
    fn gains_found_hold_the_heater_they_were_found_on() {
        let (mut block, mut sensor) = (20.0, 20.0);
        let mut relay = Relay::new(Duty::FULL, 5);
        for _ in 0..20 * 1_800 {
            let duty = relay.update(Celsius(200.0), Celsius(sensor), PERIOD);
            step(&mut block, &mut sensor, duty);
        }
        let Gains { p, i, d } = relay.gains().expect("half an hour is enough for five swings");
        let gains = PidGains { p, i, d, i_max: 255.0, on_measurement: false, conditional_integral: true };
        let mut law = Law::new(&LawSettings::Pid(gains), Duty::FULL);
        for second in 0..1_200 {
            for _ in 0..20 {
                let duty = law.update(Celsius(200.0), Celsius(sensor), PERIOD);
                step(&mut block, &mut sensor, duty);
            }
            assert!(second < 600 || (sensor - 200.0).abs() < 0.5, "{sensor} after {second} s with {gains:?}");
        }
    }
}
