//! Jerk-limited motion: limits and continuity over random programs, holds, overrides and stops anywhere, and
//! what it costs in time.

use std::vec::Vec;

use proptest::prelude::*;
use units::{Axis, MmPerSecond, MmPerSecond2, MmPerSecond3};

use super::{
    laws::{program, run, step_error},
    rig::{Rig, at, printer},
};
use crate::{Limits, MotionConfig, Move, ramp::Bounds, trajectory::Piece};

/// A printer with jerk along the path and of its axes.
fn smooth(acceleration: f64, path: Option<f64>, axes: [Option<f64>; 3]) -> MotionConfig {
    let printer = printer();
    MotionConfig {
        limits: Limits {
            acceleration: MmPerSecond2(acceleration),
            jerk: path.map(MmPerSecond3),
            axis_jerk: axes.map(|jerk| jerk.map(MmPerSecond3)),
            ..printer.limits
        },
        ..printer
    }
}

fn plain() -> MotionConfig {
    smooth(3_000.0, Some(100_000.0), [None; 3])
}

fn machines() -> impl Strategy<Value = MotionConfig> {
    let jerk = prop_oneof![2_000.0..20_000.0_f64, 20_000.0..1_000_000.0_f64];
    let axes = prop::array::uniform3(prop::option::of(2_000.0..300_000.0_f64));
    (200.0..6_000.0_f64, jerk, axes, any::<bool>(), 2_usize..64).prop_map(|(acceleration, path, axes, both, queue)| {
        let path = (both || axes.iter().all(Option::is_none)).then_some(path);
        MotionConfig { queue_size: queue, ..smooth(acceleration, path, axes) }
    })
}

/// Curves cut into chords of 0.05 to 0.5 mm, of every size, with lines between.
fn curves() -> impl Strategy<Value = Vec<Move>> {
    let arc = (0.2..20.0_f64, -4.0..4.0_f64, 0.05..0.5_f64, 10.0..200.0_f64, 0.0..10.0_f64);
    prop::collection::vec(arc, 1..6).prop_map(|arcs| {
        let (mut x, mut y, mut heading) = (0.0_f64, 0.0_f64, 0.0_f64);
        let mut moves = Vec::new();
        for (radius, turn, chord, feed, line) in arcs {
            x += line * heading.cos();
            y += line * heading.sin();
            moves.push(Move::feed(at(x, y, 0.0, 0.0), MmPerSecond(feed)));
            let chords = (radius * turn.abs() / chord).ceil().clamp(1.0, 150.0);
            for _ in 0..chords as u32 {
                heading += turn / chords;
                x += chord * heading.cos();
                y += chord * heading.sin();
                moves.push(Move::feed(at(x, y, 0.0, 0.0), MmPerSecond(feed)));
            }
        }
        moves
    })
}

fn programs() -> impl Strategy<Value = Vec<Move>> {
    prop_oneof![program(), curves()]
}

/// Returns the seconds that a piece lasted before the next one took over.
fn seconds(pieces: &[Piece], index: usize) -> f64 {
    let piece = &pieces[index];
    pieces.get(index + 1).map_or(piece.duration, |next| {
        let cut = (next.start.to_num::<f64>() - piece.start.to_num::<f64>()) / 200e6;
        cut.min(piece.duration)
    })
}

/// Speed and acceleration go on from piece to piece; neither they nor the jerk exceed a limit.
fn is_smooth(rig: &Rig, config: &MotionConfig) -> Result<(), TestCaseError> {
    let limits = config.limits;
    let pieces = &rig.access.pieces;
    for (index, piece) in pieces.iter().enumerate() {
        let t = seconds(pieces, index);
        let (speed, acceleration) = (piece.speed_at(t), piece.acceleration_at(t));
        // A jerk over so short a time changes nothing.
        let tolerance = limits.acceleration.get() * 1e-3;
        if let Some(next) = pieces.get(index + 1) {
            prop_assert!((speed - next.speed).abs() < 1e-4, "speed jumps from {speed} in {piece:?} to {next:?}");
            let jump = (acceleration - next.acceleration).abs();
            prop_assert!(jump < tolerance, "acceleration jumps by {jump} after {t} s of {piece:?} to {next:?}");
        } else {
            prop_assert!(
                speed.abs() < 1e-4 && acceleration.abs() < tolerance,
                "ends with {:#?}",
                pieces.iter().rev().take(4).collect::<Vec<_>>()
            );
        }
        for acceleration in [piece.acceleration, acceleration] {
            prop_assert!(acceleration.abs() <= limits.acceleration.get() * 1.001, "{piece:?}");
        }
        for speed in [piece.speed, speed] {
            for (axis, limit) in Axis::PRIMARY.into_iter().zip(limits.axis_speed) {
                let own = (piece.path.direction[axis] * speed).abs();
                prop_assert!(own <= limit.map_or(f64::INFINITY, |limit| limit.get()) * 1.001, "{axis:?} at {own} mm/s");
            }
            prop_assert!(speed > -1e-6, "backwards: {piece:?}");
        }
        if piece.duration < 1e-7 {
            continue;
        }
        if let Some(jerk) = limits.jerk {
            prop_assert!(piece.jerk.abs() <= jerk.get() * 1.001, "{piece:?}");
        }
        for (axis, limit) in Axis::PRIMARY.into_iter().zip(limits.axis_jerk) {
            let own = (piece.path.direction[axis] * piece.jerk).abs();
            prop_assert!(own <= limit.map_or(f64::INFINITY, |limit| limit.get()) * 1.001, "{axis:?}: {piece:?}");
        }
    }
    Ok(())
}

