use base::failure::Texts;
use config::{Leveling, LevelingConfig};
use motion::GridShape;
use units::Mm;

use super::grid::{around, configured, extrapolate};
use super::grid_file::Header;
use super::words::plane_words;

fn cartesian(count: [u8; 2]) -> (LevelingConfig, GridShape) {
    let mut leveling = LevelingConfig { strategy: Some(Leveling::CartesianGrid), ..LevelingConfig::default() };
    (leveling.grid.size, leveling.grid.count) = ([Mm(100.0), Mm(-60.0)], count);
    let shape = configured(&leveling).expect("a grid");
    (leveling, shape)
}

#[test]
fn the_configured_grid_begins_at_the_origin_and_ends_at_its_size() {
    let (mut leveling, shape) = cartesian([5, 4]);
    assert_eq!(shape.place(0), [0.0, 0.0]);
    assert_eq!(shape.place(19), [100.0, -60.0]);
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
