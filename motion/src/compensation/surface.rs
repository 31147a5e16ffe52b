//! A measured surface: a spline through a grid of heights.
//!
//! [`Interpolation`] gives the heights at the points of a finer grid, of up to four cells for each measured
//! one. Through those goes the natural bicubic spline, kept as coefficients of uniform cubic B-splines:
//! heights, slopes and bends are continuous everywhere, a plane stays a plane, and the greatest differences
//! of coefficients bound slopes and bends. The surface that is looked up while the machine moves has the same
//! form for every interpolation; plain bilinear patches would have a kink at each line of the grid, where a
//! motor's speed would have to jump.
//!
//! Outside the grid the heights of its edge go on: the coefficients of the border, after one more that
//! continues the slope, so that the surface turns without a kink and lies flat three fine grid distances on.

use super::{
    Fade, Interpolation, MOST_SIDE,
    b_spline::{SIDE, Weights, cell, natural},
    interpolation,
    limits::{CompensationError, LEAST_STEP, MOST_HEIGHT, MOST_POINTS, MOST_SLOPE},
};
use crate::{greatest, least};

/// Places of a grid's points. Heights are given row by row: all of the first Y, along X, then the next.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GridShape {
    /// The first point, X and Y in the program's machine space, mm.
    pub origin: [f64; 2],
    /// Distances from point to point along X and along Y, mm; negative where the grid goes the other way.
    pub step: [f64; 2],
    /// Points along X and along Y, 2 to [`MOST_SIDE`].
    pub count: [usize; 2],
}

impl GridShape {
    /// Returns the number of points.
    #[must_use]
    pub const fn points(&self) -> usize {
        self.count[0] * self.count[1]
    }

    /// Returns X and Y of the point with this index.
    #[must_use]
    pub fn place(&self, index: usize) -> [f64; 2] {
        let ([ox, oy], [sx, sy], [nx, _]) = (self.origin, self.step, self.count);
        let (column, row) = if nx > 0 { (index % nx, index / nx) } else { (0, 0) };
        [ox + sx * column as f64, oy + sy * row as f64]
    }

    /// Checks that the grid has points enough, not too many, and far enough apart.
    pub(super) fn check(&self) -> Result<(), CompensationError> {
        if !self.count.iter().all(|count| (2..=MOST_SIDE).contains(count)) {
            return Err(CompensationError::Count);
        }
        if !self.origin.iter().all(|place| place.is_finite()) {
            return Err(CompensationError::Place);
        }
        // A NaN compares false, so it is refused.
        let is_fine = |step: &f64| libm::fabs(*step) >= LEAST_STEP && step.is_finite();
        if self.step.iter().all(is_fine) { Ok(()) } else { Err(CompensationError::Spacing) }
    }
}

/// Array of heights to read.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Of {
    Draft,
    Heights,
}

/// Height and slopes of a surface at a place.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Height {
    /// Height in mm, added to Z.
    pub z: f64,
    /// Slopes for each mm along X and along Y.
    pub slope: [f64; 2],
}

/// Bounds of a surface, or of a part of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Bounds {
    /// Least height, mm.
    pub low: f64,
    /// Greatest height, mm.
    pub high: f64,
    /// Sizes of the slopes along X and Y.
    pub slope: [f64; 2],
    /// Sizes of the second derivatives: XX, YY, XY.
    pub bend: [f64; 3],
}

impl Bounds {
    /// Bounds of a flat surface.
    pub const NONE: Self = Self { low: 0.0, high: 0.0, slope: [0.0; 2], bend: [0.0; 3] };
}

const NOTHING: GridShape = GridShape { origin: [0.0; 2], step: [0.0; 2], count: [0; 2] };

