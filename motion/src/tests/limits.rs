//! Speed, acceleration and jerk of the trajectory against the limits, everywhere within blocks: lines, arcs
//! in every plane, helices, splines, rounded corners; trapezoids and S-curves; whatever happens on the way.
//!
//! The trajectory is looked at from outside: place and slope of the path are taken as they are, acceleration
//! and jerk are differences of velocities and accelerations over a fraction of a microsecond.

use std::vec::Vec;

use proptest::prelude::*;
use units::{Actuator, Mm, MmPerSecond, MmPerSecond2, MmPerSecond3, PerActuator, PerAxis};

use super::{
    nonlinear::machine,
    random_programs::{Drive, program, strokes},
    rig::{at, cases, printer},
};
use crate::{Corner, Kinematics, Limits, MotionConfig, kinematics::LinearDelta, trajectory::Piece};

/// Allowed factor over the limits in the acceptance tests.
const ALLOWED: f64 = 1.001;
/// Half the time over which differences are taken, seconds.
const STEP: f64 = 2e-7;
/// Rounding of these differences, mm/s^2 and mm/s^3.
const ROUGH: (f64, f64) = (1e-3, 1.0);

type Vector = [f64; 3];

fn size(v: Vector) -> f64 {
    v.iter().map(|part| part * part).sum::<f64>().sqrt()
}

fn primary(of: &PerAxis<f64>) -> Vector {
    let [x, y, z, ..] = of.0;
    [x, y, z]
}

fn velocity(piece: &Piece, t: f64) -> Vector {
    primary(&piece.tangent_after(piece.distance(t))).map(|part| part * piece.speed_at(t))
}

fn acceleration(piece: &Piece, t: f64) -> Vector {
    let s = piece.distance(t);
    let (tangent, bend, speed) = (piece.tangent_after(s), piece.path.curve.bend(piece.base + s), piece.speed_at(t));
    let [x, y, z] = primary(&tangent);
    let along = piece.acceleration_at(t);
    [0, 1, 2].map(|n| [x, y, z][n] * along + bend[n] * speed * speed)
}

fn change(of: impl Fn(f64) -> Vector, t: f64) -> Vector {
    let (before, after) = (of(t - STEP), of(t + STEP));
    [0, 1, 2].map(|n| (after[n] - before[n]) / (2.0 * STEP))
}

fn within(value: f64, limit: Option<f64>, rough: f64, what: &str, piece: &Piece) -> Result<(), TestCaseError> {
    let limit = limit.unwrap_or(f64::INFINITY);
    prop_assert!(value.abs() <= limit * ALLOWED + rough, "{what}: {value} above {limit} in {piece:?}");
    Ok(())
}

fn moment(piece: &Piece, t: f64, config: &MotionConfig) -> Result<(), TestCaseError> {
    let limits = &config.limits;
    let (speed, rate, jerk) = (velocity(piece, t), acceleration(piece, t), change(|t| acceleration(piece, t), t));
    // The path's own derivatives are what they should be.
    let difference = change(|t| velocity(piece, t), t);
    let off = size([0, 1, 2].map(|n| difference[n] - rate[n]));
    prop_assert!(off < 1e-4 * limits.acceleration.get(), "{difference:?} is not {rate:?} in {piece:?}");

    within(size(speed), limits.max_speed.map(MmPerSecond::get), 1e-6, "speed", piece)?;
    within(size(rate), Some(limits.acceleration.get()), ROUGH.0, "acceleration", piece)?;
    within(size(jerk), limits.jerk.map(MmPerSecond3::get), ROUGH.1, "jerk", piece)?;
    for n in 0..3 {
        within(speed[n], limits.axis_speed[n].map(MmPerSecond::get), 1e-6, "axis speed", piece)?;
        within(jerk[n], limits.axis_jerk[n].map(MmPerSecond3::get), ROUGH.1, "axis jerk", piece)?;
    }
    let motors = |t: f64| {
        let s = piece.distance(t);
        let way = PerAxis(piece.tangent_after(s).0.map(|part| part * piece.speed_at(t)));
        config.kinematics.velocities(&piece.point_after(s), &way)
    };
    let (before, rates, after) = (motors(t - STEP), motors(t), motors(t + STEP));
    for actuator in [Actuator::Alpha, Actuator::Beta, Actuator::Gamma] {
        within(rates[actuator], Some(limits.actuator_rate[actuator].get()), 1e-6, "motor speed", piece)?;
        let own = (after[actuator] - before[actuator]) / (2.0 * STEP);
        within(own, limits.actuator_acceleration[actuator].map(MmPerSecond2::get), 0.1, "motor acceleration", piece)?;
    }
    Ok(())
}