/// Checks that no piece is faster than the program asks, at this override.
fn obeys_feeds(rig: &Rig, moves: &[Move], factor: f64) -> Result<(), TestCaseError> {
    let fastest = moves.iter().map(|request| request.feed_rate.get()).fold(0.0, f64::max) * factor;
    for piece in &rig.access.pieces {
        prop_assert!(piece.speed_at(piece.duration) <= fastest * 1.001, "{piece:?} above {fastest}");
    }
    Ok(())
}

fn ends_where_it_should(rig: &mut Rig, config: &MotionConfig) -> Result<(), TestCaseError> {
    let target = rig.motion().commanded_position();
    for axis in [0, 1, 2, 3] {
        let scale = config.actuators.0[axis].map_or(0.0, |motor| motor.steps_per_mm);
        let off = f64::from(rig.counts.0[axis]) - target.0[axis] * scale;
        prop_assert!(off.abs() <= 0.500_001, "{axis} is {off} steps off");
    }
    prop_assert_eq!(rig.access.motion.counters().late, 0);
    Ok(())
}

/// Duration of the motion, seconds.
fn time(rig: &Rig) -> f64 {
    rig.access.pieces.iter().map(|piece| piece.duration).sum()
}

/// Event that happens to a running program.
#[derive(Clone, Copy, Debug)]
enum Event {
    Hold,
    Resume,
    Override(f64),
    Nothing,
}

fn events() -> impl Strategy<Value = Vec<(u32, Event)>> {
    let event = prop_oneof![
        2 => Just(Event::Hold),
        3 => Just(Event::Resume),
        2 => (0.05..1.5_f64).prop_map(Event::Override),
        1 => Just(Event::Nothing),
    ];
    prop::collection::vec((0_u32..120, event), 0..12)
}

fn disturb(rig: &mut Rig, event: Event) {
    match event {
        Event::Hold => rig.motion().hold(),
        Event::Resume => rig.motion().resume(),
        Event::Override(factor) => rig.motion().set_overrides(factor, 1.0),
        Event::Nothing => {}
    }
}

/// Submits what fits, lets events happen, in the end runs what is left.
fn disturbed(config: MotionConfig, moves: &[Move], events: &[(u32, Event)], stop: bool) -> Rig {
    let mut rig = Rig::new(config);
    let mut waiting = moves.iter();
    let mut next = waiting.next();
    let mut feed = |rig: &mut Rig| {
        while let Some(request) = next {
            if rig.motion().submit(request).is_err() {
                return;
            }
            next = waiting.next();
        }
        rig.motion().flush();
    };
    for (ticks, event) in events {
        for _ in 0..*ticks {
            feed(&mut rig);
            rig.tick();
        }
        disturb(&mut rig, *event);
    }
    if stop {
        rig.motion().stop();
        for _ in 0..20_000 {
            rig.tick();
        }
        return rig;
    }
    rig.motion().resume();
    for _ in 0..2_000_000 {
        feed(&mut rig);
        rig.tick();
        if rig.motion().is_idle() {
            return rig;
        }
    }
    panic!("never idle");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn programs_run_within_their_limits(moves in programs(), config in machines()) {
        let mut rig = run(config, &moves);
        is_smooth(&rig, &config)?;
        obeys_feeds(&rig, &moves, 1.0)?;
        ends_where_it_should(&mut rig, &config)?;
    }

    #[test]
    fn nothing_that_happens_breaks_a_limit(moves in programs(), config in machines(), events in events()) {
        let mut rig = disturbed(config, &moves, &events, false);
        is_smooth(&rig, &config)?;
        ends_where_it_should(&mut rig, &config)?;
    }

    #[test]
    fn a_stop_anywhere_ends_smoothly_at_rest(moves in programs(), config in machines(), events in events()) {
        let mut rig = disturbed(config, &moves, &events, true);
        prop_assert!(rig.motion().is_idle());
        is_smooth(&rig, &config)?;
        ends_where_it_should(&mut rig, &config)?;
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]

    #[test]
    fn every_edge_is_where_the_reference_puts_it(moves in program(), config in machines()) {
        let rig = run(config, &moves);
        // Near a rest, where the speed grows with the square of time, the rounding of knots is more than
        // elsewhere.
        let error = step_error(&rig, config)?;
        prop_assert!(error.max < 1_000.0 && error.rms() < 25.0, "{error:?}, rms {}", error.rms());
    }
}

