//! The rules of others, written from their documentation, on the same readings.

/// What a rule sees, ten times a second.
#[derive(Clone, Copy)]
pub struct Seen {
    pub second: f64,
    /// The reading; none for an open or shorted sensor, which everybody takes for one.
    pub reading: Option<f64>,
    pub target: f64,
}

/// Marlin 2.1's thermal protection with its defaults (`Configuration_adv.h`): 2 C more every 40 s (bed: 60 s)
/// until near the target; then not 4 C (bed: 2 C) below it for 40 s (bed: 20 s). Open and shorted sensors and
/// `MAXTEMP` at once.
pub struct Marlin {
    is_bed: bool,
    max: f64,
    target: f64,
    /// When the next rise is due, and to what.
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
