//! Job time against the least that the limits allow, and the rules of corners: trapezoids.
//!
//! The optimum is found by a slow method of its own: the squared speed over the whole path at once, on a fine
//! grid, lowered until no step of it needs more than the acceleration, forwards and backwards.

use std::vec::Vec;

use proptest::prelude::*;
use units::{Axis, Mm, MmPerSecond, MmPerSecond2};

use super::{
    laws::{program, run},
    rig::{Rig, at, printer},
};
use crate::{Limits, MotionConfig, Move};

/// A layer and a half of the demonstration part, with its retractions.
const PART: &str = include_str!("../../../demo/part.gcode");

fn layers() -> Vec<Move> {
    let (mut here, mut feed) = ([0.0_f64; 4], 20.0);
    let mut moves = Vec::new();
    for line in PART.lines().skip_while(|line| !line.starts_with(";LAYER_CHANGE")).skip(1).take(700) {
        let mut words = line.split(';').next().unwrap_or_default().split_whitespace();
        if !matches!(words.next(), Some("G0" | "G1")) {
            continue;
        }
        let before = here;
        for word in words {
            let value: f64 = word[1..].parse().expect("a number");
            match &word[..1] {
                "X" => here[0] = value,
                "Y" => here[1] = value,
                "Z" => here[2] = value,
                "E" => here[3] += value,
                "F" => feed = value / 60.0,
                _ => panic!("{line}"),
            }
        }
        if here != before {
            moves.push(Move::feed(at(here[0], here[1], here[2], here[3]), MmPerSecond(feed)));
        }
    }
    moves
}

/// A straight line as the slow method sees it.
struct Leg {
    length: f64,
    speed: f64,
    acceleration: f64,
    /// Greatest speed at its beginning.
    corner: f64,
}

fn legs(moves: &[Move], limits: &Limits) -> Vec<Leg> {
    let mut here = [0.0; 4];
    let mut before: Option<([f64; 3], f64)> = None;
    let mut legs = Vec::new();
    for request in moves {
        let target = request.target.0;
        let delta: Vec<f64> = (0..4).map(|axis| target[axis] - here[axis]).collect();
        let way = (delta[0].powi(2) + delta[1].powi(2) + delta[2].powi(2)).sqrt();
        if way < 1e-4 && delta[3].abs() < 1e-4 {
            continue;
        }
        let only_filament = delta[..3].iter().all(|part| part.abs() < 1e-4);
        let length = if only_filament { delta[3].abs() } else { way };
        let mut speed = request.feed_rate.get();
        for (axis, part) in delta.iter().enumerate() {
            let limit = limits.axis_speed.get(axis).copied().flatten().map_or(f64::INFINITY, |limit| limit.get());
            let limit = limit.min(limits.actuator_rate.0[axis].get());
            speed = speed.min(limit * length / part.abs());
        }
        let acceleration = limits.acceleration.get();
        let direction = (!only_filament).then(|| [delta[0] / way, delta[1] / way, delta[2] / way]);
        let corner = match (before, direction) {
            (Some((p, _)), Some(n)) => {
                let cosine = (p[0] * n[0] + p[1] * n[1] + p[2] * n[2]).clamp(-1.0, 1.0);
                // Half of the angle that the corner encloses.
                let half = (std::f64::consts::PI - cosine.acos()) / 2.0;
                let radius = limits.junction_deviation.get() * half.sin() / (1.0 - half.sin());
                if cosine > 0.999_9 {
                    f64::INFINITY
                } else if cosine < -0.999_9 {
                    0.0
                } else {
                    (acceleration * radius).sqrt()
                }
            }
            _ => 0.0,
        };
        before = direction.map(|direction| (direction, speed));
        legs.push(Leg { length, speed, acceleration, corner });
        here = [target[0], target[1], target[2], target[3]];
    }
    legs
}

/// The least time for the legs, seconds.
fn least_time(legs: &[Leg]) -> f64 {
    const CELLS: usize = 400;
    let mut squares = Vec::new();
    let mut last = 0.0_f64;
    for leg in legs {
        squares.push(leg.corner.min(leg.speed).min(last).powi(2));
        squares.extend(std::iter::repeat_n(leg.speed * leg.speed, CELLS - 1));
        last = leg.speed;
    }
    squares.push(0.0);
    let gain = |cell: usize| {
        let leg = &legs[cell / CELLS];
        2.0 * leg.acceleration * leg.length / CELLS as f64
    };
    for cell in 0..squares.len() - 1 {
        squares[cell + 1] = squares[cell + 1].min(squares[cell] + gain(cell));
    }
    for cell in (0..squares.len() - 1).rev() {
        squares[cell] = squares[cell].min(squares[cell + 1] + gain(cell));
    }
    (0..squares.len() - 1)
        .map(|cell| {
            let length = legs[cell / CELLS].length / CELLS as f64;
            2.0 * length / (squares[cell].sqrt() + squares[cell + 1].sqrt())
        })
        .sum()
}

