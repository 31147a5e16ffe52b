//! The step queue: what the step feed writes ahead and the step interrupt plays back.
//!
//! The feed is the only producer, the interrupt the only consumer. The producer alone writes `events` and
//! `written`; the consumer alone writes `played`. An event is published by the release store of `written`, so
//! the consumer never sees a half-written one, and neither side ever waits for the other. Everything is
//! 32-bit atomics: plain loads and stores on a Cortex-M7, no `unsafe`, no critical section.
//!
//! Depth: the feed writes at most [`crate::feed::HORIZON`] ahead (1.5 ms). [`CAPACITY`] events cover that
//! horizon at 1.4 million events a second, and the 0.625 ms of a board's feed at 3.2 million; beyond, it
//! writes less far ahead.

use core::sync::atomic::{AtomicBool, AtomicU32, Ordering, compiler_fence};

use units::{Actuator, Direction};

/// Number of events that fit. A power of two, so that wrapping is a mask.
pub const CAPACITY: usize = 2048;
const MASK: u32 = CAPACITY as u32 - 1;

/// Event at one instant: a motor steps, its direction pin gets a new level, or a laser another duty.
///
/// Layout of the packed word: bits 0 to 2 the motor, bit 3 forward (of a turn), bit 4 a turn. A step's word
/// is just its motor, so that the interrupt finds out with one comparison, and without shifting, what to do
/// and where.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct StepEvent {
    /// Low half of the step clock at which the event is due.
    pub at: u32,
    /// Packed action and motor.
    pub word: u32,
}

impl StepEvent {
    /// Bits of [`Self::word`] that name the motor.
    pub const MOTOR: u32 = 0b111;
    /// Bit of [`Self::word`]: the new direction is forward.
    pub const FORWARD: u32 = 0b1000;
    /// Bit of [`Self::word`]: the direction changes; the motor does not step.
    pub const TURN: u32 = 0b1_0000;
    /// Number of bits used in a word by motors.
    pub(crate) const BITS: u32 = 5;
    /// Number in the place of a motor's: with [`Self::TURN`], the power of a laser changes.
    pub const LASER: u32 = 6;
    /// Place of a power's duty in its word.
    const DUTY_SHIFT: u32 = 16;

    /// Event that steps a motor at `at`.
    #[must_use]
    pub const fn step(at: u32, actuator: Actuator) -> Self {
        Self { at, word: actuator as u32 }
    }

    /// Event that changes a motor's direction pin at `at`.
    #[must_use]
    pub const fn turn(at: u32, actuator: Actuator, direction: Direction) -> Self {
        let forward = match direction {
            Direction::Forward => Self::FORWARD,
            Direction::Backward => 0,
        };
        Self { at, word: actuator as u32 | forward | Self::TURN }
    }

    /// Event that gives a laser another duty, in 1/65535, at `at`.
    #[must_use]
    pub const fn power(at: u32, duty: u16) -> Self {
        Self { at, word: (duty as u32) << Self::DUTY_SHIFT | Self::TURN | Self::LASER }
    }

    /// Returns a laser's new duty, in 1/65535; `None` for an event of a motor.
    #[must_use]
    #[inline(always)]
    pub const fn laser_duty(self) -> Option<u16> {
        let is_power = self.word & (Self::TURN | Self::MOTOR) == Self::TURN | Self::LASER;
        if is_power { Some((self.word >> Self::DUTY_SHIFT) as u16) } else { None }
    }

    /// Returns the motor, as a place in [`units::PerActuator`].
    #[must_use]
    #[inline(always)]
    pub const fn motor(self) -> usize {
        (self.word & Self::MOTOR) as usize
    }

    /// Whether it is a turn rather than a step.
    #[must_use]
    #[inline(always)]
    pub const fn is_turn(self) -> bool {
        self.word & Self::TURN != 0
    }

