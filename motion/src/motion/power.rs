//! Power of a laser along the trajectory.
//!
//! Without filters the motors are where the trajectory is, and each slice gives its changes of power. With
//! filters the motors follow later, each axis in its own way: a change waits until the filters' output comes
//! to its place, and what follows the speed follows that of the output.

use units::{PowerLaw, Ticks};

use super::{Motion, State};
use crate::{
    config::ConfigError,
    filters::Knot,
    greatest,
    knots::Segment,
    laser::{Kind, LaserConfig, Law, NextChange, Output, Pending},
    least,
    moves::{Mode, Tag},
    planner::Block,
    run::Slice,
    square_root,
    trajectory::{TickTime, seconds_of, tick_time, whole_ticks},
};

/// Share of its former speed at which a machine that speeds up after a hold is as fast as before.
const SAME_SPEED: f64 = 0.999;

impl Motion {
    /// Gives the machine a laser, or none. Without a laser the power of moves means nothing.
    ///
    /// # Errors
    /// [`ConfigError::Laser`] for what no laser can be like, [`ConfigError::Busy`] while something moves or
    /// is queued; nothing was changed then.
    pub fn configure_laser(&mut self, laser: Option<LaserConfig>) -> Result<(), ConfigError> {
        if !self.is_idle() {
            return Err(ConfigError::Busy);
        }
        if laser.is_some_and(|laser| !laser.is_valid()) {
            return Err(ConfigError::Laser);
        }
        self.laser.clear();
        self.laser.at.config = laser;
        Ok(())
    }

    /// Gives the laser the memory without which no change of power reaches the step queue. A motion object
    /// that makes no steps needs none.
    #[cfg(not(any(test, feature = "oracle")))]
    pub fn give_power_store(&mut self, store: &'static mut crate::laser::PowerStore) {
        self.laser.store = Some(store);
    }

    /// Scales the power of every move from the present place on; 1 is as programmed. What comes to more than
    /// full power is full power. Factors outside 0 to 10 are brought to the nearer of these.
    pub fn set_power_override(&mut self, factor: f32) {
        self.laser.at.set_factor(least(greatest(f64::from(factor), 0.0), 10.0) as f32);
    }

    /// Returns the factor on the power of every move.
    #[must_use]
    pub fn power_override(&self) -> f32 {
        self.laser.at.factor()
    }

    /// Returns the power that the path has by now, a share of full power: the output follows within a
    /// millisecond and its delays, unless it is locked.
    #[must_use]
    pub fn power(&self) -> f32 {
        self.laser.at.power()
    }

    /// Whether no more changes of level fit along the blocks that wait.
    pub(super) fn has_full_levels(&self) -> bool {
        let is_on = self.laser.is_configured() && !self.planner.is_empty();
        is_on && self.laser.store.as_ref().is_some_and(|store| store.levels.is_full(self.planner.released()))
    }

    /// Takes up the power of the block just released.
    #[inline(always)]
    pub(super) fn begin_power(&mut self, block: &Block) {
        if self.laser.is_configured() {
            self.begin_level(block.power.level);
        }
    }

    #[inline(never)]
    fn begin_level(&mut self, level: u16) {
        let count = self.planner.released().wrapping_sub(1);
        if self.laser.growth.block == count {
            self.laser.growth.moves = 0;
        }
        self.laser.run_block(count, level, 0.0);
    }

    /// Constant power fades from now on as the machine slows down for a hold or a stop, so that nothing gets
    /// more of it than before.
    #[inline(never)]
    pub(super) fn fade_power(&mut self) {
        let speed = self.run.as_ref().map_or(0.0, |run| run.speed);
        if self.laser.at.fade == 0.0 {
            self.laser.at.fade = speed as f32;
        }
        self.laser.at.faded = 0.0;
    }

    /// Ends the fading when the machine is as fast again as it was, or gets no faster.
    fn end_fading(&mut self, slice: &Slice) {
        let Some(run) = self.run.as_ref().filter(|_| self.laser.at.fade > 0.0 && self.state == State::Running) else {
            return;
        };
        let before = least(f64::from(self.laser.at.fade), run.block.cruise(&self.overrides));
        if slice.entry == slice.exit || slice.entry >= SAME_SPEED * before {
            // The motors are as fast some time later.
            self.laser.at.faded += slice.seconds;
            let delay = if self.filters.engaged() { seconds_of(self.filters.primary_delays().1) } else { 0.0 };
            if self.laser.at.faded >= delay {
                (self.laser.at.fade, self.laser.at.faded) = (0.0, 0.0);
            }
        }
    }

    /// Law at the cursor.
    fn law(&self) -> Law {
        let level = self.laser.at.level;
        let Some(run) = self.run.as_ref().filter(|run| run.block.mode == Mode::Feed && level > 0) else {
            return Law::OFF;
        };
        let [x, y, z, ..] = run.path.direction.0;
        let all_axes = x == 0.0 && y == 0.0 && z == 0.0 && run.path.curve.is_line();
        let (kind, reference) = match run.block.power.law {
            PowerLaw::BySpeed => (Kind::BySpeed, run.block.requested as f32),
            PowerLaw::Constant if self.laser.at.fade > 0.0 => (Kind::Fading, self.laser.at.fade),
            PowerLaw::Constant => (Kind::Constant, 0.0),
            PowerLaw::Off => return Law::OFF,
        };
        Law { level, kind, all_axes, reference }
    }

