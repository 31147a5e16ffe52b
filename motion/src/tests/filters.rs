//! Input shaping and pressure advance, from submitted moves to played events.

use std::vec::Vec;

use proptest::prelude::*;
use units::{Actuator, Axis, MmPerSecond, MmPerSecond2, PerActuator};

use super::{
    laws::{ideal, program, run, step_error},
    rig::{Rig, at, printer},
};
use crate::{FilterConfig, Kinematics, MotionConfig, Move, PressureAdvance, Shaper, ShaperKind, oracle::StepError};

pub fn shapers() -> impl Strategy<Value = Option<Shaper>> {
    let kind = prop::sample::select(ShaperKind::ALL);
    let shaper = (kind, 25.0..120.0_f64, 0.0..0.2_f64);
    prop::option::weighted(0.8, shaper.prop_map(|(kind, frequency, damping)| Shaper { kind, frequency, damping }))
}

pub fn advances() -> impl Strategy<Value = Option<PressureAdvance>> {
    let advance = (0.0..0.2_f64, 0.005..0.06_f64);
    prop::option::weighted(0.8, advance.prop_map(|(factor, smooth_time)| PressureAdvance { factor, smooth_time }))
}

fn machines() -> impl Strategy<Value = MotionConfig> {
    (prop::array::uniform3(shapers()), advances(), any::<bool>()).prop_map(|(shapers, advance, core)| MotionConfig {
        kinematics: if core { Kinematics::CoreXy } else { Kinematics::Cartesian },
        filters: FilterConfig { shapers, advance: [advance, None, None] },
        ..printer()
    })
}

fn typical() -> MotionConfig {
    let shaper = |kind, frequency| Some(Shaper { kind, frequency, damping: 0.1 });
    MotionConfig {
        filters: FilterConfig {
            shapers: [shaper(ShaperKind::Mzv, 50.0), shaper(ShaperKind::Ei, 37.0), None],
            advance: [Some(PressureAdvance { factor: 0.05, smooth_time: 0.04 }), None, None],
        },
        ..printer()
    }
}

/// The goal is 1 us at most and 100 ns RMS.
pub fn within_filtered_goal(error: &StepError) -> Result<(), TestCaseError> {
    prop_assert!(error.max < 1_000.0 && error.rms() < 100.0, "{error:?}, rms {}", error.rms());
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(8))]

    #[test]
    fn every_filtered_edge_is_where_the_reference_puts_it(moves in program(), config in machines()) {
        let rig = run(config, &moves);
        let error = step_error(&rig, config)?;
        within_filtered_goal(&error)?;
        prop_assert_eq!(rig.access.motion.counters().late, 0);
    }

    #[test]
    fn a_filtered_program_ends_exactly_where_the_plain_one_does(moves in program(), config in machines()) {
        let mut filtered = run(config, &moves);
        let mut plain = run(MotionConfig { filters: FilterConfig::NONE, ..config }, &moves);
        prop_assert_eq!(filtered.counts, plain.counts);
        prop_assert_eq!(filtered.motion().commanded_position(), plain.motion().commanded_position());
        prop_assert_eq!(filtered.motion().steps(), filtered.counts);
    }
}

/// Speed and acceleration of an axis from the reference, sampled: the greatest of each.
fn greatest_speed_and_acceleration(rig: &Rig, config: MotionConfig, axis: Axis) -> (f64, f64) {
    let ideal = ideal(rig, config);
    let (first, last) = (rig.edges.first().map_or(0, |e| e.at), rig.edges.last().map_or(0, |e| e.at));
    let velocity = |at: f64| ideal.machine(at).map_or(0.0, |(_, velocity)| velocity[axis]);
    let samples = (first * 5..last * 5).step_by(100_000).map(|at| at as f64);
    samples.fold((0.0, 0.0), |(speed, acceleration): (f64, f64), at| {
        let (before, after) = (velocity(at), velocity(at + 10_000.0));
        (speed.max(before.abs()), acceleration.max((after - before).abs() / 1e-5))
    })
}

