//! Feeding of the watchdog, only while all that must be alive is: heat control, the step feed, the planner
//! and the slow watch over drivers and supplies, each since the last feeding; and the executor, which may
//! wait for a card.

use core::sync::atomic::{AtomicU8, Ordering};

use events::{Event, EventRing};
use units::Micros;

/// Task whose silence must reset the board.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reporter {
    /// Heat control's tick ran.
    Heat,
    /// The step feed ran.
    StepFeed,
    /// The planner ran, as it is asked to ten times a second, also when there is nothing to plan.
    Planner,
    /// The watch over drivers and supplies ran.
    Supervisor,
    /// The executor came by a waiting point.
    Executor,
}

/// Feedings that the executor may miss in a row. All others have reported within a tenth of a second, so it
/// may be away for some three seconds: as long as the slowest card with its repetitions.
const PATIENCE: u8 = 30;

/// Looks in a row with a missing report after which the silence is recorded: half of the time that the
/// watchdog waits, at heat control's 100 looks a second.
const MISSED_LOOKS: u8 = 45;

/// Reports since the watchdog was last fed. Lives in a `static`.
#[derive(Debug, Default)]
pub struct Reports {
    reported: AtomicU8,
    /// Feedings since the executor last reported.
    missed: AtomicU8,
    /// Looks since the last feeding.
    looks: AtomicU8,
}

impl Reports {
    const EXECUTOR: u8 = 1 << Reporter::Executor as u8;
    const TASKS: u8 = 0b1_1111 & !Self::EXECUTOR;

    /// Starts without any report.
    #[must_use]
    pub const fn new() -> Self {
        Self { reported: AtomicU8::new(0), missed: AtomicU8::new(0), looks: AtomicU8::new(0) }
    }

    /// Notes that this reporter is alive.
    pub fn report(&self, reporter: Reporter) {
        self.reported.fetch_or(1 << reporter as u8, Ordering::Relaxed);
    }

    /// Returns true when all tasks have reported since the last true, and the executor not too long ago:
    /// feed the watchdog. For one caller.
    pub fn take_complete(&self) -> bool {
        let reported = self.reported.load(Ordering::Relaxed);
        if reported & Self::TASKS != Self::TASKS {
            return false;
        }
        self.reported.fetch_and(!reported, Ordering::Relaxed);
        let missed = match reported & Self::EXECUTOR {
            0 => self.missed.load(Ordering::Relaxed).saturating_add(1),
            _ => 0,
        };
        self.missed.store(missed, Ordering::Relaxed);
        missed <= PATIENCE
    }

    /// Returns whether the watchdog is to be fed, at each of heat control's looks. A silent task that will
    /// soon cause a reset is recorded, once: the next start finds it. Heat control itself cannot be found so;
    /// nor can a processor whose interrupts are off.
    pub fn look(&self, now: Micros, events: EventRing<'_>) -> bool {
        let looks = self.looks.load(Ordering::Relaxed);
        if self.take_complete() {
            self.looks.store(0, Ordering::Relaxed);
            return true;
        }
        if looks == MISSED_LOOKS / 2 {
            // A task that hangs may have reported just before, and tasks that it keeps from running may not
            // have: only tasks that report from now on are alive.
            self.reported.fetch_and(!Self::TASKS, Ordering::Relaxed);
        }
        if looks == MISSED_LOOKS {
            events.record(now, &Event::Silent(self.silent()));
        }
        self.looks.store(looks.saturating_add(1), Ordering::Relaxed);
        false
    }

    fn silent(&self) -> u8 {
        if self.missed.load(Ordering::Relaxed) > PATIENCE {
            // The executor's silence was found when all tasks had reported; they have begun to do so anew.
            return Self::EXECUTOR;
        }
        !self.reported.load(Ordering::Relaxed) & Self::TASKS
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    use Reporter::{Executor, Heat, Planner, StepFeed, Supervisor};

    const TASKS: [Reporter; 4] = [Heat, StepFeed, Planner, Supervisor];

    fn all_report(reports: &Reports) {
        TASKS.into_iter().for_each(|task| reports.report(task));
    }

    #[test]
    fn the_watchdog_is_fed_only_when_all_have_reported() {
        for silent in TASKS {
            let reports = Reports::new();
            reports.report(Executor);
            for _ in 0..3 {
                TASKS.into_iter().filter(|task| *task != silent).for_each(|task| reports.report(task));
                assert!(!reports.take_complete(), "{silent:?} is missing");
            }
            reports.report(silent);
            assert!(reports.take_complete());
            assert!(!reports.take_complete(), "all must report anew");
        }
    }

    #[test]
    fn who_is_silent_is_recorded_once_and_before_the_watchdog_bites() {
        let (slots, next) = (std::boxed::Box::new(events::Slots::new()), core::sync::atomic::AtomicU32::new(1));
        let ring = EventRing::new(&slots, &next);
        for silent in [StepFeed, Planner, Supervisor, Executor] {
            let reports = Reports::new();
            let mut fed_at = 0;
            let recorded = (0..600_u64).find(|look| {
                let others = [Heat, StepFeed, Planner, Supervisor, Executor];
                others.into_iter().filter(|task| *task != silent).for_each(|task| reports.report(task));
                let before = ring.next();
                if reports.look(Micros::from_millis(10 * look), ring) {
                    fed_at = *look;
                }
                ring.next() != before
            });
            let entry = ring.last(1).next().unwrap();
            assert_eq!(entry.event, Event::Silent(1 << silent as u8));
            let looks = recorded.unwrap() - fed_at;
            assert!((40..80).contains(&looks), "{silent:?}: {looks} looks, and the watchdog waits for 90");
            assert!((0..200).all(|_| !reports.look(Micros(0), ring)) && ring.last(1).next() == Some(entry), "once");
        }
        assert_eq!(events::SILENT_TASKS.len(), Executor as usize + 1);
    }

    /// The step feed hangs, and the planner and the watch do not run below it.
    #[test]
    fn who_reports_once_more_and_hangs_is_silent_with_those_below() {
        let (slots, next) = (std::boxed::Box::new(events::Slots::new()), core::sync::atomic::AtomicU32::new(1));
        let (ring, reports) = (EventRing::new(&slots, &next), Reports::new());
        all_report(&reports);
        assert!(reports.look(Micros(0), ring));
        reports.report(StepFeed);
        for look in 0..60 {
            reports.report(Heat);
            assert!(!reports.look(Micros::from_millis(10 * look), ring));
        }
        let silent = [StepFeed, Planner, Supervisor].iter().fold(0, |bits, task| bits | 1 << *task as u8);
        assert_eq!(ring.last(1).next().unwrap().event, Event::Silent(silent));
    }

    #[test]
    fn an_executor_may_be_away_for_a_while_and_no_longer() {
        let reports = Reports::new();
        for _ in 0..2 {
            reports.report(Executor);
            all_report(&reports);
            assert!(reports.take_complete());
            for _ in 0..PATIENCE {
                all_report(&reports);
                assert!(reports.take_complete());
            }
        }
        all_report(&reports);
        assert!(!reports.take_complete());
        reports.report(Executor);
        all_report(&reports);
        assert!(reports.take_complete(), "it has come back");
    }
}
