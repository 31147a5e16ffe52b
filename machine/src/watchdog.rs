//! Who must be alive for the watchdog to be fed: heat control, the step feed, the planner, the slow watch
//! over drivers and supplies, and the dispatcher; all of them.

use core::sync::atomic::{AtomicU8, Ordering};

/// A task whose silence must reset the board.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reporter {
    /// Heat control's tick ran.
    Heat,
    /// The step feed ran.
    StepFeed,
    /// The planner ran. It is asked to ten times a second, also when there is nothing to plan.
    Planner,
    /// The watch over drivers and supplies ran.
    Supervisor,
    /// The dispatcher came by a waiting point.
    Dispatcher,
}

/// Reports since the watchdog was last fed. Lives in a `static`.
#[derive(Debug, Default)]
pub struct Reports(AtomicU8);

impl Reports {
    const ALL: u8 = 0b1_1111;

    /// Nobody has reported.
    #[must_use]
    pub const fn new() -> Self {
        Self(AtomicU8::new(0))
    }

    /// This reporter is alive.
    pub fn report(&self, reporter: Reporter) {
        self.0.fetch_or(1 << reporter as u8, Ordering::Relaxed);
    }

    /// True when all have reported since this last returned true: feed the watchdog.
    pub fn take_complete(&self) -> bool {
        self.0.compare_exchange(Self::ALL, 0, Ordering::Relaxed, Ordering::Relaxed).is_ok()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_watchdog_is_fed_only_when_all_have_reported() {
        use Reporter::{Dispatcher, Heat, Planner, StepFeed, Supervisor};
        let all = [Heat, StepFeed, Planner, Supervisor, Dispatcher];
        for silent in all {
            let reports = Reports::new();
            for _ in 0..3 {
                all.into_iter().filter(|reporter| *reporter != silent).for_each(|reporter| reports.report(reporter));
                assert!(!reports.take_complete(), "{silent:?} is missing");
            }
            reports.report(silent);
            assert!(reports.take_complete());
            assert!(!reports.take_complete(), "all must report anew");
        }
    }
}
