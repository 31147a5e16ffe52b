//! G64: corners rounded within their tolerance, at the speed the arc allows; G61.1: a stop in each.

use std::vec::Vec;

use proptest::prelude::*;
use units::{MmPerSecond, PerAxis, PowerLaw};

use super::{
    curves::path_within_limits,
    filters::within_filtered_goal,
    laws::step_error,
    nonlinear::{balanced, machine, within_limits},
    rig::{Rig, at, cases, printer},
};
use crate::{Corner, Kinematics, MotionConfig, Move, kinematics::LinearDelta, laser::Power};

/// Corners of a polygon, some of it coarse, some of it fine.
fn polygon() -> impl Strategy<Value = Vec<PerAxis<f64>>> {
    let step = (-1.0..1.0_f64, -1.0..1.0_f64, -0.1..0.1_f64, 0.0..0.2_f64);
    let size = prop_oneof![Just(10.0), Just(1.0), Just(0.05)];
    prop::collection::vec((step, size), 2..25).prop_map(|steps| {
        let mut here = at(0.0, 0.0, 0.0, 0.0);
        steps
            .into_iter()
            .map(|((x, y, z, e), size)| {
                let [px, py, pz, pe, ..] = here.0;
                here = at(px + size * x, py + size * y, pz + size * z, pe + size * e);
                here
            })
            .collect()
    })
}

fn draw(config: MotionConfig, points: &[PerAxis<f64>], feed: f64, corner: Corner) -> Rig {
    let mut rig = Rig::new(config);
    rig.tick();
    rig.counts = rig.motion().steps();
    for point in points {
        rig.submit(&Move { corner, ..Move::feed(*point, MmPerSecond(feed)) });
    }
    rig.finish();
    rig
}

fn distance(p: [f64; 3], a: [f64; 3], b: [f64; 3]) -> f64 {
    let minus = |p: [f64; 3], q: [f64; 3]| [0, 1, 2].map(|n| p[n] - q[n]);
    let dot = |p: [f64; 3], q: [f64; 3]| (0..3).map(|n| p[n] * q[n]).sum::<f64>();
    let (way, seen) = (minus(b, a), minus(p, a));
    let share = if dot(way, way) > 0.0 { (dot(seen, way) / dot(way, way)).clamp(0.0, 1.0) } else { 0.0 };
    let off = minus(seen, way.map(|part| part * share));
    dot(off, off).sqrt()
}

/// Places along the trajectory, closely.
fn places(rig: &Rig) -> Vec<[f64; 3]> {
    let mut places = std::vec![[0.0; 3]; 2];
    for piece in &rig.access.pieces {
        for n in 0..=100 {
            let [x, y, z, ..] = piece.point_after(piece.distance(piece.duration * f64::from(n) / 100.0)).0;
            places.push([x, y, z]);
        }
    }
    places
}

fn xyz(point: &PerAxis<f64>) -> [f64; 3] {
    let [x, y, z, ..] = point.0;
    [x, y, z]
}

/// Returns the greatest distance of the way from the polygon, and of a corner from the way.
fn deviation(rig: &Rig, points: &[PerAxis<f64>]) -> f64 {
    let mut corners = std::vec![[0.0; 3]];
    corners.extend(points.iter().map(xyz));
    let places = places(rig);
    let from_polygon = places
        .iter()
        .map(|place| corners.windows(2).map(|line| distance(*place, line[0], line[1])).fold(f64::INFINITY, f64::min));
    let from_way = corners
        .iter()
        .map(|corner| places.windows(2).map(|line| distance(*corner, line[0], line[1])).fold(f64::INFINITY, f64::min));
    from_polygon.chain(from_way).fold(0.0, f64::max)
}

