//! The ring: slots in memory that a reset leaves alone, and a count of events in memory that it does not.
//!
//! **Writing.** A writer takes a number and with it a slot, marks the slot as empty, writes the event and,
//! last, the number. A writer that interrupts another takes the next number. No lock, no wait, no allocation:
//! a few stores for each word of the event, from any priority. Only whole words are written: the last part of
//! a word stays in the memory's own buffer and is lost by a reset (RM0399 rev 4 section 2.4, "Embedded SRAM";
//! AN5342).
//!
//! **Reading.** A slot is an event when its number belongs there, its sum is right and its words mean
//! something. An entry that is being overwritten, was cut by a reset, or is what memory holds after power
//! came, is none: with a sum of 32 bits, once in four thousand million.

use core::fmt;
use core::sync::atomic::{AtomicU32, Ordering, compiler_fence};

use units::Micros;

use crate::Event;
use crate::codec::{Words, decode, encode};

/// Number of events that are kept.
pub const EVENTS: usize = 256;
/// Number of words of a slot.
pub const SLOT_WORDS: usize = 32;
/// Number of words of a slot that belong to the event: number, sum and time come first.
pub const PAYLOAD_WORDS: usize = SLOT_WORDS - HEAD_WORDS;
const HEAD_WORDS: usize = 4;
/// Version of the events' meaning and of the slots' layout, part of each sum, so that an entry of another
/// version is no event.
pub const FORMAT: u32 = 1;

/// Slot of an entry: its number (0: none), the sum, the time's lower half, then kind, count of words and the
/// time's upper half; then the event's words.
#[derive(Debug)]
struct Slot([AtomicU32; SLOT_WORDS]);

/// Memory of a ring, 32 KiB. Any contents are sound.
#[derive(Debug)]
#[repr(C)]
pub struct Slots([Slot; EVENTS]);

impl Slots {
    /// Creates slots without events; all zero.
    #[must_use]
    pub const fn new() -> Self {
        Self([const { Slot([const { AtomicU32::new(0) }; SLOT_WORDS]) }; EVENTS])
    }

    /// Returns all words, for code that brings memory into its first state.
    pub fn words(&self) -> impl Iterator<Item = &AtomicU32> {
        self.0.iter().flat_map(|slot| &slot.0)
    }

    fn slot(&self, number: u32) -> &Slot {
        &self.0[number as usize % EVENTS]
    }
}

impl Default for Slots {
    fn default() -> Self {
        Self::new()
    }
}

/// Both parts of a ring, for its writers and readers. Small enough to be handed along.
#[derive(Clone, Copy, Debug)]
pub struct EventRing<'a> {
    slots: &'a Slots,
    /// Number of the next event. In memory on which the processor's exclusive accesses work; the slots'
    /// memory need not support them.
    next: &'a AtomicU32,
}

/// An event of the ring, with its number and time.
#[derive(Clone, Debug, PartialEq)]
pub struct Entry {
    /// Number of the event, counted from 1 since power came.
    pub number: u32,
    /// Time of the event since the start of the firmware that wrote it.
    pub at: Micros,
    /// The event itself, as recorded.
    pub event: Event,
}

impl<'a> EventRing<'a> {
    /// Creates a ring in this memory. Before anything is written, [`Self::recover`] or [`Self::clear`] must
    /// determine the memory's contents.
    #[must_use]
    pub const fn new(slots: &'a Slots, next: &'a AtomicU32) -> Self {
        Self { slots, next }
    }

    /// Counts on behind the contents of the memory, after a reset. For a single caller, before all others.
    pub fn recover(&self) {
        let numbers = (0..EVENTS as u32).filter_map(|place| self.entry_in(place)).map(|entry| entry.number);
        self.next.store(numbers.max().unwrap_or(0).wrapping_add(1), Ordering::Relaxed);
    }

    /// Begins anew: memory that had no power holds nothing, and may be read only after it was written. For a
    /// single caller, before all others.
    pub fn clear(&self) {
        self.slots.words().for_each(|word| word.store(0, Ordering::Relaxed));
        self.next.store(1, Ordering::Relaxed);
    }

    /// Records an event. From any priority below the step interrupt's.
    pub fn record(&self, at: Micros, event: &Event) {
        let number = self.next.fetch_add(1, Ordering::Relaxed);
        let slot = &self.slots.slot(number).0;
        let mut words = Words::new([0; PAYLOAD_WORDS]);
        let kind = encode(event, &mut words);
        let written = words.written();
        let head = u32::from(kind) | (written.len() as u32) << 8 | ((at.0 >> 32) as u32) << 16;
        slot[0].store(0, Ordering::Relaxed);
        compiler_fence(Ordering::Release);
        slot[1].store(sum(number, at.0 as u32, head, written.iter().copied()), Ordering::Relaxed);
        slot[2].store(at.0 as u32, Ordering::Relaxed);
        slot[3].store(head, Ordering::Relaxed);
        for (place, word) in slot.iter().skip(HEAD_WORDS).zip(written) {
            place.store(*word, Ordering::Relaxed);
        }
        slot[0].store(number, Ordering::Release);
    }

