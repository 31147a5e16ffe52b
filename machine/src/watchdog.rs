//! Who must be alive for the watchdog to be fed: heat control, the step feed and the dispatcher, all of them.

use core::sync::atomic::{AtomicU8, Ordering};

/// A task whose silence must reset the board.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reporter {
    /// Heat control's tick ran.
    Heat,
    /// The step feed ran.
    StepFeed,
    /// The dispatcher came by a waiting point.
    Dispatcher,
}

/// Reports since the watchdog was last fed. Lives in a `static`.
#[derive(Debug, Default)]
pub struct Reports(AtomicU8);

impl Reports {
    const ALL: u8 = 0b111;

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
    fn the_watchdog_is_fed_only_when_all_three_have_reported() {
        let reports = Reports::new();
        for round in 0..3 {
            reports.report(Reporter::Heat);
            reports.report(Reporter::StepFeed);
            assert!(!reports.take_complete(), "round {round}: the dispatcher is missing");
            reports.report(Reporter::Dispatcher);
            assert!(reports.take_complete());
            assert!(!reports.take_complete());
        }
    }
}
