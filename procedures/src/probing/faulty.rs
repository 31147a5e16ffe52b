//! Faulty regions, whose points must not be touched: heights there come from touches at the region's edges.

use heapless::Vec;

use crate::leveling::area::Area;

/// Edges of the region to the left, to the right, in front and behind a place.
pub(super) type Ends = [Option<[f64; 2]>; 4];

/// Returns the region that a place lies in, its edges not counted.
pub(super) fn region_of(place: [f64; 2], corners: &[[f64; 2]]) -> Option<Area> {
    let (regions, _) = corners.as_chunks::<2>();
    let sorted = regions.iter().map(|[[ax, ay], [bx, by]]| [[ax.min(*bx), ay.min(*by)], [ax.max(*bx), ay.max(*by)]]);
    let [x, y] = place;
    sorted.into_iter().find(|[low, high]| low[0] < x && x < high[0] && low[1] < y && y < high[1])
}

/// Returns the places to touch instead of a place in `region`: straight ahead from it at the region's edges,
/// if the mesh's area and the other regions let the probe.
pub(super) fn ends(place: [f64; 2], region: &Area, within: &Area, corners: &[[f64; 2]]) -> Ends {
    let ([x, y], [low, high]) = (place, *region);
    let candidates = [[low[0], y], [high[0], y], [x, low[1]], [x, high[1]]];
    candidates.map(|at| {
        let is_inside = (0..2).all(|axis| {
            let get = |of: [f64; 2]| of.get(axis).copied().unwrap_or(0.0);
            get(within[0]) <= get(at) && get(at) <= get(within[1])
        });
        (is_inside && region_of(at, corners).is_none()).then_some(at)
    })
}

/// Returns the height at a place from those at its ends: on a straight line between two that lie opposite, or
/// the height of a single end; nearer ends count more. `None` without any.
pub(super) fn between(place: [f64; 2], ends: &Ends, heights: &[Option<f64>; 4]) -> Option<f64> {
    let mut parts = Vec::<(f64, f64), 2>::new();
    let mut lone = Vec::<(f64, f64), 4>::new();
    let far = |index: usize| {
        let end = ends.get(index).copied().flatten()?;
        let height = heights.get(index).copied().flatten()?;
        let distance = libm::fabs(end[0] - place[0]) + libm::fabs(end[1] - place[1]);
        Some((distance, height))
    };
    for (one, other) in [(0, 1), (2, 3)] {
        match (far(one), far(other)) {
            // The list has room for all parts, here and below.
            (Some((a, left)), Some((b, right))) => parts.extend([(1.0 / (a + b), (left * b + right * a) / (a + b))]),
            (one, other) => lone.extend(one.into_iter().chain(other).map(|(a, height)| (1.0 / a, height))),
        }
    }
    let weighted = if parts.is_empty() { lone.as_slice() } else { parts.as_slice() };
    let weight: f64 = weighted.iter().map(|(weight, _)| weight).sum();
    (!weighted.is_empty()).then(|| weighted.iter().map(|(one, height)| one * height).sum::<f64>() / weight)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const BED: Area = [[0.0, 0.0], [200.0, 150.0]];
    const CORNERS: [[f64; 2]; 4] = [[40.0, 60.0], [80.0, 30.0], [150.0, 100.0], [260.0, 180.0]];

    proptest! {
        #[test]
        fn on_a_plane_the_height_is_exact_where_ends_lie_opposite(
            at in prop::array::uniform2(0.01..0.99_f64), slope in prop::array::uniform2(-0.1..0.1_f64),
        ) {
            let place = [40.0 + 40.0 * at[0], 30.0 + 30.0 * at[1]];
            let plane = |[x, y]: [f64; 2]| 0.3 + slope[0] * x + slope[1] * y;
            let region = region_of(place, &CORNERS).expect("it lies in one");
            let ends = ends(place, &region, &BED, &CORNERS);
            prop_assert!(ends.iter().all(Option::is_some));
            let heights = ends.map(|end| end.map(plane));
            let found = between(place, &ends, &heights).expect("four ends");
            prop_assert!((found - plane(place)).abs() < 1e-12, "{found}");
        }
    }

    #[test]
    fn only_what_can_be_touched_is() {
        let place = [180.0, 120.0];
        let region = region_of(place, &CORNERS).expect("it lies in one");
        let found = ends(place, &region, &BED, &CORNERS);
        assert_eq!(found, [Some([150.0, 120.0]), None, Some([180.0, 100.0]), None]);
        // The place is twenty behind the front end, thirty beside the left.
        let height = between(place, &found, &[Some(0.3), None, Some(0.6), None]).expect("two ends");
        assert!((height - (0.3 / 30.0 + 0.6 / 20.0) / (1.0 / 30.0 + 1.0 / 20.0)).abs() < 1e-12);
        assert_eq!(between(place, &[None; 4], &[None; 4]), None);
        assert_eq!(region_of([40.0, 45.0], &CORNERS), None, "the edge can be touched");
        // Regions that overlap cover each other's edges.
        let both = [[0.0, 0.0], [60.0, 60.0], [40.0, 0.0], [100.0, 60.0]];
        let region = region_of([50.0, 30.0], &both).expect("it lies in both");
        assert_eq!(
            ends([50.0, 30.0], &region, &BED, &both),
            [Some([0.0, 30.0]), None, Some([50.0, 0.0]), Some([50.0, 60.0])]
        );
    }
}