    /// Returns the number that the next event will have.
    #[must_use]
    pub fn next(&self) -> u32 {
        self.next.load(Ordering::Relaxed)
    }

    /// Returns the event of this number, while it is kept.
    #[must_use]
    pub fn entry(&self, number: u32) -> Option<Entry> {
        self.entry_in(number).filter(|entry| entry.number == number)
    }

    /// Returns the last `count` events that are kept, oldest first.
    #[must_use]
    pub fn last(&self, count: u32) -> Entries<'a> {
        let next = self.next();
        let count = count.min(EVENTS as u32).min(next.wrapping_sub(1));
        Entries { ring: *self, number: next.wrapping_sub(count), end: next }
    }

    /// Returns the kept events from a number up to before another.
    #[must_use]
    pub fn between(&self, number: u32, end: u32) -> Entries<'a> {
        Entries { ring: *self, number, end }
    }

    fn entry_in(&self, place: u32) -> Option<Entry> {
        let slot = &self.slots.slot(place).0;
        let number = slot[0].load(Ordering::Acquire);
        let at_low = slot[2].load(Ordering::Relaxed);
        let head = slot[3].load(Ordering::Relaxed);
        let count = (head >> 8 & 0xFF) as usize;
        if number == 0 || !((number ^ place) as usize).is_multiple_of(EVENTS) || count > PAYLOAD_WORDS {
            return None;
        }
        let mut payload = [0; PAYLOAD_WORDS];
        for (word, place) in payload.iter_mut().zip(slot.iter().skip(HEAD_WORDS)).take(count) {
            *word = place.load(Ordering::Relaxed);
        }
        let found = sum(number, at_low, head, payload.iter().copied().take(count));
        if found != slot[1].load(Ordering::Relaxed) {
            return None;
        }
        let mut words = Words::new(payload);
        let event = decode(head as u8, &mut words)?;
        let at = Micros(u64::from(head >> 16) << 32 | u64::from(at_low));
        (words.count == count).then_some(Entry { number, at, event })
    }
}

/// Writes ` 0:00:12.345 motor supply is off`; a start has a line that shows.
impl fmt::Display for Entry {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.event.is_start() {
            return write!(f, "--- {}", self.event);
        }
        let (seconds, millis) = (self.at.0 / 1_000_000, self.at.0 / 1_000 % 1_000);
        let (hours, minutes) = (seconds / 3_600, seconds / 60 % 60);
        write!(f, "{hours:>4}:{minutes:02}:{:02}.{millis:03} {}", seconds % 60, self.event)
    }
}

/// Returns the check sum of an entry. Every bit of an entry changes about half of the sum's bits:
/// multiplication carries upwards, the rotation brings down again.
fn sum(number: u32, at_low: u32, head: u32, payload: impl Iterator<Item = u32>) -> u32 {
    [number, at_low, head]
        .into_iter()
        .chain(payload)
        .fold(0x5EED_0000 | FORMAT, |sum, word| (sum ^ word).wrapping_mul(0x9E37_79B1).rotate_left(15))
}

/// Iterator over events, oldest first.
#[derive(Clone, Copy, Debug)]
pub struct Entries<'a> {
    ring: EventRing<'a>,
    number: u32,
    end: u32,
}

impl Entries<'_> {
    /// Returns the numbers that are looked at: the next, and the number behind the last.
    #[must_use]
    pub const fn span(&self) -> (u32, u32) {
        (self.number, self.end)
    }
}

