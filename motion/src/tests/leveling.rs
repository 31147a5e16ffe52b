//! Levelling and skew, from submitted moves to played events: edges against the reference, motors within
//! their limits.

use std::vec::Vec;

use proptest::prelude::*;
use units::{Actuator, Axis, MmPerSecond, MmPerSecond2, PerAxis};

use super::{
    curves::{Kind, Stroke, program, strokes},
    filters::within_filtered_goal,
    laws::step_error,
    nonlinear::{balanced, machine, within_limits},
    rig::{Rig, at, cases, printer},
};
use crate::{
    CompensationError, Fade, FilterConfig, GridShape, Interpolation, Kinematics, MotionConfig, Move, Plane,
    PressureAdvance, Shaper, ShaperKind, Skew, geometry,
    kinematics::{LinearDelta, tests::machines},
    oracle::StepError,
};

/// Levelling of a test's machine, in shares of its space, so that it fits every machine.
#[derive(Clone, Debug)]
struct Bed {
    count: [usize; 2],
    way: Interpolation,
    /// -1 to 1 for each point.
    heights: Vec<f32>,
    most: f64,
    fade: Option<f64>,
    skew: Skew,
}

fn beds() -> impl Strategy<Value = Bed> {
    let factor = || prop_oneof![Just(0.0), -0.05..0.05_f64];
    let skew = (factor(), factor(), factor()).prop_map(|(xy, xz, yz)| Skew { xy, xz, yz });
    let fade = prop_oneof![2 => Just(None), 1 => (0.0..10.0_f64).prop_map(Some)];
    let ways = [Interpolation::Spline, Interpolation::Bilinear, Interpolation::Lagrange];
    let way = prop::sample::select(ways.to_vec());
    (2_usize..9, 2_usize..9, way, 0.02..1.0_f64, fade, skew).prop_flat_map(|(nx, ny, way, most, fade, skew)| {
        let count = [nx, ny].map(|count| count.min(way.most_points()));
        // A polynomial swings higher than its points.
        let most = if way == Interpolation::Lagrange { 0.2 * most } else { most };
        prop::collection::vec(-1.0..1.0_f32, count[0] * count[1]).prop_map(move |heights| Bed {
            count,
            way,
            heights,
            most,
            fade,
            skew,
        })
    })
}

impl Bed {
    /// Levels the machine whose space this is.
    fn level(&self, rig: &mut Rig, span: &[[f64; 2]; 3], from_z: f64) {
        let motion = rig.motion();
        let step = [0, 1].map(|axis| {
            let [low, high] = span[axis];
            ((high - low) / (self.count[axis] - 1) as f64).max(2.0)
        });
        let shape = GridShape { origin: [span[0][0], span[1][0]], step, count: self.count };
        let most = self.most.min(0.1 * step[0].min(step[1]));
        for (to, share) in motion.draft().iter_mut().zip(&self.heights) {
            *to = share * most as f32;
        }
        let fade = self.fade.map(|more| Fade {
            start: from_z,
            end: from_z + 4.0 * 1.5 * most + more,
            target: 0.25 * most * libm::sin(more),
        });
        let mut fade = fade;
        while let Err(error) = motion.level_by_draft(&shape, self.way, fade) {
            assert!(matches!(error, CompensationError::FadeShort { .. }), "{error}");
            fade = fade.map(|fade| Fade { end: fade.end + (fade.end - fade.start), ..fade });
        }
        motion.set_skew(self.skew).expect("within bounds");
    }
}

fn draw(config: MotionConfig, bed: &Bed, span: &[[f64; 2]; 3], start: PerAxis<f64>, moves: &[Move]) -> Rig {
    let mut rig = Rig::new(config);
    bed.level(&mut rig, span, start[Axis::Z]);
    rig.motion().set_position(start).expect("at rest");
    rig.tick();
    rig.counts = rig.motion().steps();
    for request in moves {
        rig.submit(request);
    }
    rig.finish();
    rig
}

fn checked(config: &MotionConfig, rig: &mut Rig) -> Result<StepError, TestCaseError> {
    let error = step_error(rig, *config)?;
    within_filtered_goal(&error)?;
    balanced(rig, config)?;
    prop_assert_eq!(rig.access.motion.counters().late, 0);
    Ok(error)
}

