//! Three point leveling: the plane through three touches.

use base::failure::{Answer, Failure, Outcome};
use motion::Plane;
use motion::compensation::Bed as Shape;
use units::{Axis, AxisSet};

use super::points::{clear_of, find_bed, nozzle_over, probe_point};
use super::search::check_homed;
use crate::homing;
use crate::leveling;
use crate::probing::ProbeHands;

/// Least area of the triangle, mm^2, whose corners tell a plane.
const LEAST_AREA: f64 = 1.0;

/// G29: touches the three points and reports their heights.
pub(super) fn measure_three_points<'c>(hands: &mut impl ProbeHands<'c>) -> Outcome {
    check_homed(hands)?;
    let height = hands.position()[Axis::Z];
    touch_three_points(hands, height)?;
    Ok(Answer::Ok)
}

/// G31: reports the plane in force.
pub(super) fn show_plane<'c>(hands: &mut impl ProbeHands<'c>) -> Answer {
    match hands.motion(|motion| motion.compensation().bed()) {
        Shape::Plane(plane) => {
            hands.say(format_args!("Bed leveling plane: Z = {:.6} X + {:.6} Y + {:.4}\n", plane.x, plane.y, plane.z));
        }
        Shape::Grid => hands.say(format_args!("Bed leveling plane is not set: a grid levels the bed\n")),
        Shape::Flat => hands.say(format_args!("Bed leveling plane is not set\n")),
    }
    let inputs = hands.inputs();
    let touches = hands.tuning().probe_touches(inputs);
    hands.say(format_args!("Probe is {}\n", if touches { "Triggered" } else { "Not triggered" }));
    Answer::Ok
}

/// G32: sets Z by the first touch; the plane through all three levels the bed.
pub(super) fn level_by_three_points<'c>(hands: &mut impl ProbeHands<'c>) -> Outcome {
    let (config, bed, probe) = (hands.config(), *hands.bed(), hands.tuning().probe);
    // The points are checked before anything moves.
    plane_through(&bed.points, [0.0; 3])?;
    leveling::take_off(hands)?;
    if config.leveling.home_first {
        homing::home(hands, AxisSet::of(Axis::X).with(Axis::Y))?;
    }
    let from = hands.position()[Axis::Z];
    let first = find_bed(hands, nozzle_over(&bed, bed.points[0]), from)?;
    // The height of the probe's contact is known, so that of the machine is.
    let offset = bed.probe_offsets[2];
    let mut position = hands.position();
    position[Axis::Z] += offset - first[Axis::Z];
    hands.set_position(position)?;
    hands.declare_homed(AxisSet::of(Axis::Z));
    let touches = touch_three_points(hands, clear_of(&probe, offset))?;
    let heights = touches.map(|touch| touch[2] - offset);
    if spread(heights) <= config.leveling.tolerance.0 {
        hands.say(format_args!("The bed is flat, nothing to level\n"));
        return Ok(Answer::Ok);
    }
    let plane = plane_through(&bed.points, heights)?;
    leveling::adopt_plane(hands, plane)?;
    Ok(show_plane(hands))
}

/// Touches the points; returns X and Y of the points, Z of the contacts.
fn touch_three_points<'c>(hands: &mut impl ProbeHands<'c>, height: f64) -> Result<[[f64; 3]; 3], Failure> {
    let bed = *hands.bed();
    let mut touches = [[0.0; 3]; 3];
    for (touch, point) in touches.iter_mut().zip(bed.points) {
        let contact = probe_point(hands, nozzle_over(&bed, point), height)?;
        *touch = [point[0], point[1], contact[Axis::Z]];
        // The report has the way down, as Smoothieware's.
        hands.say(format_args!("X:{:.4} Y:{:.4} Z:{:.4}\n", touch[0], touch[1], height - touch[2]));
        hands.drain();
    }
    hands.say(format_args!("max delta: {:.6}\n", spread(touches.map(|touch| touch[2]))));
    Ok(touches)
}

/// Returns the plane that has these heights at these points. Fails when they stand in a row.
fn plane_through([a, b, c]: &[[f64; 2]; 3], [za, zb, zc]: [f64; 3]) -> Result<Plane, Failure> {
    let area = (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1]);
    if libm::fabs(area) < LEAST_AREA {
        return Err(Failure::refused(&"the three points stand in a row: set point1 to point3, or M557"));
    }
    let x = ((zb - za) * (c[1] - a[1]) - (zc - za) * (b[1] - a[1])) / area;
    let y = ((zc - za) * (b[0] - a[0]) - (zb - za) * (c[0] - a[0])) / area;
    Ok(Plane { x, y, z: za - x * a[0] - y * a[1] })
}

fn spread(heights: [f64; 3]) -> f64 {
    let (mut least, mut most) = (f64::INFINITY, f64::NEG_INFINITY);
    for height in heights {
        least = if height < least { height } else { least };
        most = if height > most { height } else { most };
    }
    most - least
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn the_plane_goes_through_its_points(
            heights in proptest::array::uniform3(-2.0..2.0_f64), x in -200.0..200.0_f64, y in -200.0..200.0_f64,
            width in 20.0..300.0_f64, depth in 20.0..300.0_f64,
        ) {
            let points = [[x, y], [x + width, y], [x, y + depth]];
            let plane = plane_through(&points, heights).expect("a triangle");
            for ([x, y], height) in points.into_iter().zip(heights) {
                prop_assert!((plane.x * x + plane.y * y + plane.z - height).abs() < 1e-9);
            }
        }
    }

    #[test]
    fn points_in_a_row_tell_no_plane() {
        assert!(plane_through(&[[0.0, 0.0], [50.0, 50.0], [100.0, 100.0]], [0.0; 3]).is_err());
    }
}
