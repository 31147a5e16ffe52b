//! The trajectory through the filters: it runs ahead and is remembered; segments are cut from what comes out.

use units::{Actuator, PerActuator, StepPosition};

use super::{Motion, State};
use crate::{
    compensation::Compensation,
    config::MotionConfig,
    feed_exchange::Supply,
    feed_schedule::Window,
    filters::{Knot, LEAST_SPACING, Source, Stretch},
    knots::{SEGMENT_SECONDS, Segment, Span, step_positions_after},
    laser::Law,
    path::{Curve, Path},
    run::Slice,
    trajectory::{Piece, TickTime, at_tick, seconds_between, tick_time},
};

/// Slices that are made into one stretch at most: bounds the work of one segment.
const MAX_LUMPED: u32 = 32;

impl Motion {
    /// Switches the filters off, for homing and probing, where a late stop would matter, or on again. Filters
    /// are on at first. Takes effect when the motors next begin to move from standstill.
    pub fn bypass_filters(&mut self, bypass: bool) {
        self.filters.bypass_wanted = bypass;
    }

    /// Switches filters on or off as wanted, at a standstill only.
    pub(super) fn obey_bypass(&mut self) {
        if self.resting && self.filters.drained {
            self.filters.bypassed = self.filters.bypass_wanted;
            self.filters.settle(self.place, self.clock);
        }
    }

    /// The next segment of filtered trajectory.
    pub(super) fn filtered_segment(&mut self, window: &Window, segment: &mut Segment) -> Supply {
        if self.state == State::Aborting {
            return Supply::Nothing;
        }
        if self.resume_wanted && !self.is_behind() {
            self.resume();
        }
        let was_behind = self.is_behind();
        // Never the last sliver of what is known: in a segment so short, the rounding of positions is more
        // than the way.
        if self.is_sliver() && self.settle_more(&window.unbounded()).is_none() {
            if self.filters.drained {
                self.rest_power();
            }
            return Supply::Nothing;
        }
        if was_behind {
            return Supply::Later;
        }
        segment.start = self.filters.out;
        let longest = self.lead().longest_segment_seconds();
        let Some(knot) = self.filters.advance(longest, self.clock, at_tick(window.latest)) else {
            return Supply::Enough;
        };
        segment.duration = self.filters.out.saturating_sub(segment.start);
        if let Some(config) = &self.config {
            let warped = if self.compensation.is_active() { compensated(&self.compensation, &knot) } else { knot };
            let ends = step_positions_after(config, &warped.point, &self.knots);
            segment.motors = spans(config, &warped, &self.knots, &ends);
            self.knots = ends;
        }
        self.shift_if_late(segment, window);
        if self.laser.is_on() {
            self.power_of_knot(&knot, segment);
            segment.has_power = self.has_power_before(segment);
        }
        Supply::Segment
    }

    fn is_sliver(&self) -> bool {
        self.clock.saturating_sub(self.filters.out).to_bits() < u128::from(LEAST_SPACING)
    }

    /// Moves the trajectory on: by a slice, or by a moment of rest while the filters have not drained.
    fn settle_more(&mut self, window: &Window) -> Option<()> {
        let Some(slice) = self.next_slice(window) else { return self.rest_a_moment() };
        self.filters.drained = false;
        let begin = self.clock;
        self.power_of_slice(&slice, begin);
        let cut = self.filters.cut_piece.take().filter(|_| !slice.fresh);
        if let Some(cut) = cut {
            self.piece = Some(rest_of(&cut, begin));
        }
        let mut crowded = false;
        if let Some(piece) = &self.piece
            && (slice.fresh || cut.is_some() || self.filters.newest().is_older_than(begin))
        {
            let rest = rest_of(piece, begin);
            crowded = !self.filters.has_room_for(&rest.path.curve);
            let source = self.source_of(piece, &rest);
            if crowded {
                self.filters.push(Stretch::straight(&rest), None);
            } else {
                self.filters.push(Stretch::of(&rest), Some(source));
            }
            if crowded {
                self.piece = Some(rest);
            }
        }
        self.clock = slice.end;
        if slice.fresh || crowded {
            self.lump(&slice, begin, window, crowded);
        }
        Some(())
    }

