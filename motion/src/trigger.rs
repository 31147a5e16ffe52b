//! An input that stops motion: an end switch or a probe. The input's interrupt latches *when*; the feed works
//! out *where*.

use core::sync::atomic::{AtomicBool, AtomicU32, Ordering};

use units::{PerActuator, StepCount, Ticks};

use crate::queue::StepQueue;

/// Value for no input that has fired.
const NONE: u32 = u32::MAX;

/// The meeting place of the input interrupts and the step feed. Lives in a `static`; plain atomics, nobody
/// waits.
///
/// The executor arms it for some inputs and gives the order to move; the first armed input to report
/// disarms it and leaves its number and tick; the feed takes them at its next run and stops the motion.
///
/// Armed softly, the motion brakes along its path from what is already written: no step is lost, at the price
/// of the way that takes. Armed hard, reporting cuts the step queue at once ([`StepQueue::cut`]): the motors
/// stand within a step, and may lose some if they were fast. For an approach whose place is measured again
/// afterwards.
#[derive(Debug)]
pub struct Latch {
    /// Inputs that may fire, one bit each. Written by the executor, cleared by the interrupt that fires.
    armed: AtomicU32,
    /// Stop at once rather than brake. Written by the executor while disarmed.
    hard: AtomicBool,
    /// Low half of the step clock when the input fired. Written by the interrupt before `fired`.
    at: AtomicU32,
    /// Number of the input that fired, or [`NONE`]. Written by the interrupt, reset by the feed and by
    /// arming.
    fired: AtomicU32,
}

/// An input that has fired.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Fired {
    /// Number of the input.
    pub input: u8,
    /// Low half of the step clock at that moment.
    pub at: u32,
}

/// Event that stopped the motion: the input, its time, and the motors' step counts then.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Trigger {
    /// Number of the input.
    pub input: u8,
    /// Time at which the input fired.
    pub at: Ticks,
    /// Each motor's step count at that tick, exactly.
    pub steps: PerActuator<StepCount>,
}

impl Default for Latch {
    fn default() -> Self {
        Self::new()
    }
}

impl Latch {
    /// A latch that is not armed.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            armed: AtomicU32::new(0),
            hard: AtomicBool::new(false),
            at: AtomicU32::new(0),
            fired: AtomicU32::new(NONE),
        }
    }

    /// Arms the inputs of this mask (bit n: input n), to brake, and forgets what fired before. Zero disarms.
    pub fn arm(&self, inputs: u32) {
        self.arm_to(inputs, false);
    }

    /// Arms the inputs of this mask to stop the motors at once.
    pub fn arm_hard(&self, inputs: u32) {
        self.arm_to(inputs, true);
    }

    fn arm_to(&self, inputs: u32, hard: bool) {
        // Disarmed first, so that no interrupt can fire between the stores and be forgotten.
        self.armed.store(0, Ordering::SeqCst);
        self.fired.store(NONE, Ordering::SeqCst);
        self.hard.store(hard, Ordering::SeqCst);
        self.armed.store(inputs, Ordering::SeqCst);
    }

    /// Disarms every input and forgets what fired.
    pub fn disarm(&self) {
        self.arm(0);
    }

    /// Returns the inputs still armed, one bit each.
    #[must_use]
    pub fn armed(&self) -> u32 {
        self.armed.load(Ordering::SeqCst)
    }

    /// Whether the present arming, or the last, is hard.
    #[must_use]
    pub fn is_hard(&self) -> bool {
        self.hard.load(Ordering::SeqCst)
    }

    /// Called by an input's interrupt with the low half of the step clock. Only the first armed input counts;
    /// armed hard, it cuts the queue.
    pub fn report(&self, input: u8, at: u32, queue: &StepQueue) {
        let bit = 1_u32.checked_shl(u32::from(input)).unwrap_or(0);
        if self.armed.load(Ordering::SeqCst) & bit == 0 {
            return;
        }
        // Another input's interrupt may come between: the one that swaps the mask out is the first.
        if self.armed.swap(0, Ordering::SeqCst) & bit == 0 {
            return;
        }
        if self.is_hard() {
            queue.cut();
        }
        self.at.store(at, Ordering::SeqCst);
        self.fired.store(u32::from(input), Ordering::SeqCst);
    }

    /// The input that fired, if one has and the feed has not seen it yet.
    #[must_use]
    pub fn fired(&self) -> Option<Fired> {
        let input = self.fired.load(Ordering::SeqCst);
        if input == NONE {
            return None;
        }
        Some(Fired { input: input as u8, at: self.at.load(Ordering::SeqCst) })
    }

    /// Takes the input that fired. The feed's side.
    pub(crate) fn take(&self) -> Option<Fired> {
        let fired = self.fired();
        if fired.is_some() {
            self.fired.store(NONE, Ordering::SeqCst);
        }
        fired
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_the_first_armed_input_fires() {
        let (latch, queue) = (Latch::new(), StepQueue::new());
        latch.report(3, 10, &queue);
        assert_eq!(latch.fired(), None, "nothing is armed");
        latch.arm(0b1010);
        latch.report(0, 20, &queue);
        latch.report(40, 20, &queue);
        assert_eq!((latch.fired(), latch.armed()), (None, 0b1010), "input 0 is not armed");
        latch.report(3, 30, &queue);
        latch.report(1, 31, &queue);
        assert_eq!(latch.take(), Some(Fired { input: 3, at: 30 }));
        assert_eq!((latch.take(), latch.armed()), (None, 0));
    }

    #[test]
    fn arming_forgets_what_fired_before() {
        let (latch, queue) = (Latch::new(), StepQueue::new());
        latch.arm(1);
        latch.report(0, 5, &queue);
        latch.arm(2);
        assert_eq!(latch.fired(), None);
        latch.disarm();
        latch.report(1, 6, &queue);
        assert_eq!(latch.fired(), None);
        assert!(!queue.is_cut(), "it brakes");
    }

    #[test]
    fn the_first_input_of_a_hard_stop_cuts_and_the_next_arming_decides_anew() {
        let (latch, queue) = (Latch::new(), StepQueue::new());
        latch.arm_hard(0b110);
        latch.report(0, 4, &queue);
        assert!(!queue.is_cut(), "input 0 is not armed");
        latch.report(1, 5, &queue);
        assert!(queue.is_cut());
        assert_eq!(latch.take(), Some(Fired { input: 1, at: 5 }));
        queue.restart();
        latch.report(2, 6, &queue);
        latch.arm(0b110);
        latch.report(2, 7, &queue);
        assert!(!queue.is_cut(), "the next arming is soft");
    }
}
