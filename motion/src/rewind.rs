//! Actual motor positions: the feed's position less the events that the interrupt has yet to play.
//!
//! The interrupt keeps no position. The ring of events still holds what was written last, so walking back
//! over it from the newest event undoes steps one by one: to the last one played, or to any tick of the
//! recent past.

use units::{PerActuator, StepCount};

use crate::queue::{CAPACITY, StepEvent, StepQueue};

/// Step counts and directions of all motors as of the newest event in the queue, and a way back.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rewind {
    /// Step counts at the current point.
    pub steps: PerActuator<StepCount>,
    /// Motors that turn forward after the event at the current point, one bit each.
    forward: u8,
    /// Motors of which a turn was undone, one bit each.
    turned: u8,
    /// Count of the event just after the current point.
    count: u32,
    /// Count of the oldest event still in the ring.
    oldest: u32,
}

impl Rewind {
    /// Starts at the newest event. `since` is the count of the first event that belongs to `steps`.
    pub fn new(queue: &StepQueue, steps: PerActuator<StepCount>, forward: u8, since: u32) -> Self {
        let count = queue.written();
        let kept = count.wrapping_sub(since).min(CAPACITY as u32);
        Self { steps, forward, turned: 0, count, oldest: count.wrapping_sub(kept) }
    }

    /// Undoes the newest event that is not undone yet, if `undo` says so.
    fn back(&mut self, queue: &StepQueue, undo: impl Fn(StepEvent) -> bool) -> bool {
        if self.count == self.oldest {
            return false;
        }
        let before = self.count.wrapping_sub(1);
        let event = queue.event(before);
        if !undo(event) {
            return false;
        }
        self.count = before;
        let bit = 1 << event.motor();
        if event.is_turn() {
            // A turn is only written when the direction changes, so before it the other one held.
            self.forward ^= bit;
            self.turned |= bit;
        } else if let Some(steps) = self.steps.0.get_mut(event.motor()) {
            *steps += if self.forward & bit != 0 { -1 } else { 1 };
        }
        true
    }

    /// Whether a motor's direction was changed after the current point.
    pub fn turns_later(&self, motor: usize) -> bool {
        self.turned & 1 << motor != 0
    }

    /// Back to the last event played.
    pub fn to_played(mut self, queue: &StepQueue) -> Self {
        let played = queue.played();
        while self.count != played && self.back(queue, |_| true) {}
        self
    }

    /// Back to this tick: undoes what is due after it. `newest` is the tick of the newest event on the same
    /// clock.
    pub fn to_tick(mut self, queue: &StepQueue, tick: u64, newest: u64) -> Self {
        let mut at = newest;
        loop {
            if at <= tick {
                return self;
            }
            let here = self.count;
            if !self.back(queue, |_| true) || self.count == self.oldest {
                return self;
            }
            // The queue holds low halves; neighbours are less than half a turn (10 s) of the clock apart.
            let (newer, older) = (queue.event(here.wrapping_sub(1)).at, queue.event(here.wrapping_sub(2)).at);
            at = at.saturating_sub(u64::from(newer.wrapping_sub(older)));
        }
    }
}