/// Speed is continuous where the path goes straight on; with jerk the acceleration along it is too, and that
/// across it jumps by no more than the junction deviation allows.
fn junction(before: &Piece, t: f64, after: &Piece, limits: &Limits) -> Result<(), TestCaseError> {
    prop_assert!((before.speed_at(t) - after.speed).abs() < 1e-4, "speed jumps from {before:?} after {t} to {after:?}");
    let units = [velocity(before, t), velocity(after, 0.0)].map(|v| v.map(|part| part / size(v)));
    let straight = (0..3).map(|n| units[0][n] * units[1][n]).sum::<f64>() > 1.0 - 1e-9;
    if !limits.has_jerk() || !straight {
        return Ok(());
    }
    let along = before.acceleration_at(t) - after.acceleration;
    prop_assert!(along.abs() < 1e-3 * limits.acceleration.get(), "{along} mm/s^2 from {before:?} to {after:?}");
    let (from, to) = (acceleration(before, t), acceleration(after, 0.0));
    let jump = [0, 1, 2].map(|n| to[n] - from[n]);
    let deviation = match limits.square_corner_velocity {
        Some(square) => square.get() * square.get() * (2.0_f64.sqrt() - 1.0) / limits.acceleration.get(),
        None => limits.junction_deviation.get(),
    };
    let most = |jerk: MmPerSecond3| (24.0 * deviation.max(1e-3) * jerk.get() * jerk.get()).cbrt();
    let rough = 2e-3 * limits.acceleration.get();
    within(size(jump), limits.jerk.map(most), rough, "jump", after)?;
    for (own, jerk) in jump.into_iter().zip(limits.axis_jerk) {
        within(own, jerk.map(most), rough, "axis jump", after)?;
    }
    Ok(())
}

fn kept(drive: &Drive, config: &MotionConfig) -> Result<(), TestCaseError> {
    let lengths = drive.lengths();
    for (index, (piece, length)) in drive.pieces.iter().zip(&lengths).enumerate() {
        // An extruder's move takes X Y Z along by less than counts (0.1 um), no matter how.
        let is_auxiliary = piece.path.curve.is_line() && size(primary(&piece.path.direction)) < 0.999;
        // The rest of a ramp that is cut off at once is too short to check.
        if *length > 1e-8 && !is_auxiliary {
            for part in 0..=8 {
                moment(piece, length * f64::from(part) / 8.0, config)?;
            }
        }
        if let Some(next) = drive.pieces.get(index + 1) {
            junction(piece, *length, next, &config.limits)?;
        }
    }
    let last = drive.pieces.last().zip(lengths.last());
    prop_assert!(last.is_none_or(|(piece, length)| piece.speed_at(*length).abs() < 1e-4), "does not end at rest");
    prop_assert_eq!(drive.motion.counters().late, 0);
    Ok(())
}

fn jerks() -> impl Strategy<Value = (Option<f64>, [Option<f64>; 3])> {
    let jerk = || prop_oneof![2_000.0..20_000.0_f64, 20_000.0..1_000_000.0_f64];
    let axes = prop::array::uniform3(prop::option::of(jerk()));
    prop_oneof![
        1 => Just((None, [None; 3])),
        4 => (prop::option::weighted(0.7, jerk()), axes),
        2 => jerk().prop_map(|jerk| (Some(jerk), [None; 3])),
    ]
}

