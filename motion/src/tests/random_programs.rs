//! Random programs of lines, arcs, helices and splines, and a machine without motors that runs through their
//! trajectory.

use std::{boxed::Box, vec::Vec};

use proptest::prelude::*;
use units::{Axis, MmPerSecond, PerAxis, Ticks};

use super::rig::PERIOD;
use crate::{
    Corner, Motion, MotionConfig, Move, Refusal,
    feed_exchange::{FeedReport, Supply},
    feed_schedule::{FeedSchedule, Lead},
    geometry::{Arc, ArcShape, Bezier, Plane, SplineMoves},
    knots::Segment,
    trajectory::{Piece, at_tick, whole_ticks},
};

/// A stretch of a program.
#[derive(Clone, Copy, Debug)]
pub struct Stroke {
    pub plane: Plane,
    /// Angle by which the path turns at its beginning, rad: zero goes straight on.
    pub bend: f64,
    pub size: f64,
    pub rise: f64,
    pub filament: f64,
    pub feed: f64,
    pub shape: Shape,
}

#[derive(Clone, Copy, Debug)]
pub enum Shape {
    /// Straight, so long as the size.
    Line,
    /// Arc with the size as radius: by this angle to the left, in one block or so many, with more turns.
    Arc(f64, u32, u32),
    /// Lengths of the handles at the beginning and the end, and the turn between, in sizes and rad; as long
    /// as the size.
    Spline(f64, f64, f64),
}

fn shapes() -> impl Strategy<Value = Shape> {
    let angle = prop_oneof![0.1..6.2_f64, -6.2..-0.1_f64];
    let blocks = prop_oneof![2 => Just(1_u32), 1 => 2_u32..6];
    let turns = prop_oneof![6 => Just(1_u32), 1 => 2_u32..4];
    prop_oneof![
        3 => Just(Shape::Line),
        4 => (angle, blocks, turns).prop_map(|(angle, blocks, turns)| Shape::Arc(angle, blocks, turns)),
        2 => (0.1..0.8_f64, 0.1..0.8_f64, -3.0..3.0_f64).prop_map(|(p, q, turn)| Shape::Spline(p, q, turn)),
    ]
}

pub fn strokes(most: usize) -> impl Strategy<Value = Vec<Stroke>> {
    let plane = prop_oneof![3 => Just(Plane::Xy), 1 => Just(Plane::Xz), 1 => Just(Plane::Yz)];
    // Half of all junctions are tangential.
    let bend = prop_oneof![3 => Just(0.0), 2 => -3.0..3.0_f64, 1 => -0.4..0.4_f64];
    let size = prop_oneof![3 => 1.0..20.0_f64, 2 => 0.05..1.0_f64, 1 => 0.002..0.05_f64];
    let rise = prop_oneof![2 => Just(0.0), 1 => -1.0..1.0_f64];
    let stroke = (plane, bend, size, rise, -0.3..0.6_f64, 20.0..300.0_f64, shapes()).prop_map(
        |(plane, bend, size, rise, filament, feed, shape)| Stroke { plane, bend, size, rise, filament, feed, shape },
    );
    prop::collection::vec(stroke, 1..most)
}

/// The moves of a program that begins at `start`, with this sort of corners; `scale` makes all of it smaller.
pub fn program(start: PerAxis<f64>, strokes: &[Stroke], scale: f64, corner: Corner) -> Vec<Move> {
    let (mut here, mut heading) = (start, 0.0_f64);
    let mut moves = Vec::new();
    for stroke in strokes {
        heading += stroke.bend;
        let drawn = draw(here, &mut heading, stroke, scale * stroke.size);
        here = drawn.last().map_or(here, |last| last.target);
        let only_first = drawn.into_iter().map(|request| Move { corner, ..request });
        moves.extend(only_first);
    }
    moves
}

