//! Schedule of the step feed: its run times, and how far ahead of the motors it writes.
//!
//! Steps in the queue are not taken back, so a hold, a stop or an override is felt behind the last one: how
//! far ahead that is decides how soon. Two ways:
//!
//! - **On demand**, for a board. The feed runs again when what is written ends a `Lead` from now, and then
//!   takes one segment, and others as long as none ends later than the longest would. A segment is half a
//!   millisecond at most, so the writing ends 125 to 625 us ahead, and 700 us at a start from standstill.
//!   With a limit of jerk the next segment may have to wait for a plan that takes long: 225 to 725 us, and
//!   where many blocks wait, 425 to 725 us with segments of 0.3 ms at most; 800 us at a start.
//! - **By period**, every half millisecond, until more than `REFILL` is written: 1 to 1.5 ms ahead. The
//!   native runner works by period, as its time goes by half milliseconds, and so does a board while it
//!   searches for a switch or the probe: the start of the brake depends on the phase of the runs, so a
//!   search ends alike on both.

use units::Ticks;

use crate::knots::{SEGMENT_SECONDS, SHORT_SEGMENT_SECONDS};

/// Time between two runs by period, and at most between two on demand.
pub const PERIOD: Ticks = Ticks::from_micros(500);
/// Time written ahead at which a run by period stops taking segments.
const REFILL: Ticks = Ticks::from_micros(1_000);
/// A run on demand takes no segment that ends later than this from now, if it can wait for the next run: the
/// longest segment behind the lead.
const FARTHEST: Ticks = Ticks::from_micros(625);
/// Time by which a run may come too soon, its timer counting whole microseconds; the run takes its segment
/// all the same.
const SLACK: Ticks = Ticks::from_micros(5);
/// Time from a run by period to the start of motion from standstill.
pub(crate) const START_BY_PERIOD: Ticks = Ticks::from_micros(500);
/// Least time to the next run: a sooner one would be asked for while the present one has not ended.
const LEAST_WAIT: Ticks = Ticks::from_micros(5);

/// Time that is still written ahead when the feed runs on demand.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Lead {
    /// 125 us. Until the first steps of the next segment can be played it takes 60 us at worst: who runs
    /// before the feed or holds the lock of the motion object (20), the segment (10), its first
    /// [`crate::feed::BATCH`] of steps (20), those that are played meanwhile.
    #[default]
    Short,
    /// 225 us. The plan of a few jerk-limited blocks takes up to 130 us, under the same lock.
    OverShortPlans,
    /// 425 us. The plan of a whole queue of such blocks takes up to 350 us.
    OverLongPlans,
}

/// Number of waiting jerk-limited blocks up to which they are few. A plan visits each of them at most, for
/// 5.5 us; and no more than eight others come before the feed runs again and sees them.
const FEW_BLOCKS: usize = 16;

impl Lead {
    /// Time written ahead below which a run is urgent: something has kept the feed from running.
    pub(crate) const URGENT: Ticks = Ticks(Self::Short.ticks().0 / 2);

    const fn ticks(self) -> Ticks {
        Ticks::from_micros(match self {
            Self::Short => 125,
            Self::OverShortPlans => 225,
            Self::OverLongPlans => 425,
        })
    }

    /// Motion from standstill begins this long after the run that takes its first segment.
    const fn before_start(self) -> Ticks {
        Ticks::from_micros(match self {
            Self::Short => 200,
            Self::OverShortPlans => 300,
            Self::OverLongPlans => 500,
        })
    }

    /// Returns the lead for plans of this many jerk-limited blocks.
    pub(crate) const fn over_plans_of(blocks: usize) -> Self {
        if blocks <= FEW_BLOCKS { Self::OverShortPlans } else { Self::OverLongPlans }
    }

    /// Greatest length of a segment behind it, in seconds: a hold waits for both.
    pub(crate) const fn longest_segment_seconds(self) -> f64 {
        match self {
            Self::Short | Self::OverShortPlans => SEGMENT_SECONDS,
            Self::OverLongPlans => SHORT_SEGMENT_SECONDS,
        }
    }
}

/// Choice between the two schedules.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FeedSchedule {
    /// The feed runs every [`PERIOD`].
    #[default]
    ByPeriod,
    /// The feed runs when the steps in the queue come to their end.
    OnDemand,
}

/// A feed run's request to the motion object: moments between which a segment may lie.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Window {
    /// Present time of the run.
    pub now: Ticks,
    /// Motion that follows a standstill begins at this tick.
    pub start: Ticks,
    /// Latest end of a segment.
    pub latest: Ticks,
}

impl Window {
    /// Any segment, however late it ends.
    const fn open(now: Ticks, start: Ticks) -> Self {
        Self { now, start, latest: Ticks(u64::MAX) }
    }

    /// Returns the window without its latest end, for trajectory of which no segment is made yet.
    #[must_use]
    pub const fn unbounded(self) -> Self {
        Self::open(self.now, self.start)
    }

    /// Whether segments that end late are refused.
    #[must_use]
    pub const fn is_bounded(&self) -> bool {
        self.latest.0 != u64::MAX
    }
}

impl FeedSchedule {
    /// Returns the window in which a segment may be taken at a run that begins `now`, when everything up to
    /// `end` is written and the last segment lasted `last`. `None`: enough is written. If another segment as
    /// long would end too late, the motion object is not even asked: most segments are as long as the one
    /// before, and asking takes the lock.
    #[inline(always)]
    pub(crate) fn window(self, now: Ticks, end: Ticks, lead: Lead, last: Ticks) -> Option<Window> {
        match self {
            Self::ByPeriod => (end < now.plus(REFILL)).then_some(Window::open(now, now.plus(START_BY_PERIOD))),
            Self::OnDemand => {
                let window = Window::open(now, now.plus(lead.before_start()));
                if end < now.plus(lead.ticks()).plus(SLACK) {
                    return Some(window);
                }
                let latest = now.plus(FARTHEST);
                (end.plus(last) <= latest).then_some(Window { latest, ..window })
            }
        }
    }

    /// Returns the time from `now` before which no motion begins from standstill.
    pub(crate) const fn before_start(self, lead: Lead) -> Ticks {
        match self {
            Self::ByPeriod => START_BY_PERIOD,
            Self::OnDemand => lead.before_start(),
        }
    }

    /// Returns the time from `now` to the next run, when everything up to `end` is written and there is more
    /// to write.
    #[must_use]
    pub(crate) fn wait(self, now: Ticks, end: Ticks, lead: Lead) -> Ticks {
        match self {
            Self::ByPeriod => PERIOD,
            Self::OnDemand => end.since(now.plus(lead.ticks())).clamp(LEAST_WAIT, PERIOD),
        }
    }
}
