//! The jerk-limited way through one block: ramps ([`crate::ramp`]) and cruises, chosen from a state without
//! acceleration.
//!
//! Every change of speed is a ramp that begins and ends without acceleration, and may run through any number
//! of blocks. With no ramp under way, the next one is chosen: up, as far as the look-ahead allows
//! ([`Ahead::climb`]); or none for now, and down to the anchor's speed ([`crate::planner::Brake`]) just in
//! time. A ramp under way may still get another end while its acceleration has not begun to fall
//! ([`Ahead::redirect`]): the ramp then goes on up as newly known blocks allow, or need not go all the way
//! down.

use crate::{
    least,
    planner::{Block, Brake, Overrides, Planner, ROUNDING, SAME},
    profile::{MAX_PHASES, Phase, Profile, cruise},
    ramp::{Bounds, Ramp},
};

/// Ramps in one profile.
const MAX_RAMPS: usize = 2;
/// Ends of ramps this near to the end of the block are at it, mm.
const SNAP: f64 = 2.0 * ROUNDING;
/// Least gain of a ramp up, as a share of the cruise speed.
const WORTHWHILE: f64 = 0.001;
/// Halvings that find the peak of a ramp up and a ramp down that share a length.
const HALVINGS: u32 = 40;

/// A ramp in a profile.
#[derive(Clone, Copy, Debug)]
struct Placed {
    from: f64,
    to: f64,
    bounds: Bounds,
    /// Seconds that the ramp had run when the profile began.
    elapsed: f64,
    /// First phase of the ramp in the profile; `NOWHERE`: no ramp.
    phase: u8,
}

const NOWHERE: u8 = u8::MAX;

impl Default for Placed {
    fn default() -> Self {
        Self { from: 0.0, to: 0.0, bounds: Bounds::default(), elapsed: 0.0, phase: NOWHERE }
    }
}

impl Placed {
    fn new(ramp: &Ramp, elapsed: f64, phase: usize) -> Self {
        Self { from: ramp.from, to: ramp.to, bounds: ramp.bounds, elapsed, phase: phase as u8 }
    }
}

/// The ramps of a profile, in order.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Ramps([Placed; MAX_RAMPS]);

impl Ramps {
    /// The ramp under way before there is a profile.
    pub fn carried(ramp: Option<(Ramp, f64)>) -> Self {
        let mut ramps = Self::default();
        if let (Some((ramp, elapsed)), Some(first)) = (ramp, ramps.0.first_mut()) {
            *first = Placed::new(&ramp, elapsed, 0);
        }
        ramps
    }

    /// The ramp that is not over `local` seconds into this phase.
    pub fn at(&self, profile: &Profile, phase: usize, local: f64) -> Option<(Ramp, f64)> {
        let placed = self.0.iter().rfind(|placed| usize::from(placed.phase) <= phase)?;
        let before =
            profile.phases.get(usize::from(placed.phase)..phase)?.iter().map(|phase| phase.duration).sum::<f64>();
        let elapsed = placed.elapsed + before + local;
        // `Run` leaves out phases of a nanosecond.
        let ramp = Ramp::new(placed.from, placed.to, placed.bounds);
        if elapsed < ramp.duration() - 1e-9 { Some((ramp, elapsed)) } else { None }
    }
}

/// A profile in the making.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Draft {
    pub profile: Profile,
    pub ramps: Ramps,
    phases: usize,
    placed: usize,
    /// Path still to go in the block, mm.
    pub left: f64,
    /// Speed at the end so far, mm/s.
    pub speed: f64,
}

impl Draft {
    /// Creates an empty draft for what is left of a block, mm, from this speed on, mm/s.
    pub fn new(left: f64, speed: f64) -> Self {
        Self { profile: Profile::default(), ramps: Ramps::default(), phases: 0, placed: 0, left, speed }
    }

    fn is_full(&self) -> bool {
        self.placed == MAX_RAMPS || self.phases + 3 > MAX_PHASES
    }

    fn push(&mut self, phase: Phase) {
        if let Some(slot) = self.profile.phases.get_mut(self.phases) {
            *slot = phase;
            self.phases += 1;
        }
    }

