//! Hard files: what slicers and CAM programs do to a planner, edge by edge against the reference.

use std::vec::Vec;

use units::{Actuator, MmPerSecond, MmPerSecond2, PerActuator, PerAxis};

use super::{
    laws::step_error,
    rig::{Rig, at, printer},
};
use crate::{
    Corner, FilterConfig, Kinematics, MotionConfig, Move, PressureAdvance, Shaper, ShaperKind,
    geometry::{Arc, ArcShape, Bezier, Plane, SplineMoves},
    kinematics::LinearDelta,
};

/// A quick machine: 500 mm/s, 20 m/s^2, 200 steps/mm.
fn quick() -> MotionConfig {
    let mut config = printer();
    for motor in config.actuators.0.iter_mut().flatten() {
        motor.steps_per_mm = 200.0;
    }
    config.limits.acceleration = MmPerSecond2(20_000.0);
    config.limits.axis_speed = [None; 3];
    config.limits.actuator_rate = PerActuator([MmPerSecond(600.0); 6]);
    config.queue_size = 256;
    config
}

fn delta() -> MotionConfig {
    MotionConfig { kinematics: Kinematics::LinearDelta(LinearDelta::default()), ..quick() }
}

/// Configuration with shapers and pressure advance as a printer has them.
fn filtered(config: MotionConfig) -> MotionConfig {
    let shaper = |kind, frequency| Some(Shaper { kind, frequency, damping: 0.1 });
    MotionConfig {
        filters: FilterConfig {
            shapers: [shaper(ShaperKind::Mzv, 55.0), shaper(ShaperKind::Ei, 42.0), None],
            advance: [Some(PressureAdvance { factor: 0.03, smooth_time: 0.02 }), None, None],
        },
        ..config
    }
}

/// Requirements for every hard file: 1 us at most, 100 ns RMS, positions exact, no edge late.
fn keeps_time(name: &str, config: MotionConfig, start: PerAxis<f64>, moves: &[Move]) {
    let mut rig = Rig::new(config);
    rig.motion().set_position(start).expect("at rest");
    rig.tick();
    rig.counts = rig.motion().steps();
    let lowest = rig.edges.len();
    moves.iter().for_each(|request| rig.submit(request));
    rig.finish();
    let error = step_error(&rig, config).expect("edges of this path");
    std::eprintln!("{name}: {} edges, {:.1} ns at most, {:.2} ns RMS", error.edges, error.max, error.rms());
    assert!(error.edges > 1_000 && rig.edges.len() > lowest, "{name} hardly moves: {} edges", error.edges);
    assert!(error.max < 1_000.0 && error.rms() < 100.0, "{name}: {error:?}, rms {}", error.rms());
    let target = moves.last().map_or(start, |last| last.target);
    assert_eq!(rig.motion().commanded_position(), target, "{name}");
    let motors = config.kinematics.actuators(&target);
    for actuator in Actuator::ALL {
        let Some(motor) = config.actuators[actuator] else { continue };
        let off = f64::from(rig.counts[actuator]) - motors[actuator] * motor.steps_per_mm;
        assert!(off.abs() <= 0.500_001, "{name}: {actuator:?} is {off} steps off");
    }
    let counters = rig.motion().counters();
    assert_eq!((counters.late, counters.urgent), (0, 0), "{name}");
}

fn both(name: &str, start: PerAxis<f64>, moves: &[Move]) {
    keeps_time(name, quick(), start, moves);
    keeps_time(&std::format!("{name}, filtered"), filtered(quick()), start, moves);
}

fn feed(x: f64, y: f64, e: f64, rate: f64) -> Move {
    Move::feed(at(x, y, 0.0, e), MmPerSecond(rate))
}

const ORIGIN: PerAxis<f64> = PerAxis([0.0; 6]);

#[test]
fn tiny_zigzags() {
    let zigzag: Vec<_> = (1..=250)
        .map(|n| feed(0.04 * f64::from(n), if n % 2 == 0 { 0.0 } else { 0.3 }, 0.01 * f64::from(n), 300.0))
        .collect();
    both("tiny zigzags", ORIGIN, &zigzag);
    let rounded: Vec<_> = zigzag.iter().map(|to| Move { corner: Corner::Rounded(0.05), ..*to }).collect();
    both("tiny zigzags, rounded", ORIGIN, &rounded);
}

