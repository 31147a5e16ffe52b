use std::boxed::Box;

use proptest::prelude::*;

use super::*;
use crate::oracle::Warp;

/// Grids of any size with gentle and rough heights, and what lies between.
pub fn grids() -> impl Strategy<Value = (GridShape, std::vec::Vec<f32>, Interpolation)> {
    let side = || prop_oneof![2_usize..9, Just(MOST_SIDE)];
    let step = || (1.5..40.0_f64, any::<bool>()).prop_map(|(step, back)| if back { -step } else { step });
    let shape = (side(), side(), step(), step(), -100.0..100.0_f64, -100.0..100.0_f64);
    shape.prop_flat_map(|(nx, ny, sx, sy, x, y)| {
        let way = prop::sample::select(&[Interpolation::Spline, Interpolation::Bilinear, Interpolation::Lagrange][..]);
        way.prop_flat_map(move |way| {
            let count = [nx, ny].map(|count| count.min(way.most_points()));
            let shape = GridShape { origin: [x, y], step: [sx, sy], count };
            // A polynomial swings higher than its points.
            let steep = if way == Interpolation::Lagrange { 0.02 } else { 0.1 };
            let most = (steep * sx.abs().min(sy.abs())).min(0.5) as f32;
            (Just(shape), prop::collection::vec(-most..most, shape.points()), Just(way))
        })
    })
}

fn flat() -> Compensation {
    Compensation::new(Box::default())
}

fn compensation(shape: &GridShape, heights: &[f32], way: Interpolation, fade: Option<Fade>) -> Compensation {
    let mut compensation = flat();
    compensation.draft()[..heights.len()].copy_from_slice(heights);
    let mut fade = fade;
    // As long as these heights need.
    while let Err(error) = compensation.set_grid(shape, way, fade) {
        assert!(matches!(error, CompensationError::FadeShort { .. }), "{error}");
        fade = fade.map(|fade| Fade { end: fade.end + (fade.end - fade.start), ..fade });
    }
    compensation
}

/// A place in or around a grid.
fn place(shape: &GridShape, [u, v]: [f64; 2]) -> [f64; 2] {
    let at = |axis: usize, share: f64| {
        shape.origin[axis] + shape.step[axis] * (share * (shape.count[axis] as f64 + 5.0) - 3.0)
    };
    [at(0, u), at(1, v)]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn the_surface_goes_through_its_points_and_is_what_the_reference_says(
        (shape, heights, way) in grids(), places in prop::collection::vec(prop::array::uniform2(0.0..1.0_f64), 20),
    ) {
        let compensation = compensation(&shape, &heights, way, None);
        let warp = Warp::of(&compensation).expect("it levels");
        for (index, height) in heights.iter().enumerate() {
            let [x, y] = shape.place(index);
            prop_assert!((compensation.height(x, y).z - f64::from(*height)).abs() < 1e-12);
        }
        for [x, y] in places.into_iter().map(|at| place(&shape, at)) {
            let (ours, theirs) = (compensation.height(x, y).z, warp.height(x, y));
            prop_assert!((ours - theirs).abs() < 1e-12, "{ours} is not {theirs} at {x} {y}");
        }
    }

    #[test]
    fn slopes_are_those_of_the_surface_and_bounds_hold(
        (shape, heights, between) in grids(), places in prop::collection::vec(prop::array::uniform2(0.0..1.0_f64), 20), way in prop::array::uniform2(-3.0..3.0_f64),
    ) {
        let compensation = compensation(&shape, &heights, between, None);
        let step = 1e-4;
        for [x, y] in places.into_iter().map(|at| place(&shape, at)) {
            let (here, z) = (compensation.height(x, y), |dx, dy| compensation.height(x + dx, y + dy));
            let slope = [z(step, 0.0).z - z(-step, 0.0).z, z(0.0, step).z - z(0.0, -step).z].map(|rise| rise / (2.0 * step));
            prop_assert!((here.slope[0] - slope[0]).abs() < 1e-6 && (here.slope[1] - slope[1]).abs() < 1e-6);
            let (to, length) = ([x + way[0], y + way[1]], way[0].hypot(way[1]));
            let (from, to) = (PerAxis([x, y, 0.0, 0.0, 0.0, 0.0]), PerAxis([to[0], to[1], 0.0, 0.0, 0.0, 0.0]));
            let lift = compensation.over_line(&from, &to).lift.expect("it levels");
            let unit = [way[0] / length, way[1] / length, 0.0];
            let rate = |height: Height| height.slope[0] * unit[0] + height.slope[1] * unit[1];
            let ahead = z(step * unit[0], step * unit[1]);
            prop_assert!(rate(here).abs() <= lift.slope_along(&unit) + 1e-12);
            prop_assert!((rate(ahead) - rate(here)).abs() / step <= lift.bend_along(&unit) + 1e-9);
            prop_assert!(lift.low - 1e-12 <= here.z && here.z <= lift.high + 1e-12);
            prop_assert!(lift.slope_along(&unit) <= lift.slope() + 1e-12 && lift.bend_along(&unit) <= lift.bend() + 1e-12);
        }
    }

    #[test]
    fn a_plane_through_a_grid_stays_a_plane_and_the_outside_lies_flat(
        (shape, _, way) in grids(), a in -0.1..0.1_f64, b in -0.1..0.1_f64, at in prop::array::uniform2(0.0..1.0_f64),
    ) {
        // 25 mm at most over the widest grid.
        let widest = shape.step[0].abs().max(shape.step[1].abs()) * MOST_SIDE as f64;
        let (a, b) = (a * (100.0 / widest).min(1.0), b * (100.0 / widest).min(1.0));
        let z = |[x, y]: [f64; 2]| a * (x - shape.origin[0]) + b * (y - shape.origin[1]);
        let heights: std::vec::Vec<f32> = (0..shape.points()).map(|index| z(shape.place(index)) as f32).collect();
        let compensation = compensation(&shape, &heights, way, None);
        let inside = |axis: usize| shape.origin[axis] + shape.step[axis] * at[axis] * (shape.count[axis] - 1) as f64;
        let (x, y) = (inside(0), inside(1));
        prop_assert!((compensation.height(x, y).z - z([x, y])).abs() < 1e-5, "single precision is in the heights");
        let far = compensation.height(shape.origin[0] - 3.001 * shape.step[0], y);
        let farther = compensation.height(shape.origin[0] - 90.0 * shape.step[0], y);
        prop_assert_eq!(far.z, farther.z);
        prop_assert_eq!(far.slope[0], 0.0);
        let edge = compensation.height(shape.origin[0], y);
        prop_assert!((far.z - edge.z).abs() < 1e-12, "outside the edge's height goes on");
    }

    #[test]
    fn every_place_is_found_back(
        (shape, heights, way) in grids(), at in prop::array::uniform3(0.0..1.0_f64), faded in any::<bool>(), length in 2.5..30.0_f64,
        target in -0.3..0.3_f64, factors in prop::array::uniform3(-0.1..0.1_f64),
    ) {
        let fade = faded.then_some(Fade { start: 1.0, end: 1.0 + length, target });
        let mut compensation = compensation(&shape, &heights, way, fade);
        let [xy, xz, yz] = factors;
        compensation.set_skew(Skew { xy, xz, yz }).expect("within bounds");
        let [x, y] = place(&shape, [at[0], at[1]]);
        let there = PerAxis([x, y, at[2] * (length + 4.0) - 1.0, 7.0, 8.0, 9.0]);
        let back = compensation.program(&compensation.motors(&there));
        for (one, other) in there.0.iter().zip(back.0) {
            prop_assert!((one - other).abs() < 1e-9, "{there:?} became {back:?}");
        }
        let theirs = Warp::of(&compensation).expect("it levels").motors(&there.0);
        for (one, other) in compensation.motors(&there).0.iter().zip(theirs) {
            prop_assert!((one - other).abs() < 1e-10);
        }
    }
}