/// Room for a grid, what is being gathered and what is in force. Large: it belongs where memory is plentiful.
#[derive(Debug)]
pub struct Surface {
    /// Heights being gathered, mm.
    pub(crate) draft: [f32; MOST_POINTS],
    /// Heights in force, mm.
    pub(super) heights: [f32; MOST_POINTS],
    /// Grid of the measured points.
    shape: GridShape,
    interpolation: Interpolation,
    /// The grid of the coefficients.
    pub(super) fine: GridShape,
    coefficients: [[f64; SIDE]; SIDE],
    /// Bounds of the whole surface, and of the part inside the grid.
    everywhere: Bounds,
    inside: Bounds,
}

impl Default for Surface {
    fn default() -> Self {
        Self::new()
    }
}

impl Surface {
    /// Copies the surface in force of another one. Arrays are copied in place: they are large for a stack.
    pub(super) fn copy_in_force(&mut self, other: &Self) {
        self.heights.copy_from_slice(&other.heights);
        self.coefficients.copy_from_slice(&other.coefficients);
        (self.shape, self.interpolation, self.fine) = (other.shape, other.interpolation, other.fine);
        (self.everywhere, self.inside) = (other.everywhere, other.inside);
    }

    /// Creates a surface without measured heights.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            draft: [0.0; MOST_POINTS],
            heights: [0.0; MOST_POINTS],
            shape: NOTHING,
            interpolation: Interpolation::Spline,
            fine: NOTHING,
            coefficients: [[0.0; SIDE]; SIDE],
            everywhere: Bounds::NONE,
            inside: Bounds::NONE,
        }
    }

    /// The grid in force.
    #[must_use]
    pub const fn shape(&self) -> &GridShape {
        &self.shape
    }

    /// Returns the interpolation between its points.
    #[must_use]
    pub const fn interpolation(&self) -> Interpolation {
        self.interpolation
    }

    /// The heights in force, mm, row by row.
    #[must_use]
    pub fn heights(&self) -> &[f32] {
        self.heights.get(..self.shape.points()).unwrap_or_default()
    }

    /// Puts the gathered heights in force.
    ///
    /// # Errors
    /// A mistake in the grid; the surface in force stays in force then.
    pub(super) fn adopt(
        &mut self,
        shape: &GridShape,
        interpolation: Interpolation,
        fade: Option<Fade>,
    ) -> Result<(), CompensationError> {
        shape.check()?;
        let most = interpolation.most_points();
        if shape.count.iter().any(|count| *count > most) {
            return Err(CompensationError::Interpolation { most });
        }
        check_heights(shape, &self.draft)?;
        let before = (self.shape, self.interpolation);
        (self.shape, self.interpolation) = (*shape, interpolation);
        self.fit(Of::Draft);
        if let Some(Err(flaw)) = fade.map(|fade| fade.check(self.greatest_size())) {
            (self.shape, self.interpolation) = before;
            if self.shape.points() > 0 {
                self.fit(Of::Heights);
            }
            return Err(flaw);
        }
        self.heights = self.draft;
        let [nx, ny] = self.last();
        self.inside = self.bounds([-1, nx + 1], [-1, ny + 1]);
        self.everywhere = self.bounds([-3, nx + 3], [-3, ny + 3]);
        Ok(())
    }

    /// Index of the last point of the finer grid along X and Y.
    const fn last(&self) -> [i32; 2] {
        [self.fine.count[0] as i32 - 1, self.fine.count[1] as i32 - 1]
    }

    /// Works out the finer grid and its coefficients: measured rows along X, then fine columns along Y, then
    /// rows of coefficients along X.
    fn fit(&mut self, of: Of) {
        let ([nx, ny], [sx, sy]) = (self.shape.count, self.shape.step);
        let finer = [(nx, sx), (ny, sy)].map(|(count, step)| interpolation::finer(self.interpolation, count, step));
        let heights = if of == Of::Draft { &self.draft } else { &self.heights };
        let mut line = [0.0; SIDE];
        let (mut wide, mut deep) = (nx, ny);
        for row in 0..ny {
            for (to, height) in line.iter_mut().skip(1).zip(heights.iter().skip(row * nx).take(nx)) {
                *to = f64::from(*height);
            }
            wide = interpolation::refine(self.interpolation, &mut line, nx, finer[0]);
            if let Some(coefficients) = self.coefficients.get_mut(row + 1) {
                *coefficients = line;
            }
        }
        for column in 1..=wide {
            for (to, row) in line.iter_mut().zip(&self.coefficients) {
                *to = row.get(column).copied().unwrap_or(0.0);
            }
            deep = interpolation::refine(self.interpolation, &mut line, ny, finer[1]);
            natural(&mut line, deep);
            for (row, value) in self.coefficients.iter_mut().zip(line) {
                if let Some(to) = row.get_mut(column) {
                    *to = value;
                }
            }
        }
        for row in self.coefficients.iter_mut().take(deep + 2) {
            natural(row, wide);
        }
        let step = [sx / finer[0] as f64, sy / finer[1] as f64];
        self.fine = GridShape { origin: self.shape.origin, step, count: [wide, deep] };
    }

    /// Returns a bound of the height: the greatest size of the control points of its Bezier patches.
    fn greatest_size(&self) -> f64 {
        const TO_BEZIER: [[f64; 3]; 3] =
            [[1.0 / 6.0, 4.0 / 6.0, 1.0 / 6.0], [0.0, 2.0 / 3.0, 1.0 / 3.0], [0.0, 1.0 / 3.0, 2.0 / 3.0]];
        let [nx, ny] = self.last();
        let mut most = 0.0;
        for (row, column) in (-2..=ny + 2).flat_map(|row| (-2..=nx + 2).map(move |column| (row, column))) {
            let near = [-1, 0, 1].map(|up| [-1, 0, 1].map(|right| self.coefficient(column + right, row + up)));
            for (along, across) in
                TO_BEZIER.iter().flat_map(|along| TO_BEZIER.iter().map(move |across| (along, across)))
            {
                let mut control = 0.0;
                for (weight, line) in along.iter().zip(&near) {
                    control += weight * (across[0] * line[0] + across[1] * line[1] + across[2] * line[2]);
                }
                most = greatest(most, libm::fabs(control));
            }
        }
        most
    }

    fn row(&self, index: i32, [_, ny]: [i32; 2]) -> &[f64; SIDE] {
        self.coefficients.get(kept(index, ny)).unwrap_or(&[0.0; SIDE])
    }

    fn coefficient(&self, column: i32, row: i32) -> f64 {
        let [nx, ny] = self.last();
        self.row(row, [nx, ny]).get(kept(column, nx)).copied().unwrap_or(0.0)
    }

    /// Height and slopes at X and Y.
    #[must_use]
    pub fn at(&self, x: f64, y: f64) -> Height {
        let ([ox, oy], [sx, sy], [nx, ny]) = (self.fine.origin, self.fine.step, self.last());
        let (column, across) = Weights::at((x - ox) / sx, nx);
        let (row, along) = Weights::at((y - oy) / sy, ny);
        let columns = [-1, 0, 1, 2].map(|by| kept(column + by, nx));
        let mut height = Height::default();
        for (by, (value, slope)) in [-1, 0, 1, 2].into_iter().zip(along.value.into_iter().zip(along.slope)) {
            let line = self.row(row + by, [nx, ny]);
            let (mut sum, mut change) = (0.0, 0.0);
            for (index, (weight, tilt)) in columns.into_iter().zip(across.value.into_iter().zip(across.slope)) {
                let coefficient = line.get(index).copied().unwrap_or(0.0);
                sum += weight * coefficient;
                change += tilt * coefficient;
            }
            height.z += value * sum;
            height.slope[0] += value * change;
            height.slope[1] += slope * sum;
        }
        height.slope = [height.slope[0] / sx, height.slope[1] / sy];
        height
    }

    /// Bounds of the box from `low` to `high` (X and Y). Small boxes are looked at as they are.
    pub(super) fn bounds_of(&self, low: [f64; 2], high: [f64; 2]) -> Bounds {
        let [nx, ny] = self.last();
        let cells = |axis: usize, last: i32| {
            let at = |place: f64| cell((place - self.fine.origin[axis]) / self.fine.step[axis], last).0;
            let (one, other) = (at(low[axis]), at(high[axis]));
            if one < other { [one - 1, other + 2] } else { [other - 1, one + 2] }
        };
        let (columns, rows) = (cells(0, nx), cells(1, ny));
        if (columns[1] - columns[0] + 1) * (rows[1] - rows[0] + 1) <= MOST_LOOKED_AT {
            return self.bounds(columns, rows);
        }
        let is_inside = columns[0] >= -1 && columns[1] <= nx + 1 && rows[0] >= -1 && rows[1] <= ny + 1;
        if is_inside { self.inside } else { self.everywhere }
    }

    /// Returns bounds from the coefficients in these columns and rows, both ends included. A spline lies in
    /// the hull of its coefficients, its derivatives in that of their differences.
    fn bounds(&self, [left, right]: [i32; 2], [near, far]: [i32; 2]) -> Bounds {
        let [sx, sy] = self.fine.step.map(libm::fabs);
        let first = self.coefficient(left, near);
        let mut bounds = Bounds { low: first, high: first, ..Bounds::NONE };
        let [mut x, mut y, mut xx, mut yy, mut xy] = [0.0; 5];
        for row in near..=far {
            for column in left..=right {
                let here = self.coefficient(column, row);
                bounds.low = least(bounds.low, here);
                bounds.high = greatest(bounds.high, here);
                let (right_of, beyond) = (column < right, row < far);
                let ahead = if right_of { self.coefficient(column + 1, row) } else { here };
                let above = if beyond { self.coefficient(column, row + 1) } else { here };
                x = greatest(x, libm::fabs(ahead - here));
                y = greatest(y, libm::fabs(above - here));
                if right_of && column > left {
                    xx = greatest(xx, libm::fabs(ahead - 2.0 * here + self.coefficient(column - 1, row)));
                }
                if beyond && row > near {
                    yy = greatest(yy, libm::fabs(above - 2.0 * here + self.coefficient(column, row - 1)));
                }
                if right_of && beyond {
                    xy = greatest(xy, libm::fabs(self.coefficient(column + 1, row + 1) - ahead - above + here));
                }
            }
        }
        bounds.slope = [x / sx, y / sy];
        bounds.bend = [xx / (sx * sx), yy / (sy * sy), xy / (sx * sy)];
        bounds
    }
}

