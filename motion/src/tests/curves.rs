//! Arcs, helices and splines: edges against the reference, limits along the whole path, hard cases.

use std::vec::Vec;

use proptest::prelude::*;
use units::{Actuator, Axis, MmPerSecond, MmPerSecond2, PerAxis};

use super::{
    filters::within_filtered_goal,
    laws::{step_error, within_goal},
    nonlinear::{balanced, machine, within_limits},
    rig::{Rig, at, cases, printer},
};
use crate::{
    FilterConfig, Kinematics, MotionConfig, Move, PressureAdvance, Refusal, Shaper, ShaperKind,
    geometry::{Arc, ArcShape, Bezier, Plane, SplineMoves},
    kinematics::{LinearDelta, tests::machines},
    oracle::StepError,
    path::Curve,
};

/// A stretch of a program: straight on, or an arc.
#[derive(Clone, Copy, Debug)]
pub struct Stroke {
    pub plane: Plane,
    pub radius: f64,
    /// Direction of the centre seen from the start, rad.
    pub towards: f64,
    pub sweep: f64,
    pub clockwise: bool,
    pub turns: u32,
    pub rise: f64,
    pub filament: f64,
    pub feed: f64,
    pub kind: Kind,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kind {
    Arc,
    Straight,
    /// Spline with its last three control points seen from the start, in radii.
    Spline([(f64, f64); 3]),
}

fn kinds() -> impl Strategy<Value = Kind> {
    let place = (-1.0..1.0_f64, -1.0..1.0_f64);
    prop_oneof![3 => Just(Kind::Arc), 2 => Just(Kind::Straight), 2 => prop::array::uniform3(place).prop_map(Kind::Spline)]
}

pub fn strokes() -> impl Strategy<Value = Vec<Stroke>> {
    let plane = prop::sample::select(&[Plane::Xy, Plane::Xy, Plane::Xz, Plane::Yz][..]);
    let radius = prop_oneof![1.0..20.0_f64, 0.05..1.0_f64, 0.001..0.05_f64];
    let shape =
        (plane, radius, 0.0..6.2_f64, 0.02..6.2_f64, any::<bool>(), prop_oneof![6 => Just(1_u32), 1 => 2_u32..5]);
    let more = (-1.0..1.0_f64, -0.3..0.6_f64, 5.0..300.0_f64, kinds());
    let stroke =
        (shape, more).prop_map(|((plane, radius, towards, sweep, clockwise, turns), (rise, filament, feed, kind))| {
            Stroke { plane, radius, towards, sweep, clockwise, turns, rise: rise * radius, filament, feed, kind }
        });
    prop::collection::vec(stroke, 1..8)
}

/// Random programs of arcs, splines and lines that begin at the origin.
pub fn flat_programs() -> impl Strategy<Value = Vec<Move>> {
    strokes().prop_map(|strokes| program(PerAxis([0.0; 6]), &strokes))
}

/// The moves of a program that begins at `start`.
pub fn program(start: PerAxis<f64>, strokes: &[Stroke]) -> Vec<Move> {
    let mut here = start;
    let mut moves = Vec::new();
    for stroke in strokes {
        let added = match stroke.kind {
            Kind::Spline(places) => spline(here, stroke, places),
            _ => arc(here, stroke),
        };
        here = added.last().map_or(here, |last| last.target);
        moves.extend(added);
    }
    moves
}

/// A Bezier curve in the plane of X and Y.
fn spline(here: PerAxis<f64>, stroke: &Stroke, places: [(f64, f64); 3]) -> Vec<Move> {
    let seen = |(x, y): (f64, f64)| [here[Axis::X] + stroke.radius * x, here[Axis::Y] + stroke.radius * y, 0.0];
    let [q, r, s] = places.map(seen);
    let mut to = here;
    (to[Axis::X], to[Axis::Y]) = (s[0], s[1]);
    to[Axis::Z] += stroke.rise;
    to[Axis::A] += stroke.filament;
    SplineMoves::new(Bezier::cubic([seen((0.0, 0.0)), q, r, s]), here, to)
        .map(|(target, curve)| Move { curve, ..Move::feed(target, MmPerSecond(stroke.feed)) })
        .collect()
}

/// An arc, or the line between its ends.
fn arc(here: PerAxis<f64>, stroke: &Stroke) -> Vec<Move> {
    let (first, second) = stroke.plane.axes();
    let rises = Axis::PRIMARY.into_iter().find(|axis| *axis != first && *axis != second).expect("a third");
    let (to_centre_first, to_centre_second) =
        (stroke.radius * stroke.towards.cos(), stroke.radius * stroke.towards.sin());
    let angle = if stroke.clockwise { -stroke.sweep } else { stroke.sweep };
    let mut to = here;
    to[first] += to_centre_first - stroke.radius * (stroke.towards + angle).cos();
    to[second] += to_centre_second - stroke.radius * (stroke.towards + angle).sin();
    to[rises] += stroke.rise;
    to[Axis::A] += stroke.filament;
    let shape = ArcShape {
        plane: stroke.plane,
        to_centre_first,
        to_centre_second,
        clockwise: stroke.clockwise,
        turns: stroke.turns,
    };
    let arc = Arc::new(here, to, &shape).expect("an arc");
    let curve = arc.parts(1).next().map_or(Curve::Line, |(_, curve)| curve);
    let straight = Move::feed(to, MmPerSecond(stroke.feed));
    std::vec![if stroke.kind == Kind::Straight { straight } else { Move { curve, ..straight } }]
}

fn draw(config: MotionConfig, start: PerAxis<f64>, moves: &[Move]) -> Rig {
    let mut rig = Rig::new(config);
    rig.motion().set_position(start).expect("at rest");
    rig.tick();
    rig.counts = rig.motion().steps();
    for request in moves {
        rig.submit(request);
    }
    rig.finish();
    rig
}

/// Speed and acceleration of the path as vectors, and of X, Y and Z, are nowhere beyond their limits.
pub fn path_within_limits(rig: &Rig, config: &MotionConfig) -> Result<(), TestCaseError> {
    for piece in &rig.access.pieces {
        let velocity = |t: f64| {
            let [x, y, z, ..] = piece.tangent_after(piece.distance(t)).0.map(|part| part * piece.speed_at(t));
            [x, y, z]
        };
        for share in 0..=40 {
            let t = piece.duration * f64::from(share) / 40.0;
            for (part, limit) in velocity(t).into_iter().zip(config.limits.axis_speed) {
                let limit = limit.map_or(f64::INFINITY, MmPerSecond::get);
                prop_assert!(part.abs() <= limit * 1.001, "{part} mm/s in {piece:?}");
            }
            let step = (1e-3 * piece.duration).min(1e-7);
            let (before, after) = (velocity(t - step), velocity(t + step));
            let change = [0, 1, 2].map(|n| (after[n] - before[n]) / (2.0 * step));
            let size = change.iter().map(|part| part * part).sum::<f64>().sqrt();
            let limit = config.limits.acceleration.get();
            prop_assert!(size <= limit * 1.001 + 0.1, "{size} mm/s^2 in {piece:?} at {t} s");
        }
    }
    Ok(())
}

fn checked(config: MotionConfig, start: PerAxis<f64>, moves: &[Move]) -> Result<StepError, TestCaseError> {
    let mut rig = draw(config, start, moves);
    let error = step_error(&rig, config)?;
    path_within_limits(&rig, &config)?;
    within_limits(&rig, &config)?;
    balanced(&mut rig, &config)?;
    prop_assert_eq!(rig.access.motion.counters().late, 0);
    Ok(error)
}

/// A turn of a motor makes its crossing of a step uncertain: a few edges of many may be off by more than the
/// grid.
fn within_curved_goal(error: &StepError) -> Result<(), TestCaseError> {
    within_filtered_goal(error)
}

proptest! {
    #![proptest_config(cases(24))]

    #[test]
    fn every_edge_of_curves_is_where_the_reference_puts_it(strokes in strokes(), core in any::<bool>()) {
        let mut config = printer();
        if core {
            config.kinematics = Kinematics::CoreXy;
            config.limits.actuator_acceleration[Actuator::Alpha] = Some(MmPerSecond2(2_000.0));
            config.limits.actuator_acceleration[Actuator::Gamma] = Some(MmPerSecond2(300.0));
        }
        let moves = program(at(0.0, 0.0, 0.0, 0.0), &strokes);
        within_curved_goal(&checked(config, at(0.0, 0.0, 0.0, 0.0), &moves)?)?;
    }
}

proptest! {
    #![proptest_config(cases(4))]

    #[test]
    fn curves_of_every_machine_keep_time_and_limits(strokes in strokes(), shares in prop::array::uniform3(0.4..0.6_f64)) {
        for (kinematics, span) in machines() {
            let [x, y, z] = [0, 1, 2].map(|n| span[n][0] + (span[n][1] - span[n][0]) * shares[n]);
            let start = at(x, y, z, 0.0);
            // The curve is only as wide as the space is there, and uses the axes that the machine has.
            let is_lathe = matches!(kinematics, Kinematics::Lathe);
            let has_extruder = kinematics.motors_of(Axis::A) != 0;
            let small: Vec<_> = strokes.iter().map(|stroke| Stroke {
                radius: 0.15 * stroke.radius,
                rise: if is_lathe { 0.0 } else { 0.1 * stroke.rise },
                plane: if is_lathe { Plane::Xz } else { stroke.plane },
                kind: if is_lathe { Kind::Arc } else { stroke.kind },
                filament: if has_extruder { stroke.filament } else { 0.0 },
                ..*stroke
            }).collect();
            within_curved_goal(&checked(machine(kinematics), start, &program(start, &small))?)?;
        }
    }

    #[test]
    fn filtered_curves_are_where_the_reference_puts_them(strokes in strokes()) {
        let shaper = |kind, frequency| Some(Shaper { kind, frequency, damping: 0.1 });
        let config = MotionConfig {
            filters: FilterConfig {
                shapers: [shaper(ShaperKind::Mzv, 50.0), shaper(ShaperKind::Ei, 37.0), None],
                advance: [Some(PressureAdvance { factor: 0.05, smooth_time: 0.04 }), None, None],
            },
            ..printer()
        };
        let moves = program(at(0.0, 0.0, 0.0, 0.0), &strokes);
        let mut rig = draw(config, at(0.0, 0.0, 0.0, 0.0), &moves);
        within_curved_goal(&step_error(&rig, config)?)?;
        balanced(&mut rig, &config)?;
    }
}

/// A circle of this radius around the origin.
fn circle(radius: f64, z: f64, turns: u32, feed: f64) -> (PerAxis<f64>, Vec<Move>) {
    let start = at(radius, 0.0, z, 0.0);
    let shape = ArcShape { plane: Plane::Xy, to_centre_first: -radius, to_centre_second: 0.0, clockwise: false, turns };
    let arc = Arc::new(start, start, &shape).expect("a circle");
    let parts = arc.parts(16 * turns).map(|(to, curve)| Move { curve, ..Move::feed(to, MmPerSecond(feed)) });
    (start, parts.collect())
}

/// On a path too long to count, rounding would swallow the way that braking takes.
#[test]
fn a_circle_too_large_to_count_is_refused_and_on_the_largest_a_stop_brakes() {
    let circle = |radius: f64| {
        let shape =
            ArcShape { plane: Plane::Xy, to_centre_first: -radius, to_centre_second: 0.0, clockwise: false, turns: 1 };
        let arc = Arc::new(at(0.0, 0.0, 0.0, 0.0), at(0.0, 0.0, 0.0, 0.0), &shape).expect("a circle");
        let curve = arc.parts(1).next().map_or(Curve::Line, |(_, curve)| curve);
        Move { curve, ..Move::feed(at(0.0, 0.0, 0.0, 0.0), MmPerSecond(2.9)) }
    };
    let mut rig = Rig::new(printer());
    for radius in [4.3e5, 2e9, 4e9] {
        assert_eq!(rig.motion().submit(&circle(radius)), Err(Refusal::NotFinite), "{radius}");
    }
    rig.submit(&circle(4.2e5));
    rig.motion().flush();
    (0..1_000).for_each(|_| rig.tick());
    let before = rig.counts[Actuator::Beta];
    assert!(before > 100, "it does not move");
    rig.motion().stop();
    rig.finish();
    assert!(rig.counts[Actuator::Beta] - before <= 1, "{} steps on", rig.counts[Actuator::Beta] - before);
}

#[test]
fn arcs_at_the_rim_of_a_delta_keep_time() {
    let config = machine(Kinematics::LinearDelta(LinearDelta::default()));
    for radius in [100.0, 125.0, 125.9, 125.98] {
        let (start, moves) = circle(radius, 10.0, 1, 200.0);
        within_curved_goal(&checked(config, start, &moves).expect("a good run")).expect("in time");
    }
}

#[test]
fn a_helix_of_many_turns_ends_where_it_should_and_goes_at_its_speed() {
    let start = at(10.0, 0.0, 0.0, 0.0);
    let shape = ArcShape { plane: Plane::Xy, to_centre_first: -10.0, to_centre_second: 0.0, clockwise: true, turns: 5 };
    let arc = Arc::new(start, at(10.0, 0.0, 5.0, 3.0), &shape).expect("a helix");
    let moves: Vec<_> = arc.parts(1).map(|(to, curve)| Move { curve, ..Move::feed(to, MmPerSecond(100.0)) }).collect();
    assert_eq!(moves.len(), 1, "one block");
    let error = checked(printer(), start, &moves).expect("a good run");
    within_goal(&error).expect("in time");
    let rig = draw(printer(), start, &moves);
    assert_eq!(rig.counts.0[..4], [800, 0, 2_000, 1_200]);
    assert!(rig.access.pieces.iter().any(|piece| (piece.speed - 100.0).abs() < 1e-6), "100^2 / 10 is below 3000");
}

#[test]
fn a_hold_on_an_arc_stays_on_it_and_a_resume_loses_nothing() {
    let (start, moves) = circle(10.0, 0.0, 3, 100.0);
    for before in [40, 90, 160, 400] {
        let mut rig = Rig::new(printer());
        rig.motion().set_position(start).expect("at rest");
        rig.tick();
        rig.counts = rig.motion().steps();
        moves.iter().for_each(|request| rig.submit(request));
        rig.motion().flush();
        (0..before).for_each(|_| rig.tick());
        rig.motion().hold();
        (0..400).for_each(|_| rig.tick());
        let [x, y, ..] = rig.motion().live_position().0;
        assert!((x.hypot(y) - 10.0).abs() < 0.02, "held {x} {y}");
        rig.motion().resume();
        rig.finish();
        assert_eq!(rig.counts.0[..2], [800, 0]);
        within_curved_goal(&step_error(&rig, printer()).expect("edges of this path")).expect("in time");
    }
}

#[test]
fn more_curves_than_wait_at_once_are_all_drawn() {
    let (start, moves) = circle(30.0, 0.0, 8, 100.0);
    let mut config = printer();
    config.queue_size = 256;
    let rig = draw(config, start, &moves);
    assert_eq!(rig.counts.0[..2], [2_400, 0]);
    within_goal(&step_error(&rig, config).expect("edges of this path")).expect("in time");
}