    fn shorten(&mut self, by: f64) {
        self.left -= by;
        if self.left < SNAP {
            self.left = 0.0;
        }
    }

    /// Appends a ramp that has run for `elapsed` seconds, up to the end of the block.
    pub fn ramp(&mut self, ramp: Ramp, elapsed: f64) {
        // Without room for another ramp the profile ends, and the next one begins with this ramp.
        if self.is_full() {
            return;
        }
        let Some(slot) = self.ramps.0.get_mut(self.placed) else { return };
        *slot = Placed::new(&ramp, elapsed, self.phases);
        self.placed += 1;
        let done = ramp.distance(elapsed);
        let rest = ramp.length() - done;
        let whole = rest <= self.left + SNAP;
        let until = if whole { ramp.duration() } else { ramp.time_at(done + self.left) };
        ramp.phases(elapsed, until, |phase| self.push(phase));
        if whole {
            self.shorten(rest);
            self.speed = ramp.to;
        } else {
            self.left = 0.0;
            self.speed = ramp.speed(until);
        }
    }

    /// Goes on at constant speed.
    fn cruise(&mut self, length: f64) {
        let length = least(length, self.left);
        if length > 0.0 && self.speed > 0.0 {
            self.push(cruise(self.speed, length));
            self.shorten(length);
        }
    }

    /// Returns the finished profile, never empty: whatever went wrong, the block comes to its end.
    pub fn finish(&mut self, stopping: bool) {
        if self.phases == 0 && !stopping {
            self.speed = crate::greatest(self.speed, 0.01);
            self.cruise(self.left);
        }
        debug_assert!(self.phases <= MAX_PHASES);
        self.profile.exit = self.speed;
    }
}

/// Limits and path ahead of a point in the running block.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ahead<'a> {
    pub planner: &'a Planner,
    pub block: &'a Block,
    /// Anchor of the block.
    pub brake: Brake,
    pub overrides: Overrides,
    /// Greatest speed in the block under these overrides.
    pub cruise: f64,
    /// Path to the end of the block.
    pub left: f64,
}

