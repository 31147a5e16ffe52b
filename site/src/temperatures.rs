//! Temperatures of the last ten minutes, for charts of who comes: `server.temperature_store`.

use base::snapshot::Snapshot;
use http::json::Writer;
use units::MAX_HEATERS;

use crate::objects;

/// Time between two samples, seconds. Moonraker's store has one a second: each is told so many times.
const EVERY_S: usize = 5;
/// Samples that are kept: ten minutes.
const SAMPLES: usize = 120;
/// Samples of a part of the answer: 24 times five times `-123.4,`.
const PART: usize = 24;
/// Parts of a series, and of a heater with its two series.
const SERIES: usize = SAMPLES / PART;
const HEATER: usize = 2 * SERIES;
/// Parts of the answer.
pub const PARTS: usize = MAX_HEATERS * HEATER;

/// Temperature that no sensor gives, tenths of a degree.
const NONE: i16 = i16::MIN;

/// Temperature and target of a heater at a time, tenths of a degree.
type Sample = [i16; 2];

/// Temperatures of the last minutes.
#[derive(Debug)]
pub struct Temperatures {
    samples: [[Sample; MAX_HEATERS]; SAMPLES],
    /// Number of samples so far.
    taken: u32,
    /// Time of the next one, milliseconds.
    due_ms: u64,
}

impl Temperatures {
    /// Makes a store without samples.
    #[must_use]
    pub const fn new() -> Self {
        Self { samples: [[[0; 2]; MAX_HEATERS]; SAMPLES], taken: 0, due_ms: 0 }
    }

    /// Returns whether the next sample is due.
    #[must_use]
    pub const fn is_due(&self, now_ms: u64) -> bool {
        now_ms >= self.due_ms
    }

    /// Takes a sample, if one is due.
    pub fn take(&mut self, of: &Snapshot, now_ms: u64) {
        if !self.is_due(now_ms) {
            return;
        }
        let tenths = |degrees: f32| libm::roundf(degrees * 10.0) as i16;
        let sample = self.samples.get_mut(self.taken as usize % SAMPLES);
        for (to, heater) in sample.into_iter().flatten().zip(&of.heaters) {
            *to = [heater.reading.map_or(NONE, |reading| tenths(reading.0)), tenths(heater.target.0)];
        }
        (self.taken, self.due_ms) = (self.taken.wrapping_add(1), now_ms + EVERY_S as u64 * 1_000);
    }

    /// Writes a part of the answer, which is an object of the heaters by their names: oldest samples first.
    pub fn write(&self, part: usize, of: &Snapshot, json: &mut Writer<'_, '_>) {
        let (place, series, piece) = (part / HEATER, part % HEATER / SERIES, part % SERIES);
        let Some(heater) = of.heaters.get(place) else { return };
        let is_told = series == 0 || heater.heats;
        if part.is_multiple_of(HEATER) {
            objects::heater_name(place, of).into_iter().for_each(|name| json.key(&name));
            json.begin_object();
        }
        if piece == 0 && is_told {
            json.key(if series == 0 { "temperatures" } else { "targets" });
            json.begin_array();
        }
        let kept = self.taken.min(SAMPLES as u32);
        for number in (piece * PART) as u32..kept.min((piece * PART + PART) as u32) {
            let at = self.taken.wrapping_sub(kept).wrapping_add(number) as usize % SAMPLES;
            let sample = self.samples.get(at).and_then(|sample| sample.get(place));
            let tenths = sample.and_then(|sample| sample.get(series)).copied().filter(|_| is_told);
            for tenths in tenths.into_iter().flat_map(|tenths| [tenths; EVERY_S]) {
                if tenths == NONE { json.null() } else { json.fixed(i64::from(tenths), 1) }
            }
        }
        if piece + 1 == SERIES && is_told {
            json.end_array();
        }
        if (part + 1).is_multiple_of(HEATER) {
            json.end_object();
        }
    }
}