    /// Whether the new direction of a turn is forward.
    #[must_use]
    #[inline(always)]
    pub const fn is_forward(self) -> bool {
        self.word & Self::FORWARD != 0
    }

    /// Motors that step, one bit each.
    #[must_use]
    pub const fn stepping(self) -> u8 {
        if self.is_turn() { 0 } else { 1 << self.motor() }
    }

    /// Motors whose direction becomes forward, one bit each.
    #[must_use]
    pub const fn turning_forward(self) -> u8 {
        if self.is_turn() && self.is_forward() && self.laser_duty().is_none() { 1 << self.motor() } else { 0 }
    }

    /// Motors whose direction becomes backward, one bit each.
    #[must_use]
    pub const fn turning_backward(self) -> u8 {
        if self.is_turn() && !self.is_forward() && self.laser_duty().is_none() { 1 << self.motor() } else { 0 }
    }
}

/// A place in the ring.
#[derive(Debug)]
#[repr(C)]
struct Slot {
    at: AtomicU32,
    word: AtomicU32,
}

impl Slot {
    #[inline(always)]
    fn read(&self) -> StepEvent {
        StepEvent { at: self.at.load(Ordering::Relaxed), word: self.word.load(Ordering::Relaxed) }
    }

    #[inline(always)]
    fn write(&self, event: StepEvent) {
        self.at.store(event.at, Ordering::Relaxed);
        self.word.store(event.word, Ordering::Relaxed);
    }
}

/// The ring itself. Lives in a `static` (DTCM on the board).
///
/// The step queue, with its fields in the order of use: those that the interrupt reads every time come first,
/// within reach of one base register.
#[derive(Debug)]
#[repr(C)]
pub struct StepQueue {
    /// Count of events ever published, wrapping. Written by the feed only.
    written: AtomicU32,
    /// Count of events ever played, wrapping. Written by the interrupt only.
    played: AtomicU32,
    /// Set by anyone who must stop the motors at once, cleared by the feed: nothing more may be played.
    cut: AtomicBool,
    slots: [Slot; CAPACITY],
}

impl Default for StepQueue {
    fn default() -> Self {
        Self::new()
    }
}

