//! A stepper's rotor in its field: its deflection under load, its loss of steps, and its stallGuard2
//! readings.
//!
//! Textbook physics of a hybrid stepper at constant current: torque is the holding torque times the sine of
//! the load angle, whose right angle is one full step; past two full steps the rotor falls into the next
//! stable place, four full steps back. The voltage that a turning rotor induces grows with its speed, and
//! the share of it that load leaves in phase with the current shrinks with the load. stallGuard2 measures
//! that share once a full step (TMC2660 datasheet rev. 1.05, chapter 4; TMC2130 datasheet rev. 1.09, 14.2
//! and 14.4): the reading is high for little load, low for much, 0 for a rotor that stands, little for a
//! slow one; and `SGT` shifts all of it.
//!
//! Nothing here knows the firmware's use of the reading.

use super::surface::TouchNoise;

/// Positions of a full step that a driver tells apart.
const FULL_STEP: i64 = 256;
/// Distance between two stable places of the rotor.
const CYCLE: i64 = 4 * FULL_STEP;
/// Difference between the measured share of full scale and a reading with `SGT` = 0: so a usual motor reads
/// some hundreds free and 0 stalled ("a good SGT starting value is zero").
const OFFSET: f64 = 200.0;
/// Increase of the reading per unit of `SGT`.
const PER_SGT: f64 = 20.0;
const FULL_SCALE: f64 = 1_023.0;

/// Constants of a motor and its load.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plant {
    /// Peak current at which the motor has its rated torque, amperes.
    pub rated_amps: f64,
    /// Friction of the load, as a share of the rated torque.
    pub friction: f64,
    /// Standard deviation of friction from full step to full step.
    pub friction_noise: f64,
    /// Share of the rated torque that accelerates by one full step per second squared.
    pub inertia: f64,
    /// Induced voltage at one full step per second, volts.
    pub volts_per_full_step: f64,
    /// Resistance of a coil, ohms.
    pub ohms: f64,
    /// Standard deviation of a reading of stallGuard2.
    pub reading_noise: f64,
}

impl Plant {
    /// Constants of a NEMA 17 of 0.4 N m, 1.2 A, 2 Ohm, 6.3 mV s per full step, with a carriage of 0.4 kg
    /// on a belt pulley of 20 teeth.
    pub const PRINTER: Self = Self {
        rated_amps: 1.2,
        friction: 0.15,
        friction_noise: 0.02,
        inertia: 1.8e-6,
        volts_per_full_step: 6.3e-3,
        ohms: 2.0,
        reading_noise: 15.0,
    };
}

/// Regulation of the coils by a driver.
#[derive(Clone, Copy, Debug)]
pub struct Drive {
    /// Peak coil current, amperes.
    pub amps: f64,
    /// Voltage of the motor supply, volts.
    pub supply_volts: f64,
    /// Threshold of stallGuard2, `SGT`.
    pub threshold: i32,
    /// Filter of stallGuard2, `SFILT`: a reading is the mean of four full steps, and made once for them.
    pub filter: bool,
}

/// The rotor of one motor.
#[derive(Clone, Debug)]
pub struct Rotor {
    plant: Plant,
    /// Lead of the field over a rotor that a stop holds, 1/256 full steps.
    lag: i64,
    /// Turns of the field and of the rotor since the last full step, and the time of that.
    field: i64,
    moved: i64,
    since_ns: Option<u64>,
    /// Speed in the last full step, full steps per second.
    speed: f64,
    /// Sum and number of the filter's measurements.
    sum: f64,
    count: u8,
    noise: TouchNoise,
}

impl Rotor {
    /// Makes a rotor that stands in its field.
    #[must_use]
    pub fn new(plant: Plant) -> Self {
        Self {
            plant,
            lag: 0,
            field: 0,
            moved: 0,
            since_ns: None,
            speed: 0.0,
            sum: 0.0,
            count: 0,
            noise: TouchNoise::default(),
        }
    }

    /// Turns the field by so much; `may` limits a travel to the part that the rotor can go. Returns the
    /// rotor's travel, and the part of it lost for good, all in 1/256 full steps.
    pub fn follow(&mut self, field: i64, may: impl Fn(i64) -> i64) -> (i64, i64) {
        self.field += field;
        self.lag += field;
        let mut went = may(self.lag);
        self.lag -= went;
        let mut lost = 0;
        if self.lag.abs() > CYCLE / 2 {
            // The rotor falls back to the position of the field a cycle earlier.
            lost = CYCLE * self.lag.signum();
            self.lag -= lost;
            let back = may(self.lag + went) - went;
            self.lag -= back;
            went += back;
        }
        self.moved += went;
        (went, lost)
    }

