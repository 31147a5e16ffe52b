//! Power of a laser along the trajectory.
//!
//! Without filters the motors are where the trajectory is, and each slice gives its changes of power. With
//! filters the motors follow later, each axis in its own way: a change waits until the filters' output comes
//! to its place, and what follows the speed follows that of the output.

use units::{Axis, PowerLaw, Ticks};

use super::{Motion, State};
use crate::{
    config::ConfigError,
    filters::Knot,
    greatest,
    knots::Segment,
    laser::{Kind, LaserConfig, Law, NextChange, Pending},
    least,
    moves::{Mode, Tag},
    planner::Block,
    run::Slice,
    square_root,
    trajectory::{TickTime, seconds_of, tick_time, whole_ticks},
};

/// Distance from its place, mm, at which a change counts as being there; and the greatest part of the speed
/// that may go the other way, for rounding.
const NEAR: f64 = 1e-6;
/// Halvings of half a millisecond: to half a nanosecond.
const HALVINGS: u32 = 20;
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
        self.laser.config = laser;
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
        self.laser.set_factor(least(greatest(f64::from(factor), 0.0), 10.0) as f32);
    }

    /// Returns the factor on the power of every move.
    #[must_use]
    pub fn power_override(&self) -> f32 {
        self.laser.factor()
    }

    /// Whether no more changes of level fit along the blocks that wait.
    pub(super) fn has_full_levels(&self) -> bool {
        let is_on = self.laser.config.is_some() && !self.planner.is_empty();
        is_on && self.laser.store.as_ref().is_some_and(|store| store.levels.is_full(self.planner.released()))
    }

    /// Takes up the power of the block just released.
    pub(super) fn begin_power(&mut self, block: &Block) {
        let count = self.planner.released().wrapping_sub(1);
        if self.laser.growth.block == count {
            self.laser.growth.moves = 0;
        }
        if self.laser.is_on() {
            self.laser.run_block(count, block.power.level, 0.0);
        }
    }

    /// Constant power fades from now on as the machine slows down for a hold or a stop, so that nothing gets
    /// more of it than before.
    pub(super) fn fade_power(&mut self) {
        let speed = self.run.as_ref().map_or(0.0, |run| run.speed);
        if self.laser.fade == 0.0 {
            self.laser.fade = speed as f32;
        }
        self.laser.faded = 0.0;
    }

    /// Ends the fading when the machine is as fast again as it was, or gets no faster.
    fn end_fading(&mut self, slice: &Slice) {
        let Some(run) = self.run.as_ref().filter(|_| self.laser.fade > 0.0 && self.state == State::Running) else {
            return;
        };
        let before = least(f64::from(self.laser.fade), run.block.cruise(&self.overrides));
        if slice.entry == slice.exit || slice.entry >= SAME_SPEED * before {
            // The motors are as fast some time later.
            self.laser.faded += slice.seconds;
            let delay = if self.filters.engaged() { seconds_of(self.filters.primary_delays().1) } else { 0.0 };
            if self.laser.faded >= delay {
                (self.laser.fade, self.laser.faded) = (0.0, 0.0);
            }
        }
    }

    /// Law at the cursor.
    fn law(&self) -> Law {
        let level = self.laser.level;
        let Some(run) = self.run.as_ref().filter(|run| run.block.mode == Mode::Feed && level > 0) else {
            return Law::OFF;
        };
        let [x, y, z, ..] = run.path.direction.0;
        let all_axes = x == 0.0 && y == 0.0 && z == 0.0 && run.path.curve.is_line();
        let (kind, reference) = match run.block.power.law {
            PowerLaw::BySpeed => (Kind::BySpeed, run.block.requested as f32),
            PowerLaw::Constant if self.laser.fade > 0.0 => (Kind::Fading, self.laser.fade),
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

    /// Turns the power along a slice that begins at `start` into changes.
    pub(super) fn power_of_slice(&mut self, slice: &Slice, start: TickTime) {
        self.end_fading(slice);
        let Some(end) = self.run.as_ref().map(|run| run.travelled) else { return };
        let mut from = 0.0;
        // Ends: each turn takes an entry of a table.
        loop {
            self.laser.law = self.law();
            let step = self.laser.next_step(end);
            let to = step.map_or(1.0, |(distance, _)| greatest(slice.share_at(distance, end), from));
            let speeds = [slice.speed_at(from, end), slice.speed_at(to, end)];
            self.laser.along(start + tick_time(from * slice.seconds), (to - from) * slice.seconds, speeds);
            let Some((_, later)) = step else { return };
            self.tell_later_tag(later, start + tick_time(to * slice.seconds));
            from = to;
        }
    }

    /// Sends the laws along a slice that begins at `begin` on their way through the filters.
    pub(super) fn send_power_of(&mut self, slice: &Slice, begin: TickTime) {
        if !self.laser.is_on() {
            return;
        }
        self.end_fading(slice);
        let Some(end) = self.run.as_ref().map(|run| run.travelled) else { return };
        let mut at = begin;
        // Ends: each turn takes an entry of a table.
        loop {
            let law = self.law();
            self.send_power(at, law);
            let Some((distance, later)) = self.laser.next_step(end) else { return };
            at = at.max(begin + tick_time(slice.share_at(distance, end) * slice.seconds));
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
    pub(super) fn power_of_knot(&mut self, knot: &Knot, segment: &Segment) {
        let mut from = 0.0;
        // Ends: each turn but the last takes a law that was sent.
        loop {
            let pending = self.laser.store.as_ref().and_then(|store| store.pending.get(0));
            let reached = pending.and_then(|pending| Some((self.share_where(&pending, knot, segment, from)?, pending)));
            let to = reached.map_or(1.0, |(share, _)| share);
            let all_axes = self.laser.law.all_axes;
            let speeds = [knot.speed_at(from, all_axes), knot.speed_at(to, all_axes)];
            self.laser.along(segment.start + tick_time(from * knot.seconds), (to - from) * knot.seconds, speeds);
            let (Some((_, pending)), Some(store)) = (reached, &mut self.laser.store) else { return };
            store.pending.drop_first();
            self.laser.law = pending.law;
            from = to;
        }
    }

    /// Returns the share of a segment, `from` at least, at which the output passes the place where the
    /// trajectory was at this time, or is nearest to it; `None` where it does not come there yet.
    fn share_where(&self, pending: &Pending, knot: &Knot, segment: &Segment, from: f64) -> Option<f64> {
        let start = segment.start.to_bits() as u64;
        let share = |delay: u64| {
            let ahead = pending.time.wrapping_add(delay).wrapping_sub(start) as i64;
            let seconds = seconds_of(ahead.unsigned_abs()) / knot.seconds;
            if ahead < 0 { -seconds } else { seconds }
        };
        let (least_delay, most_delay) = self.filters.primary_delays();
        let (earliest, latest) = (greatest(share(least_delay), from), greatest(share(most_delay), from));
        if earliest > 1.0 {
            return None;
        }
        // Fading begins before the output slows down.
        let begins_to_fade = pending.law.kind == Kind::Fading
            && self.laser.law.kind == Kind::Constant
            && pending.law.level == self.laser.law.level;
        if least_delay == most_delay || begins_to_fade {
            return Some(earliest);
        }
        let within = |share: f64| if share <= 1.0 { Some(share) } else { None };
        let Some((point, direction)) = self.filters.way_at(pending.time) else { return within(latest) };
        let passed = |share: f64| knot.has_passed(&point, &direction, share, pending.law == Law::OFF);
        if passed(earliest) {
            return Some(earliest);
        }
        let mut bounds = (earliest, least(latest, 1.0));
        if !passed(bounds.1) {
            return within(latest);
        }
        for _ in 0..HALVINGS {
            let middle = 0.5 * (bounds.0 + bounds.1);
            if passed(middle) { bounds.1 = middle } else { bounds.0 = middle }
        }
        Some(bounds.1)
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

impl Slice {
    /// Path distance from its beginning and speed, mm and mm for a whole slice, at a share of its time. `end`
    /// is the path distance at its end.
    fn along(&self, share: f64, end: f64) -> (f64, f64) {
        let (length, entry, exit) = (end - self.from, self.entry * self.seconds, self.exit * self.seconds);
        let (square, cube) = (3.0 * length - 2.0 * entry - exit, entry + exit - 2.0 * length);
        let way = share * (entry + share * (square + share * cube));
        (way, entry + share * (2.0 * square + share * 3.0 * cube))
    }

    /// Returns the share of its time at which it comes to this path distance.
    fn share_at(&self, distance: f64, end: f64) -> f64 {
        let (wanted, length) = (distance - self.from, end - self.from);
        if wanted <= 0.0 || length <= 0.0 {
            return 0.0;
        }
        let mut bounds = (0.0, 1.0);
        let mut share = least(wanted / length, 1.0);
        for _ in 0..8 {
            let (way, speed) = self.along(share, end);
            if way < wanted {
                bounds.0 = share
            } else {
                bounds.1 = share
            }
            let next = share + (wanted - way) / speed;
            // Newton's method where it stays within bounds.
            share = if next >= bounds.0 && next <= bounds.1 { next } else { 0.5 * (bounds.0 + bounds.1) };
        }
        share
    }

    /// Returns the path speed at a share of its time, mm/s.
    fn speed_at(&self, share: f64, end: f64) -> f64 {
        if share <= 0.0 {
            self.entry
        } else if share >= 1.0 {
            self.exit
        } else {
            greatest(self.along(share, end).1 / self.seconds, 0.0)
        }
    }
}

impl Knot {
    /// Returns the speed at a share of the segment's time, mm/s: of X, Y and Z, or of all axes.
    fn speed_at(&self, share: f64, all_axes: bool) -> f64 {
        let count = if all_axes { units::MAX_AXES } else { Axis::PRIMARY.len() };
        let mean = self.entry.0.iter().zip(&self.exit.0).map(|(entry, exit)| entry + share * (exit - entry));
        square_root(mean.take(count).map(|speed| speed * speed).sum())
    }

    /// Whether the output, at a share of the segment's time, moves this way and comes no nearer to the place.
    /// (It goes another way where a path comes back on itself, and it may round the place.) Where it rests it
    /// has passed the place if it is there and the path `ends` there, not if the path begins there.
    fn has_passed(&self, place: &[f64; 3], direction: &[f64; 3], share: f64, ends: bool) -> bool {
        let (mut nearing, mut along, mut speed_sq, mut left_sq) = (0.0, 0.0, 0.0, 0.0);
        for (axis, (place, direction)) in Axis::PRIMARY.into_iter().zip(place.iter().zip(direction)) {
            let (start, way) = (self.start[axis], self.point[axis] - self.start[axis]);
            let (entry, exit) = (self.entry[axis] * self.seconds, self.exit[axis] * self.seconds);
            let (square, cube) = (3.0 * way - 2.0 * entry - exit, entry + exit - 2.0 * way);
            let left = place - start - share * (entry + share * (square + share * cube));
            let speed = entry + share * (2.0 * square + share * 3.0 * cube);
            nearing += left * speed;
            along += direction * speed;
            speed_sq += speed * speed;
            left_sq += left * left;
        }
        let speed = square_root(speed_sq);
        if speed == 0.0 {
            return ends && left_sq <= NEAR * NEAR;
        }
        nearing <= NEAR * speed && along >= -NEAR * speed
    }
}
