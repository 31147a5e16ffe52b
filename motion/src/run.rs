//! The block in execution: where it is, how fast, and its next slice of trajectory.

use units::{MmPerSecond, PerActuator, PerAxis};

use crate::{
    convert::ceil_i32,
    greatest,
    jerk_limited::{Draft, Ramps},
    knots::SEGMENT_SECONDS,
    least,
    moves::{Mode, Tag},
    path::{Curve, Path},
    planner::Block,
    profile::{Phase, Profile},
    ramp::Ramp,
    trajectory::{Piece, TickTime, tick_time},
};

/// A block that has begun. The cursor stands at the end of the last slice taken.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Run {
    pub block: Block,
    /// Path of the block in machine space.
    pub path: Path,
    /// Movement of each motor for a millimetre of path at the cursor, once it is known.
    pub rates: Option<PerActuator<f64>>,
    profile: Profile,
    /// The ramps that the profile is made of, when it is limited in jerk.
    ramps: Ramps,
    /// Seconds from the beginning of the present phase to the cursor.
    local: f64,
    /// Phase the cursor is in.
    phase: usize,
    /// The rest of it is cut evenly from here on, in seconds from its beginning, into slices no longer than
    /// this; and how many of those are taken.
    cut_from: f64,
    longest: f64,
    taken: u32,
    /// Time at which that phase begins.
    phase_start: TickTime,
    /// Path distance from the beginning of the block at which that phase begins, mm.
    phase_base: f64,
    /// Path distance from the beginning of the block at the cursor, mm.
    pub travelled: f64,
    /// Path speed at the cursor, mm/s.
    pub speed: f64,
}

/// A bit of trajectory between two knots.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Slice {
    /// Time at its end.
    pub end: TickTime,
    /// Duration, seconds.
    pub seconds: f64,
    /// Path speed at the beginning, mm/s.
    pub entry: f64,
    /// Path speed at the end, mm/s.
    pub exit: f64,
    /// Machine position at the end.
    pub point: PerAxis<f64>,
    /// Path distance from the beginning of the block to the beginning of the slice, mm.
    pub from: f64,
    /// The first of a new piece.
    pub fresh: bool,
}

/// A block that was passed.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Passage {
    /// Purpose of the move, as its submitter numbered it.
    pub tag: Tag,
    /// Kind of move: rapid or feed.
    pub mode: Mode,
    /// Length of its path, mm.
    pub length: f64,
    /// Speed that the program asks for.
    pub requested: MmPerSecond,
    /// Speed limit by axes and motors.
    pub limit: MmPerSecond,
    /// Seconds at even speed.
    pub even_seconds: f64,
    /// Seconds in which the speed changes.
    pub ramp_seconds: f64,
    /// The greatest speed in it, mm/s.
    pub peak: f64,
}

impl Passage {
    /// Returns the duration of the block, seconds.
    #[must_use]
    pub fn seconds(&self) -> f64 {
        self.even_seconds + self.ramp_seconds
    }
}

/// Phases shorter than this (a fifth of a tick) are left out; the next knot makes up for their length.
const NEGLIGIBLE_SECONDS: f64 = 1e-9;

/// A nanometre, in mm: far above rounding, far below a step.
const NEAR: f64 = 1e-6;

/// Greatest share of the clearance that one slice may cover. With 1/16 the error of the cubic is below a
/// hundredth of a microsecond of time for every kinematics: see "Knots" in `docs/motion.md`.
const CLEARANCE_SHARE: f64 = 1.0 / 16.0;
/// Shortest slice, seconds: a bound for the work, not for the accuracy.
const SHORTEST_SLICE_SECONDS: f64 = 0.000_025;

/// Greatest distance of knots in a phase of this block, where `longest` is the greatest anywhere.
fn slice_seconds(phase: &Phase, block: &Block, longest: f64) -> f64 {
    // Within a phase the acceleration keeps its sign: the speed is greatest at an end.
    let end = phase.speed_at(phase.duration);
    let free = CLEARANCE_SHARE * block.clearance / greatest(phase.speed, end);
    least(longest, greatest(free, SHORTEST_SLICE_SECONDS))
}

impl Run {
    /// Begins a block at `origin` and time `start`, moving with `speed`, in the ramp that goes on from the
    /// block before.
    pub fn new(
        block: Block,
        curve: Curve,
        origin: PerAxis<f64>,
        start: TickTime,
        speed: f64,
        carried: Option<(Ramp, f64)>,
    ) -> Self {
        let path = Path::new(origin, &block.target, block.length, curve);
        Self::within(block, path, 0.0, start, speed, carried)
    }

    /// Begins within a block, `travelled` millimetres along its path.
    pub fn within(
        block: Block,
        path: Path,
        travelled: f64,
        start: TickTime,
        speed: f64,
        carried: Option<(Ramp, f64)>,
    ) -> Self {
        Self {
            block,
            path,
            rates: None,
            profile: Profile::default(),
            ramps: Ramps::carried(carried),
            local: 0.0,
            phase: 0,
            cut_from: 0.0,
            longest: SEGMENT_SECONDS,
            taken: 0,
            phase_start: start,
            phase_base: travelled,
            travelled,
            speed,
        }
    }

    /// Moves what is left of the trajectory in time.
    pub fn shift(&mut self, by: TickTime) {
        self.phase_start += by;
    }

