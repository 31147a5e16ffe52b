use base::bench::words;
use base::failure::Texts;
use base::hands::Hands;
use config::{Leveling, LevelingConfig};
use motion::GridShape;
use units::{Axis, Mm, PerAxis};

use super::grid::{around, configured, extrapolate};
use super::grid_file::Header;
use super::words::plane_words;
use super::{bed_plane, grid_point, level_off, mesh_offset, skew};
use crate::bench::{Bench, PROBE, machine};

fn cartesian(count: [u8; 2]) -> (LevelingConfig, GridShape) {
    let mut leveling = LevelingConfig { strategy: Some(Leveling::CartesianGrid), ..LevelingConfig::default() };
    (leveling.grid.size, leveling.grid.count) = ([Mm(100.0), Mm(-60.0)], count);
    let shape = configured(&leveling).expect("a grid");
    (leveling, shape)
}

#[test]
fn the_configured_grid_begins_at_its_start_and_ends_at_its_size() {
    let (mut leveling, shape) = cartesian([5, 4]);
    assert_eq!(shape.place(0), [0.0, 0.0]);
    assert_eq!(shape.place(19), [100.0, -60.0]);
    leveling.grid.start = [Mm(30.0), Mm(70.0)];
    let shape = configured(&leveling).expect("a grid");
    assert_eq!([shape.place(0), shape.place(19)], [[30.0, 70.0], [130.0, 10.0]]);
    leveling.grid.two_corners = true;
    assert_eq!(configured(&leveling), None);
    leveling.strategy = Some(Leveling::ThreePoint);
    assert_eq!(configured(&leveling), None);
    let round = around(50.0, 5);
    assert_eq!((round.place(0), round.place(12), round.place(24)), ([-50.0; 2], [0.0; 2], [50.0; 2]));
}

#[test]
fn headers_are_those_of_smoothieware_and_tell_what_differs() {
    let (_, square) = cartesian([5, 5]);
    let (_, oblong) = cartesian([5, 4]);
    let header = |shape| Header::of(Leveling::CartesianGrid, shape);
    assert!(header(&square).matches(&Texts::new(), Leveling::CartesianGrid, &square).is_ok());
    assert!(header(&oblong).matches(&Texts::new(), Leveling::CartesianGrid, &oblong).is_ok());
    let (_, other) = cartesian([7, 4]);
    assert!(header(&other).matches(&Texts::new(), Leveling::CartesianGrid, &oblong).is_err());
    let wide = GridShape { step: [26.0, -20.0], ..oblong };
    assert!(header(&wide).matches(&Texts::new(), Leveling::CartesianGrid, &oblong).is_err());
    let (small, large) = (around(40.0, 5), around(50.0, 5));
    let found = Header::of(Leveling::DeltaGrid, &large)
        .matches(&Texts::new(), Leveling::DeltaGrid, &small)
        .expect("any radius");
    assert_eq!(found, (large, true));
    assert_eq!(
        Header::of(Leveling::DeltaGrid, &small).matches(&Texts::new(), Leveling::DeltaGrid, &small),
        Ok((small, false))
    );
}

#[test]
fn corners_that_no_probe_reaches_go_on_from_inside() {
    let shape = around(60.0, 7);
    let plane = |index: usize| {
        let [x, y] = shape.place(index);
        (0.001 * x - 0.002 * y + 0.1) as f32
    };
    let is_reached = |index: usize| {
        let [x, y] = shape.place(index);
        x * x + y * y <= 60.0 * 60.0
    };
    let mut heights: std::vec::Vec<f32> =
        (0..shape.points()).map(|index| if is_reached(index) { plane(index) } else { f32::NAN }).collect();
    assert!(heights.iter().any(|height| height.is_nan()));
    extrapolate(&shape, &mut heights);
    for (index, height) in heights.iter().enumerate() {
        assert!((height - plane(index)).abs() < 1e-5, "point {index}: {height}");
    }
    // A spike just inside does not spread, since the median leaves it out.
    let mut spiked: std::vec::Vec<f32> =
        (0..shape.points()).map(|index| if is_reached(index) { 0.0 } else { f32::NAN }).collect();
    spiked[8] = 1.0;
    extrapolate(&shape, &mut spiked);
    assert!(spiked.iter().all(|height| height.is_finite()));
    let mut nothing = std::vec![f32::NAN; shape.points()];
    extrapolate(&shape, &mut nothing);
    assert!(nothing.iter().all(|height| height.is_nan()));
}

#[test]
fn planes_that_smoothieware_saved_are_read_to_the_last_bit() {
    let numbers = [-0.012_345_f32, 0.003, 0.999_9, -1.5];
    let saved = numbers.map(|number| f64::from(number.to_bits()));
    assert_eq!(plane_words(saved), numbers.map(f64::from));
    let signed = numbers.map(|number| f64::from(number.to_bits() as i32));
    assert_eq!(plane_words(signed), numbers.map(f64::from));
    let plain = [-0.01, 0.02, 1.0, -3.0];
    assert_eq!(plane_words(plain), plain);
    assert_eq!(plane_words([0.0, 0.0, 1.0, 0.0]), [0.0, 0.0, 1.0, 0.0]);
}