fn machines() -> impl Strategy<Value = MotionConfig> {
    let kinematics = prop_oneof![
        3 => Just(Kinematics::Cartesian),
        1 => Just(Kinematics::CoreXy),
        1 => Just(Kinematics::LinearDelta(LinearDelta::default())),
    ];
    let corners = (prop_oneof![Just(0.0), 0.005..0.2_f64], prop::option::weighted(0.2, 1.0..20.0_f64));
    let motors = prop::option::weighted(0.3, 300.0..3_000.0_f64);
    (kinematics, 200.0..6_000.0_f64, jerks(), corners, motors, 8_usize..64, prop::option::of(20.0..200.0_f64)).prop_map(
        |(kinematics, acceleration, (jerk, axis_jerk), (deviation, square), motors, queue_size, max_speed)| {
            let own = motors.map(MmPerSecond2);
            let mut config = printer();
            if !kinematics.is_linear() {
                config = machine(kinematics);
            }
            let mut limits = Limits {
                acceleration: MmPerSecond2(acceleration),
                jerk: jerk.map(MmPerSecond3),
                axis_jerk: axis_jerk.map(|jerk| jerk.map(MmPerSecond3)),
                junction_deviation: Mm(deviation),
                square_corner_velocity: square.map(MmPerSecond),
                max_speed: max_speed.map(MmPerSecond),
                actuator_rate: PerActuator([MmPerSecond(400.0); 6]),
                ..config.limits
            };
            for actuator in [Actuator::Alpha, Actuator::Beta, Actuator::Gamma] {
                limits.actuator_acceleration[actuator] = own;
            }
            MotionConfig { kinematics, queue_size, limits, ..config }
        },
    )
}

fn corners() -> impl Strategy<Value = Corner> {
    prop_oneof![2 => Just(Corner::Sharp), 2 => (0.005..0.5_f64).prop_map(Corner::Rounded), 1 => Just(Corner::Stop)]
}

/// Returns the beginning of programs, and a factor for their size where space is scarce.
fn space(config: &MotionConfig) -> (PerAxis<f64>, f64) {
    if config.kinematics.is_linear() { (at(0.0, 0.0, 0.0, 0.0), 1.0) } else { (at(5.0, -3.0, 30.0, 0.0), 0.2) }
}

/// Event that happens to a running program.
#[derive(Clone, Copy, Debug)]
enum Event {
    Hold,
    Resume,
    Override(f64),
    Stop,
}

fn events() -> impl Strategy<Value = Vec<(u32, Event)>> {
    let event = prop_oneof![
        4 => Just(Event::Hold),
        6 => Just(Event::Resume),
        6 => (0.05..1.5_f64).prop_map(Event::Override),
        1 => Just(Event::Stop),
    ];
    prop::collection::vec((0_u32..200, event), 1..12)
}

proptest! {
    #![proptest_config(cases(256))]

    #[test]
    fn no_limit_is_exceeded_within_a_block(strokes in strokes(12), config in machines(), corner in corners()) {
        let (start, scale) = space(&config);
        let moves = program(start, &strokes, scale, corner);
        let mut drive = Drive::new(config, start);
        drive.finish(&moves);
        kept(&drive, &config)?;
        // A move of less than 0.1 um is left to the next move.
        let (ends, target) = (drive.motion.commanded_position(), moves.last().map_or(start, |last| last.target));
        prop_assert!(ends.0.iter().zip(target.0).all(|(is, meant)| (is - meant).abs() < 1e-4), "{ends:?} not {target:?}");
    }

    #[test]
    fn nothing_that_happens_exceeds_a_limit(
        strokes in strokes(12), config in machines(), corner in corners(), events in events(),
    ) {
        let (start, scale) = space(&config);
        let moves = program(start, &strokes, scale, corner);
        let mut drive = Drive::new(config, start);
        let mut left = moves.as_slice();
        for (ticks, event) in events {
            for _ in 0..ticks {
                left = drive.offer(left);
                drive.tick();
            }
            match event {
                Event::Hold => drive.motion.hold(),
                Event::Resume => drive.motion.resume(),
                Event::Override(factor) => drive.motion.set_overrides(factor, 1.0),
                Event::Stop => {
                    drive.motion.stop();
                    left = &[];
                }
            }
        }
        drive.motion.resume();
        drive.finish(left);
        kept(&drive, &config)?;
    }
}
