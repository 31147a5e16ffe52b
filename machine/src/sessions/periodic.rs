//! Reports that a session gets without asking (M155, M27 S, M113): which, and how often.

use program::Dialect;
use units::Micros;

/// A report that repeats.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Periodic {
    /// Temperatures.
    Temperatures,
    /// How far the file is.
    Job,
    /// The line in work is not done yet (`busy: processing`).
    Busy,
}

/// Seconds between `busy` lines in Marlin's dialect, without M113: its hosts count on them.
const MARLINS: u8 = 2;

/// How often each is said, and when it was said last.
#[derive(Clone, Copy, Debug, Default)]
pub struct Periods([(Option<u8>, Micros); 3]);

impl Periods {
    /// Nothing was asked for.
    pub const NONE: Self = Self([(None, Micros(0)); 3]);

    /// Repeats a report every so many seconds from now on; 0 for never.
    pub fn set(&mut self, what: Periodic, seconds: u8, now: Micros) {
        if let Some(period) = self.0.get_mut(what as usize) {
            *period = (Some(seconds), now);
        }
    }

    /// Seconds between two times that it is said to whoever speaks this dialect, 0 for never.
    #[must_use]
    pub fn seconds(&self, what: Periodic, dialect: Dialect) -> u8 {
        let usual = if what == Periodic::Busy && dialect == Dialect::Marlin { MARLINS } else { 0 };
        self.0.get(what as usize).and_then(|(seconds, _)| *seconds).unwrap_or(usual)
    }

    /// Which of them are due, once.
    pub fn take_due(&mut self, dialect: Dialect, is_busy: bool, now: Micros) -> [bool; 3] {
        [Periodic::Temperatures, Periodic::Job, Periodic::Busy].map(|what| {
            let seconds = self.seconds(what, dialect);
            let waits = seconds > 0 && (what != Periodic::Busy || is_busy);
            let Some((_, last)) = self.0.get_mut(what as usize) else { return false };
            let is_due = waits && now.since(*last) >= Micros::from_seconds(u64::from(seconds));
            if is_due || !waits {
                *last = now;
            }
            is_due
        })
    }
}