impl Ahead<'_> {
    /// Path to the anchor.
    fn room(&self) -> f64 {
        self.brake.length - (self.block.length - self.left)
    }

    fn bounds(&self) -> Bounds {
        self.block.bounds()
    }

    /// The view from farther on in the same block.
    fn after(&self, draft: &Draft) -> Self {
        Self { left: draft.left, ..*self }
    }

    /// Completes a draft: on along the path.
    pub fn go(&self, draft: &mut Draft) {
        let here = self.after(draft);
        let speed = draft.speed;
        if speed > here.cruise * SAME || !here.brake.is_safe(speed, here.room(), &here.bounds()) {
            // An override or a hold left it faster than planned.
            match here.slow_down(speed) {
                Some(down) => draft.ramp(down, 0.0),
                None => draft.cruise(draft.left),
            }
            return;
        }
        let least = WORTHWHILE * here.cruise;
        if let Some(peak) = here.climb(speed, 0.0, speed)
            && (peak > speed + least || speed < least)
        {
            draft.ramp(Ramp::new(speed, peak, here.bounds()), 0.0);
        }
        let here = self.after(draft);
        if draft.left <= 0.0 || draft.is_full() {
            return;
        }
        let (speed, target) = (draft.speed, here.brake.speed);
        if speed <= target * SAME + ROUNDING {
            draft.cruise(here.left);
            return;
        }
        draft.cruise(here.room() - here.brake.braking(speed, &here.bounds()));
        if draft.left > 0.0 {
            let full = draft.is_full();
            draft.ramp(Ramp::new(speed, target, here.bounds()), 0.0);
            if !full {
                draft.cruise(draft.left);
            }
        }
    }

    /// Returns the ramp down from a speed that is too high: to the cruise speed, to the anchor's, or to rest,
    /// whichever comes in time.
    fn slow_down(&self, speed: f64) -> Option<Ramp> {
        let (bounds, brake, room) = (self.bounds(), &self.brake, self.room());
        let to_cruise = bounds.length(speed, self.cruise);
        if speed > self.cruise * SAME && to_cruise <= self.left && brake.is_safe(self.cruise, room - to_cruise, &bounds)
        {
            return Some(Ramp::new(speed, self.cruise, bounds));
        }
        if speed > brake.speed * SAME && brake.is_safe(speed, room, &bounds) {
            return Some(Ramp::new(speed, brake.speed, bounds));
        }
        self.halt(speed)
    }

    /// Completes a draft: as soon as possible to rest.
    pub fn stop(&self, draft: &mut Draft) {
        while draft.left > 0.0 && draft.speed > 0.0 && !draft.is_full() {
            match self.after(draft).halt(draft.speed) {
                Some(ramp) => draft.ramp(ramp, 0.0),
                None => draft.cruise(draft.left),
            }
        }
    }

    /// The ramp to rest, if it is safe all along. Else as far down as the plan goes: to the anchor's speed,
    /// or by what the rest of the block allows, or not before the next block.
    fn halt(&self, speed: f64) -> Option<Ramp> {
        if speed <= 0.0 {
            return None;
        }
        let own = self.bounds();
        if let Some(bounds) = self.rest_bounds(speed, 0.0, own) {
            return Some(Ramp::new(speed, 0.0, bounds));
        }
        if speed > self.brake.speed * (1.0 + 1e-6) && self.brake.is_safe(speed, self.room(), &own) {
            return Some(Ramp::new(speed, self.brake.speed, own));
        }
        if !self.brake.is_safe(speed, self.room(), &own) {
            // An override lowered the plan below what can be had. The path's own limits are safe.
            let hard = Ahead { brake: self.planner.hard_brake(self.block, speed), ..*self };
            if speed > hard.brake.speed * SAME && hard.brake.is_safe(speed, hard.room(), &own) {
                return Some(Ramp::new(speed, hard.brake.speed, own));
            }
        }
        // The ramp ends as high as the rest of the block allows.
        let fits = |to: f64| own.length(speed, to) <= self.left;
        let (mut low, mut high) = (0.0, speed);
        for _ in 0..HALVINGS / 2 {
            let middle = 0.5 * (low + high);
            if fits(middle) {
                high = middle;
            } else {
                low = middle;
            }
        }
        if high < speed { Some(Ramp::new(speed, high, own)) } else { None }
    }

    /// The limits under which a ramp that began with `from`, `done` millimetres ago, may go down to rest:
    /// those of all blocks it runs through. `None` if the path is too short or the ramp too fast for a
    /// junction.
    fn rest_bounds(&self, from: f64, done: f64, own: Bounds) -> Option<Bounds> {
        let mut bounds = own;
        let mut end = done + self.left;
        let mut passed = 0;
        while bounds.length(from, 0.0) > end + ROUNDING {
            let next = self.planner.ahead(passed)?;
            bounds = bounds.and(&next.bounds());
            end += next.length;
            passed += 1;
        }
        let rest = Ramp::new(from, 0.0, bounds);
        if self.passes(&rest, done, passed) { Some(bounds) } else { None }
    }

    /// Whether a ramp down that began `done` millimetres ago is slow enough for each of the next junctions.
    fn passes(&self, ramp: &Ramp, done: f64, junctions: usize) -> bool {
        let mut at = done + self.left;
        for next in (0..junctions).map_while(|index| self.planner.ahead(index)) {
            let limit = next.bound();
            if ramp.from > limit && ramp.bounds.launch(ramp.to, limit) < ramp.length() - at {
                return false;
            }
            at += next.length;
        }
        true
    }

    /// The greatest end of a ramp up that began with `from`, `done` millimetres ago, and can not end below
    /// `lowest`.
    ///
    /// Block by block ahead, until the ramp has certainly ended or may go no farther: the steepest ramp would
    /// pass the next junction too fast. Every junction passed is safe then, wherever the ramp ends. The end
    /// must be safe by the anchor of the last block: the greatest is found by halving.
    fn climb(&self, from: f64, done: f64, lowest: f64) -> Option<f64> {
        let bounds = self.bounds();
        let mut highest = self.cruise;
        let mut end = done + self.left;
        let mut index = 0;
        let (mut brake, mut room) = (self.brake, done + self.room());
        while bounds.length(from, highest) > end {
            let Some(next) = self.planner.ahead(index) else { break };
            let limit = next.limit();
            let free =
                next.is_tangent && next.ramps_like(self.block) && limit > from && bounds.launch(from, limit) >= end;
            // An anchor that holds the speed below the junction's own limit is no place to pass.
            if !free || (room <= end + ROUNDING && brake.speed < limit) {
                break;
            }
            brake = next.brake();
            room = end + brake.length;
            end += next.length;
            highest = next.cruise(&self.overrides);
            index += 1;
        }
        let highest = least(highest, brake.top);
        let fits = |peak: f64| {
            let up = bounds.length(from, peak);
            up <= end + ROUNDING && up + brake.braking(peak, &bounds) <= room + ROUNDING
        };
        if highest <= lowest || !fits(lowest) {
            return None;
        }
        if fits(highest) {
            return Some(highest);
        }
        let (mut low, mut high) = (lowest, highest);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            if fits(middle) {
                low = middle;
            } else {
                high = middle;
            }
        }
        Some(low)
    }

    /// The ramp under way, with the end that is best by what is known now.
    pub fn redirect(&self, ramp: Ramp, elapsed: f64) -> Ramp {
        if ramp.is_closing(elapsed) || ramp.bounds != self.bounds() {
            return ramp;
        }
        let soonest = ramp.soonest(elapsed);
        let done = ramp.distance(elapsed);
        if ramp.rises() {
            let peak = self.climb(ramp.from, done, soonest).unwrap_or(soonest);
            return Ramp::new(ramp.from, peak, ramp.bounds);
        }
        if soonest > ramp.to && self.may_level(&ramp, soonest, done, ramp.speed(elapsed)) {
            return Ramp::new(ramp.from, soonest, ramp.bounds);
        }
        let (speed, room) = (self.brake.speed, done + self.room());
        if speed > ramp.to && speed < soonest && ramp.bounds.length(ramp.from, speed) <= room {
            return Ramp::new(ramp.from, speed, ramp.bounds);
        }
        ramp
    }

    /// The ramp under way, going to rest if it can.
    pub fn redirect_to_rest(&self, ramp: Ramp, elapsed: f64) -> Ramp {
        if ramp.is_closing(elapsed) || ramp.bounds != self.bounds() {
            return ramp;
        }
        if ramp.rises() {
            return Ramp::new(ramp.from, ramp.soonest(elapsed), ramp.bounds);
        }
        match self.rest_bounds(ramp.from, ramp.distance(elapsed), ramp.bounds) {
            Some(bounds) if bounds == ramp.bounds => Ramp::new(ramp.from, 0.0, bounds),
            _ => ramp,
        }
    }

    /// Whether a ramp down, now at `speed`, may end at `soonest`: safe at its end, and nothing slower comes
    /// before.
    fn may_level(&self, ramp: &Ramp, soonest: f64, done: f64, speed: f64) -> bool {
        let bounds = ramp.bounds;
        let ahead = bounds.length(ramp.from, soonest) - done;
        if ahead <= self.left {
            return soonest <= self.cruise && self.brake.is_safe(soonest, self.room() - ahead, &bounds);
        }
        let mut begin = self.left;
        let mut index = 0;
        while let Some(next) = self.planner.ahead(index) {
            // Slowing down for an override, it is above what is asked for in any case.
            let limit = if speed > self.cruise { next.bound() } else { next.limit() };
            if !next.is_tangent || !next.ramps_like(self.block) || limit < speed {
                return false;
            }
            if ahead <= begin + next.length {
                let brake = next.brake();
                let room = brake.length - (ahead - begin);
                return soonest <= next.cruise(&self.overrides) && brake.is_safe(soonest, room, &bounds);
            }
            begin += next.length;
            index += 1;
        }
        false
    }
}