    /// The program is at another move of the same block from then on.
    fn tell_later_tag(&mut self, later: u16, at: TickTime) {
        if let Some(run) = self.run.as_ref().filter(|_| later > 0) {
            let tag = Tag(run.block.tag.0.wrapping_add(u32::from(later)));
            self.timeline.begin(self.planner.released().wrapping_sub(1), tag, at);
        }
    }

    /// Turns the power along a slice that begins at `start` into changes, or with filters sends it on its way
    /// through them.
    #[inline(always)]
    pub(super) fn power_of_slice(&mut self, slice: &Slice, start: TickTime) {
        if self.laser.is_on() {
            self.power_from(slice, start);
        }
    }

    #[inline(never)]
    fn power_from(&mut self, slice: &Slice, start: TickTime) {
        self.end_fading(slice);
        let Some(end) = self.run.as_ref().map(|run| run.travelled) else { return };
        let Slice { from, entry, exit, seconds, .. } = *slice;
        let way = laser_power::Slice { from, end, entry, exit, seconds };
        let is_filtered = self.filters.engaged();
        let (mut from, mut at) = (0.0, start);
        // Ends: each turn takes an entry of a table.
        loop {
            let law = self.law();
            if is_filtered {
                self.laser.send(at.to_bits() as u64, law);
            }
            let step = self.laser.next_step(end);
            let to = step.map_or(1.0, |(distance, _)| greatest(way.share_at(distance), from));
            if !is_filtered {
                self.laser.at.law = law;
                let speeds = [from, to].map(|share| way.speed_at(share));
                self.laser.along(at, (to - from) * seconds, speeds);
            }
            let Some((_, later)) = step else { return };
            (from, at) = (to, start + tick_time(to * seconds));
            self.tell_later_tag(later, at);
        }
    }

    /// The law holds from this time of the trajectory on, and reaches the laser behind the filters.
    pub(super) fn send_power(&mut self, at: TickTime, law: Law) {
        if self.laser.is_on() {
            self.laser.send(at.to_bits() as u64, law);
        }
    }

    /// Turns the power along a segment of the filters' output into changes.
    #[inline(never)]
    pub(super) fn power_of_knot(&mut self, knot: &Knot, segment: &Segment) {
        let Knot { start, point, entry, exit, seconds, .. } = knot;
        let output = Output { start, point, entry, exit, seconds: *seconds };
        let mut from = 0.0;
        // Ends: each turn but the last takes a law that was sent.
        loop {
            let pending = self.laser.store.as_ref().and_then(|store| store.pending.get(0));
            let reached =
                pending.and_then(|pending| Some((self.share_where(&pending, &output, segment, from)?, pending)));
            let to = reached.map_or(1.0, |(share, _)| share);
            let all_axes = self.laser.at.law.all_axes;
            let speeds = [from, to].map(|share| square_root(output.speed_sq_at(share, all_axes)));
            self.laser.along(segment.start + tick_time(from * knot.seconds), (to - from) * knot.seconds, speeds);
            let (Some((_, pending)), Some(store)) = (reached, &mut self.laser.store) else { return };
            store.pending.drop_first();
            self.laser.at.law = pending.law;
            from = to;
        }
    }

    /// Returns the share of a segment, `from` at least, at which the output passes the place where the
    /// trajectory was at this time, or is nearest to it; `None` where it does not come there yet.
    fn share_where(&self, pending: &Pending, output: &Output<'_>, segment: &Segment, from: f64) -> Option<f64> {
        let (least_delay, most_delay) = self.filters.primary_delays();
        let start = segment.start.to_bits() as u64;
        let reach = output.reach(pending.time, start, from, [least_delay, most_delay]);
        let [earliest, latest] = reach;
        if earliest > 1.0 {
            return None;
        }
        // Fading begins before the output slows down.
        let begins_to_fade = pending.law.kind == Kind::Fading
            && self.laser.at.law.kind == Kind::Constant
            && pending.law.level == self.laser.at.law.level;
        if least_delay == most_delay || begins_to_fade {
            return Some(earliest);
        }
        match self.filters.way_at(pending.time) {
            Some(way) => output.share_past(&way, reach, pending.law == Law::OFF),
            None if latest <= 1.0 => Some(latest),
            None => None,
        }
    }

    /// The output of the filters rests: so does the laser.
    pub(super) fn rest_power(&mut self) {
        if let Some(store) = &mut self.laser.store {
            store.pending.clear();
        }
        self.laser.rest(self.filters.out);
    }

    /// Whether the power changes before the end of this segment.
    pub(super) fn has_power_before(&self, segment: &Segment) -> bool {
        let end = whole_ticks(segment.start + segment.duration);
        self.laser.is_on() && self.laser.store.as_ref().is_some_and(|store| store.changes.has_before(end))
    }

    /// Takes the next change of power for the feed, if it is due before `until`.
    pub(crate) fn take_power(&mut self, until: Ticks) -> NextChange {
        self.laser.store.as_mut().map_or(NextChange::None, |store| store.changes.take(until))
    }
}
