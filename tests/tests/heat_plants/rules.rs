//! Detection rules of other firmwares, written from their documentation, on the same readings.

use sim::models::heater::Plant;

/// Inputs of a detection rule.
#[derive(Clone, Copy)]
pub struct Seen {
    pub second: f64,
    /// The reading; none for an open or shorted sensor, which everybody takes for one.
    pub reading: Option<f64>,
    pub target: f64,
    /// Share of full output that the heater is given, and of full speed that the fan has.
    pub driven: f64,
    pub fan: f64,
}

/// Marlin 2.1's thermal protection with its defaults (`Configuration_adv.h`): 2 C more every 40 s (bed: 60 s)
/// until near the target; then not 4 C (bed: 2 C) below it for 40 s (bed: 20 s). Open and shorted sensors and
/// `MAXTEMP` at once.
pub struct Marlin {
    is_bed: bool,
    max: f64,
    target: f64,
    /// Time and value of the next rise that is due.
    watch: Option<(f64, f64)>,
    was_there: bool,
    good_at: f64,
}

impl Marlin {
    pub fn new(is_bed: bool, max: f64) -> Self {
        Self { is_bed, max, target: 0.0, watch: None, was_there: false, good_at: 0.0 }
    }

    pub fn trips(&mut self, seen: Seen) -> bool {
        let Some(reading) = seen.reading.filter(|reading| (5.0..self.max).contains(reading)) else { return true };
        let (watch_s, period_s, hysteresis) = if self.is_bed { (60.0, 20.0, 2.0) } else { (40.0, 40.0, 4.0) };
        const INCREASE: f64 = 2.0;
        if seen.target != self.target {
            (self.target, self.was_there) = (seen.target, false);
            let is_near = reading >= seen.target - (INCREASE + hysteresis + 1.0);
            self.watch = (!is_near && seen.target > 0.0).then_some((seen.second + watch_s, reading + INCREASE));
        }
        if self.target <= 0.0 {
            return false;
        }
        if let Some((due, needed)) = self.watch
            && seen.second >= due
        {
            if reading < needed {
                return true;
            }
            let is_near = reading >= self.target - (INCREASE + hysteresis + 1.0);
            self.watch = (!is_near).then_some((seen.second + watch_s, reading + INCREASE));
        }
        self.was_there |= reading >= self.target;
        if !self.was_there || reading >= self.target - hysteresis {
            self.good_at = seen.second;
        }
        seen.second - self.good_at > period_s
    }
}

/// Klipper's `verify_heater` with its defaults: once a second; 2 C more every 20 s (bed: 60 s) on the way to
/// a target; then degrees below `target - 5` summed up to 120. Open and shorted sensors and `max_temp` at
/// once.
pub struct Klipper {
    gain_s: f64,
    max: f64,
    target: f64,
    approaching: bool,
    goal: f64,
    goal_due: f64,
    error: f64,
    due: f64,
}

impl Klipper {
    pub fn new(is_bed: bool, max: f64) -> Self {
        let gain_s = if is_bed { 60.0 } else { 20.0 };
        Self { gain_s, max, target: 0.0, approaching: false, goal: 0.0, goal_due: 0.0, error: 0.0, due: 0.0 }
    }

    pub fn trips(&mut self, seen: Seen) -> bool {
        let Some(reading) = seen.reading.filter(|reading| (0.0..self.max).contains(reading)) else { return true };
        if seen.second < self.due {
            return false;
        }
        self.due = seen.second + 1.0;
        if seen.target <= 0.0 || reading >= seen.target - 5.0 {
            (self.approaching, self.error, self.target) = (false, 0.0, seen.target);
            return false;
        }
        self.error += seen.target - 5.0 - reading;
        if seen.target != self.target {
            (self.approaching, self.target, self.error) = (true, seen.target, 0.0);
            (self.goal, self.goal_due) = (reading + 2.0, seen.second + self.gain_s);
        } else if self.approaching && reading >= self.goal {
            self.error = 0.0;
            (self.goal, self.goal_due) = (reading + 2.0, seen.second + self.gain_s);
        } else if self.approaching && seen.second >= self.goal_due {
            self.approaching = false;
        }
        !self.approaching && self.error > 120.0
    }
}

/// Prusa's thermal model of a hot end (MK3, firmware 3.12 and later), from its makers' description
/// (prusa3d/Prusa-Firmware, pull requests 3552 and 3957) and the parameters of its calibrated hot ends
/// (`M310`). 3.7 times a second the rate of change that power, capacity and loss explain, with the response
/// of the sensor, is compared with the rate that is read; when the difference, filtered, exceeds a threshold,
/// heating ends. Beds have no such model.
///
/// Thermal model protection of Prusa, at its best: its parameters are the plant's own, as if calibration were
/// perfect. Of the threshold only that of the E3D V6 is known to go with a plant: 1.74 K/s where full power
/// makes 3.14 K/s (38 W, 12.1 J/K). Others get the same share of what their full power makes. Open and
/// shorted sensors are detected at once.
pub struct Prusa {
    plant: Plant,
    air_c: f64,
    threshold: f64,
    due: f64,
    /// Sum of the output since the last sample, and number of its values.
    driven: (f64, f64),
    before: Option<f64>,
    explained: f64,
    difference: f64,
}

impl Prusa {
    const SAMPLE_S: f64 = 0.27;
    /// Weight of a sample in the difference.
    const FILTER: f64 = 0.05;

    /// Returns the model; none for a bed.
    pub fn new(plant: &Plant, is_bed: bool, air_c: f64) -> Option<Self> {
        const V6_SHARE: f64 = 1.74 / (38.0 / 12.1);
        let full = plant.power_w / plant.capacity_j_per_k;
        let (plant, threshold) = (*plant, V6_SHARE * full);
        let none = (0.0, 0.0);
        let model =
            Self { plant, air_c, threshold, due: 0.0, driven: none, before: None, explained: 0.0, difference: 0.0 };
        (!is_bed).then_some(model)
    }

    pub fn trips(&mut self, seen: Seen) -> bool {
        let Some(reading) = seen.reading else { return true };
        self.driven = (self.driven.0 + seen.driven, self.driven.1 + 1.0);
        if seen.second < self.due {
            return false;
        }
        self.due = seen.second + Self::SAMPLE_S;
        let (driven, count) = std::mem::take(&mut self.driven);
        let Some(before) = self.before.replace(reading) else { return false };
        let plant = &self.plant;
        let lost_w = (plant.loss_w_per_k + seen.fan * plant.fan_loss_w_per_k) * (before - self.air_c);
        let rate = (plant.power_w * driven / count - lost_w) / plant.capacity_j_per_k;
        self.explained += (rate - self.explained) * (1.0 - (-Self::SAMPLE_S / plant.sensor_lag_s).exp());
        let difference = (reading - before) / Self::SAMPLE_S - self.explained;
        self.difference += (difference - self.difference) * Self::FILTER;
        self.difference.abs() > self.threshold
    }
}
