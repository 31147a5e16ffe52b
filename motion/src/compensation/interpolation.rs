//! Interpolation of a bed mesh: three ways from measured heights to a surface between the points of the grid.
//!
//! Each is a function of one line of heights, used along X and then along Y. None is looked up while the
//! machine moves: the surface is laid through what they give at the points of a finer grid, once, when a grid
//! comes into force.

use units::{Interpolation, MOST_SIDE};

use super::b_spline::{SIDE, Weights, natural};

/// Cells of the finer grid for each of the measured one, where there is room.
const FINER: usize = 4;
/// Least distance of the finer grid's points, mm: the distance of knots, which is bounded by it, is then the
/// same up to 500 mm/s as on a coarser grid.
const LEAST_FINE_MM: f64 = 4.0;

/// Cells of the finer grid for each between `count` points that lie `step_mm` apart.
pub(super) fn finer(way: Interpolation, count: usize, step_mm: f64) -> usize {
    let room = (MOST_SIDE - 1) / count.saturating_sub(1).max(1);
    let coarsest = if way == Interpolation::Bilinear { 2 } else { 1 };
    let finest = (libm::fabs(step_mm) / LEAST_FINE_MM) as usize;
    finest.max(coarsest).min(FINER).min(room).max(1)
}

/// Refines `count` heights at 1.. in `line` to those of the finer line, at 1..; returns their number.
pub(super) fn refine(way: Interpolation, line: &mut [f64; SIDE], count: usize, finer: usize) -> usize {
    let fine = count.saturating_sub(1) * finer + 1;
    if finer > 1 {
        prepare(way, line, count);
        let prepared = *line;
        for (index, to) in line.iter_mut().skip(1).take(fine).enumerate() {
            *to = between(way, &prepared, count, index as f64 / finer as f64);
        }
    }
    fine
}

/// Prepares a line: a spline is evaluated from its coefficients.
fn prepare(way: Interpolation, line: &mut [f64; SIDE], count: usize) {
    if way == Interpolation::Spline {
        natural(line, count);
    }
}

