//! Outputs that change when the path has come to a place: they ride on motion as marks, and nothing waits for
//! them.

use heapless::Deque;
use motion::Mark;
use units::{Celsius, Duty, HeaterId};

/// Number of effects that can wait; a line with one more waits until the first has been made.
const WAITING: usize = 64;

/// A change of an output.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Output {
    /// A heater's target, 0 for off.
    Target(HeaterId, Celsius),
    /// A digital or sigma-delta switch, by its place in the configuration's list; a digital one is off or
    /// full.
    Switch(u8, Duty),
    /// A switch on a hardware timer, likewise; 0 to 1.
    Pwm(u8, f32),
}

/// Too many changes wait. Not an error: ask again later.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Full;

/// Changes that wait for their marks, in the marks' order.
#[derive(Clone, Debug)]
pub struct Effects<T = Output> {
    waiting: Deque<(Mark, T), WAITING>,
}

impl<T: Copy> Default for Effects<T> {
    fn default() -> Self {
        Self::new()
    }
}

impl<T: Copy> Effects<T> {
    /// Creates an empty queue.
    #[must_use]
    pub const fn new() -> Self {
        Self { waiting: Deque::new() }
    }

    /// Queues a change for a mark, which is not before that of the last change.
    ///
    /// # Errors
    /// When too many wait.
    pub fn wait(&mut self, mark: Mark, output: T) -> Result<(), Full> {
        self.waiting.push_back((mark, output)).map_err(|_| Full)
    }

    /// Takes the next change whose mark has been reached.
    #[inline]
    pub fn reached(&mut self, mark: Mark) -> Option<T> {
        let (wanted, output) = *self.waiting.front()?;
        if !wanted.is_reached_with(mark) {
            return None;
        }
        self.waiting.pop_front();
        Some(output)
    }

    /// Drops all changes that still wait.
    pub fn clear(&mut self) {
        self.waiting.clear();
    }

    /// Returns whether nothing waits.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.waiting.is_empty()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn changes_come_in_order_and_none_before_its_mark() {
        let mut effects = Effects::new();
        for (mark, switch) in [(3, 0), (3, 1), (5, 2)] {
            assert_eq!(effects.wait(Mark(mark), Output::Switch(switch, Duty::FULL)), Ok(()));
        }
        let mut reached = |mark| core::iter::from_fn(|| effects.reached(Mark(mark))).count();
        assert_eq!([2, 3, 4, 5, 6].map(&mut reached), [0, 2, 0, 1, 0]);
    }

    #[test]
    fn a_full_queue_refuses_and_forgets_nothing() {
        let mut effects = Effects::new();
        for mark in 0..WAITING as u32 {
            assert_eq!(effects.wait(Mark(mark), Output::Pwm(0, 0.5)), Ok(()));
        }
        assert_eq!(effects.wait(Mark(100), Output::Pwm(0, 0.5)), Err(Full));
        assert_eq!(core::iter::from_fn(|| effects.reached(Mark(1_000))).count(), WAITING);
        assert!(effects.is_empty());
    }
}