const WIDE: [[f64; 2]; 3] = [[-60.0, 60.0]; 3];

fn core(is_core: bool) -> MotionConfig {
    let mut config = printer();
    config.limits.axis_speed = [None; 3];
    config.limits.actuator_acceleration[Actuator::Gamma] = Some(MmPerSecond2(200.0));
    if is_core {
        config.kinematics = Kinematics::CoreXy;
        config.limits.actuator_acceleration[Actuator::Alpha] = Some(MmPerSecond2(2_500.0));
    }
    config
}

proptest! {
    #![proptest_config(cases(24))]

    #[test]
    fn every_levelled_edge_is_where_the_reference_puts_it(
        strokes in strokes(), bed in beds(), is_core in any::<bool>(), rate in 0.5..20.0_f64,
    ) {
        let mut config = core(is_core);
        config.limits.actuator_rate[Actuator::Gamma] = MmPerSecond(rate);
        let start = at(3.0, -4.0, 1.0, 0.0);
        let mut rig = draw(config, &bed, &WIDE, start, &program(start, &strokes));
        checked(&config, &mut rig)?;
        within_limits(&rig, &config)?;
    }

}

proptest! {
    #![proptest_config(cases(6))]

    #[test]
    fn filtered_and_levelled_edges_are_where_the_reference_puts_them(strokes in strokes(), bed in beds()) {
        let shaper = |kind, frequency| Some(Shaper { kind, frequency, damping: 0.1 });
        let filters = FilterConfig {
            shapers: [shaper(ShaperKind::Mzv, 50.0), shaper(ShaperKind::Ei, 37.0), None],
            advance: [Some(PressureAdvance { factor: 0.05, smooth_time: 0.04 }), None, None],
        };
        let config = MotionConfig { filters, ..core(false) };
        let start = at(3.0, -4.0, 1.0, 0.0);
        let mut rig = draw(config, &bed, &WIDE, start, &program(start, &strokes));
        checked(&config, &mut rig)?;
    }
}

proptest! {
    #![proptest_config(cases(4))]

    #[test]
    fn every_machine_can_be_levelled(
        strokes in strokes(), bed in beds(), shares in prop::array::uniform3(0.4..0.6_f64),
    ) {
        for (kinematics, span) in machines() {
            let [x, y, z] = [0, 1, 2].map(|n| span[n][0] + (span[n][1] - span[n][0]) * shares[n]);
            let start = at(x, y, z, 0.0);
            let is_lathe = matches!(kinematics, Kinematics::Lathe);
            let has_extruder = kinematics.motors_of(Axis::A) != 0;
            let small: Vec<_> = strokes.iter().map(|stroke| Stroke {
                radius: 0.15 * stroke.radius,
                rise: if is_lathe { 0.0 } else { 0.1 * stroke.rise },
                plane: if is_lathe { geometry::Plane::Xz } else { stroke.plane },
                kind: if is_lathe { Kind::Arc } else { stroke.kind },
                filament: if has_extruder { stroke.filament } else { 0.0 },
                ..*stroke
            }).collect();
            let config = machine(kinematics);
            let mut rig = draw(config, &bed, &span, start, &program(start, &small));
            checked(&config, &mut rig)?;
            within_limits(&rig, &config)?;
        }
    }

    #[test]
    fn changing_it_at_rest_moves_no_motor_and_what_it_was_comes_back(bed in beds(), place in prop::array::uniform3(-50.0..50.0_f64)) {
        let mut rig = Rig::new(printer());
        let [x, y, z] = place;
        rig.motion().set_position(at(x, y, z, 1.0)).expect("at rest");
        rig.tick();
        let before = rig.motion().steps();
        bed.level(&mut rig, &WIDE, 0.0);
        rig.tick();
        prop_assert_eq!(rig.motion().steps(), before);
        let (there, live) = (rig.motion().commanded_position(), rig.motion().live_position());
        for axis in Axis::ALL {
            prop_assert!((there[axis] - live[axis]).abs() < 0.02, "{there:?} {live:?}: within a step of the motors");
        }
        rig.motion().suspend_compensation(true).expect("at rest");
        let raw = rig.motion().commanded_position();
        for (one, other) in raw.0.iter().zip([x, y, z, 1.0]) {
            prop_assert!((one - other).abs() < 1e-9);
        }
        rig.motion().suspend_compensation(false).expect("at rest");
        for axis in Axis::ALL {
            prop_assert!((rig.motion().commanded_position()[axis] - there[axis]).abs() < 1e-9);
        }
        rig.tick();
        prop_assert_eq!(rig.motion().steps(), before);
        prop_assert!(rig.edges.is_empty());
    }
}

