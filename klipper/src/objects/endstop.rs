//! End stops, and the triggers that stop motors.

use crate::board::Input;

/// A search for a level.
#[derive(Clone, Copy, Debug, Default)]
pub struct Search {
    /// Distance of the reads that confirm a level, ticks.
    pub sample_ticks: u32,
    /// Reads that must have the level, one after another.
    pub sample_count: u8,
    /// Distance of the reads before, ticks.
    pub rest_ticks: u32,
    /// The level that is searched.
    pub level: bool,
    /// The trigger to fire, by its object.
    pub trigger: u8,
    /// Reason that the trigger is given.
    pub reason: u8,
}

/// An input that ends a move.
#[derive(Debug)]
pub struct Endstop<I> {
    pin: I,
    search: Search,
    is_searching: bool,
    /// Reads that are still to confirm the level; zero before it was seen.
    confirming: u8,
    /// Time of the read at which the search goes on when the level is not confirmed.
    next: u32,
}

/// Outcome of a read.
pub enum Seen {
    /// The next read is due then.
    Later(u32),
    /// The level has been seen often enough: the trigger, and what it is told.
    Found(u8, u8),
}

impl<I: Input> Endstop<I> {
    /// An input that nobody searches.
    pub const fn new(pin: I) -> Self {
        let search = Search { sample_ticks: 0, sample_count: 0, rest_ticks: 0, level: false, trigger: 0, reason: 0 };
        Self { pin, search, is_searching: false, confirming: 0, next: 0 }
    }

    /// Begins a search at `clock`, or ends it when no reads are wanted: the host asks for the state of one
    /// that is over. Returns when to read first.
    pub const fn begin(&mut self, search: Search, clock: u32) -> Option<u32> {
        self.is_searching = search.sample_count != 0;
        if !self.is_searching {
            return None;
        }
        self.search = search;
        self.confirming = 0;
        self.next = clock;
        Some(clock)
    }

    /// Reads the input once.
    pub fn read(&mut self, due: u32) -> Seen {
        let is_there = self.pin.is_high() == self.search.level;
        if self.confirming == 0 {
            self.next = due.wrapping_add(self.search.rest_ticks);
            if !is_there {
                return Seen::Later(self.next);
            }
            self.confirming = self.search.sample_count;
        } else if !is_there {
            self.confirming = 0;
            return Seen::Later(self.next);
        }
        self.confirming -= 1;
        if self.confirming > 0 {
            return Seen::Later(due.wrapping_add(self.search.sample_ticks));
        }
        self.is_searching = false;
        Seen::Found(self.search.trigger, self.search.reason)
    }

    /// Ends the search without a result.
    pub const fn stop(&mut self) {
        self.is_searching = false;
    }

    /// Whether it searches; the time of the next read, or a rest behind the first one that had the level; the
    /// level now.
    pub fn state(&self) -> [u32; 3] {
        [u32::from(self.is_searching), self.next, u32::from(self.pin.is_high())]
    }
}

/// A trigger: stops motors once, whoever fires it, or when its time runs out.
#[derive(Debug, Default)]
pub struct Trigger {
    is_armed: bool,
    reason: u8,
    expire_reason: u8,
    report_ticks: u32,
    report_at: Option<u32>,
    expires_at: Option<u32>,
    /// Motors to stop, one bit each.
    pub motors: u8,
}

/// Action that a trigger's timer asks for.
pub enum Due {
    /// The state is to be reported.
    Report,
    /// Fire with this reason.
    Expired(u8),
    /// Nothing is due yet.
    Nothing,
}

impl Trigger {
    /// Arms the trigger; with no time for reports it ends what was before.
    pub fn start(&mut self, report_clock: u32, report_ticks: u32, expire_reason: u8) {
        *self = Self {
            is_armed: true,
            expire_reason,
            report_ticks,
            report_at: (report_ticks != 0).then_some(report_clock),
            ..Self::default()
        };
    }

    /// Sets the time at which it fires by itself.
    pub fn set_timeout(&mut self, clock: u32) {
        if self.is_armed {
            self.expires_at = Some(clock);
        }
    }

    /// Fires. Returns the motors to stop; `None` when it has fired before.
    pub fn fire(&mut self, reason: u8) -> Option<u8> {
        if !core::mem::take(&mut self.is_armed) {
            return None;
        }
        self.reason = reason;
        self.expires_at = None;
        Some(core::mem::take(&mut self.motors))
    }

    /// Ends reports as well as a time-out.
    pub fn rest(&mut self) {
        self.report_at = None;
        self.expires_at = None;
    }

    /// Forgets motors, times and reason.
    pub fn shut_down(&mut self) {
        *self = Self::default();
    }

    /// The time has come that the trigger has named.
    pub fn on_timer(&mut self, now: u32) -> Due {
        let has_come = |time: u32| now.wrapping_sub(time) as i32 >= 0;
        if self.expires_at.is_some_and(has_come) {
            return Due::Expired(self.expire_reason);
        }
        match self.report_at {
            Some(at) if has_come(at) => {
                // Once fired it has reported at once, and says no more.
                self.report_at = self.is_armed.then(|| at.wrapping_add(self.report_ticks));
                if self.is_armed { Due::Report } else { Due::Nothing }
            }
            _ => Due::Nothing,
        }
    }

    /// Returns the time at which it wants to be looked at.
    pub fn due(&self) -> Option<u32> {
        match (self.report_at, self.expires_at) {
            (Some(report), Some(expiry)) => {
                Some(if (expiry.wrapping_sub(report) as i32) < 0 { expiry } else { report })
            }
            (report, expiry) => report.or(expiry),
        }
    }

    /// Whether it can still fire, and why it has.
    pub const fn state(&self) -> [u32; 2] {
        [self.is_armed as u32, self.reason as u32]
    }
}
