//! Laws that every kind of kinematics must satisfy.

use std::vec::Vec;

use proptest::prelude::*;
use units::{Actuator, Axis, PerActuator, PerAxis};

use super::*;
use crate::compensation::Over;

/// A machine of every kind, some of them crooked, and a box in which it works.
pub fn machines() -> Vec<(Kinematics, [[f64; 2]; 3])> {
    let crooked = LinearDeltaGeometry {
        tower_offset: [0.7, -0.4, 0.2],
        tower_angle: [0.5, -0.3, 0.1],
        arm_offset: [0.7, -0.4, 0.25],
        ..LinearDeltaGeometry::default()
    };
    let skewed = Generic::new([[1.0, 0.5, 0.0], [0.3, -1.0, 0.1], [0.0, 0.2, 2.0]]).expect("independent rows");
    let ropes = [[-500.0, -400.0, 900.0], [500.0, -400.0, 950.0], [0.0, 600.0, 1_000.0], [10.0, 20.0, -300.0]];
    let wide = [[-200.0, 200.0]; 3];
    let drum = [[-80.0, 80.0], [-80.0, 80.0], [0.0, 200.0]];
    std::vec![
        (Kinematics::Cartesian, wide),
        (Kinematics::CoreXy, wide),
        (Kinematics::CoreXz(CoreXz::default()), wide),
        (Kinematics::HybridCoreXy, wide),
        (Kinematics::HybridCoreXz, wide),
        (Kinematics::Lathe, [[-100.0, 100.0], [0.0, 0.0], [-200.0, 200.0]]),
        (Kinematics::Generic(skewed), wide),
        (Kinematics::LinearDelta(LinearDelta::default()), drum),
        (Kinematics::LinearDelta(LinearDelta::new(crooked)), drum),
        (Kinematics::RotaryDelta(RotaryDelta::default()), [[-50.0, 50.0], [-50.0, 50.0], [0.0, 20.0]]),
        (Kinematics::Morgan(Morgan::default()), [[-60.0, 60.0], [40.0, 120.0], [0.0, 100.0]]),
        (Kinematics::Deltesian(Deltesian::default()), [[-80.0, 80.0], [-100.0, 100.0], [0.0, 200.0]]),
        (Kinematics::Polar, [[-100.0, 100.0], [1.0, 100.0], [0.0, 100.0]]),
        (
            Kinematics::Winch(Winch::new(&ropes).expect("four anchors")),
            [[-200.0, 200.0], [-200.0, 200.0], [0.0, 400.0]]
        ),
        (Kinematics::Winch(Winch::new(&ropes[..3]).expect("three")), [[-200.0, 200.0], [-200.0, 200.0], [0.0, 400.0]]),
    ]
}

/// Shares of the way through a box, 0 to 1, as a point in it.
fn inside(span: &[[f64; 2]; 3], [u, v, w]: [f64; 3], auxiliary: [f64; 3]) -> PerAxis<f64> {
    let [x, y, z] = [0, 1, 2].map(|n| span[n][0] + (span[n][1] - span[n][0]) * [u, v, w][n]);
    PerAxis([x, y, z, auxiliary[0], auxiliary[1], auxiliary[2]])
}

fn anywhere() -> impl Strategy<Value = [f64; 3]> {
    prop::array::uniform3(0.0..1.0_f64)
}

fn near(a: f64, b: f64, tolerance: f64) -> Result<(), TestCaseError> {
    prop_assert!((a - b).abs() <= tolerance, "{a} is not {b}");
    Ok(())
}

#[test]
fn every_machine_has_its_own_name_and_a_sound_geometry() {
    let mut names: Vec<_> = machines().iter().map(|(kinematics, _)| kinematics.name()).collect();
    names.dedup();
    assert_eq!(names.len(), 13);
    for (kinematics, _) in machines() {
        assert!(kinematics.is_sound(), "{}", kinematics.name());
    }
    let flat = LinearDeltaGeometry { arm_length: 100.0, ..LinearDeltaGeometry::default() };
    assert!(!Kinematics::LinearDelta(LinearDelta::new(flat)).is_sound());
    assert!(!Kinematics::CoreXz(CoreXz { x: 1.0, z: 0.0 }).is_sound());
    assert!(!Kinematics::Morgan(Morgan { arm1: 0.0, ..Morgan::default() }).is_sound());
    assert!(Winch::new(&[[0.0; 3], [1.0, 1.0, 1.0], [2.0, 2.0, 2.0]]).is_none(), "anchors in a line");
}

