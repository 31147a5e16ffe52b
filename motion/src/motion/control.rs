//! Orders that change the plan under way: hold, resume, stop, abort, overrides. Each is a new plan from the
//! cursor.

use super::{Motion, State, taking_back::Pace};
use crate::{greatest, least, planner::Overrides};

impl Motion {
    /// Brakes along the path from the present state; keeps the rest for [`Self::resume`].
    pub fn hold(&mut self) {
        self.resume_wanted = false;
        if self.state == State::Running {
            self.take_back(Pace::Slower);
            self.state = State::Holding;
            self.fade_power();
            self.brake();
        }
    }

    /// Goes on after a hold, or in the middle of one.
    pub fn resume(&mut self) {
        if !matches!(self.state, State::Holding | State::Held) {
            return;
        }
        // Until the trajectory taken back is replaced, the motion must stay as slow as was promised to the
        // axes that have used it.
        self.resume_wanted = self.is_behind();
        if !self.resume_wanted {
            self.state = State::Running;
            self.follow_plan();
        }
    }

    /// Brakes along the path from the present state and drops the rest. Idle when done.
    pub fn stop(&mut self) {
        self.resume_wanted = false;
        match self.state {
            State::Running | State::Holding => {
                if self.state == State::Running {
                    self.take_back(Pace::Slower);
                }
                self.state = State::Stopping;
                self.fade_power();
                self.brake();
            }
            State::Held => {
                self.state = State::Stopping;
                self.rest_here();
            }
            State::Stopping | State::Aborting => {}
        }
    }

    /// Drops everything without deceleration. The feed cuts the step queue at its next run and reports where
    /// the motors stand; that becomes the position. (A fault need not wait for the feed:
    /// [`crate::queue::StepQueue::cut`].)
    pub fn abort(&mut self) {
        self.state = State::Aborting;
        self.orders.cut = true;
        self.planner.clear();
        self.curves.clear();
        self.timeline.clear(self.planner.pushed());
        self.laser.clear();
        self.run = None;
        self.resting = true;
        self.resume_wanted = false;
    }

    /// Scales the speed of working moves and of rapids; 1 is as programmed. Takes effect from the present
    /// state on. Factors outside 0.01 to 10 are brought to the nearer of these.
    pub fn set_overrides(&mut self, feed: f64, rapid: f64) {
        let bounded = |factor: f64| least(greatest(factor, 0.01), 10.0);
        let overrides = Overrides { feed: bounded(feed), rapid: bounded(rapid) };
        let changes = overrides != self.overrides;
        self.overrides = overrides;
        if changes && self.state == State::Running {
            self.take_back(Pace::Any);
        }
        let cruise_before = match (&self.run, self.planner.front()) {
            (Some(run), _) => run.block.cruise(&self.overrides),
            (None, Some(front)) => front.cruise(&self.overrides),
            (None, None) => return,
        };
        self.planner.replan(cruise_before, &self.overrides);
        if self.state == State::Running {
            self.follow_plan();
        }
    }
}
