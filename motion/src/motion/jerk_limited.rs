//! Jerk-limited profiles for the running block: what [`crate::jerk_limited`] chooses, from the cursor on.

use super::{Motion, State};
use crate::jerk_limited::{Ahead, Draft};

impl Motion {
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
    pub(super) fn follow_jerk_limited(&mut self) {
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