fn straight(length: f64) -> [Move; 1] {
    [Move::feed(at(length, 0.6 * length, 0.0, 0.05 * length), MmPerSecond(150.0))]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(8))]

    #[test]
    fn a_shaped_axis_is_no_faster_and_accelerates_no_more_than_the_path(length in 0.5..60.0_f64, config in machines()) {
        let rig = run(config, &straight(length));
        let shares = [1.0 / 1.36_f64.sqrt(), 0.6 / 1.36_f64.sqrt()];
        for (axis, share) in [Axis::X, Axis::Y].into_iter().zip(shares) {
            let (speed, acceleration) = greatest_speed_and_acceleration(&rig, config, axis);
            prop_assert!(speed <= 150.0 * share * 1.001, "{axis:?} at {speed} mm/s");
            prop_assert!(acceleration <= 3_000.0 * share * 1.001, "{axis:?} by {acceleration} mm/s^2");
        }
    }

    #[test]
    fn a_hold_drains_the_filters_and_a_resume_loses_nothing(before in 1_u32..400, pause in 0_u32..200) {
        let config = typical();
        let mut rig = Rig::new(config);
        for index in 1..=20 {
            let x = f64::from(index) * 2.0;
            rig.submit(&Move::feed(at(x, 0.3 * x, 0.0, 0.1 * x), MmPerSecond(100.0)));
        }
        rig.motion().flush();
        for _ in 0..before {
            rig.tick();
        }
        rig.motion().hold();
        for _ in 0..pause {
            rig.tick();
        }
        rig.motion().resume();
        rig.finish();
        prop_assert_eq!(rig.counts.0, [3_200, 960, 0, 1_600, 0, 0]);
        within_filtered_goal(&step_error(&rig, config)?)?;
        prop_assert_eq!(rig.access.motion.counters().late, 0);
    }

    #[test]
    fn a_stop_ends_at_rest_where_the_motors_are(before in 60_u32..600, in_hold in any::<bool>()) {
        let config = typical();
        let mut rig = Rig::new(config);
        rig.submit(&straight(60.0)[0]);
        rig.motion().flush();
        for _ in 0..before {
            rig.tick();
        }
        if in_hold {
            rig.motion().hold();
        }
        rig.motion().stop();
        rig.finish();
        let place = rig.motion().commanded_position();
        let motors = config.kinematics.actuators(&place);
        for (actuator, scale) in [(Actuator::Alpha, 80.0), (Actuator::Beta, 80.0), (Actuator::Delta, 400.0)] {
            let off = f64::from(rig.counts[actuator]) - motors[actuator] * scale;
            prop_assert!(off.abs() <= 0.500_001, "{actuator:?} is {off} steps off");
        }
        within_filtered_goal(&step_error(&rig, config)?)?;
        rig.submit(&Move::feed(at(0.0, 0.0, 0.0, 0.0), MmPerSecond(100.0)));
        rig.finish();
        prop_assert_eq!(rig.counts, PerActuator([0; 6]));
    }

    #[test]
    fn an_abort_forgets_what_the_filters_still_held(before in 60_u32..400) {
        let mut rig = Rig::new(typical());
        rig.submit(&straight(60.0)[0]);
        rig.motion().flush();
        for _ in 0..before {
            rig.tick();
        }
        rig.motion().abort();
        let edges = rig.edges.len();
        rig.tick();
        prop_assert!(rig.motion().is_idle());
        rig.tick();
        prop_assert_eq!(rig.edges.len(), edges);
        rig.submit(&Move::feed(at(0.0, 0.0, 0.0, 0.0), MmPerSecond(100.0)));
        rig.finish();
        prop_assert_eq!(rig.counts, PerActuator([0; 6]));
    }

    #[test]
    fn bypassed_filters_change_no_event(moves in program()) {
        let mut bypassed = Rig::new(typical());
        bypassed.motion().bypass_filters(true);
        for request in &moves {
            bypassed.submit(request);
        }
        bypassed.finish();
        prop_assert_eq!(&bypassed.events, &run(printer(), &moves).events);
        // The filters are there again from the next standstill on.
        bypassed.motion().bypass_filters(false);
        let start = bypassed.now;
        let here = bypassed.motion().commanded_position();
        bypassed.submit(&Move::feed(at(here.0[0] + 5.0, here.0[1], here.0[2], here.0[3]), MmPerSecond(50.0)));
        bypassed.finish();
        let first = bypassed.edges.iter().find(|edge| edge.at >= start.0);
        let waited = first.map_or(0, |edge| edge.at - start.0);
        prop_assert!(waited > 20_000 * 200 / 2, "latency of half the smoothing time and more, not {waited} ticks");
    }
}

#[test]
fn a_late_feed_shifts_the_filters_with_the_trajectory_and_loses_no_step() {
    let mut rig = Rig::new(typical());
    rig.submit(&straight(60.0)[0]);
    rig.motion().flush();
    for _ in 0..200 {
        rig.tick();
    }
    rig.now = rig.now.plus(units::Ticks::from_micros(10_000));
    rig.play_until(rig.now);
    rig.finish();
    assert!(rig.access.motion.counters().late > 0);
    assert_eq!(rig.counts.0, [4_800, 2_880, 0, 1_200, 0, 0]);
    assert!(rig.events.is_sorted_by(|a, b| a.0 <= b.0));
}

/// A circle of segments far shorter than the filters can remember one by one.
fn dense_circle() -> Vec<Move> {
    let point = |index: u32| {
        let angle = f64::from(index) * 0.001;
        at(10.0 * angle.sin(), 10.0 - 10.0 * angle.cos(), 0.0, 0.000_5 * f64::from(index))
    };
    (1..=6_000).map(|index| Move::feed(point(index), MmPerSecond(200.0))).collect()
}

#[test]
fn pieces_too_short_to_remember_are_made_into_chords_that_keep_to_the_path() {
    let mut config = typical();
    config.queue_size = 256;
    config.limits.acceleration = MmPerSecond2(5_000.0);
    let rig = run(config, &dense_circle());
    assert!(rig.access.motion.counters().lumped > 100, "{:?}", rig.access.motion.counters());
    assert_eq!(rig.access.motion.counters().late, 0);
    let error = step_error(&rig, config).expect("every edge belongs to a crossing");
    assert!(error.max < 1_000.0 && error.rms() < 100.0, "{error:?}, rms {}", error.rms());
    for piece in &rig.access.pieces {
        let middle = piece.point_after(piece.distance(0.5 * piece.duration));
        let off = middle.0[0].hypot(middle.0[1] - 10.0) - 10.0;
        assert!(off.abs() < 0.001, "{piece:?} leaves the circle by {off} mm");
    }
}

#[test]
fn shaping_and_advance_take_the_stated_latency() {
    let filters = typical().filters;
    assert!((filters.latency() - 0.02).abs() < 1e-12);
    let shaped = FilterConfig { advance: [None; 3], ..filters };
    assert!((shaped.latency() - shaped.shapers[1].expect("ei").pulses().shift()).abs() < 1e-12);
    assert_eq!(FilterConfig::NONE.latency(), 0.0);
}