proptest! {
    #![proptest_config(cases(32))]

    #[test]
    fn a_rounded_corner_stays_within_its_tolerance_and_all_limits(
        points in polygon(), tolerance in 0.005..0.5_f64, feed in 20.0..300.0_f64, delta in prop::bool::weighted(0.2),
    ) {
        let config = if delta { machine(Kinematics::LinearDelta(LinearDelta::default())) } else { printer() };
        let mut rig = draw(config, &points, feed, Corner::Rounded(tolerance));
        let off = deviation(&rig, &points);
        // A move of less than 0.1 um is made up for later.
        prop_assert!(off <= tolerance * 1.000_1 + 2e-4, "{off} mm off");
        within_filtered_goal(&step_error(&rig, config)?)?;
        path_within_limits(&rig, &config)?;
        within_limits(&rig, &config)?;
        balanced(&mut rig, &config)?;
        prop_assert_eq!(rig.access.motion.counters().late, 0);
        for pair in rig.access.pieces.windows(2) {
            let speed = pair[0].speed_at(pair[0].duration);
            prop_assert!((speed - pair[1].speed).abs() < 1e-3, "speed jumps from {speed} to {}", pair[1].speed);
        }
    }

    #[test]
    fn rounding_does_not_depend_on_when_moves_arrive(points in polygon(), pauses in prop::collection::vec(0_u8..4, 25)) {
        let quick = draw(printer(), &points, 100.0, Corner::Rounded(0.1));
        let mut rig = Rig::new(printer());
        rig.tick();
        for (point, pause) in points.iter().zip(pauses) {
            rig.submit(&Move { corner: Corner::Rounded(0.1), ..Move::feed(*point, MmPerSecond(100.0)) });
            (0..pause).for_each(|_| rig.tick());
        }
        rig.finish();
        prop_assume!(rig.access.motion.counters().starved == 0);
        let durations = |rig: &Rig| rig.access.pieces.iter().map(|piece| piece.duration).collect::<Vec<_>>();
        prop_assert_eq!(durations(&quick), durations(&rig));
    }
}

fn square() -> [PerAxis<f64>; 4] {
    [at(20.0, 0.0, 0.0, 0.0), at(20.0, 20.0, 0.0, 0.0), at(0.0, 20.0, 0.0, 0.0), at(0.0, 0.0, 0.0, 0.0)]
}

/// Seconds that the whole trajectory takes.
fn seconds(rig: &Rig) -> f64 {
    rig.access.pieces.iter().map(|piece| piece.duration).sum()
}

#[test]
fn corners_are_rounded_by_as_much_as_allowed_and_that_is_faster() {
    let sharp = draw(printer(), &square(), 100.0, Corner::Sharp);
    let round = draw(printer(), &square(), 100.0, Corner::Rounded(0.5));
    let stops = draw(printer(), &square(), 100.0, Corner::Stop);
    assert!((deviation(&round, &square()) - 0.5).abs() < 1e-3, "{}", deviation(&round, &square()));
    assert!(deviation(&sharp, &square()) < 1e-9);
    assert!(seconds(&round) < seconds(&sharp) && seconds(&sharp) < seconds(&stops));
    assert_eq!(stops.access.pieces.iter().filter(|piece| piece.speed == 0.0).count(), 4, "a stop in each corner");
    assert_eq!(round.counts.0[..2], [0, 0]);
}

#[test]
fn a_corner_of_unlike_moves_and_one_already_begun_stay_sharp() {
    let [first, second, ..] = square();
    let rounded = Move { corner: Corner::Rounded(0.5), ..Move::feed(first, MmPerSecond(100.0)) };
    let unlike = [
        Move { power: Power { level: 32_768, law: PowerLaw::Constant }, target: second, ..rounded },
        Move { mode: crate::Mode::Rapid, target: second, ..rounded },
        Move { corner: Corner::Sharp, target: second, ..rounded },
    ];
    for after in unlike {
        let mut rig = Rig::new(printer());
        rig.submit(&rounded);
        rig.submit(&after);
        rig.finish();
        assert!(rig.access.pieces.iter().all(|piece| piece.path.curve.is_line()), "{after:?}");
    }
    let mut rig = Rig::new(printer());
    rig.submit(&rounded);
    rig.motion().flush();
    (0..50).for_each(|_| rig.tick());
    rig.submit(&Move { target: second, ..rounded });
    rig.finish();
    assert!(rig.access.pieces.iter().all(|piece| piece.path.curve.is_line()));
    assert_eq!(rig.counts.0[..2], [1_600, 1_600]);
}