fn between(way: Interpolation, line: &[f64; SIDE], count: usize, place: f64) -> f64 {
    let get = |index: usize| line.get(index).copied().unwrap_or(0.0);
    // The last cell has both its ends.
    let cell = (place as usize).min(count.saturating_sub(2));
    match way {
        Interpolation::Spline => {
            let weights = Weights::of(place - cell as f64).value;
            weights.into_iter().enumerate().map(|(by, weight)| weight * get(cell + by)).sum()
        }
        Interpolation::Bilinear => {
            let share = place - cell as f64;
            (1.0 - share) * get(cell + 1) + share * get(cell + 2)
        }
        Interpolation::Lagrange => (0..count).map(|index| get(index + 1) * basis(index, count, place)).sum(),
    }
}
/// The polynomial that is one at this point of a line and zero at all others.
fn basis(index: usize, count: usize, place: f64) -> f64 {
    let others = (0..count).filter(|other| *other != index);
    others.map(|other| (place - other as f64) / (index as f64 - other as f64)).product()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const ALL: [Interpolation; 3] = [Interpolation::Spline, Interpolation::Bilinear, Interpolation::Lagrange];

    /// The height at `place` on a line of heights one apart, the first at 0: for places from 0 to the last.
    fn height_at(way: Interpolation, heights: &[f64], place: f64) -> f64 {
        let mut line = [0.0; SIDE];
        for (to, height) in line.iter_mut().skip(1).zip(heights) {
            *to = *height;
        }
        let count = heights.len().min(MOST_SIDE);
        prepare(way, &mut line, count);
        between(way, &line, count, place)
    }

    fn lines() -> impl Strategy<Value = (Interpolation, std::vec::Vec<f64>)> {
        (0..3_usize).prop_flat_map(|way| {
            let way = ALL[way];
            (Just(way), prop::collection::vec(-0.5..0.5_f64, 2..way.most_points().min(20) + 1))
        })
    }

    proptest! {
        #[test]
        fn each_goes_through_the_points_and_has_no_jump((way, heights) in lines(), at in 0.0..1.0_f64) {
            for (index, height) in heights.iter().enumerate() {
                prop_assert!((height_at(way, &heights, index as f64) - height).abs() < 1e-12);
            }
            let place = at * (heights.len() - 1) as f64;
            let near = (place + 1e-7).min((heights.len() - 1) as f64);
            prop_assert!((height_at(way, &heights, place) - height_at(way, &heights, near)).abs() < 1e-5);
        }

        #[test]
        fn each_keeps_a_straight_line(way in 0..3_usize, count in 2..7_usize, a in -1.0..1.0_f64, b in -1.0..1.0_f64, at in 0.0..1.0_f64) {
            let heights: std::vec::Vec<f64> = (0..count).map(|index| a + b * index as f64).collect();
            let place = at * (count - 1) as f64;
            prop_assert!((height_at(ALL[way], &heights, place) - (a + b * place)).abs() < 1e-12);
        }

        #[test]
        fn a_polynomial_is_found_again(factors in prop::array::uniform6(-0.1..0.1_f64), at in 0.0..5.0_f64) {
            let of = |x: f64| factors.iter().rev().fold(0.0, |sum, factor| sum * x + factor);
            let heights: [f64; 6] = core::array::from_fn(|index| of(index as f64));
            let found = height_at(Interpolation::Lagrange, &heights, at);
            prop_assert!((found - of(at)).abs() < 1e-10 * (1.0 + of(5.0).abs()), "{found} for {}", of(at));
        }

        #[test]
        fn the_spline_bends_without_a_jump(heights in prop::collection::vec(-0.5..0.5_f64, 4..20), point in 1..3_usize) {
            let way = Interpolation::Spline;
            let (here, by) = (point as f64, 1e-3);
            let z = |offset: f64| height_at(way, &heights, here + offset);
            let bend = |middle: f64| (z(middle + by) - 2.0 * z(middle) + z(middle - by)) / (by * by);
            // Just before and just after the point: by the third derivative, not by a jump.
            prop_assert!((bend(-2.0 * by) - bend(2.0 * by)).abs() < 0.2, "{} {}", bend(-2.0 * by), bend(2.0 * by));
        }

        #[test]
        fn straight_lines_never_leave_the_heights_of_their_ends(heights in prop::collection::vec(-0.5..0.5_f64, 2..20), at in 0.0..1.0_f64) {
            let place = at * (heights.len() - 1) as f64;
            let (a, b) = (heights[place as usize], heights[(place.ceil() as usize).min(heights.len() - 1)]);
            let found = height_at(Interpolation::Bilinear, &heights, place);
            prop_assert!(a.min(b) - 1e-12 <= found && found <= a.max(b) + 1e-12);
        }

        #[test]
        fn a_finer_line_has_the_heights_of_the_function((way, heights) in lines(), finer in 1..5_usize) {
            prop_assume!((heights.len() - 1) * finer < MOST_SIDE);
            let mut line = [0.0; SIDE];
            line[1..=heights.len()].copy_from_slice(&heights);
            let count = refine(way, &mut line, heights.len(), finer);
            prop_assert_eq!(count, (heights.len() - 1) * finer + 1);
            for (index, found) in line[1..=count].iter().enumerate() {
                prop_assert!((found - height_at(way, &heights, index as f64 / finer as f64)).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn finer_grids_have_room_and_no_needless_points() {
        for way in ALL {
            for count in 2..=way.most_points() {
                for step in [1.0, 3.9, 8.0, -40.0] {
                    let finer = finer(way, count, step);
                    assert!((count - 1) * finer < MOST_SIDE, "{way:?} {count} {step}");
                    assert!((1..=4).contains(&finer) && (way != Interpolation::Bilinear || finer > 1));
                }
            }
        }
        assert_eq!(finer(Interpolation::Spline, 50, 10.0), 1);
        assert_eq!(finer(Interpolation::Spline, 5, 25.0), 4);
    }
}
