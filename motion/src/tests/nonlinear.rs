//! Machines whose motors do not run straight: edges against the reference, limits in motor space, hard paths.

use std::vec::Vec;

use proptest::prelude::*;
use units::{Actuator, MmPerSecond, MmPerSecond2, PerActuator, PerAxis};

use super::{
    laws::{step_error, within_goal},
    rig::{Rig, at, printer},
};
use crate::{
    Kinematics, MotionConfig, Move, Refusal,
    geometry::{Arc, ArcSettings, ArcShape, Chords, Plane},
    kinematics::{LinearDelta, Morgan, tests::machines},
    oracle::StepError,
    planner::SMALLEST,
};

/// A machine of this kind with brisk limits: mm or degrees per second.
pub fn machine(kinematics: Kinematics) -> MotionConfig {
    let mut config = printer();
    config.kinematics = kinematics;
    for motor in config.actuators.0.iter_mut().flatten() {
        motor.steps_per_mm = 80.0;
    }
    config.limits.axis_speed = [None; 3];
    config.limits.actuator_rate = PerActuator([MmPerSecond(400.0); 6]);
    for actuator in [Actuator::Alpha, Actuator::Beta, Actuator::Gamma] {
        config.limits.actuator_acceleration[actuator] = Some(MmPerSecond2(4_000.0));
    }
    config
}

/// Starts at the first point, goes on to the others.
fn draw(config: MotionConfig, points: &[PerAxis<f64>], feed: f64) -> Rig {
    let mut rig = Rig::new(config);
    let mut points = points.iter();
    if let Some(first) = points.next() {
        rig.motion().set_position(*first).expect("at rest");
        rig.tick();
        rig.counts = rig.motion().steps();
    }
    for point in points {
        rig.submit(&Move::feed(*point, MmPerSecond(feed)));
    }
    rig.finish();
    rig
}

/// Steps add up to where the machine says it is.
pub fn balanced(rig: &mut Rig, config: &MotionConfig) -> Result<(), TestCaseError> {
    let target = rig.motion().commanded_position();
    let motors = config.kinematics.actuators(&rig.motion().compensation().motors(&target));
    for actuator in Actuator::ALL {
        let Some(motor) = config.actuators[actuator] else { continue };
        let turn = config.kinematics.turn_of(actuator).map_or(f64::INFINITY, |degrees| degrees * motor.steps_per_mm);
        let off = f64::from(rig.counts[actuator]) - motors[actuator] * motor.steps_per_mm;
        let off = if turn.is_finite() { off - (off / turn).round() * turn } else { off };
        prop_assert!(off.abs() <= 0.500_001, "{actuator:?} is {off} steps off");
    }
    Ok(())
}

/// Checks that no motor is beyond its limits anywhere along the trajectory.
pub fn within_limits(rig: &Rig, config: &MotionConfig) -> Result<(), TestCaseError> {
    let compensation = rig.access.motion.compensation();
    for piece in &rig.access.pieces {
        // An extruder's move that takes X Y Z along by less than counts: no matter how fast that is.
        let [x, y, z, ..] = piece.path.direction.0.map(|part| part * piece.distance(piece.duration));
        if piece.path.curve.is_line() && [x, y, z].iter().all(|part| part.abs() < SMALLEST) {
            continue;
        }
        for share in 0..=20 {
            let t = piece.duration * f64::from(share) / 20.0;
            let point = piece.point_after(piece.distance(t));
            let speeds = |t: f64| {
                let tangent = piece.tangent_after(piece.distance(t));
                let way = PerAxis(tangent.0.map(|part| part * piece.speed_at(t)));
                let at = compensation.at(&piece.point_after(piece.distance(t)));
                config.kinematics.velocities(&at.point, &compensation.along(&at, &way))
            };
            let point = compensation.motors(&point);
            prop_assert!(config.kinematics.reaches(&point), "{point:?} is out of reach");
            let (before, now, after) = (speeds(t - 1e-7), speeds(t), speeds(t + 1e-7));
            for actuator in Actuator::ALL {
                let (rate, limit) = (now[actuator].abs(), config.limits.actuator_rate[actuator].get());
                prop_assert!(rate <= limit * 1.001, "{actuator:?} at {rate}/s in {piece:?}");
                let own = config.limits.actuator_acceleration[actuator].map_or(f64::INFINITY, MmPerSecond2::get);
                let acceleration = (after[actuator] - before[actuator]).abs() / 2e-7;
                prop_assert!(acceleration <= own * 1.001 + 0.1, "{actuator:?} at {acceleration}/s^2, {piece:?}");
            }
        }
    }
    Ok(())
}