/// Draws moves from `here` along `heading`, which becomes that of the end.
fn draw(here: PerAxis<f64>, heading: &mut f64, stroke: &Stroke, size: f64) -> Vec<Move> {
    // Splines lie in the level plane only.
    let plane = if matches!(stroke.shape, Shape::Spline(..)) { Plane::Xy } else { stroke.plane };
    let (first, second) = plane.axes();
    let third = Axis::PRIMARY.into_iter().find(|axis| *axis != first && *axis != second).expect("a third");
    let along = |angle: f64, length: f64| (length * angle.cos(), length * angle.sin());
    let mut to = here;
    to[third] += stroke.rise * size;
    to[Axis::A] += stroke.filament;
    let feed = |(target, curve)| Move { curve, ..Move::feed(target, MmPerSecond(stroke.feed)) };
    match stroke.shape {
        Shape::Line => {
            let (dx, dy) = along(*heading, size);
            (to[first], to[second]) = (here[first] + dx, here[second] + dy);
            std::vec![Move::feed(to, MmPerSecond(stroke.feed))]
        }
        Shape::Arc(angle, blocks, turns) => {
            let (ci, cj) = along(*heading + std::f64::consts::FRAC_PI_2.copysign(angle), size);
            *heading += angle;
            let (ei, ej) = along(*heading - std::f64::consts::FRAC_PI_2.copysign(angle), size);
            (to[first], to[second]) = (here[first] + ci + ei, here[second] + cj + ej);
            let shape = ArcShape { plane, to_centre_first: ci, to_centre_second: cj, clockwise: angle < 0.0, turns };
            Arc::new(here, to, &shape).expect("an arc").parts(blocks).map(feed).collect()
        }
        Shape::Spline(p, q, turn) => {
            let (begin, end) = (*heading, *heading + turn);
            *heading = end;
            let point = |(dx, dy): (f64, f64)| [here[first] + dx, here[second] + dy, 0.0];
            let (whole, from, back) = (along(begin + 0.5 * turn, size), along(begin, p * size), along(end, -q * size));
            let points = [point((0.0, 0.0)), point(from), point((whole.0 + back.0, whole.1 + back.1)), point(whole)];
            (to[first], to[second]) = (here[first] + whole.0, here[second] + whole.1);
            SplineMoves::new(Bezier::cubic(points), here, to).map(feed).collect()
        }
    }
}

/// Motion and the trajectory it gave.
pub struct Drive {
    pub motion: Box<Motion>,
    pub pieces: Vec<Piece>,
    segment: Segment,
    now: Ticks,
}

impl Drive {
    pub fn new(config: MotionConfig, start: PerAxis<f64>) -> Self {
        let mut motion = Box::new(Motion::new());
        motion.configure(config).expect("a valid configuration");
        motion.set_position(start).expect("at rest");
        Self { motion, pieces: Vec::new(), segment: Segment::default(), now: Ticks(1_000_000) }
    }

    /// Half a millisecond, as the feed asks for it.
    pub fn tick(&mut self) {
        self.now = self.now.plus(PERIOD);
        let mut end = self.segment.start + self.segment.duration;
        while let Some(window) = FeedSchedule::ByPeriod.window(self.now, whole_ticks(end), Lead::Short, Ticks(0))
            && self.motion.take_segment(&window, &mut self.segment) == Supply::Segment
        {
            end = self.segment.start + self.segment.duration;
            if let Some(piece) = self.motion.last_piece()
                && self.pieces.last() != Some(piece)
            {
                self.pieces.push(*piece);
            }
        }
        let drained = end < at_tick(self.now);
        self.motion.feed_reports(Ticks(0), FeedReport { drained, ..FeedReport::RESTING }, false, 0);
    }

    /// Submits what fits, from the front.
    pub fn offer<'a>(&mut self, moves: &'a [Move]) -> &'a [Move] {
        let mut left = moves;
        while let Some((first, rest)) = left.split_first() {
            match self.motion.submit(first) {
                Ok(()) => left = rest,
                Err(Refusal::Full) => return left,
                Err(refusal) => panic!("{first:?} refused: {refusal}"),
            }
        }
        self.motion.flush();
        left
    }

    /// Runs what is left of a program to its end.
    pub fn finish(&mut self, moves: &[Move]) {
        let mut left = moves;
        for _ in 0..600_000 {
            left = self.offer(left);
            self.tick();
            if left.is_empty() && self.motion.is_idle() {
                return;
            }
        }
        panic!("never idle: {:?}", self.motion.state());
    }

    /// Returns the time that each piece lasted before the next one took over, seconds.
    pub fn lengths(&self) -> Vec<f64> {
        let at = |piece: &Piece| piece.start.to_num::<f64>() / 200e6;
        let mut lengths: Vec<_> =
            self.pieces.windows(2).map(|pair| pair[0].duration.min(at(&pair[1]) - at(&pair[0]))).collect();
        lengths.extend(self.pieces.last().map(|last| last.duration));
        lengths
    }
}
