//! Grids of heights: their place by the configuration, and the heights of points that no probe reaches.

use config::{Leveling, LevelingConfig};
use motion::GridShape;

/// Returns the grid that the configuration describes; `None` without a grid strategy, or when its area comes
/// with each probing.
pub fn configured(leveling: &LevelingConfig) -> Option<GridShape> {
    let apart = |size: f64, count: u8| size / f64::from(count.saturating_sub(1));
    match leveling.strategy? {
        Leveling::CartesianGrid if !leveling.grid.two_corners => {
            let ([x, y], [nx, ny]) = (leveling.grid.size, leveling.grid.count);
            let step = [apart(x.0, nx), apart(y.0, ny)];
            let origin = leveling.grid.start.map(|start| start.0);
            Some(GridShape { origin, step, count: [usize::from(nx), usize::from(ny)] })
        }
        Leveling::DeltaGrid => Some(around(leveling.delta.radius.0, leveling.delta.count)),
        _ => None,
    }
}

/// Returns the square grid around the middle that a circle of this radius fits in.
pub fn around(radius: f64, count: u8) -> GridShape {
    let step = 2.0 * radius / f64::from(count.saturating_sub(1));
    GridShape { origin: [-radius; 2], step: [step; 2], count: [usize::from(count); 2] }
}

/// Gives heights to the points of a square grid around the middle that have none (NaN): the median of the
/// straight continuations from the two neighbours towards the middle along X, along Y and along the diagonal.
/// From the inside outwards, so that neighbours have theirs.
///
/// A point whose neighbours have no height either keeps none; leveling refuses such a grid.
pub fn extrapolate(shape: &GridShape, heights: &mut [f32]) {
    let [nx, ny] = shape.count.map(|count| count as i32);
    // Rings around the middle are counted by the doubled distance from it.
    for ring in 0..=(nx + ny) {
        for row in 0..ny {
            for column in 0..nx {
                let (across, along) = (2 * column - (nx - 1), 2 * row - (ny - 1));
                if (across.abs() + along.abs()) / 2 == ring {
                    fill((nx, column, -across.signum()), (row, -along.signum()), heights);
                }
            }
        }
    }
}

fn fill((nx, column, inwards_x): (i32, i32, i32), (row, inwards_y): (i32, i32), heights: &mut [f32]) {
    let at = |x: i32, y: i32| usize::try_from(y * nx + x).ok().filter(|_| (0..nx).contains(&x));
    let height = |x: i32, y: i32| at(x, y).and_then(|index| heights.get(index)).copied().filter(|h| h.is_finite());
    if height(column, row).is_some() {
        return;
    }
    let mut found = heapless::Vec::<f32, 3>::new();
    for (dx, dy) in [(inwards_x, 0), (0, inwards_y), (inwards_x, inwards_y)] {
        let near = height(column + dx, row + dy).zip(height(column + 2 * dx, row + 2 * dy));
        if let (Some((near, far)), true) = (near, (dx, dy) != (0, 0)) {
            // The list has room for three directions.
            let _ = found.push(2.0 * near - far);
        }
    }
    units::sort_short(&mut found, f32::total_cmp);
    let median = match found.as_slice() {
        [] => return,
        [one] => *one,
        [one, other] => 0.5 * (one + other),
        [_, median, ..] => *median,
    };
    if let Some(slot) = at(column, row).and_then(|index| heights.get_mut(index)) {
        *slot = median;
    }
}
