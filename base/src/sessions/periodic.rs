//! Reports that a session gets without asking (M155, M27 S, M113), and their periods.

use program::Dialect;
use units::Micros;

/// Report that repeats by itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Periodic {
    /// Temperatures of the heaters.
    Temperatures,
    /// Progress of the played file.
    Job,
    /// Notice that the line in work is not done yet (`busy: processing`).
    Busy,
}

/// Seconds between `busy` lines in Marlin's dialect, without M113: its hosts count on them.
const MARLINS: u8 = 2;

/// Period of each report, s, and the time of the last one.
#[derive(Clone, Copy, Debug, Default)]
pub struct Periods([(Option<u8>, Micros); 3]);

impl Periods {
    /// No periods: nothing was asked for.
    pub const NONE: Self = Self([(None, Micros(0)); 3]);

    /// Repeats a report every so many seconds from now on; 0 for never.
    pub fn set(&mut self, what: Periodic, seconds: u8, now: Micros) {
        if let Some(period) = self.0.get_mut(what as usize) {
            *period = (Some(seconds), now);
        }
    }

    /// Returns the period of a report for a session of this dialect, s; 0 for never.
    #[must_use]
    pub fn seconds(&self, what: Periodic, dialect: Dialect) -> u8 {
        let usual = if what == Periodic::Busy && dialect == Dialect::Marlin { MARLINS } else { 0 };
        self.0.get(what as usize).and_then(|(seconds, _)| *seconds).unwrap_or(usual)
    }

    /// Takes the reports that are due.
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

#[cfg(test)]
mod tests {
    use super::*;

    const fn at(seconds: u64) -> Micros {
        Micros::from_seconds(seconds)
    }

    #[test]
    fn a_report_comes_each_period_and_no_other_with_it() {
        for (place, what) in [Periodic::Temperatures, Periodic::Job].into_iter().enumerate() {
            let mut periods = Periods::NONE;
            periods.set(what, 3, at(10));
            let mut due = [false; 3];
            due[place] = true;
            let took: Vec<_> = (10..20).map(|second| periods.take_due(Dialect::Smoothie, false, at(second))).collect();
            for (second, taken) in took.into_iter().enumerate() {
                let expected = if second > 0 && second % 3 == 0 { due } else { [false; 3] };
                assert_eq!(taken, expected, "after {second} s");
            }
            periods.set(what, 0, at(20));
            assert_eq!(periods.take_due(Dialect::Smoothie, false, at(90)), [false; 3], "0 is never");
        }
    }

    #[test]
    fn only_a_line_that_takes_long_is_busy() {
        let mut periods = Periods::NONE;
        let mut busy = |is_busy, second| periods.take_due(Dialect::Marlin, is_busy, at(second))[2];
        assert!(!busy(false, 100) && !busy(true, 101));
        assert!(busy(true, 102), "Marlin's hosts count on it");
        assert!(!busy(false, 103) && !busy(true, 104));
        let mut never = Periods::NONE;
        assert!(!never.take_due(Dialect::Smoothie, true, at(900))[2]);
    }
}
