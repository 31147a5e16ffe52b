//! Watch over step times: late steps are always reported, and end the job if a step might have been lost.
//!
//! A step that is somewhat late does no harm by itself. But steps that had to be delayed to keep a driver's
//! least distance, or a feed so late that the motion stood still in the middle of its way, may have made a
//! motor fall behind: the machine halts, braking along the path. All steps were given in any case, so
//! positions are kept.

use core::fmt;

use units::Micros;

use crate::ports::StepTimes;

/// Least time between two reports of late steps.
const TELL_PERIOD: Micros = Micros::from_seconds(1);

/// State of the reports so far.
#[derive(Clone, Copy, Debug, Default)]
pub struct StepTimesWatch {
    reported: StepTimes,
    reported_feed: u32,
    tell_due: Micros,
}

/// News of late steps, for a report.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Lateness {
    /// The motion stood still for a moment: the machine halts.
    FeedCameLate,
    /// Steps had to be delayed: the machine halts.
    Delayed {
        /// The worst lateness, us.
        worst_us: f64,
    },
    /// Steps came late and nothing was lost.
    Late {
        /// Number of late steps.
        count: u32,
        /// The worst lateness, us.
        worst_us: f64,
    },
}

impl Lateness {
    /// Returns whether a step may have been lost.
    #[must_use]
    pub const fn halts(self) -> bool {
        !matches!(self, Self::Late { .. })
    }
}

impl fmt::Display for Lateness {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::FeedCameLate => f.write_str(
                "ERROR: steps were not ready in time and the motion stood still for a moment. Positions are kept; check them, then M999",
            ),
            Self::Delayed { worst_us } => write!(
                f,
                "ERROR: steps came up to {worst_us:.1} us late and had to be delayed for their driver. Positions are kept; check them, then M999"
            ),
            Self::Late { count, worst_us } => write!(f, "WARNING: {count} steps came late, by up to {worst_us:.1} us"),
        }
    }
}

/// Converts a lateness to microseconds.
#[must_use]
pub fn microseconds(worst: units::Ticks) -> f64 {
    worst.0 as f64 / f64::from(units::STEP_CLOCK_HZ / 1_000_000)
}

impl StepTimesWatch {
    /// Polls the step times; `feed_late` counts the feed's runs that came too late.
    pub fn poll(&mut self, times: StepTimes, feed_late: u32, now: Micros) -> Option<Lateness> {
        let reported = *self;
        let lost_time = times.delayed != reported.reported.delayed || feed_late != reported.reported_feed;
        if !lost_time && (times.late == reported.reported.late || now < reported.tell_due) {
            return None;
        }
        *self = Self { reported: times, reported_feed: feed_late, tell_due: now.plus(TELL_PERIOD) };
        let worst_us = microseconds(times.worst);
        Some(if feed_late != reported.reported_feed {
            Lateness::FeedCameLate
        } else if times.delayed != reported.reported.delayed {
            Lateness::Delayed { worst_us }
        } else {
            Lateness::Late { count: times.late.wrapping_sub(reported.reported.late), worst_us }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn times(late: u32, delayed: u32) -> StepTimes {
        StepTimes { late, delayed, ..StepTimes::default() }
    }

    #[test]
    fn late_steps_are_told_once_a_second_and_all_of_them() {
        let mut watch = StepTimesWatch::default();
        let at = |watch: &mut StepTimesWatch, late, ms| watch.poll(times(late, 0), 0, Micros::from_millis(ms));
        assert_eq!(at(&mut watch, 0, 10), None);
        assert_eq!(at(&mut watch, 3, 20), Some(Lateness::Late { count: 3, worst_us: 0.0 }));
        assert_eq!(at(&mut watch, 5, 900), None, "within the second");
        assert_eq!(at(&mut watch, 9, 1_020), Some(Lateness::Late { count: 6, worst_us: 0.0 }));
        assert_eq!(at(&mut watch, 9, 5_000), None, "nothing new");
    }

    #[test]
    fn a_step_that_may_be_lost_halts_at_once_and_once() {
        let mut watch = StepTimesWatch::default();
        let now = Micros::from_millis(1);
        watch.poll(times(1, 0), 0, now);
        let delayed = watch.poll(times(2, 1), 0, now).expect("news");
        assert!(delayed.halts() && matches!(delayed, Lateness::Delayed { .. }));
        let feed = watch.poll(times(2, 1), 1, now).expect("news");
        assert!(feed.halts() && feed == Lateness::FeedCameLate);
        assert_eq!(watch.poll(times(2, 1), 1, now), None);
        assert!(!Lateness::Late { count: 1, worst_us: 0.3 }.halts());
    }
}
