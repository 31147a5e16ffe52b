//! Tachometers: edges of an input, counted by looking at it.

use crate::board::Input;

/// An input whose edges are counted.
#[derive(Debug)]
pub struct Counter<I> {
    pin: I,
    poll_ticks: u32,
    sample_ticks: u32,
    next_report: u32,
    count: u32,
    /// Time of the last edge.
    counted_at: u32,
    was_high: bool,
}

impl<I: Input> Counter<I> {
    /// A counter that does not count yet.
    pub const fn new(pin: I) -> Self {
        Self { pin, poll_ticks: 0, sample_ticks: 0, next_report: 0, count: 0, counted_at: 0, was_high: false }
    }

    /// Begins to count, or ends it. Returns when to look first.
    pub fn ask(&mut self, clock: u32, poll_ticks: u32, sample_ticks: u32) -> Option<u32> {
        self.poll_ticks = poll_ticks;
        self.sample_ticks = sample_ticks;
        self.next_report = clock.wrapping_add(sample_ticks);
        self.was_high = self.pin.is_high();
        (poll_ticks != 0 && sample_ticks != 0).then_some(clock)
    }

    /// Looks at the input. Returns the time of the next look, and a report: the time of the next one, edges
    /// so far, and when the last one was seen.
    pub fn look(&mut self, due: u32) -> (u32, Option<[u32; 3]>) {
        let is_high = self.pin.is_high();
        if is_high != self.was_high {
            self.was_high = is_high;
            self.count = self.count.wrapping_add(1);
            self.counted_at = due;
        }
        let is_due = due.wrapping_sub(self.next_report) as i32 >= 0;
        if is_due {
            self.next_report = self.next_report.wrapping_add(self.sample_ticks);
        }
        let report = is_due.then_some([self.next_report, self.count, self.counted_at]);
        (due.wrapping_add(self.poll_ticks), report)
    }
}
