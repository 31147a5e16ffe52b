//! Part of a grid that suffices for the objects of a job.

use motion::GridShape;

/// Least number of points along a side, if the whole grid has as many: fewer show no bend.
const LEAST_POINTS: usize = 3;
/// Least width of a part, mm, if the whole grid is as wide.
const LEAST_MM: f64 = 20.0;

/// A rectangle: least and greatest X and Y, mm.
pub type Area = [[f64; 2]; 2];

/// Returns the rectangle that a grid lies in.
pub fn area_of(shape: &GridShape) -> Area {
    let ([ax, ay], [bx, by]) = (shape.place(0), shape.place(shape.points().saturating_sub(1)));
    [[ax.min(bx), ay.min(by)], [ax.max(bx), ay.max(by)]]
}

/// Returns the part of a grid that covers `wanted`: at least as dense as the whole, and within it. `None` if
/// they have nothing in common.
pub fn part_of(whole: &GridShape, wanted: &Area) -> Option<GridShape> {
    let within = area_of(whole);
    if wanted.iter().flatten().any(|place| place.is_nan()) {
        return None;
    }
    let mut part = *whole;
    for axis in 0..2 {
        let get = |place: [f64; 2]| place.get(axis).copied().unwrap_or(0.0);
        let (least, most) = (get(within[0]), get(within[1]));
        let (mut low, mut high) = (get(wanted[0]).max(least), get(wanted[1]).min(most));
        if low > high {
            return None;
        }
        let least_width = LEAST_MM.min(most - least);
        if high - low < least_width {
            low = (0.5 * (low + high - least_width)).max(least).min(most - least_width);
            high = low + least_width;
        }
        let (count, step) = (whole.count.get(axis).copied()?, get(whole.step));
        let cells = libm::ceil((high - low) / libm::fabs(step) - 1e-9) as usize;
        let points = (cells + 1).max(LEAST_POINTS).min(count);
        let apart = (high - low) / (points - 1) as f64;
        let back = step < 0.0;
        set(&mut part.origin, axis, if back { high } else { low });
        set(&mut part.step, axis, if back { -apart } else { apart });
        set(&mut part.count, axis, points);
    }
    Some(part)
}

fn set<T>(pair: &mut [T; 2], axis: usize, value: T) {
    if let Some(slot) = pair.get_mut(axis) {
        *slot = value;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const WHOLE: GridShape = GridShape { origin: [10.0, 20.0], step: [30.0, 40.0], count: [7, 5] };

    #[test]
    fn a_part_has_as_dense_points_and_never_too_few() {
        let part = part_of(&WHOLE, &[[50.0, 60.0], [120.0, 150.0]]).expect("it lies within");
        assert_eq!((part.origin, part.count), ([50.0, 60.0], [4, 4]));
        assert_eq!(area_of(&part), [[50.0, 60.0], [120.0, 150.0]]);
        // A small area in a corner is widened, and stays on the bed.
        let part = part_of(&WHOLE, &[[0.0, 0.0], [12.0, 22.0]]).expect("it touches");
        assert_eq!((area_of(&part), part.count), ([[10.0, 20.0], [30.0, 40.0]], [3, 3]));
        let part = part_of(&WHOLE, &[[185.0, 100.0], [189.0, 101.0]]).expect("it lies within");
        assert_eq!((area_of(&part), part.count), ([[170.0, 90.5], [190.0, 110.5]], [3, 3]));
        assert_eq!(part_of(&WHOLE, &[[300.0, 0.0], [310.0, 100.0]]), None);
        assert_eq!(part_of(&WHOLE, &[[f64::NAN, 0.0], [310.0, 100.0]]), None);
        assert_eq!(part_of(&WHOLE, &[[-1e9, -1e9], [1e9, 1e9]]), Some(WHOLE));
    }

    proptest! {
        #[test]
        fn a_part_lies_within_covers_what_is_wanted_and_is_no_coarser(
            at in prop::array::uniform2(-50.0..250.0_f64), size in prop::array::uniform2(0.0..200.0_f64),
            back in any::<bool>(), count in prop::array::uniform2(2_usize..9),
        ) {
            let (origin, step) = if back { ([190.0, 180.0], [-30.0, -25.0]) } else { ([10.0, 20.0], [30.0, 40.0]) };
            let whole = GridShape { origin, step, count };
            let wanted = [at, [at[0] + size[0], at[1] + size[1]]];
            let (all, Some(part)) = (area_of(&whole), part_of(&whole, &wanted)) else { return Ok(()) };
            let found = area_of(&part);
            for axis in 0..2 {
                prop_assert!(found[0][axis] >= all[0][axis] - 1e-9 && found[1][axis] <= all[1][axis] + 1e-9, "{found:?}");
                prop_assert!(found[0][axis] <= wanted[0][axis].max(all[0][axis]) + 1e-9);
                prop_assert!(found[1][axis] >= wanted[1][axis].min(all[1][axis]) - 1e-9);
                prop_assert!(part.step[axis].abs() <= whole.step[axis].abs() + 1e-9 && part.step[axis] * whole.step[axis] > 0.0);
                prop_assert!(part.count[axis] >= whole.count[axis].min(3) && part.count[axis] <= whole.count[axis]);
            }
        }
    }
}
