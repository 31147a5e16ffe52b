//! Form of a bed from its mesh: high and low points, tilt, twist and bend.
//!
//! The heights are taken apart into a plane, a twist and a bend along each axis. On a rectangular grid these
//! are independent of each other, so each is a quotient of two sums (discrete orthogonal polynomials of the
//! first and second degree).

use motion::GridShape;

/// Form of a bed, mm.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Form {
    /// Highest point: X, Y and height.
    pub highest: [f64; 3],
    /// Lowest point: X, Y and height.
    pub lowest: [f64; 3],
    /// Mean of all heights.
    pub mean: f64,
    /// Rise of the plane over the grid along X (to the right) and along Y (to the rear).
    pub tilt: [f64; 2],
    /// Height of the corners front left and rear right over the other two, by the twist.
    pub twist: f64,
    /// Height of the middle over both ends, along X and along Y.
    pub bend: [f64; 2],
    /// Standard deviation of the remaining heights.
    pub rest: f64,
}

/// Sums along an axis of the grid, on which places run from -1 to 1.
struct Axis {
    count: usize,
    ascends: bool,
    /// Mean of the squares of places.
    square: f64,
    /// Mean of the squares of the second polynomial.
    fourth: f64,
}

impl Axis {
    fn new(count: usize, step: f64) -> Self {
        let mut axis = Self { count, ascends: step >= 0.0, square: 0.0, fourth: 0.0 };
        axis.square = axis.mean(|u| u * u);
        axis.fourth = axis.mean(|u| (u * u - axis.square) * (u * u - axis.square));
        axis
    }

    fn place(&self, index: usize) -> f64 {
        let u = 2.0 * index as f64 / (self.count - 1) as f64 - 1.0;
        if self.ascends { u } else { -u }
    }

    fn mean(&self, of: impl Fn(f64) -> f64) -> f64 {
        (0..self.count).map(|index| of(self.place(index))).sum::<f64>() / self.count as f64
    }

    /// Returns the second polynomial; zero through two points.
    fn bent(&self, u: f64) -> f64 {
        if self.fourth > 1e-12 { u * u - self.square } else { 0.0 }
    }
}

impl Form {
    /// Returns the form of a mesh. `None` when it has fewer than two points along a side, or another number
    /// of heights.
    #[must_use]
    pub fn of(shape: &GridShape, heights: &[f32]) -> Option<Self> {
        let [nx, ny] = shape.count;
        let heights = heights.get(..shape.points())?;
        if nx < 2 || ny < 2 {
            return None;
        }
        let (x, y) = (Axis::new(nx, shape.step[0]), Axis::new(ny, shape.step[1]));
        let all = || {
            let places = (0..ny).flat_map(|row| (0..nx).map(move |column| (column, row)));
            places.zip(heights).map(|((column, row), z)| (x.place(column), y.place(row), f64::from(*z)))
        };
        let share = 1.0 / heights.len() as f64;
        let part = |of: &dyn Fn(f64, f64) -> f64| all().map(|(u, v, z)| of(u, v) * z).sum::<f64>() * share;
        let mean = part(&|_, _| 1.0);
        let [right, rear] = [part(&|u, _| u) / x.square, part(&|_, v| v) / y.square];
        let twist = part(&|u, v| u * v) / (x.square * y.square);
        let bend = |axis: &Axis, sum: f64| if axis.fourth > 1e-12 { sum / axis.fourth } else { 0.0 };
        let across = bend(&x, part(&|u, _| x.bent(u)));
        let along = bend(&y, part(&|_, v| y.bent(v)));
        let made =
            |u: f64, v: f64| mean + right * u + rear * v + twist * u * v + across * x.bent(u) + along * y.bent(v);
        let left = all().map(|(u, v, z)| (z - made(u, v)) * (z - made(u, v))).sum::<f64>() * share;
        let place = |index: usize, z: f32| {
            let [x, y] = shape.place(index);
            [x, y, f64::from(z)]
        };
        let ends = |sign: f32| {
            let found = heights.iter().enumerate().reduce(|a, b| if sign * b.1 > sign * a.1 { b } else { a });
            found.map_or([0.0; 3], |(index, z)| place(index, *z))
        };
        Some(Self {
            highest: ends(1.0),
            lowest: ends(-1.0),
            mean,
            tilt: [2.0 * right, 2.0 * rear],
            twist: 2.0 * twist,
            bend: [-across, -along],
            rest: libm::sqrt(left),
        })
    }

    /// Returns the difference of the highest and the lowest height.
    #[must_use]
    pub fn range(&self) -> f64 {
        self.highest[2] - self.lowest[2]
    }

    /// Returns the height difference that the tilt makes from corner to corner.
    #[must_use]
    pub fn tilt_range(&self) -> f64 {
        libm::fabs(self.tilt[0]) + libm::fabs(self.tilt[1])
    }

    /// Returns the height of the middle over the corners, by the bend.
    #[must_use]
    pub fn dome(&self) -> f64 {
        self.bend[0] + self.bend[1]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn each_part_is_found_beside_the_others(
            tilt in prop::array::uniform2(-0.5..0.5_f64), twist in -0.3..0.3_f64, bend in prop::array::uniform2(-0.3..0.3_f64),
            mean in -0.5..0.5_f64, nx in 3_usize..12, ny in 3_usize..12, back in any::<bool>(),
        ) {
            let width = if back { -90.0 } else { 90.0 };
            let shape = GridShape { origin: [10.0, 20.0], step: [width / (nx - 1) as f64, 60.0 / (ny - 1) as f64], count: [nx, ny] };
            let middle = [10.0 + width / 2.0, 50.0];
            let heights: std::vec::Vec<f32> = (0..shape.points())
                .map(|index| {
                    let [x, y] = shape.place(index);
                    let (u, v) = ((x - middle[0]) / 45.0, (y - middle[1]) / 30.0);
                    let bent = bend[0] * (1.0 - u * u) + bend[1] * (1.0 - v * v);
                    (mean + 0.5 * (tilt[0] * u + tilt[1] * v + twist * u * v) + bent) as f32
                })
                .collect();
            let form = Form::of(&shape, &heights).expect("a mesh");
            for (found, wanted) in form.tilt.into_iter().chain(form.bend).zip(tilt.into_iter().chain(bend)) {
                prop_assert!((found - wanted).abs() < 1e-5, "{found} for {wanted}");
            }
            prop_assert!((form.twist - twist).abs() < 1e-5 && form.rest < 1e-5);
            let most = heights.iter().copied().fold(f32::MIN, f32::max);
            prop_assert_eq!(form.highest[2], f64::from(most));
            prop_assert!(form.range() >= 0.0);
        }
    }

    #[test]
    fn two_points_along_a_side_have_no_bend_and_one_is_no_mesh() {
        let shape = GridShape { origin: [0.0; 2], step: [100.0; 2], count: [2, 2] };
        let form = Form::of(&shape, &[0.0, 0.2, 0.1, 0.3]).expect("a mesh");
        assert!((form.tilt[0] - 0.2).abs() < 1e-6 && (form.tilt[1] - 0.1).abs() < 1e-6);
        assert_eq!(form.bend, [0.0; 2]);
        assert!(Form::of(&GridShape { count: [1, 2], ..shape }, &[0.0; 2]).is_none());
        assert!(Form::of(&shape, &[0.0; 3]).is_none());
    }
}