    /// Takes an active edge at this time. Returns the new reading of stallGuard2 if the edge completes a
    /// full step and a measurement.
    pub fn reading(&mut self, now_ns: u64, drive: Drive) -> Option<u16> {
        if self.field.abs() < FULL_STEP {
            return None;
        }
        let turned = (self.moved as f64 / self.field as f64).clamp(0.0, 1.0);
        let full_steps = self.field.abs() as f64 / FULL_STEP as f64;
        (self.field, self.moved) = (0, 0);
        let seconds = now_ns.saturating_sub(self.since_ns.replace(now_ns)?) as f64 * 1e-9;
        if seconds <= 0.0 {
            return None;
        }
        let speed = full_steps / seconds;
        let faster = (speed - core::mem::replace(&mut self.speed, speed)) / seconds;
        let measured = self.share(speed * turned, faster, drive);
        self.sum += measured;
        self.count += 1;
        let due = if drive.filter { 4 } else { 1 };
        if self.count < due {
            return None;
        }
        let mean = self.sum / f64::from(self.count);
        (self.sum, self.count) = (0.0, 0);
        Some((mean - OFFSET + PER_SGT * f64::from(drive.threshold)).clamp(0.0, FULL_SCALE) as u16)
    }

    /// Returns the measurement of a full step: the share of full scale that the load leaves of the induced
    /// voltage.
    fn share(&mut self, speed: f64, faster: f64, drive: Drive) -> f64 {
        let plant = self.plant;
        let induced = plant.volts_per_full_step * speed;
        let across_coil = drive.amps * plant.ohms;
        // At speed the supply no longer gets the current through the coil.
        let regulated = (drive.supply_volts / (induced + across_coil)).min(1.0);
        let torque = drive.amps / plant.rated_amps * regulated;
        self.noise.next(1.0);
        let friction = plant.friction + plant.friction_noise * self.noise.now_mm();
        // A rotor that a stop holds back has the load angle of its lag.
        let held = (self.lag.abs().min(FULL_STEP) as f64 / FULL_STEP as f64 * std::f64::consts::FRAC_PI_2).sin();
        let load = ((friction + plant.inertia * faster).abs() / torque.max(1e-6)).max(held).min(1.0);
        self.noise.next(plant.reading_noise);
        FULL_SCALE * induced / (induced + across_coil).max(1e-9) * (1.0 - load) + self.noise.now_mm()
    }

    /// Returns a rotor's reading without noise at so many full steps a second, for tests of the model.
    #[cfg(test)]
    fn reads(amps: f64, full_steps_per_s: f64, friction: f64) -> f64 {
        let plant = Plant { friction, friction_noise: 0.0, reading_noise: 0.0, ..Plant::PRINTER };
        let drive = Drive { amps, supply_volts: 24.0, threshold: 0, filter: false };
        Self::new(plant).share(full_steps_per_s, 0.0, drive)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_reading_falls_with_load_and_rises_with_speed_and_current_s_reserve() {
        let free = Rotor::reads(1.2, 400.0, 0.1);
        assert!(free > Rotor::reads(1.2, 400.0, 0.5) && Rotor::reads(1.2, 400.0, 1.0) < 1.0);
        assert!(free > 1.5 * Rotor::reads(1.2, 150.0, 0.1), "slow motors induce little");
        // Less current leaves less reserve over the same load.
        let (full, half) = (Rotor::reads(1.2, 400.0, 0.4), Rotor::reads(0.6, 400.0, 0.4));
        let without = |amps| Rotor::reads(amps, 400.0, 0.0);
        assert!(half / without(0.6) < full / without(1.2));
    }

    #[test]
    fn a_held_rotor_gives_way_up_to_two_full_steps_and_then_falls_back_by_four() {
        let mut rotor = Rotor::new(Plant::PRINTER);
        let mut place = 0_i64;
        // A stop stands at 100: nothing moves beyond it.
        let mut turn = |rotor: &mut Rotor, by: i64| {
            let (went, lost) = rotor.follow(by, |wanted| wanted.min(100 - place));
            place += went;
            (place, lost)
        };
        assert_eq!(turn(&mut rotor, 100), (100, 0));
        for _ in 0..32 {
            assert_eq!(turn(&mut rotor, 16), (100, 0));
        }
        // The field turns back before the rotor has fallen out: nothing is lost.
        assert_eq!(turn(&mut rotor, -512), (100, 0));
        assert_eq!(turn(&mut rotor, -100), (0, 0));
        assert_eq!(turn(&mut rotor, 100 + 512), (100, 0));
        assert_eq!(turn(&mut rotor, 16), (100 + 528 - 1_024, 1_024));
    }

    #[test]
    fn a_stall_reads_zero_within_two_full_steps_and_a_free_motor_does_not() {
        let drive = Drive { amps: 1.2, supply_volts: 24.0, threshold: 0, filter: false };
        let mut rotor = Rotor::new(Plant::PRINTER);
        let mut place = 0_i64;
        let (mut lowest_free, mut zero_after) = (u16::MAX, None);
        for step in 0..16 * 300_i64 {
            let (went, _) = rotor.follow(16, |wanted| wanted.min(256 * 250 - place));
            place += went;
            // The field turns at 400 full steps a second.
            let read = rotor.reading(step as u64 * 156_250, drive);
            match read {
                Some(value) if step < 16 * 249 => lowest_free = lowest_free.min(value),
                Some(0) => zero_after = zero_after.or(Some((step - 16 * 250) as f64 / 16.0)),
                _ => {}
            }
        }
        assert!(lowest_free > 20, "{lowest_free}");
        assert!(zero_after.is_some_and(|full_steps| full_steps <= 2.0), "{zero_after:?}");
    }
}