/// Coefficients that bounds are worked out from for a single block.
const MOST_LOOKED_AT: i32 = 64;

/// Checks that every height is a number, none too high, and none too far from its neighbours.
fn check_heights(shape: &GridShape, heights: &[f32]) -> Result<(), CompensationError> {
    let [nx, _] = shape.count;
    let [sx, sy] = shape.step.map(libm::fabs);
    for (index, height) in heights.iter().take(shape.points()).enumerate() {
        let here = f64::from(*height);
        if !here.is_finite() {
            return Err(CompensationError::NotMeasured { point: index });
        }
        if libm::fabs(here) > MOST_HEIGHT {
            return Err(CompensationError::TooHigh { point: index });
        }
        let slope_from = |back: usize, step: f64| {
            index
                .checked_sub(back)
                .and_then(|before| heights.get(before))
                .map_or(0.0, |before| libm::fabs(here - f64::from(*before)) / step)
        };
        let from_left = if index % nx == 0 { 0.0 } else { slope_from(1, sx) };
        if greatest(from_left, slope_from(nx, sy)) > MOST_SLOPE {
            return Err(CompensationError::TooSteep { point: index });
        }
    }
    Ok(())
}

/// Place in memory of the coefficient of this index: those of -1 to the last point and one more are kept;
/// farther out the edge's coefficient stands in, which is the height there.
const fn kept(index: i32, last: i32) -> usize {
    let index = if index < -1 {
        0
    } else if index > last + 1 {
        last
    } else {
        index
    };
    (index + 1) as usize
}
