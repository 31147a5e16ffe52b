//! Profiles for the running block, from the cursor on: trapezoids, or what [`crate::jerk_limited`] chooses.

use super::{Motion, State};
use crate::{
    greatest,
    jerk_limited::{Ahead, Draft},
    least,
    profile::Profile,
    square_root,
};

impl Motion {
    /// Gives the running block the planned profile from the cursor on.
    pub(super) fn follow_plan(&mut self) {
        if self.is_jerk_limited() {
            return self.follow_jerk_limited();
        }
        let Some(run) = &mut self.run else { return };
        self.planner.plan();
        let (length, acceleration) = (run.remaining(), run.block.acceleration);
        if length <= 0.0 {
            return;
        }
        let (gain_sq, entry_sq) = (2.0 * acceleration * length, run.speed * run.speed);
        let highest_sq = least(self.planner.next_entry_sq(), entry_sq + gain_sq);
        let exit = square_root(greatest(highest_sq, greatest(entry_sq - gain_sq, 0.0)));
        let cruise = run.block.cruise(&self.overrides);
        let (cruise, exit) = if self.planner.keeps_cruise_ratio() {
            self.peak_sq = run.block.cruise_plan().peak_sq().unwrap_or(self.peak_sq);
            let cruise = least(cruise, square_root(self.peak_sq));
            // The exit is no faster than the cruise plan's peak, if the block can brake so far.
            (cruise, greatest(least(exit, cruise), square_root(greatest(entry_sq - gain_sq, 0.0))))
        } else {
            (cruise, exit)
        };
        run.follow(Profile::trapezoid(length, run.speed, cruise, exit, acceleration), self.clock);
    }

    /// Gives the running block a profile that brakes from the cursor on.
    pub(super) fn brake(&mut self) {
        if self.is_jerk_limited() {
            return self.follow_jerk_limited();
        }
        match &mut self.run {
            Some(run) if run.remaining() > 0.0 => {
                let profile = Profile::brake(run.remaining(), run.speed, run.block.acceleration);
                run.follow(profile, self.clock);
            }
            Some(_) => {}
            None => self.rest_here(),
        }
    }

    /// Ends a hold or a stop at rest.
    pub(super) fn rest_here(&mut self) {
        if self.state == State::Holding {
            self.state = State::Held;
            return;
        }
        if let Some(run) = self.run.take() {
            self.place = run.point();
        }
        self.planner.clear();
        self.curves.clear();
        self.timeline.clear(self.planner.pushed());
        self.planned = self.place;
        self.last = None;
        (self.laser.growth.moves, self.laser.at.fade) = (0, 0.0);
        self.resting = true;
        self.state = State::Running;
    }

    /// Whether the running block has a jerk.
    pub(super) fn is_jerk_limited(&self) -> bool {
        self.run.as_ref().is_some_and(|run| run.block.jerk > 0.0)
    }

    /// Whether the queue is as full as it can be just after a block was taken out: more may follow than the
    /// blocks that wait.
    fn was_full(&self) -> bool {
        let most = self.config.as_ref().map_or(0, |config| config.queue_size);
        self.planner.len() + usize::from(self.wants_two) + 1 >= most || self.curves.was_full()
    }

    /// Gives the running block the rest of the ramp under way and what follows it.
    fn follow_jerk_limited(&mut self) {
        self.planner.plan();
        self.planner.set_complete(!self.was_full());
        let Some(run) = &mut self.run else { return };
        let left = run.remaining();
        if left <= 0.0 {
            return;
        }
        let under_way = run.ramp();
        let stopping = self.state != State::Running;
        let (fresh, entry_sq) = self.planner.brake(&run.block, self.planner.front());
        let room = fresh.length - (run.block.length - left);
        // The new anchor must be safe for where what is under way can end.
        let (speed, ahead) = match under_way {
            None => (run.speed, 0.0),
            Some((ramp, elapsed)) => {
                let end = if ramp.rises() { ramp.soonest(elapsed) } else { ramp.to };
                (end, ramp.bounds.length(ramp.from, end) - ramp.distance(elapsed))
            }
        };
        if entry_sq >= run.block.entry_sq && fresh.is_safe(speed, room - ahead, &run.block.bounds()) {
            run.block.set_brake(fresh, entry_sq);
        }
        let ahead = Ahead {
            planner: &self.planner,
            block: &run.block,
            brake: run.block.brake(),
            overrides: self.overrides,
            cruise: run.block.cruise(&self.overrides),
            left,
        };
        let mut draft = Draft::new(left, run.speed);
        if let Some((ramp, elapsed)) = under_way {
            let ramp = if stopping { ahead.redirect_to_rest(ramp, elapsed) } else { ahead.redirect(ramp, elapsed) };
            draft.ramp(ramp, elapsed);
        }
        if draft.left > 0.0 {
            if stopping { ahead.stop(&mut draft) } else { ahead.go(&mut draft) }
        }
        draft.finish(stopping);
        run.follow_ramps(&draft, self.clock);
    }
}