/// A bed that is high in the middle.
fn hill() -> Bed {
    let heights = [0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0].to_vec();
    Bed { count: [3, 3], way: Interpolation::Spline, heights, most: 0.5, fade: None, skew: Skew::NONE }
}

#[test]
fn z_follows_the_bed_and_the_program_does_not_see_it() {
    let start = at(-60.0, 0.0, 0.2, 0.0);
    let over = [Move::feed(at(0.0, 0.0, 0.2, 0.0), MmPerSecond(50.0))];
    let mut rig = draw(printer(), &hill(), &WIDE, start, &over);
    assert_eq!(rig.counts[Actuator::Gamma], 280, "0.2 mm and the hill's 0.5 at 400 steps/mm");
    let live = rig.motion().live_position();
    assert!((live[Axis::Z] - 0.2).abs() < 0.001_3, "{live:?}");
    rig.submit(&Move::feed(at(60.0, 60.0, 0.2, 0.0), MmPerSecond(50.0)));
    rig.finish();
    assert_eq!(rig.counts[Actuator::Gamma], 80);
}

#[test]
fn a_moving_machine_is_not_compensated_anew() {
    let mut rig = draw(printer(), &hill(), &WIDE, at(0.0, 0.0, 0.0, 0.0), &[]);
    rig.submit(&Move::feed(at(10.0, 0.0, 0.0, 0.0), MmPerSecond(50.0)));
    assert_eq!(rig.motion().level_off(), Err(CompensationError::Busy));
    assert_eq!(rig.motion().suspend_compensation(true), Err(CompensationError::Busy));
    rig.finish();
    rig.motion().level_off().expect("at rest");
    assert!(!rig.motion().compensation().is_active());
}

#[test]
fn a_cut_on_a_levelled_bed_leaves_the_place_of_the_motors() {
    let mut rig = draw(printer(), &hill(), &WIDE, at(-60.0, 0.0, 0.2, 0.0), &[]);
    rig.submit(&Move::feed(at(60.0, 0.0, 0.2, 0.0), MmPerSecond(50.0)));
    rig.motion().flush();
    (0..1_500).for_each(|_| rig.tick());
    rig.motion().abort();
    (0..3).for_each(|_| rig.tick());
    let place = rig.motion().commanded_position();
    assert!(place[Axis::X] > -50.0 && place[Axis::X] < 50.0, "{place:?}");
    assert!((place[Axis::Z] - 0.2).abs() < 0.001_3, "{place:?}");
    assert_eq!(rig.motion().steps(), rig.counts);
    rig.submit(&Move::feed(at(0.0, 0.0, 0.2, 0.0), MmPerSecond(50.0)));
    rig.finish();
    assert_eq!(rig.counts[Actuator::Gamma], 280);
}

#[test]
fn a_tilted_plane_costs_no_accuracy_on_a_delta() {
    let config = machine(Kinematics::LinearDelta(LinearDelta::default()));
    let mut rig = Rig::new(config);
    rig.motion().level_by_plane(Plane { x: 0.01, y: -0.02, z: 0.3 }).expect("a gentle plane");
    rig.motion().set_position(at(0.0, 0.0, 10.0, 0.0)).expect("at rest");
    rig.tick();
    rig.counts = rig.motion().steps();
    for [x, y] in [[50.0, 20.0], [-40.0, 60.0], [0.0, 0.0]] {
        rig.submit(&Move::feed(at(x, y, 10.0, 0.0), MmPerSecond(200.0)));
    }
    rig.finish();
    let error = checked(&config, &mut rig).expect("edges of this path");
    assert!(error.max < 10.0, "{error:?}");
    within_limits(&rig, &config).expect("within limits");
}