fn checked(config: MotionConfig, points: &[PerAxis<f64>], feed: f64) -> Result<StepError, TestCaseError> {
    let mut rig = draw(config, points, feed);
    let error = step_error(&rig, config)?;
    within_limits(&rig, &config)?;
    balanced(&mut rig, &config)?;
    prop_assert_eq!(rig.access.motion.counters().late, 0);
    Ok(error)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(6))]

    #[test]
    fn every_edge_of_every_machine_is_where_the_reference_puts_it(
        shares in prop::collection::vec(prop::array::uniform3(0.0..1.0_f64), 2..5), feed in 30.0..300.0_f64,
        small in prop::bool::ANY,
    ) {
        for (kinematics, span) in machines() {
            let scale = if small { 0.01 } else { 0.2 };
            let points: Vec<_> = shares.iter().map(|share| {
                let [x, y, z] = [0, 1, 2].map(|n| span[n][0] + (span[n][1] - span[n][0]) * (0.5 + scale * (share[n] - 0.5)));
                at(x, y, z, 0.0)
            }).collect();
            let error = checked(machine(kinematics), &points, feed)?;
            within_goal(&error)?;
        }
    }
}

/// The points of a circle around the origin, cut into chords.
fn circle(radius: f64, z: f64) -> Vec<PerAxis<f64>> {
    let start = at(radius, 0.0, z, 0.0);
    let shape =
        ArcShape { plane: Plane::Xy, to_centre_first: -radius, to_centre_second: 0.0, clockwise: false, turns: 1 };
    let settings = ArcSettings { segment_length: 0.0, max_error: 0.01 };
    let arc = Arc::new(start, start, &shape).expect("a circle");
    core::iter::once(start).chain(Chords::new(arc, &settings).expect("chords")).collect()
}

#[test]
fn a_circle_at_the_rim_of_a_delta_keeps_time() {
    let config = machine(Kinematics::LinearDelta(LinearDelta::default()));
    // The rods lie flat 126 mm away, opposite the towers: from 1 mm to 0.02 mm short of that.
    for radius in [125.0, 125.9, 125.98] {
        let error = checked(config, &circle(radius, 10.0), 200.0).expect("a good run");
        within_goal(&error).expect("in time");
    }
    let mut rig = draw(config, &[at(100.0, 0.0, 0.0, 0.0)], 10.0);
    assert_eq!(
        rig.motion().submit(&Move::feed(at(0.0, -126.0, 0.0, 0.0), MmPerSecond(10.0))),
        Err(Refusal::Unreachable)
    );
}

#[test]
fn long_lines_of_a_scara_keep_time() {
    let config = machine(Kinematics::Morgan(Morgan { tower: [0.0; 2], ..Morgan::default() }));
    let square = [
        at(60.0, 60.0, 0.0, 0.0),
        at(-60.0, 60.0, 0.0, 0.0),
        at(-200.0, 0.0, 5.0, 0.0),
        at(-60.0, -60.0, 0.0, 0.0),
        at(60.0, -60.0, 0.0, 0.0),
        at(60.0, 60.0, 0.0, 0.0),
    ];
    let error = checked(config, &square, 150.0).expect("a good run");
    within_goal(&error).expect("in time");
}

#[test]
fn lines_past_the_middle_of_a_polar_bed_keep_time() {
    let config = machine(Kinematics::Polar);
    for distance in [5.0, 0.5, 0.05] {
        let points = [
            at(30.0, distance, 0.0, 0.0),
            at(2.0, distance, 0.0, 0.0),
            at(-2.0, distance, 0.0, 0.0),
            at(-30.0, distance, 0.0, 0.0),
        ];
        let error = checked(config, &points, 100.0).expect("a good run");
        within_goal(&error).expect("in time");
    }
}

#[test]
fn a_polar_bed_goes_round_and_round() {
    let config = machine(Kinematics::Polar);
    let mut points = circle(20.0, 0.0);
    points.extend(circle(20.0, 0.0));
    let rig = draw(config, &points, 100.0);
    assert_eq!(rig.counts[Actuator::Beta], 2 * 360 * 80);
    within_goal(&step_error(&rig, config).expect("edges of this path")).expect("in time");
}