#[test]
fn what_is_no_surface_is_refused_and_changes_nothing() {
    let shape = GridShape { origin: [0.0; 2], step: [10.0, 10.0], count: [3, 3] };
    let way = Interpolation::Spline;
    let mut good = compensation(&shape, &[0.1; 9], way, None);
    let with = |good: &mut Compensation, index: usize, height: f32, shape: &GridShape| {
        let draft = good.draft();
        draft[..9].fill(0.2);
        draft[index] = height;
        good.set_grid(shape, way, None)
    };
    assert_eq!(with(&mut good, 4, f32::NAN, &shape), Err(CompensationError::NotMeasured { point: 4 }));
    assert_eq!(with(&mut good, 4, -26.0, &shape), Err(CompensationError::TooHigh { point: 4 }));
    assert_eq!(with(&mut good, 4, 3.0, &shape), Err(CompensationError::TooSteep { point: 4 }));
    assert_eq!(with(&mut good, 8, 0.2, &GridShape { count: [1, 9], ..shape }), Err(CompensationError::Count));
    assert_eq!(with(&mut good, 8, 0.2, &GridShape { count: [3, 51], ..shape }), Err(CompensationError::Count));
    let many = GridShape { count: [3, 7], ..shape };
    let refused = good.set_grid(&many, Interpolation::Lagrange, None);
    assert_eq!(refused, Err(CompensationError::Interpolation { most: 6 }));
    assert_eq!(with(&mut good, 8, 0.2, &GridShape { step: [0.5, 10.0], ..shape }), Err(CompensationError::Spacing));
    assert_eq!(with(&mut good, 8, 0.2, &GridShape { origin: [f64::NAN, 0.0], ..shape }), Err(CompensationError::Place));
    assert_eq!(good.set_skew(Skew { xy: 0.2, ..Skew::NONE }), Err(CompensationError::Skew));
    assert_eq!(good.set_skew(Skew { xy: f64::NAN, ..Skew::NONE }), Err(CompensationError::Skew));
    assert_eq!(good.set_plane(Plane { x: 0.3, y: 0.0, z: 0.0 }), Err(CompensationError::PlaneSteep));
    assert_eq!(good.set_plane(Plane { x: 0.0, y: 0.0, z: 30.0 }), Err(CompensationError::PlaneHigh));
    assert!((good.height(10.0, 10.0).z - 0.1).abs() < 1e-7, "what was in force still is");
    assert_eq!(Plane::from_equation([0.0, 0.0, 0.0, 1.0]), None);
    assert_eq!(Plane::from_equation([-0.1, 0.2, 1.0, -3.0]), Some(Plane { x: 0.1, y: -0.2, z: 3.0 }));
}

#[test]
fn a_copy_is_the_same_surface() {
    let shape = GridShape { origin: [0.0; 2], step: [20.0, 20.0], count: [3, 3] };
    for way in [Interpolation::Spline, Interpolation::Bilinear, Interpolation::Lagrange] {
        let one = compensation(&shape, &[0.0, 0.1, 0.0, 0.2, 0.3, 0.1, 0.0, 0.1, 0.2], way, None);
        let mut other = flat();
        other.copy(&one);
        for (x, y) in [(7.0, 9.0), (33.0, 21.0), (-30.0, 5.0), (60.0, 60.0)] {
            assert_eq!(other.height(x, y), one.height(x, y), "{way:?}");
        }
        assert_eq!(other.grid().map(Surface::interpolation), Some(way));
    }
}