#[test]
fn a_motor_without_current_loses_what_it_moves() {
    let axes = |kinematics: Kinematics, motor| kinematics.axes_of(motor).to_string();
    assert_eq!(axes(Kinematics::Cartesian, Actuator::Beta), "Y");
    assert_eq!(axes(Kinematics::CoreXy, Actuator::Beta), "XY");
    // X is where both motors are together, Y where its own is.
    assert_eq!(axes(Kinematics::HybridCoreXy, Actuator::Alpha), "X");
    assert_eq!(axes(Kinematics::HybridCoreXy, Actuator::Beta), "XY");
    assert_eq!(axes(Kinematics::Polar, Actuator::Gamma), "XYZ");
    assert_eq!(axes(Kinematics::Polar, Actuator::Delta), "A");
}

#[test]
fn every_parameter_can_be_changed_by_its_letter() {
    for (kinematics, _) in machines() {
        let before = kinematics.parameters();
        assert_eq!(kinematics.with_parameters(&before), kinematics);
        for (letter, value) in before.iter() {
            let mut changed = before;
            assert!(changed.set(letter, value + 0.125));
            let after = kinematics.with_parameters(&changed).parameters();
            let moved: Vec<_> = before.iter().zip(after.iter()).filter(|(old, new)| old != new).collect();
            assert_eq!(moved, [((letter, value), (letter, value + 0.125))], "{} {letter}", kinematics.name());
        }
        assert!(!before.clone().set('Q', 1.0));
    }
}

#[test]
fn the_arms_stand_where_the_drawings_say() {
    let middle = PerAxis([0.0; 6]);
    let towers = Kinematics::LinearDelta(LinearDelta::default()).actuators(&middle).0;
    let rise = (250.0_f64 * 250.0 - 124.0 * 124.0).sqrt();
    assert!(towers[..3].iter().all(|height| (height - rise).abs() < 1e-9));
    // Away from the tower of gamma (at 90 degrees) its carriage comes down.
    let back = Kinematics::LinearDelta(LinearDelta::default()).actuators(&PerAxis([0.0, -50.0, 0.0, 0.0, 0.0, 0.0])).0;
    assert!(back[2] < rise && back[0] > rise);
    let arm = Morgan { tower: [0.0; 2], ..Morgan::default() };
    let stretched = Kinematics::Morgan(arm).point(&PerActuator([0.0, 90.0, 5.0, 0.0, 0.0, 0.0])).0;
    assert!((stretched[0] - 150.0).abs() < 1e-9 && (stretched[1] - 150.0).abs() < 1e-9);
    let bed = Kinematics::Polar.actuators(&PerAxis([0.0, 20.0, 1.0, 0.0, 0.0, 0.0])).0;
    assert!((bed[0] - 20.0).abs() < 1e-12 && (bed[1] - 90.0).abs() < 1e-12);
}

