//! The feed's side of the motion object: segments, orders and reports.

use units::{PerActuator, StepCount, StepPosition, Ticks};

use super::{Motion, State};
use crate::{
    feed_exchange::{FeedOrders, FeedReport, Supply},
    feed_schedule::Window,
    knots::Segment,
    run::Run,
    timeline::Passed,
    trigger::Trigger,
};

impl Motion {
    /// The next segment of trajectory, written to `segment`.
    ///
    /// Never inlined: once a slice, it would take registers from the feed's loop over the steps.
    #[inline(never)]
    pub(crate) fn take_segment(&mut self, window: &Window, segment: &mut Segment) -> Supply {
        if self.planner.pushed() != self.seen.0 {
            self.seen = (self.planner.pushed(), window.now);
        }
        if self.laser.growth.moves > 0 {
            self.end_growth_in_time(window.now);
        }
        if self.filters.bypassed != self.filters.bypass_wanted {
            self.obey_bypass();
        }
        if self.filters.engaged() {
            return self.filtered_segment(window, segment);
        }
        let Some(slice) = self.next_slice(window) else {
            if self.resting {
                self.laser.rest(self.clock);
            }
            let has_more = self.run.as_ref().is_some_and(Run::has_more);
            return if has_more { Supply::Enough } else { Supply::Nothing };
        };
        self.segment(&slice, window, segment);
        segment.has_power = self.has_power_before(segment);
        Supply::Segment
    }

    /// Takes the orders for the feed's next run.
    pub(crate) fn feed_orders(&mut self) -> FeedOrders {
        let lead = self.lead();
        FeedOrders { searching: self.filters.bypass_wanted, lead, ..core::mem::take(&mut self.orders) }
    }

    /// Takes the feed's report of a run.
    pub(crate) fn feed_reports(&mut self, now: Ticks, report: FeedReport, urgent: bool, squeezed: u32) -> Passed {
        self.report = report;
        self.counters.urgent = self.counters.urgent.saturating_add(u32::from(urgent));
        self.counters.squeezed = self.counters.squeezed.saturating_add(squeezed);
        let rests = self.is_idle();
        self.passed = self.timeline.pass(now, rests, self.planner.pushed());
        self.passed
    }

    /// Stops the motion, as an armed input has fired.
    pub(crate) fn triggered(&mut self, trigger: Trigger) {
        self.trigger = Some(trigger);
        self.stop();
    }

    /// Lets the motors stand at these steps after the queue was cut, and forgets everything else.
    pub(crate) fn resume_from_cut(&mut self, steps: PerActuator<StepCount>, now: Ticks) {
        self.abort();
        self.laser.off_at_once(now);
        let (position, set_back) = (self.position_of_steps(&steps), self.set_back);
        self.settle_at(position);
        // Whole steps, not their image through two roundings; and the feed knows them.
        self.knots = PerActuator(steps.0.map(|count| StepPosition::from_bits(i64::from(count) << 24)));
        self.set_back = set_back;
        self.orders.rebase = None;
        self.orders.cut = false;
        self.report.played = steps;
        self.state = State::Running;
    }
}