    /// Path left after the cursor, mm.
    pub fn remaining(&self) -> f64 {
        self.block.length - self.travelled
    }

    /// Whether the cursor is at the block's end, or so near that the rest is no phase of its own.
    pub fn is_over(&self) -> bool {
        let near = if self.block.jerk > 0.0 { greatest(NEAR, 2.0 * NEGLIGIBLE_SECONDS * self.speed) } else { 0.0 };
        self.remaining() <= near
    }

    /// Gives the rest of the block, from the cursor at `now` on, this profile.
    pub fn follow(&mut self, profile: Profile, now: TickTime) {
        self.profile = profile;
        self.ramps = Ramps::default();
        self.begin_profile(now);
    }

    /// Gives the rest of the block a draft of ramps, as [`Self::follow`] does a profile.
    pub fn follow_ramps(&mut self, draft: &Draft, now: TickTime) {
        (self.profile, self.ramps) = (draft.profile, draft.ramps);
        self.begin_profile(now);
    }

    fn begin_profile(&mut self, now: TickTime) {
        self.phase = 0;
        self.begin_phase();
        self.phase_start = now;
        self.phase_base = self.travelled;
    }

    fn begin_phase(&mut self) {
        (self.local, self.cut_from, self.taken) = (0.0, 0.0, 0);
    }

    /// The ramp that the cursor is in, and how many seconds it has run. `None` where there is no
    /// acceleration.
    pub fn ramp(&self) -> Option<(Ramp, f64)> {
        self.ramps.at(&self.profile, self.phase, self.local)
    }

    /// Machine position at the cursor.
    pub fn point(&self) -> PerAxis<f64> {
        if self.remaining() > 0.0 { self.path.point(self.travelled) } else { self.block.target }
    }

    /// The phase the cursor is in; phases too short to matter are passed over.
    fn current(&mut self) -> Option<Phase> {
        while let Some(phase) = self.profile.phases.get(self.phase) {
            if phase.duration > NEGLIGIBLE_SECONDS {
                return Some(*phase);
            }
            self.phase_base += phase.length;
            self.phase += 1;
        }
        None
    }

    /// The piece of trajectory that begins at the cursor, if one does.
    pub fn new_piece(&mut self) -> Option<Piece> {
        let phase = self.current()?;
        if self.local > 0.0 {
            return None;
        }
        Some(Piece {
            start: self.phase_start,
            duration: phase.duration,
            path: self.path,
            base: self.phase_base,
            speed: phase.speed,
            acceleration: phase.acceleration,
            jerk: phase.jerk,
        })
    }

    /// Whether more of the profile is left.
    pub fn has_more(&self) -> bool {
        self.profile.phases.iter().skip(self.phase).any(|phase| phase.duration > NEGLIGIBLE_SECONDS)
    }

    /// Moves the cursor one slice on, `longest` seconds at most. `None` at the end of the profile, and when
    /// the slice would end later than `latest`: then the cursor stays where it is.
    pub fn advance(&mut self, latest: TickTime, longest: f64) -> Option<Slice> {
        let phase = self.current()?;
        if longest != self.longest {
            self.longest = longest;
            (self.cut_from, self.taken) = (self.local, 0);
        }
        let rest = phase.duration - self.cut_from;
        let slices = f64::from(ceil_i32(rest / slice_seconds(&phase, &self.block, longest)));
        let seconds = rest / slices;
        let taken = self.taken + 1;
        let last = f64::from(taken) >= slices;
        let local = if last { phase.duration } else { self.cut_from + f64::from(taken) * seconds };
        let end = self.phase_start + tick_time(local);
        if end > latest {
            return None;
        }
        let fresh = self.local == 0.0;
        self.taken = taken;
        let (entry, from) = (self.speed, self.travelled);
        if last {
            self.speed = phase.speed_at(phase.duration);
            self.phase_base += phase.length;
            self.travelled = self.phase_base;
            self.phase_start = end;
            self.phase += 1;
            self.begin_phase();
            self.close();
        } else {
            self.local = local;
            self.speed = phase.speed_at(local);
            self.travelled = self.phase_base + phase.distance(local);
        }
        Some(Slice { end, seconds, entry, exit: self.speed, point: self.point(), from, fresh })
    }

    /// Moves the cursor to the end of the profile at once, and adds the time that it takes. (When it ends is
    /// of no interest then.)
    pub fn pass(&mut self, passage: &mut Passage) {
        while let Some(phase) = self.current() {
            let is_even = phase.acceleration == 0.0 && phase.jerk == 0.0;
            *if is_even { &mut passage.even_seconds } else { &mut passage.ramp_seconds } += phase.duration;
            self.speed = phase.speed_at(phase.duration);
            passage.peak = greatest(passage.peak, greatest(phase.speed, self.speed));
            self.phase_base += phase.length;
            self.travelled = self.phase_base;
            self.phase += 1;
        }
        self.begin_phase();
        self.close();
    }

    /// At the end of the profile the speed is the profile's own, free of rounding; near the end of the block,
    /// the place is the block's target itself.
    fn close(&mut self) {
        if self.current().is_none() {
            self.speed = self.profile.exit;
            if self.remaining() < NEAR {
                self.travelled = self.block.length;
            }
        }
    }
}
