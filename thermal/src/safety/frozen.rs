//! Frozen readings: they go on coming and are always the same, since the converter or the path of its data
//! stands.
//!
//! A reading that stays the same for a while proves nothing: a heater may be held that well. But then the
//! heater takes the same output all the while. If it is given more, or less, than when the reading began to
//! stand, and if the difference would have warmed or cooled it by many times the least step that its sensor
//! has been seen to make, the reading is not the heater's. The expected warming is that of the law of
//! response (`verify_gain` within `verify_gain_time` of full output), which every heater of the machine must
//! do in any weather. A sensor of coarse steps proves nothing at all: it is left alone.

use units::{Celsius, Micros};

use super::look::{HeatCause, LOOK_PERIOD, Look};
use super::response::ResponseLimits;

/// Time from the last change of the reading, s, whose mean output belongs to that reading.
const USUAL_S: f32 = 10.0;
/// Number of sensor steps that must be missing...
const STEPS: f32 = 4.0;
/// ...and number of degrees that must be missing.
const LEAST: f32 = 0.25;
/// Greatest least step of a sensor that proves something, degrees.
const COARSE: f32 = 0.1;
/// A heater hotter than this, degrees, cools by many steps within `COOLS_S` seconds without any output.
const HOT: f32 = 50.0;
const COOLS_S: f32 = 120.0;

/// History of a reading that may stand.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frozen {
    reading: f32,
    /// Least step of the sensor while the heater is on.
    step: f32,
    /// Time for which the reading has been the same, seconds.
    same_s: f32,
    /// Output that belongs to the reading: the mean of its first seconds.
    usual: f32,
    /// Effort beyond that output, seconds at full output; below zero: less.
    beyond_s: f32,
    /// Seconds without any output.
    off_s: f32,
}

impl Default for Frozen {
    fn default() -> Self {
        Self { reading: f32::NAN, step: f32::MAX, same_s: 0.0, usual: 0.0, beyond_s: 0.0, off_s: 0.0 }
    }
}

impl Frozen {
    pub(super) fn check(&mut self, limits: &ResponseLimits, full_share: f32, look: &Look) -> Result<(), HeatCause> {
        let Some(Celsius(reading)) = look.reading.filter(|_| look.is_on()) else {
            *self = Self::default();
            return Ok(());
        };
        if reading != self.reading {
            let change = (reading - self.reading).abs();
            // The first reading gives no change.
            let step = if change.is_nan() { self.step } else { self.step.min(change) };
            *self = Self { reading, step, ..Self::default() };
            return Ok(());
        }
        let seconds = LOOK_PERIOD.seconds() as f32;
        let share = look.driven / full_share.max(f32::MIN_POSITIVE);
        self.same_s += seconds;
        self.off_s = if share > 0.0 { 0.0 } else { self.off_s + seconds };
        if self.same_s <= USUAL_S {
            self.usual += share * seconds / USUAL_S;
            return Ok(());
        }
        self.beyond_s += (share - self.usual) * seconds;
        let is_coarse = self.step > COARSE;
        let within_s = limits.within.seconds() as f32;
        if is_coarse || within_s <= 0.0 || limits.gain.0 <= 0.0 {
            return Ok(());
        }
        let missing = LEAST.max(STEPS * self.step) * within_s / limits.gain.0;
        let must_cool = reading > HOT && self.off_s > COOLS_S;
        if self.beyond_s.abs() > missing || must_cool {
            return Err(HeatCause::Frozen(Micros::from_seconds(self.same_s as u64)));
        }
        Ok(())
    }
}
