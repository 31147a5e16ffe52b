//! Counter of tachometer pulses, which samples the inputs in each run of the heat task.
//!
//! Looking [`crate::MODULATION_HZ`] times a second sees every pulse that is high, and low, for half a
//! millisecond and a little more, which is 800 pulses a second: 24,000 turns a minute with two pulses a turn.
//! A noisy wire costs no interrupt so, and any input will do.

/// Greatest number of inputs.
const INPUTS: usize = config::MAX_FANS;

/// Pulses counted since the start, modulo 2^16.
#[derive(Clone, Copy, Debug, Default)]
pub struct Pulses {
    levels: u8,
    counts: [u16; INPUTS],
}

impl Pulses {
    /// Creates a counter without pulses.
    #[must_use]
    pub const fn new() -> Self {
        Self { levels: 0, counts: [0; INPUTS] }
    }

    /// Samples the inputs: a bit for each that is on.
    #[inline]
    pub fn look(&mut self, levels: u8) {
        let mut rose = levels & !self.levels;
        self.levels = levels;
        while rose != 0 {
            if let Some(count) = self.counts.get_mut(rose.trailing_zeros() as usize) {
                *count = count.wrapping_add(1);
            }
            rose &= rose - 1;
        }
    }

    /// Returns the counts by input.
    #[must_use]
    pub const fn counts(&self) -> [u16; INPUTS] {
        self.counts
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_pulse_counts_once_whichever_others_there_are() {
        let mut pulses = Pulses::new();
        for tick in 0..2_000_u32 {
            // 800 a second on the first, 100 on the last.
            let fast = u8::from(tick * 800 % 2_000 >= 1_000);
            let slow = u8::from(tick * 100 % 2_000 >= 1_000) << 7;
            pulses.look(fast | slow);
        }
        let counts = pulses.counts();
        assert_eq!((counts[0], counts[7], counts[1]), (800, 100, 0));
    }
}
