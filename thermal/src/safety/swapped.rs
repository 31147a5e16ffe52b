//! Sensors in each other's plugs: a heater that warms the sensor of another heater, and not its own.
//!
//! The warming since nothing was heated is compared, so the fault is found in the first heating after the
//! wires were changed, before anything is hot.

use units::Celsius;

use super::look::{LOOK_PERIOD, Look};

/// Seconds at full output after which a heater is judged.
const EFFORT_S: f32 = 5.0;
/// The heater's own sensor has warmed by less than this, C...
const OWN: f32 = 2.0;
/// ...and the sensor of another heater by more than this, C...
const OTHER: f32 = 8.0;
/// ...while that other heater was given less than this share of the effort.
const OTHER_EFFORT: f32 = 0.05;

/// Warming of a single heater's sensor since nothing was heated.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Warmed {
    /// Reading when nothing was last heated.
    from: Option<f32>,
    rise: f32,
    effort_s: f32,
}

impl Warmed {
    /// Takes a look at the heater.
    pub(super) fn note(&mut self, look: &Look, nothing_is_heated: bool, full_share: f32) {
        let Some(Celsius(reading)) = look.reading else {
            *self = Self::default();
            return;
        };
        if nothing_is_heated {
            *self = Self { from: Some(reading), ..Self::default() };
            return;
        }
        self.rise = self.from.map_or(0.0, |from| reading - from);
        self.effort_s += look.driven / full_share.max(f32::MIN_POSITIVE) * LOOK_PERIOD.seconds() as f32;
    }

    /// Returns whether this heater has warmed the other's sensor and not its own.
    pub(super) fn instead(&self, other: &Self) -> bool {
        let judged = self.from.is_some() && self.effort_s >= EFFORT_S && self.rise < OWN;
        judged && other.from.is_some() && other.rise > OTHER && other.effort_s < OTHER_EFFORT * self.effort_s
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the warming of a heater at this share of output after so many looks, from 20 C to `reading`.
    fn warmed(looks: u32, driven: f32, reading: f32) -> Warmed {
        let mut warmed = Warmed::default();
        warmed.note(&Look { reading: Some(Celsius(20.0)), ..Look::default() }, true, 0.5);
        let look = Look { reading: Some(Celsius(reading)), driven, ..Look::default() };
        (0..looks).for_each(|_| warmed.note(&look, false, 0.5));
        warmed
    }

    #[test]
    fn a_heater_is_judged_after_five_seconds_at_its_full_output() {
        for (looks, judged) in [(99, false), (101, true)] {
            // Full output of this heater is half of the time.
            let (driven, other) = (warmed(looks, 0.5, 21.0), warmed(looks, 0.0, 30.0));
            assert_eq!(driven.instead(&other), judged, "{looks} looks");
            assert!(!other.instead(&driven));
        }
    }

    #[test]
    fn a_heater_that_warms_its_own_sensor_or_a_neighbour_that_heats_too_is_sound() {
        let other = warmed(200, 0.0, 30.0);
        assert!(!warmed(200, 0.5, 22.5).instead(&other));
        assert!(!warmed(200, 0.5, 21.0).instead(&warmed(200, 0.1, 30.0)));
        assert!(!warmed(200, 0.5, 21.0).instead(&warmed(200, 0.0, 27.5)));
        assert!(!Warmed::default().instead(&other), "nothing is known from before");
    }
}