impl StepQueue {
    /// Creates an empty queue.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            slots: [const { Slot { at: AtomicU32::new(0), word: AtomicU32::new(0) } }; CAPACITY],
            written: AtomicU32::new(0),
            played: AtomicU32::new(0),
            cut: AtomicBool::new(false),
        }
    }

    // --- feed side ---

    /// Appends an event. False when the queue is full; then nothing was written.
    #[must_use]
    #[inline]
    pub fn push(&self, event: StepEvent) -> bool {
        let written = self.written.load(Ordering::Relaxed);
        if written.wrapping_sub(self.played.load(Ordering::Acquire)) >= CAPACITY as u32 {
            return false;
        }
        self.slots[(written & MASK) as usize].write(event);
        self.written.store(written.wrapping_add(1), Ordering::Release);
        true
    }

    /// A writer for so many events at most: they are published together when it is dropped.
    #[must_use]
    pub fn writer(&self, most: u32) -> Writer<'_> {
        let written = self.written.load(Ordering::Relaxed);
        let room = (self.free() as u32).min(most);
        Writer { queue: self, written, end: written.wrapping_add(room) }
    }

    /// Returns the number of events that wait to be played.
    #[must_use]
    pub fn len(&self) -> usize {
        self.written.load(Ordering::Acquire).wrapping_sub(self.played.load(Ordering::Acquire)) as usize
    }

    /// Returns whether nothing waits to be played.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Returns the number of events ever played, wrapping.
    #[must_use]
    pub fn played(&self) -> u32 {
        self.played.load(Ordering::Acquire)
    }

    /// Returns the number of events ever published, wrapping.
    #[must_use]
    pub fn written(&self) -> u32 {
        self.written.load(Ordering::Acquire)
    }

    /// The event that was published as number `count` (see [`Self::written`]). Only the feed may ask, and
    /// only for the last [`CAPACITY`] events: older ones are overwritten.
    #[must_use]
    #[inline(always)]
    pub fn event(&self, count: u32) -> StepEvent {
        self.slots[(count & MASK) as usize].read()
    }

    /// Returns the number of events that still fit. The interrupt only ever makes this more.
    #[must_use]
    pub fn free(&self) -> usize {
        CAPACITY - self.len()
    }

    /// Forgets what was not played and lets the interrupt go on. Only the feed may call this, and only while
    /// the queue is cut: then the interrupt does not write `played`.
    pub(crate) fn restart(&self) {
        self.played.store(self.written.load(Ordering::Relaxed), Ordering::Release);
        self.cut.store(false, Ordering::SeqCst);
    }

    /// Drops those events that were not played and that `keeps` refuses, and lets the interrupt go on with
    /// the rest. Only the feed may call this, and only while the queue is cut.
    pub fn go_on_with(&self, mut keeps: impl FnMut(StepEvent) -> bool) {
        let (played, written) = (self.played.load(Ordering::Relaxed), self.written.load(Ordering::Relaxed));
        let (mut count, mut kept) = (played, played);
        while count != written {
            let event = self.event(count);
            if keeps(event) {
                self.slots[(kept & MASK) as usize].write(event);
                kept = kept.wrapping_add(1);
            }
            count = count.wrapping_add(1);
        }
        self.written.store(kept, Ordering::Release);
        self.cut.store(false, Ordering::SeqCst);
    }

    // --- any side ---

    /// Stops playing at once, without deceleration: for faults and the kill switch. The feed notices at its
    /// next run, works out where the motors stand and makes that the position.
    pub fn cut(&self) {
        self.cut.store(true, Ordering::SeqCst);
    }

    /// Whether playing has been cut short and the feed has not yet cleared up.
    #[must_use]
    #[inline(always)]
    pub fn is_cut(&self) -> bool {
        self.cut.load(Ordering::SeqCst)
    }

    // --- interrupt side ---

    /// Returns the next event, if there is one, and leaves it in the queue until [`Self::advance`].
    #[must_use]
    #[inline(always)]
    pub fn front(&self) -> Option<StepEvent> {
        let played = self.played.load(Ordering::Relaxed);
        if played == self.written.load(Ordering::Acquire) || self.cut.load(Ordering::Relaxed) {
            return None;
        }
        Some(self.event(played))
    }

    /// Removes the event that [`Self::front`] returned.
    #[inline(always)]
    pub fn advance(&self) {
        self.played.store(self.played.load(Ordering::Relaxed).wrapping_add(1), Ordering::Release);
    }

    /// Hands events to `play` in order and removes each it accepts, until none is left or one is not due yet.
    ///
    /// For an interrupt on the core that also runs the feed, and that nobody who writes or cuts the queue can
    /// interrupt: what it finds at the beginning holds to the end. A core sees its own memory accesses in
    /// order, so compiler fences do what barriers do in [`Self::front`] and [`Self::advance`], at no
    /// instruction.
    #[inline(always)]
    pub fn play_on_this_core(&self, mut play: impl FnMut(StepEvent) -> bool) {
        if self.cut.load(Ordering::Relaxed) {
            return;
        }
        let (mut played, written) = (self.played.load(Ordering::Relaxed), self.written.load(Ordering::Relaxed));
        compiler_fence(Ordering::Acquire);
        while played != written {
            if !play(self.event(played)) {
                return;
            }
            played = played.wrapping_add(1);
            compiler_fence(Ordering::Release);
            self.played.store(played, Ordering::Relaxed);
        }
    }
}

/// Appends many events at the cost of one publication.
#[derive(Debug)]
pub struct Writer<'a> {
    queue: &'a StepQueue,
    written: u32,
    /// Count of events that would be written with all room used.
    end: u32,
}

