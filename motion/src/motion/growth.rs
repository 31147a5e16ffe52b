//! The last block in the queue grows: moves that go straight on become part of it.
//!
//! A picture comes as thousands of collinear moves, each a pixel, of which the look-ahead could never hold
//! enough to reach a speed. So between M3 or M4 and M5 such moves become one block with a table of levels.
//!
//! The path is the same: only what lies within a micrometre of the line is taken. While a block grows, its
//! whole length is in reserve, so no plan depends on how far it has come when the motors need the plan.
//! Marks, curves, corners, other feeds and laws end it, a flush, and [`MOST_MOVES`].

use units::{Axis, PerAxis, PowerLaw, Ticks};

use super::{Exit, Last, Motion, State, corner::MOST_CUT};
use crate::{
    laser::{Growth, MOST_MOVES, Step},
    moves::{Corner, Mode, Move, Refusal},
    path,
    planner::{Envelope, SMALLEST},
    square_root,
};

/// Cosine of a milliradian, the greatest angle between moves that go straight on.
const STRAIGHT_ON: f64 = 0.999_999_5;
/// Greatest distance of a place from the line, mm.
const OFF_LINE: f64 = 1e-3;

/// Returns X, Y and Z of the way between two places.
fn way(from: &PerAxis<f64>, to: &PerAxis<f64>) -> path::Vector {
    Axis::PRIMARY.map(|axis| to[axis] - from[axis])
}

impl Motion {
    /// Whether a move may become part of the last block.
    #[inline(always)]
    pub(super) fn goes_straight_on(&self, request: &Move) -> bool {
        self.laser.growth.moves > 0 && self.is_straight_on(request)
    }

    #[inline(never)]
    fn is_straight_on(&self, request: &Move) -> bool {
        let growth = &self.laser.growth;
        if growth.moves >= MOST_MOVES {
            return false;
        }
        let waits = growth.block == self.planner.pushed().wrapping_sub(1) && !self.planner.is_empty();
        let goes_on = matches!(self.state, State::Running | State::Holding | State::Held);
        let is_plain = request.mode == Mode::Feed && request.corner != Corner::Stop && request.curve.is_line();
        let alike = request.feed_rate.get() == growth.requested
            && request.power.law == growth.power.law
            && request.part == growth.part;
        let only_primary = Axis::ALL.into_iter().skip(3).all(|axis| request.target[axis] == self.planned[axis]);
        waits && goes_on && is_plain && alike && only_primary && self.is_on_line(request)
    }

    /// Whether a move goes on along the line of the last block.
    fn is_on_line(&self, request: &Move) -> bool {
        let Growth { origin, direction, .. } = &self.laser.growth;
        let own = way(&self.planned, &request.target);
        let length = square_root(path::dot(own, own));
        let whole = way(origin, &request.target);
        let along = path::dot(whole, *direction);
        let off_sq = path::dot(whole, whole) - along * along;
        length >= SMALLEST && path::dot(own, *direction) >= STRAIGHT_ON * length && off_sq <= OFF_LINE * OFF_LINE
    }

    /// Whether the level of a move that goes straight on has room.
    ///
    /// # Errors
    /// [`Refusal::Full`] when it has none yet.
    #[inline(never)]
    pub(super) fn has_room_for_level(&self, request: &Move) -> Result<(), Refusal> {
        let new_level = request.power.level != self.laser.growth.level;
        if new_level && self.has_full_levels() { Err(Refusal::Full) } else { Ok(()) }
    }

    /// Makes a move that goes straight on part of the last block, which then has this envelope and way.
    #[inline(never)]
    pub(super) fn extend(&mut self, envelope: &Envelope, way: &PerAxis<f64>, request: &Move) {
        let growth = &mut self.laser.growth;
        let mut block = envelope.block(request);
        (block.power, block.tag) = (growth.power, growth.tag);
        let before = self.planner.replace_last(&block, &self.overrides);
        let mut last = Last::new(&block, Exit::straight(envelope.primary));
        last.power = request.power;
        if let (Corner::Rounded(_), Some(_)) = (request.corner, envelope.primary) {
            // A corner takes no more than the last move's share, whose power is its own.
            last.line = Some((PerAxis(way.0.map(|part| part / envelope.length)), envelope.length - before));
        }
        self.last = Some(last);
        self.planned = request.target;
        growth.moves += 1;
        let new_level = core::mem::replace(&mut growth.level, request.power.level) != request.power.level;
        if let (true, Some(store)) = (new_level, &mut self.laser.store) {
            let later = u16::try_from(request.tag.0.wrapping_sub(growth.tag.0)).unwrap_or_default();
            store.levels.push(growth.block, Step { distance: before as f32, level: request.power.level, later });
        }
    }

    /// Returns the beginning of the block that is about to be appended, behind a `corner` if one is rounded.
    /// `None` without a laser: no block will grow.
    #[inline(always)]
    pub(super) fn growth_origin(&self, corner: Option<PerAxis<f64>>) -> Option<PerAxis<f64>> {
        self.laser.is_configured().then(|| corner.unwrap_or(self.planned))
    }

    /// Lets the block just appended grow from its beginning, if that is given.
    #[inline(always)]
    pub(super) fn begin_growth(&mut self, request: &Move, origin: Option<PerAxis<f64>>, unit: &PerAxis<f64>) {
        if let Some(origin) = origin {
            self.grow_from(request, origin, unit);
        }
    }

    /// Lets the block just appended grow, if it is a straight working move of X, Y and Z with a laser that is
    /// on, dark or not, and adds `unit` to each axis for a millimetre.
    #[inline(never)]
    fn grow_from(&mut self, request: &Move, origin: PerAxis<f64>, unit: &PerAxis<f64>) {
        self.laser.growth.moves = 0;
        let [x, y, z, others @ ..] = unit.0;
        let only_primary = others.iter().all(|part| *part == 0.0);
        let is_plain = request.mode == Mode::Feed && request.corner != Corner::Stop && only_primary;
        let is_lit = request.power.law != PowerLaw::Off;
        // The plan of a cruise ratio knows no reserve.
        if !is_plain || !is_lit || self.planner.keeps_cruise_ratio() {
            return;
        }
        let Some(length) = self.planner.ahead(self.planner.len().wrapping_sub(1)).map(|block| block.length) else {
            return;
        };
        self.laser.growth = Growth {
            moves: 1,
            block: self.planner.pushed().wrapping_sub(1),
            origin,
            direction: [x, y, z],
            requested: request.feed_rate.get(),
            power: request.power,
            level: request.power.level,
            tag: request.tag,
            part: request.part,
        };
        self.planner.set_reserve(length);
    }

    /// The last block grows no more; only a corner behind it may yet take its share.
    #[inline(never)]
    pub(super) fn end_growth(&mut self) {
        if self.laser.growth.moves > 0 {
            self.laser.growth.moves = 0;
            let line = self.last.as_ref().and_then(|last| last.line);
            self.planner.set_reserve(line.map_or(0.0, |(_, length)| MOST_CUT * length));
        }
    }

    /// Ends the growth of the last block when nothing new has come for the queue's delay.
    #[inline(never)]
    pub(super) fn end_growth_in_time(&mut self, now: Ticks) {
        let Some(config) = &self.config else { return };
        // Into a full queue nothing can come.
        let is_full = self.planner.len() >= config.queue_size || self.has_full_levels();
        if !is_full && now.since(self.seen.1) >= config.queue_delay {
            self.end_growth();
        }
    }
}
