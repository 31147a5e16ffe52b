//! Strips of lights on the outputs of timers.

use super::World;
use crate::models::led_strip::Seen;

impl World {
    /// The strip on an output of a timer, if there is one.
    #[must_use]
    pub fn strip_at(&self, timer: usize, channel: usize) -> Option<usize> {
        self.config.strips.iter().position(|strip| strip.output == (timer, channel))
    }

    /// Sets the level of a strip's line from now on.
    pub fn strip_pin(&mut self, at_ns: u64, strip: usize, high: bool) {
        if let Some(strip) = self.strips.get_mut(strip) {
            strip.level(at_ns, high);
        }
    }

    /// Hands bytes to a strip, from a sender that makes no pulses.
    pub fn strip_bytes(&mut self, strip: usize, bytes: &[u8]) {
        if let Some(strip) = self.strips.get_mut(strip) {
            strip.take(bytes);
        }
    }

    /// Returns the bytes that the lights of a strip show, in the order of sending.
    pub fn strip_shows(&mut self, strip: usize) -> Vec<u8> {
        let now_ns = self.now_ns;
        self.strips.get_mut(strip).map_or_else(Vec::new, |strip| strip.shown(now_ns).to_vec())
    }

    /// Returns the number of transmissions to a strip so far, and of violations of its chips' data sheets.
    #[must_use]
    pub fn strip_counters(&self, strip: usize) -> (u64, u64) {
        self.strips.get(strip).map_or((0, 0), |strip| (strip.frames(), strip.faults()))
    }

    /// Returns the lengths of pulses and pauses on a strip's line.
    #[must_use]
    pub fn strip_times(&self, strip: usize) -> Seen {
        self.strips.get(strip).map_or_else(Seen::default, |strip| strip.seen())
    }
}
