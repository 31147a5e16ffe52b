//! Steps that came late are told, and end the job where a step might have been lost: never silent.
//!
//! A step somewhat late does no harm by itself. When steps had to be delayed to keep a driver's least distance, or the feed came so late that
//! the motion stood still in the middle of its way, a motor may not have followed: the machine halts, braking along the path. All steps were
//! given in any case, so positions are kept.

use units::Micros;

use crate::controller::Controller;
use crate::ports::{Ports, StepTimes};

/// Late steps are told no more often than this.
const TELL_PERIOD: Micros = Micros::from_seconds(1);

/// What has been told.
#[derive(Clone, Copy, Debug, Default)]
pub struct PunctualityWatch {
    told: StepTimes,
    told_feed: u32,
    tell_due: Micros,
}

impl<P: Ports> Controller<P> {
    /// One poll of how well step times were kept.
    pub(crate) fn watch_step_times(&mut self, now: Micros) {
        let times = self.ports.step_times();
        let feed = self.ports.motion(|motion| motion.counters().late);
        let told = self.punctuality;
        let lost_time = times.delayed != told.told.delayed || feed != told.told_feed;
        if !lost_time && (times.late == told.told.late || now < told.tell_due) {
            return;
        }
        self.punctuality = PunctualityWatch { told: times, told_feed: feed, tell_due: now.plus(TELL_PERIOD) };
        let worst_us = times.worst.0 as f64 / f64::from(units::STEP_CLOCK_HZ / 1_000_000);
        if feed != told.told_feed {
            self.halt(format_args!(
                "ERROR: steps were not ready in time and the motion stood still for a moment. Positions are kept; check them, then M999\n"
            ));
        } else if times.delayed != told.told.delayed {
            self.halt(format_args!(
                "ERROR: steps came up to {worst_us:.1} us late and had to be delayed for their driver. Positions are kept; check them, then M999\n"
            ));
        } else {
            let count = times.late.wrapping_sub(told.told.late);
            self.announce(format_args!("WARNING: {count} steps came late, by up to {worst_us:.1} us\n"));
        }
    }

    /// `get steps`
    pub(crate) fn get_step_times(&mut self) {
        let times = self.ports.step_times();
        let worst_us = times.worst.0 as f64 / f64::from(units::STEP_CLOCK_HZ / 1_000_000);
        let counters = self.ports.motion(|motion| motion.counters());
        self.say(format_args!(
            "steps late: {} (worst {worst_us:.2} us), delayed: {}\n\
             feed late: {}, urgent: {}\n\
             steps moved for a driver: {}, blocks without look-ahead: {}, pieces joined: {}\n",
            times.late,
            times.delayed,
            counters.late,
            counters.urgent,
            counters.squeezed,
            counters.starved,
            counters.lumped
        ));
    }
}
