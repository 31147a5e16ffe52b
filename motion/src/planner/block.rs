//! A move in the look-ahead queue.

use units::PerAxis;

use super::{brake::Brake, cruise_ratio::CruisePlan};
use crate::{
    laser::Power,
    least,
    moves::{Mode, Part, Tag},
    ramp::Bounds,
    square_root,
};

/// A move that waits in the look-ahead queue.
#[derive(Clone, Copy, Debug)]
pub struct Block {
    /// End of the move, in machine space.
    pub target: PerAxis<f64>,
    /// Length of the path, mm: of X Y Z, or of all moving axes when X Y Z stand still.
    pub length: f64,
    /// Path acceleration, mm/s^2.
    pub acceleration: f64,
    /// Path jerk, mm/s^3; zero where profiles are trapezoids.
    pub jerk: f64,
    /// The path goes on into this block without a corner: it may be entered while the speed changes.
    pub(crate) is_tangent: bool,
    /// Additional state for some kinds of look-ahead.
    pub(super) look_ahead: LookAhead,
    /// Path speed that no override may exceed, mm/s.
    pub speed_limit: f64,
    /// Path speed that was asked for, mm/s.
    pub requested: f64,
    /// Limit of the squared entry speed by the corner alone, (mm/s)^2.
    pub corner_sq: f64,
    /// Limit of the squared entry speed by the corner and both cruise speeds, (mm/s)^2.
    pub(crate) entry_limit_sq: f64,
    /// Squared entry speed from which this block and all behind it can still brake in time, (mm/s)^2.
    pub(crate) entry_sq: f64,
    /// Distance in mm from which on motors' ways are far from straight ([`crate::Kinematics::clearance`]);
    /// infinite where they are.
    pub(crate) clearance: f64,
    /// Power of a laser.
    pub power: Power,
    /// Kind of move: rapid or feed.
    pub mode: Mode,
    /// Whether the move follows a curve, which waits in the ring of curves.
    pub(crate) curved: bool,
    /// Purpose of the move.
    pub tag: Tag,
    /// Part of the work that the move belongs to.
    pub part: Part,
}

/// Look-ahead state of a block beside its entry speed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum LookAhead {
    /// Nothing: trapezoids need no more.
    Plain,
    /// For profiles limited in jerk.
    Brake(Brake),
    /// For a minimum cruise ratio.
    CruisePlan(CruisePlan),
}

impl Block {
    /// Content of the ring's places before the first block comes there. All bits are zero.
    pub(super) const ZERO: Self = Self {
        clearance: 0.0,
        mode: Mode::Rapid,
        look_ahead: LookAhead::Brake(Brake { length: 0.0, speed: 0.0, top: 0.0, sure: false }),
        ..Self::EMPTY
    };

    /// A block without length or speed.
    pub(crate) const EMPTY: Self = Self {
        target: PerAxis([0.0; units::MAX_AXES]),
        length: 0.0,
        acceleration: 0.0,
        jerk: 0.0,
        is_tangent: false,
        look_ahead: LookAhead::Plain,
        speed_limit: 0.0,
        requested: 0.0,
        corner_sq: 0.0,
        entry_limit_sq: 0.0,
        entry_sq: 0.0,
        clearance: f64::INFINITY,
        power: Power::OFF,
        mode: Mode::Feed,
        curved: false,
        tag: Tag::NONE,
        part: 0,
    };

    /// Cruise speed under these overrides, mm/s.
    #[must_use]
    pub fn cruise(&self, overrides: &Overrides) -> f64 {
        overrides.cruise(self.speed_limit, self.requested, self.mode)
    }

    /// The limits of ramps in it.
    pub(crate) fn bounds(&self) -> Bounds {
        Bounds { acceleration: self.acceleration, jerk: self.jerk }
    }

    /// Whether ramps may run from `other` into this block or back: same limits.
    pub(crate) fn ramps_like(&self, other: &Self) -> bool {
        self.jerk == other.jerk && self.acceleration == other.acceleration
    }

    /// Returns the block's anchor, where profiles are limited in jerk.
    pub(crate) const fn brake(&self) -> Brake {
        match self.look_ahead {
            LookAhead::Brake(brake) => brake,
            _ => Brake { length: 0.0, speed: 0.0, top: 0.0, sure: true },
        }
    }

    /// Sets its anchor, and its entry speed by that.
    pub(crate) const fn set_brake(&mut self, brake: Brake, entry_sq: f64) {
        self.look_ahead = LookAhead::Brake(brake);
        self.entry_sq = entry_sq;
    }

    /// Greatest speed at its beginning by its corner and both cruise speeds.
    pub(crate) fn limit(&self) -> f64 {
        square_root(self.entry_limit_sq)
    }

    /// Greatest speed at its beginning that no override changes: by its corner and its speed limit.
    pub(crate) fn bound(&self) -> f64 {
        least(square_root(self.corner_sq), self.speed_limit)
    }

    /// Whether the planned entry speed has reached its limit.
    pub(super) fn is_at_limit(&self) -> bool {
        self.entry_sq >= self.entry_limit_sq
    }

    /// Returns the block's cruise plan, where a minimum cruise ratio is asked for.
    pub(crate) const fn cruise_plan(&self) -> CruisePlan {
        match self.look_ahead {
            LookAhead::CruisePlan(plan) => plan,
            _ => CruisePlan::NONE,
        }
    }

    /// Sets the cruise plan.
    pub(super) const fn set_cruise_plan(&mut self, plan: CruisePlan) {
        self.look_ahead = LookAhead::CruisePlan(plan);
    }

    /// Gain in squared speed along the block with this share of its acceleration, (mm/s)^2.
    pub(super) fn gain_sq(&self, share: f64) -> f64 {
        2.0 * self.acceleration * share * self.length
    }
}

/// Factors on the requested speeds; 1 is as programmed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Overrides {
    /// Feed override: factor for working moves.
    pub feed: f64,
    /// Rapid override: factor for rapid moves.
    pub rapid: f64,
}

impl Overrides {
    /// Cruise speed of what asks for a speed and must not exceed a limit, mm/s.
    pub(crate) fn cruise(&self, limit: f64, requested: f64, mode: Mode) -> f64 {
        let factor = match mode {
            Mode::Rapid => self.rapid,
            Mode::Feed => self.feed,
        };
        least(limit, requested * factor)
    }
}
