//! Measurement of the step queue's lead: the image's memory is read whenever a chosen function is entered.
//!
//! The queue is a ring of (tick, word) pairs behind three words: written, played, cut (`motion/src/queue.rs`;
//! its layout is `repr(C)` because the step interrupt counts on it).

use crate::image::Symbols;

/// Duration of a tick of the queue's clock (200 MHz), ns.
const TICK_NS: u64 = 5;
/// Offsets of the fields, and the size of a slot, in bytes.
const PLAYED: u64 = 4;
const SLOTS: u64 = 12;
const SLOT: u64 = 8;

/// Place of the queue in memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct QueueProbe {
    base: u64,
    /// Slots of the ring.
    capacity: u32,
}

/// A sample of the queue.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sample {
    /// Instant of the sample, nanoseconds since power-on.
    pub at_ns: u64,
    /// Time from the next event to be played to the last event written, nanoseconds; 0 for an empty queue.
    pub ahead_ns: u64,
}

impl QueueProbe {
    /// Finds the queue for `FUNCTION,VARIABLE,OFFSET`: it begins that many bytes into the variable, ends at
    /// the variable's end, and is sampled when the function is entered.
    ///
    /// # Errors
    /// What is wrong with the words, or not in the image.
    pub fn find(symbols: &Symbols, words: &str) -> Result<(u64, Self), String> {
        let mut parts = words.split(',');
        let (Some(function), Some(variable), Some(offset), None) =
            (parts.next(), parts.next(), parts.next(), parts.next())
        else {
            return Err(format!("`{words}` is not FUNCTION,VARIABLE,OFFSET"));
        };
        let offset: u64 = offset.parse().map_err(|_| format!("`{offset}` is no offset"))?;
        let at = symbols.function(function).ok_or_else(|| format!("no function `{function}`"))?.address;
        let whole = symbols.object(variable).ok_or_else(|| format!("no variable `{variable}`"))?;
        let slots = whole.size.saturating_sub(offset + SLOTS) / SLOT;
        // Event counts wrap at 32 bits, so slots are found by them only if their number is a power of two.
        if !slots.is_power_of_two() || offset + SLOTS + slots * SLOT != whole.size {
            return Err(format!("no ring of events {offset} bytes into `{variable}`, which has {} bytes", whole.size));
        }
        Ok((at, Self { base: whole.address + offset, capacity: slots as u32 }))
    }

    /// Returns the time that is written ahead, nanoseconds.
    pub(super) fn ahead_ns(self, mut word: impl FnMut(u64) -> u32) -> u64 {
        let (written, played) = (word(self.base), word(self.base + PLAYED));
        if written == played {
            return 0;
        }
        let mut due = |event: u32| word(self.base + SLOTS + u64::from(event % self.capacity) * SLOT);
        u64::from(due(written.wrapping_sub(1)).wrapping_sub(due(played))) * TICK_NS
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_ahead_reaches_from_the_next_event_to_the_newest() {
        let (base, ticks) = (0x2000_0000, |event: u64| 1_000 * event as u32);
        let memory = |written: u32, played: u32| {
            move |address: u64| match address - base {
                0 => written,
                4 => played,
                slot => ticks((slot - SLOTS) / SLOT),
            }
        };
        let queue = QueueProbe { base, capacity: 16 };
        assert_eq!(queue.ahead_ns(memory(10, 4)), 5 * 1_000 * TICK_NS);
        assert_eq!(queue.ahead_ns(memory(10, 10)), 0);
        assert_eq!(queue.ahead_ns(memory(35, 32)), 2 * 1_000 * TICK_NS);
    }
}