impl Writer<'_> {
    /// Returns the number of events that still fit.
    #[must_use]
    #[inline(always)]
    pub fn room(&self) -> u32 {
        self.end.wrapping_sub(self.written)
    }

    /// Appends an event unless there is no more room; says whether it did.
    #[inline(always)]
    pub fn push(&mut self, event: StepEvent) -> bool {
        if self.written == self.end {
            return false;
        }
        self.push_into_room(event);
        true
    }

    /// Appends an event where there is [`Self::room`]: an event of before would be lost otherwise.
    #[inline(always)]
    pub fn push_into_room(&mut self, event: StepEvent) {
        self.queue.slots[(self.written & MASK) as usize].write(event);
        self.written = self.written.wrapping_add(1);
    }
}

impl Drop for Writer<'_> {
    fn drop(&mut self) {
        self.queue.written.store(self.written, Ordering::Release);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn playing_removes_what_is_accepted_and_keeps_the_rest() {
        let queue = StepQueue::new();
        for at in 0..10 {
            assert!(queue.push(StepEvent::step(at, Actuator::Alpha)));
        }
        let mut seen = 0;
        queue.play_on_this_core(|event| {
            seen += 1;
            event.at < 4
        });
        assert_eq!((seen, queue.len(), queue.front()), (5, 6, Some(StepEvent::step(4, Actuator::Alpha))));
        queue.cut();
        queue.play_on_this_core(|_| unreachable!("a cut queue plays nothing"));
    }

    #[test]
    fn going_on_keeps_the_order_of_what_is_kept() {
        let queue = StepQueue::new();
        for at in 0..20 {
            assert!(queue.push(StepEvent::step(at, if at % 3 == 0 { Actuator::Alpha } else { Actuator::Beta })));
        }
        queue.play_on_this_core(|event| event.at < 4);
        queue.cut();
        queue.go_on_with(|event| event.motor() == Actuator::Beta as usize);
        let mut seen = Vec::new();
        queue.play_on_this_core(|event| {
            seen.push(event.at);
            true
        });
        assert_eq!(seen, [4, 5, 7, 8, 10, 11, 13, 14, 16, 17, 19]);
    }

    #[test]
    fn events_come_out_in_order_and_a_full_queue_refuses() {
        let queue = StepQueue::new();
        for round in 0..3_u32 {
            for index in 0..CAPACITY as u32 {
                assert!(queue.push(StepEvent::step(round * 100_000 + index, Actuator::Beta)));
            }
            assert!(!queue.push(StepEvent::step(0, Actuator::Alpha)), "a full queue must refuse");
            for index in 0..CAPACITY as u32 {
                assert_eq!(queue.front(), Some(StepEvent::step(round * 100_000 + index, Actuator::Beta)));
                queue.advance();
            }
            assert_eq!(queue.front(), None);
        }
    }

    #[test]
    fn a_packed_event_reads_back() {
        for actuator in Actuator::ALL {
            let bit = actuator.bit();
            let masks = |event: StepEvent| (event.stepping(), event.turning_forward(), event.turning_backward());
            assert_eq!(masks(StepEvent::step(7, actuator)), (bit, 0, 0));
            assert_eq!(masks(StepEvent::turn(7, actuator, Direction::Forward)), (0, bit, 0));
            assert_eq!(masks(StepEvent::turn(7, actuator, Direction::Backward)), (0, 0, bit));
            assert!(StepEvent::step(7, actuator).word <= StepEvent::MOTOR);
            assert!(StepEvent::turn(7, actuator, Direction::Backward).word > StepEvent::MOTOR);
            assert_eq!(StepEvent::turn(7, actuator, Direction::Forward).laser_duty(), None);
            let power = StepEvent::power(7, 0xABCD);
            assert_eq!((masks(power), power.laser_duty()), ((0, 0, 0), Some(0xABCD)));
        }
    }
}