impl Iterator for Entries<'_> {
    type Item = Entry;

    fn next(&mut self) -> Option<Entry> {
        while self.number != self.end {
            let number = self.number;
            self.number = number.wrapping_add(1);
            // An entry that is gone or never was whole is left out.
            if let Some(entry) = self.ring.entry(number) {
                return Some(entry);
            }
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::codec::tests::event;
    use crate::{Cause, Text};
    use proptest::prelude::*;
    use std::vec::Vec;

    #[derive(Default)]
    struct Memory {
        slots: Box<Slots>,
        next: AtomicU32,
    }

    impl Memory {
        fn ring(&self) -> EventRing<'_> {
            EventRing::new(&self.slots, &self.next)
        }

        /// Simulates a reset, which leaves the slots, and no count.
        fn after_reset(&self) -> EventRing<'_> {
            self.next.store(0, Ordering::Relaxed);
            self.ring().recover();
            self.ring()
        }
    }

    fn fresh() -> Memory {
        let memory = Memory::default();
        memory.ring().clear();
        memory
    }

    fn homed(axes: u8) -> Event {
        Event::Homed { axes }
    }

    proptest! {
        #[test]
        fn the_last_events_are_kept_and_survive_a_reset(events in proptest::collection::vec((event(), 0..1_u64 << 48), 1..600)) {
            let memory = fresh();
            for (event, at) in &events {
                memory.ring().record(Micros(*at), event);
            }
            let kept: Vec<_> = memory.ring().last(1_000).collect();
            let expected = &events[events.len().saturating_sub(EVENTS)..];
            prop_assert_eq!(kept.len(), expected.len());
            for (entry, (event, at)) in kept.iter().zip(expected) {
                prop_assert_eq!((&entry.event, entry.at), (event, Micros(*at)));
            }
            let after: Vec<_> = memory.after_reset().last(1_000).collect();
            prop_assert_eq!(after, kept);
        }

        /// Contents of memory after power came are no event, and do not keep new ones from being written.
        #[test]
        fn garbage_is_no_event(seed: u32) {
            let memory = Memory::default();
            let mut word = seed | 1;
            for place in memory.slots.words() {
                word ^= word << 13;
                word ^= word >> 17;
                word ^= word << 5;
                place.store(word, Ordering::Relaxed);
            }
            let ring = memory.after_reset();
            prop_assert_eq!(ring.last(1_000).count(), 0);
            ring.record(Micros(7), &homed(1));
            prop_assert_eq!(ring.last(1_000).map(|entry| entry.event).collect::<Vec<_>>(), [homed(1)]);
        }

        /// If any word of an entry changes, or was not written, the entry is gone, and all others stay.
        #[test]
        fn an_entry_that_was_damaged_is_left_out(count in 2..40_u8, hit in 0..40_u8, word in 0..SLOT_WORDS, flip in 1..u32::MAX) {
            let memory = fresh();
            (0..count).for_each(|axes| memory.ring().record(Micros(u64::from(axes)), &homed(axes)));
            let hit = hit % count;
            let place = &memory.slots.slot(u32::from(hit) + 1).0[word];
            place.store(place.load(Ordering::Relaxed) ^ flip, Ordering::Relaxed);
            let kept: Vec<_> = memory.ring().last(1_000).map(|entry| entry.event).collect();
            let unused = word > HEAD_WORDS;
            let expected: Vec<_> = (0..count).filter(|axes| unused || *axes != hit).map(homed).collect();
            prop_assert_eq!(kept, expected);
        }

        /// A reset may come between any two stores of an entry: the entry was written, or it was not.
        #[test]
        fn an_entry_that_a_reset_cut_is_left_out(before in 1..600_u32, stores in 0..=6_usize) {
            let (whole, cut) = (fresh(), fresh());
            for memory in [&whole, &cut] {
                (0..before).for_each(|time| memory.ring().record(Micros(u64::from(time)), &homed(time as u8)));
            }
            whole.ring().record(Micros(1_000), &homed(0xAA));
            // The words are in the order in which they are stored: the mark first, and last.
            let order = [0, 1, 2, 3, 4, 0];
            let (from, to) = (&whole.slots.slot(before + 1).0, &cut.slots.slot(before + 1).0);
            for (nth, place) in order.into_iter().take(stores).enumerate() {
                let word = if nth == 0 { 0 } else { from[place].load(Ordering::Relaxed) };
                to[place].store(word, Ordering::Relaxed);
            }
            let ring = cut.after_reset();
            let last = ring.last(1).next();
            if stores == order.len() {
                prop_assert_eq!(last.map(|entry| entry.event), Some(homed(0xAA)));
            } else {
                prop_assert_eq!(last.map(|entry| entry.number), Some(before));
            }
        }
    }

    #[test]
    fn writers_that_interrupt_one_another_lose_nothing() {
        let memory = fresh();
        std::thread::scope(|scope| {
            for writer in 0..4_u8 {
                let ring = memory.ring();
                scope.spawn(move || (0..50).for_each(|time| ring.record(Micros(time), &homed(writer))));
            }
        });
        let kept: Vec<_> = memory.ring().last(1_000).collect();
        assert_eq!(kept.len(), 200);
        for writer in 0..4_u8 {
            assert_eq!(kept.iter().filter(|entry| entry.event == homed(writer)).count(), 50);
        }
    }

    #[test]
    fn numbers_count_on_over_resets() {
        let memory = fresh();
        memory.ring().record(Micros(5), &Event::Started { cause: Cause::PowerOn, date: None });
        memory.ring().record(Micros(9), &Event::Ended(Text::from("panic at x.rs:1")));
        let ring = memory.after_reset();
        assert_eq!(ring.next(), 3);
        ring.record(Micros(2), &Event::Started { cause: Cause::Software, date: None });
        let numbers: Vec<_> = ring.last(2).map(|entry| entry.number).collect();
        assert_eq!(numbers, [2, 3]);
        assert_eq!(ring.entry(4), None);
    }
}