#[test]
fn a_long_move_takes_the_time_of_seven_phases() {
    let rig = run(plain(), &[Move::feed(at(100.0, 0.0, 0.0, 0.0), MmPerSecond(200.0))]);
    let bounds = Bounds { acceleration: 3_000.0, jerk: 100_000.0 };
    let expected = 100.0 / 200.0 + 200.0 / 3_000.0 + 0.03;
    assert!((time(&rig) - expected).abs() < 1e-6, "{} s, not {expected}", time(&rig));
    assert_eq!(rig.access.pieces.len(), 7);
    assert!((bounds.length(0.0, 200.0) - 200.0 * (200.0 / 3_000.0 + 0.03) / 2.0).abs() < 1e-12);
}

fn circle(radius: f64, chord: f64, feed: f64) -> Vec<Move> {
    let steps = (2.0 * std::f64::consts::TAU * radius / chord) as u32;
    let point = |index: u32| {
        let angle = f64::from(index) * chord / radius;
        at(radius * angle.sin(), radius - radius * angle.cos(), 0.0, 0.0)
    };
    (1..=steps).map(|index| Move::feed(point(index), MmPerSecond(feed))).collect()
}

#[test]
fn a_curve_of_short_chords_is_nearly_as_fast_as_with_trapezoids() {
    // The ramps at both ends take a/j = 30 ms longer in all; 64 chords hold the way to rest from 100 mm/s.
    for (radius, feed) in [(20.0, 100.0), (5.0, 100.0), (2.0, 60.0), (1.0, 100.0), (0.3, 60.0)] {
        let moves = circle(radius, 0.1, feed);
        let trapezoid = time(&run(MotionConfig { queue_size: 64, ..printer() }, &moves));
        let ramps = time(&run(MotionConfig { queue_size: 64, ..plain() }, &moves));
        assert!(ramps < 1.02 * trapezoid + 0.04, "{radius} mm: {ramps} s, not {trapezoid}");
    }
}

/// Returns the time after the call at which the motion first is slower than the undisturbed `calm` one,
/// seconds.
fn first_slower(disturbed: &Rig, calm: &Rig, asked: f64) -> f64 {
    let speed = |rig: &Rig, at: f64| {
        let pieces = &rig.access.pieces;
        let index = pieces.partition_point(|piece| piece.start.to_num::<f64>() / 200e6 <= at).saturating_sub(1);
        let piece = &pieces[index];
        piece.speed_at((at - piece.start.to_num::<f64>() / 200e6).min(piece.duration))
    };
    let slower = |step: &u32| {
        let at = asked + f64::from(*step) * 1e-5;
        speed(disturbed, at) < speed(calm, at) - 1e-7
    };
    (0..1_000).find(slower).map_or(f64::INFINITY, |step| f64::from(step) * 1e-5)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn a_hold_is_felt_within_two_milliseconds(before in 20_u32..500, queue_size in 20_usize..64, stop in any::<bool>()) {
        // The hold comes a long way up the ramp or along the cruise. If the acceleration falls already, as
        // fast as the jerk allows, nothing is left to do.
        let config = MotionConfig { queue_size, ..plain() };
        let begin = || {
            let mut rig = Rig::new(config);
            rig.submit(&Move::feed(at(50.0, 0.0, 0.0, 0.0), MmPerSecond(250.0)));
            rig.motion().flush();
            for _ in 0..before {
                rig.tick();
            }
            rig
        };
        let (mut held, mut calm) = (begin(), begin());
        let asked = held.now.since(super::rig::PERIOD).0 as f64 / 200e6;
        if stop { held.motion().stop() } else { held.motion().hold() }
        for _ in 0..1_000 {
            held.tick();
        }
        calm.finish();
        let falls = |piece: &Piece| {
            let begin = piece.start.to_num::<f64>() / 200e6;
            begin < asked + 0.002 && begin + piece.duration > asked && (piece.jerk < 0.0 || piece.acceleration < 0.0)
        };
        if calm.access.pieces.iter().any(falls) {
            return Ok(());
        }
        let delay = first_slower(&held, &calm, asked);
        prop_assert!(delay <= 0.002, "slower only after {delay} s");
    }
}