fn time(rig: &Rig) -> f64 {
    rig.access.pieces.iter().map(|piece| piece.duration).sum()
}

fn deep() -> MotionConfig {
    MotionConfig { queue_size: 128, ..printer() }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn no_program_takes_one_percent_more_than_the_least_time(moves in program()) {
        let (mine, least) = (time(&run(deep(), &moves)), least_time(&legs(&moves, &printer().limits)));
        prop_assert!(mine <= 1.01 * least + 1e-6, "{mine} s, {least} would do");
        // Nor less: what is quicker than the optimum breaks a limit, the grid's coarseness aside.
        prop_assert!(mine >= 0.99 * least, "{mine} s is less than {least}");
    }

    #[test]
    fn a_single_move_cruises_its_share(length in 0.05..50.0_f64, feed in 5.0..400.0_f64, ratio in 0.05..0.95_f64) {
        let mut config = deep();
        config.limits.cruise_ratio = ratio;
        let rig = run(config, &[Move::feed(at(length, 0.0, 0.0, 0.0), MmPerSecond(feed))]);
        let pieces = rig.access.pieces.iter().filter(|piece| piece.acceleration == 0.0);
        let cruised: f64 = pieces.map(|piece| piece.speed * piece.duration).sum();
        prop_assert!(cruised >= ratio * length * (1.0 - 1e-6), "cruises {cruised} of {length} mm");
    }

    #[test]
    fn calm_programs_keep_their_limits_and_only_get_slower(moves in program(), ratio in 0.05..0.95_f64) {
        let mut config = deep();
        config.limits.cruise_ratio = ratio;
        let calm = run(config, &moves);
        let hasty = run(deep(), &moves);
        prop_assert!(time(&calm) >= time(&hasty) * (1.0 - 1e-9), "{} s, not {}", time(&calm), time(&hasty));
        prop_assert_eq!(calm.counts, hasty.counts);
        for pair in calm.access.pieces.windows(2) {
            prop_assert!((pair[0].speed_at(pair[0].duration) - pair[1].speed).abs() < 1e-4, "{pair:?}");
            prop_assert!(pair[0].acceleration.abs() <= 3_003.0, "{:?}", pair[0]);
        }
    }

    #[test]
    fn corners_obey_the_square_corner_velocity(moves in program(), square in 0.5..30.0_f64) {
        let mut config = deep();
        config.limits.square_corner_velocity = Some(MmPerSecond(square));
        config.limits.junction_deviation = Mm(0.0);
        let rig = run(config, &moves);
        for pair in rig.access.pieces.windows(2) {
            let (p, n) = (&pair[0].path.direction, &pair[1].path.direction);
            let along: f64 = Axis::PRIMARY.into_iter().map(|axis| p[axis] * n[axis]).sum();
            // A right angle or sharper: no faster than through a right angle.
            if along <= 0.0 && Axis::PRIMARY.into_iter().any(|axis| p[axis] != 0.0) {
                prop_assert!(pair[1].speed <= square * 1.001, "{} mm/s through {along}", pair[1].speed);
            }
        }
    }
}

#[test]
fn layers_of_a_real_part_take_their_least_time() {
    let moves = layers();
    assert!(moves.len() > 300, "{} moves", moves.len());
    let mut config = deep();
    config.limits.acceleration = MmPerSecond2(1_500.0);
    let (mine, least) = (time(&run(config, &moves)), least_time(&legs(&moves, &config.limits)));
    std::println!("{} moves in {mine:.3} s, {least:.3} s at least", moves.len());
    assert!(mine <= 1.01 * least && mine >= 0.99 * least, "{mine} s, {least} would do");
}

#[test]
fn zigzags_are_calmed_as_a_whole() {
    // The way goes up and down over many short blocks that go straight on: the peak is that of the whole way,
    // and most of it is cruised.
    let mut config = deep();
    config.limits.cruise_ratio = 0.5;
    let moves: Vec<Move> =
        (1..=40).map(|index| Move::feed(at(0.1 * f64::from(index), 0.0, 0.0, 0.0), MmPerSecond(400.0))).collect();
    let rig = run(config, &moves);
    let fastest = rig.access.pieces.iter().map(|piece| piece.speed).fold(0.0, f64::max);
    assert!((fastest - (0.5 * 3_000.0 * 4.0_f64).sqrt()).abs() < 0.5, "{fastest} mm/s");
    let cruised: f64 =
        rig.access.pieces.iter().filter(|p| p.acceleration.abs() < 1.0).map(|p| p.speed * p.duration).sum();
    assert!(cruised > 0.49 * 4.0, "{cruised} mm of 4");
}