#[test]
fn places_that_no_posture_reaches_are_known() {
    let far = |kinematics: Kinematics, x: f64| kinematics.reaches(&PerAxis([x, 0.0, 0.0, 0.0, 0.0, 0.0]));
    let delta = Kinematics::LinearDelta(LinearDelta::default());
    assert!(far(delta, 100.0) && !far(delta, 140.0) && !far(delta, f64::NAN));
    let rotary = Kinematics::RotaryDelta(RotaryDelta::default());
    assert!(far(rotary, 50.0) && !far(rotary, 200.0));
    assert!(!rotary.reaches(&PerAxis([0.0, 0.0, 250.0, 0.0, 0.0, 0.0])), "arms beyond their angles");
    let scara = Kinematics::Morgan(Morgan { tower: [0.0; 2], ..Morgan::default() });
    assert!(far(scara, 200.0) && !far(scara, 299.0) && !far(scara, 1.0));
    assert!(!far(Kinematics::Polar, 0.0) && far(Kinematics::Polar, 0.1));
    let across = |kinematics: Kinematics| {
        kinematics.check_line(
            &PerAxis([-200.0, 0.0, 0.0, 0.0, 0.0, 0.0]),
            &PerAxis([400.0, 0.0, 0.0, 0.0, 0.0, 0.0]),
            400.0,
            &Over::NONE,
        )
    };
    assert!(across(Kinematics::Cartesian) && !across(scara), "the tower is in the way");
    assert!(!across(Kinematics::Polar), "the middle is in the way");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn point_undoes_actuators(share in anywhere(), auxiliary in prop::array::uniform3(-1e3..1e3_f64)) {
        for (kinematics, span) in machines() {
            let mut point = inside(&span, share, auxiliary);
            prop_assert!(kinematics.reaches(&point), "{} at {point:?}", kinematics.name());
            for axis in Axis::ALL {
                if kinematics.motors_of(axis) == 0 {
                    point[axis] = 0.0;
                }
            }
            let back = kinematics.point(&kinematics.actuators(&point));
            for axis in Axis::ALL {
                prop_assert!((back[axis] - point[axis]).abs() < 1e-8, "{} {axis:?}: {back:?}, {point:?}", kinematics.name());
            }
        }
    }

    #[test]
    fn velocities_are_the_derivative_of_positions(share in anywhere(), way in prop::array::uniform6(-1.0..1.0_f64)) {
        const STEP: f64 = 1e-4;
        for (kinematics, span) in machines() {
            let (point, way) = (inside(&span, share, [0.0; 3]), PerAxis(way));
            let at = |side: f64| kinematics.actuators(&crate::trajectory::along(&point, &way, side * STEP));
            let (before, after, speed) = (at(-1.0), at(1.0), kinematics.velocities(&point, &way));
            for actuator in Actuator::ALL {
                let measured = (after[actuator] - before[actuator]) / (2.0 * STEP);
                near(speed[actuator], measured, 1e-5 * (1.0 + measured.abs()))?;
            }
        }
    }

    #[test]
    fn an_axis_turns_its_motors_and_no_others(share in anywhere(), by in 0.5..2.0_f64) {
        for (kinematics, span) in machines() {
            let point = inside(&span, share, [0.0; 3]);
            for axis in Axis::ALL {
                let mut way = PerAxis([0.0; 6]);
                way[axis] = by;
                let speed = kinematics.velocities(&point, &way);
                for actuator in Actuator::ALL.into_iter().filter(|a| kinematics.motors_of(axis) & a.bit() == 0) {
                    prop_assert_eq!(speed[actuator], 0.0, "{} {:?} turns {:?}", kinematics.name(), axis, actuator);
                }
            }
        }
    }

    #[test]
    fn a_move_never_asks_more_of_a_motor_than_its_strain(from in anywhere(), to in anywhere()) {
        for (kinematics, span) in machines() {
            let (start, end) = (inside(&span, from, [0.0; 3]), inside(&span, to, [0.0; 3]));
            let by = PerAxis([0, 1, 2, 3, 4, 5].map(|n| end.0[n] - start.0[n]));
            let length = by.0.iter().map(|part| part * part).sum::<f64>().sqrt();
            prop_assume!(length > 0.01);
            let unit = PerAxis(by.0.map(|part| part / length));
            let Some(strain) = kinematics.strain(&start, &by, length, &Over::NONE) else { continue };
            prop_assert!(kinematics.check_line(&start, &by, length, &Over::NONE));
            let slopes = |share: f64| kinematics.velocities(&crate::trajectory::along(&start, &by, share), &unit);
            const PIECES: u32 = 300;
            for piece in 0..PIECES {
                let (here, there) = (f64::from(piece) / f64::from(PIECES), f64::from(piece + 1) / f64::from(PIECES));
                let (slope, next) = (slopes(here), slopes(there));
                for actuator in Actuator::ALL {
                    let bend = (next[actuator] - slope[actuator]).abs() / (length * (there - here));
                    let (most, worst) = (strain.slope[actuator], strain.bend[actuator]);
                    let name = kinematics.name();
                    prop_assert!(slope[actuator].abs() <= most * 1.000_1 + 1e-9, "{name} {actuator:?}: {slope:?}, {most}");
                    // Between two places of a SCARA or a rotary delta the bend may be a little more.
                    let slack = if matches!(kinematics, Kinematics::Morgan(_) | Kinematics::RotaryDelta(_)) { 1.2 } else { 1.001 };
                    prop_assert!(bend <= worst * slack + 1e-6, "{name} {actuator:?}: bends {bend}, {worst}");
                }
            }
        }
    }
}
