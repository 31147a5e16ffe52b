//! Digital outputs: changes at their times, pulses of software PWM, and the limits that make a host that
//! falls silent harmless.

use crate::board::Output;
use crate::moves::{Move, Pool, Queue};
use crate::reason::Reason;

/// Settings of an output.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    /// Level after a shutdown.
    pub default_high: bool,
    /// Longest time away from that level without another change, ticks; zero: no limit.
    pub most_ticks: u32,
}

/// A digital output. What has a limit is a heater: it is at its default level as well while the host is
/// silent.
#[derive(Debug)]
pub struct DigitalOut<O> {
    pin: O,
    limits: Limits,
    /// Period of software PWM, ticks; zero before it is set.
    cycle_ticks: u32,
    is_high: bool,
    is_held: bool,
    /// Ticks of high and low of the pulses that are made now.
    pulses: Option<(u32, u32)>,
    /// End of the pulse, or of the pause behind it.
    edge_at: u32,
    /// Time at which the present state has lasted for too long.
    ends_at: Option<u32>,
    queue: Queue,
}

impl<O: Output> DigitalOut<O> {
    /// An output that has been driven to `is_high`.
    pub const fn new(pin: O, is_high: bool, limits: Limits) -> Self {
        Self {
            pin,
            limits,
            cycle_ticks: 0,
            is_high,
            is_held: false,
            pulses: None,
            edge_at: 0,
            ends_at: None,
            queue: Queue::EMPTY,
        }
    }

    /// Sets the period of software PWM.
    ///
    /// # Errors
    /// Changes are queued.
    pub const fn set_cycle(&mut self, ticks: u32) -> Result<(), Reason> {
        if !self.queue.is_empty() {
            return Err(Reason::CycleWhileQueued);
        }
        self.cycle_ticks = ticks;
        Ok(())
    }

    /// Queues a change. Returns when the output wants to be looked at.
    ///
    /// # Errors
    /// No room, or the change comes too late.
    pub fn queue(&mut self, clock: u32, on_ticks: u32, pool: &mut Pool, now: u32) -> Result<Option<u32>, Reason> {
        if self.queue.is_empty() && (clock.wrapping_sub(now) as i32) < 0 {
            return Err(Reason::TimerTooClose);
        }
        let queued = Move { time: clock, value: on_ticks, flag: 0 };
        pool.push(&mut self.queue, queued).ok_or(Reason::MoveQueueOverflow)?;
        // The limit counts from the change that is under way: this one may come too late for it.
        if let Some(ends_at) = self.ends_at
            && pool.first(&self.queue).is_some_and(|first| (ends_at.wrapping_sub(first.time) as i32) < 0)
        {
            return Err(Reason::DigitalOutDuration);
        }
        Ok(self.due(pool))
    }

    /// Changes the output at once. Returns when it wants to be looked at.
    ///
    /// # Errors
    /// Changes are queued.
    pub fn update(&mut self, high: bool, now: u32, pool: &Pool) -> Result<Option<u32>, Reason> {
        if !self.queue.is_empty() {
            return Err(Reason::UpdateWhileQueued);
        }
        self.pulses = None;
        self.limit(high != self.limits.default_high, now);
        self.drive(high);
        Ok(self.due(pool))
    }

    /// The time has come that the output has named. Returns the next one.
    ///
    /// # Errors
    /// The host has not renewed the state in time.
    pub fn on_timer(&mut self, now: u32, pool: &mut Pool) -> Result<Option<u32>, Reason> {
        let has_come = |time: u32| now.wrapping_sub(time) as i32 >= 0;
        if let Some(first) = pool.first(&self.queue)
            && has_come(first.time)
        {
            let _taken = pool.pop(&mut self.queue);
            self.begin(first);
            if let (Some(ends_at), Some(next)) = (self.ends_at, pool.first(&self.queue))
                && (ends_at.wrapping_sub(next.time) as i32) < 0
            {
                return Err(Reason::DigitalOutDuration);
            }
        } else if self.ends_at.is_some_and(has_come) {
            return Err(Reason::MissedDigitalOut);
        } else if let Some((high, low)) = self.pulses
            && has_come(self.edge_at)
        {
            let next = !self.is_high;
            self.drive(next);
            self.edge_at = self.edge_at.wrapping_add(if next { high } else { low });
        }
        Ok(self.due(pool))
    }

    fn begin(&mut self, change: Move) {
        let (clock, on_ticks) = (change.time, change.value);
        let is_pulsed = on_ticks != 0 && on_ticks < self.cycle_ticks;
        self.pulses = is_pulsed.then(|| (on_ticks, self.cycle_ticks - on_ticks));
        self.edge_at = clock.wrapping_add(on_ticks);
        let high = on_ticks != 0;
        self.limit(is_pulsed || high != self.limits.default_high, clock);
        self.drive(high);
    }

    fn limit(&mut self, is_away: bool, clock: u32) {
        let is_limited = is_away && self.limits.most_ticks != 0;
        self.ends_at = is_limited.then(|| clock.wrapping_add(self.limits.most_ticks));
    }

    fn due(&self, pool: &Pool) -> Option<u32> {
        let edge = self.pulses.map(|_| self.edge_at);
        let queued = pool.first(&self.queue).map(|first| first.time);
        [edge, queued, self.ends_at]
            .into_iter()
            .flatten()
            .reduce(|first, other| if (other.wrapping_sub(first) as i32) < 0 { other } else { first })
    }

    fn drive(&mut self, high: bool) {
        self.is_high = high;
        self.pin.set(if self.is_held { self.limits.default_high } else { high });
    }

    /// Holds an output that has a limit at its default level while the host is silent, or lets it go on.
    pub fn hold(&mut self, is_held: bool) {
        if self.limits.most_ticks != 0 && self.is_held != is_held {
            self.is_held = is_held;
            self.drive(self.is_high);
        }
    }

    /// Goes to the default level for good.
    pub fn shut_down(&mut self, pool: &mut Pool) {
        pool.clear(&mut self.queue);
        self.pulses = None;
        self.ends_at = None;
        self.drive(self.limits.default_high);
    }
}