/// A machine that is leveled by a grid of 3 by 3 heights, 0 but for those that are set.
fn leveled(set: &[&str]) -> Bench {
    let mut bench = machine(
        &format!(
            "{PROBE}leveling = cartesian grid\n[cartesian grid leveling strategy]\nx_size = 40\ny_size = 20\n\
             grid_x_size = 3\ngrid_y_size = 3\n"
        ),
        [-30.0; 3],
    );
    for line in set {
        grid_point(&mut bench, &words(line)).unwrap();
    }
    bench
}

/// Returns the correction of Z at X and Y.
fn lift(bench: &mut Bench, x: f64, y: f64) -> f64 {
    let mut place = PerAxis::default();
    (place[Axis::X], place[Axis::Y]) = (x, y);
    bench.motion(|motion| motion.compensation().motors(&place))[Axis::Z]
}

fn about(value: f64, wanted: f64) -> bool {
    (value - wanted).abs() < 1e-5
}

#[test]
fn a_point_of_the_grid_is_named_by_column_and_row_place_or_tool() {
    for line in ["M421 I2 J1 Z0.5", "M421 X38 Y11 Z0.5", "M421 C Z0.5"] {
        let mut bench = leveled(&[]);
        bench.stand_at([34.0, 8.0, 0.0]);
        grid_point(&mut bench, &words(line)).unwrap();
        assert!(about(lift(&mut bench, 40.0, 10.0), 0.5), "{line}");
        for (x, y) in [(20.0, 10.0), (40.0, 0.0), (40.0, 20.0), (0.0, 10.0)] {
            assert!(about(lift(&mut bench, x, y), 0.0), "{line} at X{x} Y{y}");
        }
    }
    let mut bench = leveled(&["M421 I1 J1 Z0.5", "M421 I1 J1 Q-0.2"]);
    assert!(about(lift(&mut bench, 20.0, 10.0), 0.3), "Q is added");
    for wrong in ["M421 I3 J0 Z1", "M421 I1 Z1", "M421 I1 J1", "M421 I1 J1 Z1 Q1"] {
        assert!(grid_point(&mut bench, &words(wrong)).is_err(), "{wrong}");
    }
    assert!(about(lift(&mut bench, 20.0, 10.0), 0.3), "what is refused changes nothing");
}

#[test]
fn a_mesh_that_is_moved_has_its_heights_elsewhere_and_comes_back() {
    let mut bench = leveled(&["M421 I1 J1 Z0.5"]);
    mesh_offset(&mut bench, &words("M420.1 X5 Y-4")).unwrap();
    let [x, y] = bench.bed().mesh_offset;
    assert_eq!([x, y], [5.0, -4.0]);
    assert!(about(lift(&mut bench, 15.0, 14.0), 0.5), "looked up at this distance");
    assert!(!about(lift(&mut bench, 20.0, 10.0), 0.5));
    mesh_offset(&mut bench, &words("M420.1 X0 Y0")).unwrap();
    assert!(about(lift(&mut bench, 20.0, 10.0), 0.5));
}

#[test]
fn switching_leveling_off_leaves_the_bed_flat() {
    let mut bench = leveled(&["M421 I1 J1 Z0.5"]);
    level_off(&mut bench).unwrap();
    assert!(bench.heard().contains("grid cleared and disabled"));
    assert_eq!(lift(&mut bench, 20.0, 10.0), 0.0);
}

#[test]
fn a_skew_is_set_and_a_square_alone_is_only_reckoned() {
    let mut bench = leveled(&[]);
    skew(&mut bench, &words("M852 I0.01 K-0.002")).unwrap();
    let set = bench.motion(|motion| motion.compensation().skew());
    assert_eq!((set.xy, set.xz, set.yz), (0.01, 0.0, -0.002));
    bench.heard();
    skew(&mut bench, &words("M852.1 A141.4 B141.4 D100")).unwrap();
    assert!(bench.heard().contains("a factor of 0.0000"), "a square leans nowhere");
    assert_eq!(bench.motion(|motion| motion.compensation().skew()), set, "and nothing was changed");
    let mut place = PerAxis::default();
    place[Axis::Y] = 100.0;
    let motors = bench.motion(|motion| motion.compensation().motors(&place));
    assert!((motors[Axis::X].abs() - 1.0).abs() < 0.02, "a hundredth of Y: {motors:?}");
}

#[test]
fn the_plane_of_other_firmwares_is_read_in_both_its_forms() {
    let plane = bed_plane(&mut leveled(&[]), &words("M561 A1 B2 C3"));
    assert!(plane.is_err(), "D is missing");
    let mut bench = leveled(&[]);
    bed_plane(&mut bench, &words("M561 A-0.01 B0.02 C1 D-0.3")).unwrap();
    let [middle, right, rear] = [(0.0, 0.0), (10.0, 0.0), (0.0, 10.0)].map(|(x, y)| lift(&mut bench, x, y));
    assert!((right - middle).abs() > 0.09 && (rear - middle).abs() > 0.19, "{middle} {right} {rear}");
    assert!((right - middle) * (rear - middle) < 0.0);
}
