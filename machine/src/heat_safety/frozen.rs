//! A reading that goes on coming and is always the same: its converter, or what carries it here, stands.
//!
//! That a reading stays the same for a while proves nothing: a heater may be held that well. But then it
//! takes the same output all the while. Where it is given more, or less, than it was when the reading began
//! to stand, and that would have warmed or cooled it by many times the least step that its sensor has been
//! seen to make, the reading is not the heater's. How much warms it is what the law of response goes by
//! (`verify_gain` within `verify_gain_time` of full output), which every heater of the machine must do in any
//! weather. A sensor of coarse steps proves nothing at all: it is left alone.

use units::{Celsius, Micros};

use super::look::{HeatCause, LOOK_PERIOD, Look};
use super::response::ResponseLimits;

/// For so long the output is what the reading belongs to, seconds.
const USUAL_S: f32 = 10.0;
/// So many steps of the sensor must be missing...
const STEPS: f32 = 4.0;
/// ...and so many degrees.
const LEAST: f32 = 0.25;
/// A sensor whose least step is greater proves nothing, degrees.
const COARSE: f32 = 0.1;
/// What is this hot, degrees, cools by many steps within so many seconds without any output.
const HOT: f32 = 50.0;
const COOLS_S: f32 = 120.0;

/// What is known of a reading that may stand.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frozen {
    reading: f32,
    /// The least step that it has made while the heater is on.
    step: f32,
    /// For how long it has been the same, seconds.
    same_s: f32,
    /// The output that it belongs to: the mean of its first seconds.
    usual: f32,
    /// Seconds at full output that the heater was given beyond that; below zero: less.
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
            // There is no change to the first one.
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