    fn rest_a_moment(&mut self) -> Option<()> {
        // After a position was declared, the filters stand still already.
        if self.filters.drained && self.filters.newest().is_rest() {
            return None;
        }
        self.send_power(self.clock, Law::OFF);
        if !self.filters.newest().is_rest() {
            self.filters.cut_piece = None;
            self.filters.push(Stretch::rest(self.clock, self.place), None);
        }
        let left = self.filters.still_to_drain();
        if left == TickTime::ZERO {
            self.filters.drained = true;
            return None;
        }
        self.clock = self.clock.max(self.filters.out) + left.min(tick_time(SEGMENT_SECONDS));
        Some(())
    }

    /// Returns the origin in the program of the rest of a piece.
    fn source_of(&self, piece: &Piece, rest: &Piece) -> Source {
        let later = seconds_between(piece.start, rest.start);
        Source {
            block: self.planner.released().wrapping_sub(1),
            origin: piece.path.origin,
            base: rest.base,
            ramp: self.piece_ramp.map(|(ramp, elapsed)| (ramp, elapsed + later)),
        }
    }

    /// Joins several very short pieces into their chord, with their speeds at its ends, when such pieces fill
    /// the history. Without room for a curve, a single slice of it becomes its chord.
    fn lump(&mut self, first: &Slice, begin: TickTime, window: &Window, crowded: bool) {
        let least = self.filters.least_stretch();
        let Some(piece) = self.piece else { return };
        let mean = |slice: &Slice| 0.5 * (slice.entry + slice.exit) * slice.seconds;
        let (mut length, mut last, mut seconds) = (mean(first), *first, first.seconds);
        let mut slices = 1;
        while seconds < least && slices < MAX_LUMPED {
            let Some(slice) = self.next_slice(window) else { break };
            self.power_of_slice(&slice, self.clock);
            self.clock = slice.end;
            length += mean(&slice);
            seconds = seconds_between(begin, self.clock);
            last = slice;
            slices += 1;
        }
        if (slices > 1 || crowded) && length > 0.0 {
            self.counters.lumped = self.counters.lumped.saturating_add(1);
            self.filters.cut_piece = self.piece;
            let gain = last.exit - first.entry;
            let chord = Piece {
                duration: seconds,
                path: Path::new(piece.point_after(0.0), &last.point, length, Curve::Line),
                base: 0.0,
                speed: length / seconds - 0.5 * gain,
                acceleration: gain / seconds,
                jerk: 0.0,
                ..piece
            };
            self.filters.amend(Stretch::of(&chord));
            self.piece = Some(chord);
        }
    }
}

/// Returns the rest of a piece from `begin` on.
fn rest_of(piece: &Piece, begin: TickTime) -> Piece {
    let t = seconds_between(piece.start, begin);
    Piece {
        start: begin,
        duration: piece.duration - t,
        base: piece.base + piece.distance(t),
        speed: piece.speed_at(t),
        acceleration: piece.acceleration_at(t),
        ..*piece
    }
}

/// Maps the filters' output to the motors' space through the compensation.
#[inline(never)]
fn compensated(compensation: &Compensation, knot: &Knot) -> Knot {
    let (start, end) = (compensation.at(&knot.start), compensation.at(&knot.point));
    Knot {
        start: start.point,
        point: end.point,
        entry: compensation.along(&start, &knot.entry),
        exit: compensation.along(&end, &knot.exit),
        ..*knot
    }
}

/// Motor positions and speeds at both ends of a segment.
fn spans(
    config: &MotionConfig,
    knot: &Knot,
    starts: &PerActuator<StepPosition>,
    ends: &PerActuator<StepPosition>,
) -> PerActuator<Span> {
    let entry = config.kinematics.velocities(&knot.start, &knot.entry);
    let exit = config.kinematics.velocities(&knot.point, &knot.exit);
    let mut spans = PerActuator::<Span>::default();
    for actuator in Actuator::ALL {
        let scale = config.steps_per_mm(actuator) * knot.seconds;
        spans[actuator] = Span {
            start: starts[actuator],
            end: ends[actuator],
            entry: scale * entry[actuator],
            exit: scale * exit[actuator],
        };
    }
    spans
}
