//! Hardware PWM: values at their times, with the same limit as digital outputs.

use crate::board::Board;
use crate::moves::{Move, Pool, Queue};
use crate::reason::Reason;

/// A channel of hardware PWM. What has a limit is at its default value as well while the host is silent.
#[derive(Debug)]
pub struct PwmOut<P> {
    channel: P,
    default_value: u16,
    most_ticks: u32,
    value: u16,
    is_held: bool,
    ends_at: Option<u32>,
    queue: Queue,
}

impl<P: Copy> PwmOut<P> {
    /// A channel that has been set to `value`.
    pub const fn new(channel: P, value: u16, default_value: u16, most_ticks: u32) -> Self {
        Self { channel, default_value, most_ticks, value, is_held: false, ends_at: None, queue: Queue::EMPTY }
    }

    /// Queues a value. Returns when the channel wants to be looked at.
    ///
    /// # Errors
    /// No room, or the value comes too late.
    pub fn queue(&mut self, clock: u32, value: u16, pool: &mut Pool, now: u32) -> Result<Option<u32>, Reason> {
        if self.queue.is_empty() && (clock.wrapping_sub(now) as i32) < 0 {
            return Err(Reason::TimerTooClose);
        }
        let queued = Move { time: clock, value: u32::from(value), flag: 0 };
        pool.push(&mut self.queue, queued).ok_or(Reason::MoveQueueOverflow)?;
        self.check(pool)?;
        Ok(self.due(pool))
    }

    /// The next value must come before the present one has lasted for too long.
    fn check(&self, pool: &Pool) -> Result<(), Reason> {
        match (self.ends_at, pool.first(&self.queue)) {
            (Some(ends_at), Some(next)) if (ends_at.wrapping_sub(next.time) as i32) < 0 => Err(Reason::PwmDuration),
            _ => Ok(()),
        }
    }

    /// The time has come that the channel has named. Returns the next one.
    ///
    /// # Errors
    /// The host has not renewed the value in time.
    pub fn on_timer<B: Board<Pwm = P>>(
        &mut self,
        now: u32,
        pool: &mut Pool,
        board: &mut B,
    ) -> Result<Option<u32>, Reason> {
        let Some(first) = pool.pop(&mut self.queue) else {
            return if self.ends_at.is_some_and(|ends_at| now.wrapping_sub(ends_at) as i32 >= 0) {
                Err(Reason::MissedPwm)
            } else {
                Ok(self.due(pool))
            };
        };
        self.value = first.value as u16;
        let is_limited = self.most_ticks != 0 && self.value != self.default_value;
        self.ends_at = is_limited.then(|| first.time.wrapping_add(self.most_ticks));
        self.drive(board);
        self.check(pool)?;
        Ok(self.due(pool))
    }

    fn due(&self, pool: &Pool) -> Option<u32> {
        pool.first(&self.queue).map(|first| first.time).or(self.ends_at)
    }

    fn drive<B: Board<Pwm = P>>(&self, board: &mut B) {
        board.set_pwm(self.channel, if self.is_held { self.default_value } else { self.value });
    }

    /// Holds a channel that has a limit at its default value while the host is silent, or lets it go on.
    pub fn hold<B: Board<Pwm = P>>(&mut self, is_held: bool, board: &mut B) {
        if self.most_ticks != 0 && self.is_held != is_held {
            self.is_held = is_held;
            self.drive(board);
        }
    }

    /// Goes to the default value for good.
    pub fn shut_down<B: Board<Pwm = P>>(&mut self, pool: &mut Pool, board: &mut B) {
        pool.clear(&mut self.queue);
        self.ends_at = None;
        self.value = self.default_value;
        self.drive(board);
    }
}