#[test]
fn segments_of_a_hundredth_at_500_mm_s() {
    // A circle of 40 mm in chords of 0.01 mm.
    let chords = 6_000;
    let around = |n: i32| f64::from(n) * 0.01 / 40.0;
    let place = |n: i32| (40.0 * around(n).sin(), 40.0 - 40.0 * around(n).cos());
    let moves: Vec<_> = (1..=chords).map(|n| feed(place(n).0, place(n).1, 0.000_4 * f64::from(n), 500.0)).collect();
    keeps_time("0.01 mm at 500 mm/s", quick(), ORIGIN, &moves);
}

/// An arc around (x + i, y + j).
fn arc(from: PerAxis<f64>, to: PerAxis<f64>, [i, j]: [f64; 2], turns: u32, rate: f64, parts: u32) -> Vec<Move> {
    let shape = ArcShape { plane: Plane::Xy, to_centre_first: i, to_centre_second: j, clockwise: false, turns };
    let arc = Arc::new(from, to, &shape).expect("an arc");
    arc.parts(parts).map(|(to, curve)| Move { curve, ..Move::feed(to, MmPerSecond(rate)) }).collect()
}

#[test]
fn long_arcs_and_helices_of_many_turns() {
    let far = at(500.0 * 0.2_f64.sin(), 500.0 - 500.0 * 0.2_f64.cos(), 0.0, 4.0);
    both("an arc of 500 mm radius", ORIGIN, &arc(ORIGIN, far, [0.0, 500.0], 1, 400.0, 1));
    both("a helix of 12 turns", ORIGIN, &arc(ORIGIN, at(0.0, 0.0, 6.0, 20.0), [4.0, 0.0], 12, 200.0, 1));
    let tight: Vec<_> = (0..60)
        .flat_map(|n| {
            let from = at(0.1 * f64::from(n), 0.0, 0.0, 0.0);
            arc(from, at(0.1 * f64::from(n + 1), 0.0, 0.0, 0.0), [0.05, 0.0], 3, 300.0, 1)
        })
        .collect();
    both("180 turns of 0.05 mm radius", ORIGIN, &tight);
}

#[test]
fn circles_near_the_rim_of_a_delta() {
    for radius in [120.0, 125.9] {
        let start = at(radius, 0.0, 20.0, 0.0);
        keeps_time("a circle near the rim", delta(), start, &arc(start, start, [-radius, 0.0], 1, 300.0, 16));
    }
    let start = at(60.0, 0.0, 20.0, 0.0);
    let round = arc(start, start, [-60.0, 0.0], 1, 300.0, 16);
    keeps_time("a circle of a delta, filtered", filtered(delta()), start, &round);
}

#[test]
fn direct_reversals_and_retractions() {
    let there_and_back: Vec<_> =
        (1..=60).map(|n| feed(if n % 2 == 0 { 0.0 } else { 0.05 * f64::from(n) }, 0.0, 0.0, 400.0)).collect();
    both("direct reversals", ORIGIN, &there_and_back);
    let mut e = 0.0;
    let mut print = Vec::new();
    for n in 0..40 {
        let x = f64::from(n) * 0.5;
        e += 0.05;
        print.push(feed(x + 2.0, f64::from(n % 3), e, 150.0));
        print.push(feed(x + 2.0, f64::from(n % 3), e - 0.8, 40.0));
        print.push(feed(x + 0.5, f64::from(n % 2), e - 0.8, 400.0));
        print.push(feed(x + 0.5, f64::from(n % 2), e, 40.0));
    }
    both("retractions", ORIGIN, &print);
}

#[test]
fn splines_with_loops_and_cusps() {
    let mut moves = Vec::new();
    let mut here = ORIGIN;
    for [qx, qy, rx, ry, sx, sy] in [
        [8.0, 8.0, 0.0, 8.0, 8.0, 0.0],
        [12.0, 12.0, -8.0, 12.0, 10.0, 2.0],
        [0.0, 0.0, 4.0, 4.0, 8.0, 0.0],
        [0.5, 0.5, 0.0, 0.5, 0.5, 0.0],
    ] {
        let [x, y, ..] = here.0;
        let to = at(x + sx, y + sy, 0.0, here.0[3] + 1.0);
        let points = [[0.0, 0.0], [qx, qy], [rx, ry], [sx, sy]].map(|[dx, dy]| [x + dx, y + dy, 0.0]);
        let drawn = SplineMoves::new(Bezier::cubic(points), here, to);
        moves.extend(drawn.map(|(target, curve)| Move { curve, ..Move::feed(target, MmPerSecond(200.0)) }));
        here = to;
    }
    both("splines with loops and cusps", ORIGIN, &moves);
}
