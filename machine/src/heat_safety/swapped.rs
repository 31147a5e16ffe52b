//! Sensors in each other's plugs: a heater that warms the sensor of another heater, and not its own.
//!
//! Compared is the warming since nothing was heated, so what is told is the first heating after the wires
//! were changed, before anything is hot.

use units::Celsius;

use super::look::{LOOK_PERIOD, Look};

/// Seconds at full output after which a heater is judged.
const EFFORT_S: f32 = 5.0;
/// Its own sensor has warmed by less than this...
const OWN: f32 = 2.0;
/// ...and that of another heater by more than this...
const OTHER: f32 = 8.0;
/// ...which was itself given less than this share of the effort.
const OTHER_EFFORT: f32 = 0.05;

/// How one heater and its sensor have fared since nothing was heated.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Warmed {
    /// The reading when nothing was heated last.
    from: Option<f32>,
    rise: f32,
    effort_s: f32,
}

impl Warmed {
    /// One look.
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

    /// Whether this heater has warmed the other's sensor and not its own.
    pub(super) fn instead(&self, other: &Self) -> bool {
        let judged = self.from.is_some() && self.effort_s >= EFFORT_S && self.rise < OWN;
        judged && other.from.is_some() && other.rise > OTHER && other.effort_s < OTHER_EFFORT * self.effort_s
    }
}
