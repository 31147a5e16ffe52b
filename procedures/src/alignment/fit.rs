//! Fit of the bed's height over the motors that carry it, from touches of the probe at other places.

use base::least_squares::LeastSquares;

/// Unit of distance of the fit, mm: sums of squared distances and counts of touches are then of like size.
const SCALE: f64 = 100.0;

/// Shapes of the bed that the motors can change.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Shape {
    /// Two motors: tilt it along the line between them.
    Line,
    /// Three, or four of a stiff bed: tilt it.
    Plane,
    /// Four: tilt and twist it.
    Twisted,
}

impl Shape {
    /// Returns the shape that so many motors can follow, with or without a twist of the bed.
    pub const fn of(motors: usize, twist: bool) -> Self {
        match motors {
            0..=2 => Self::Line,
            4.. if twist => Self::Twisted,
            _ => Self::Plane,
        }
    }

    const fn unknowns(self) -> usize {
        match self {
            Self::Line => 2,
            Self::Plane => 3,
            Self::Twisted => 4,
        }
    }
}

/// A bed over its motors.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bed {
    shape: Shape,
    middle: [f64; 2],
    /// Direction of a `Shape::Line`; meaningless for other shapes.
    along: [f64; 2],
    factors: [f64; 4],
}

impl Bed {
    /// Returns the bed that fits touches (X, Y and height, mm) best, or `None` when the touches do not
    /// determine it.
    pub fn through(touches: &[[f64; 3]], motors: &[[f64; 2]], shape: Shape) -> Option<Self> {
        let (first, last) = (motors.first()?, motors.last()?);
        let way = [last[0] - first[0], last[1] - first[1]];
        let length = libm::hypot(way[0], way[1]);
        let share = 1.0 / touches.len() as f64;
        let mut bed = Self {
            shape,
            middle: touches.iter().fold([0.0; 2], |sum, at| [sum[0] + share * at[0], sum[1] + share * at[1]]),
            along: [way[0] / length, way[1] / length],
            factors: [0.0; 4],
        };
        let mut sums = LeastSquares::default();
        let count = shape.unknowns();
        for [x, y, height] in touches {
            let row = bed.row([*x, *y]);
            sums.add(row.get(..count)?, *height);
        }
        let found = sums.solve(count)?;
        bed.factors.iter_mut().zip(found).for_each(|(factor, value)| *factor = value);
        Some(bed)
    }

    /// Returns the basis functions of the fit at a place: the share of each factor in the height.
    fn row(&self, [x, y]: [f64; 2]) -> [f64; 4] {
        let (x, y) = ((x - self.middle[0]) / SCALE, (y - self.middle[1]) / SCALE);
        match self.shape {
            Shape::Line => [1.0, x * self.along[0] + y * self.along[1], 0.0, 0.0],
            Shape::Plane => [1.0, x, y, 0.0],
            Shape::Twisted => [1.0, x, y, x * y],
        }
    }

    /// Returns the bed's height at a place, mm.
    pub fn height(&self, place: [f64; 2]) -> f64 {
        self.row(place).into_iter().zip(self.factors).map(|(one, factor)| one * factor).sum()
    }

    /// Returns the greatest residual of the touches, mm: a warp that no motor can mend, and noise.
    pub fn rest(&self, touches: &[[f64; 3]]) -> f64 {
        let off = |[x, y, height]: &[f64; 3]| libm::fabs(height - self.height([*x, *y]));
        touches.iter().map(off).fold(0.0, f64::max)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const MOTORS: [[f64; 2]; 4] = [[0.0, 0.0], [250.0, 10.0], [240.0, 260.0], [-10.0, 250.0]];

    proptest! {
        #[test]
        fn heights_over_the_motors_follow_from_touches_elsewhere(
            factors in proptest::array::uniform4(-1.0..1.0_f64), count in 2_usize..5, twist: bool,
            points in proptest::collection::vec((20.0..60.0_f64, 20.0..60.0_f64), 4),
        ) {
            let shape = Shape::of(count, twist);
            let motors = &MOTORS[..count];
            let bed = |[x, y]: [f64; 2]| {
                let tilt = match shape {
                    // Across the line between the motors nothing can be told.
                    Shape::Line => factors[1] * (250.0 * x + 10.0 * y) / 25_000.0,
                    _ => factors[1] * x / 100.0 + factors[2] * y / 100.0,
                };
                factors[0] + tilt + if shape == Shape::Twisted { factors[3] * x * y / 1e4 } else { 0.0 }
            };
            // The touches: a point near each corner.
            let corners = [[0.0, 0.0], [150.0, 0.0], [150.0, 150.0], [0.0, 150.0]];
            let touches: Vec<_> = corners.into_iter().zip(points).map(|([cx, cy], (x, y))| {
                let place = [cx + x, cy + y];
                [place[0], place[1], bed(place)]
            }).collect();
            let found = Bed::through(&touches, motors, shape).expect("four points tell");
            prop_assert!(found.rest(&touches) < 1e-9);
            for motor in motors {
                prop_assert!((found.height(*motor) - bed(*motor)).abs() < 1e-8, "{} for {}", found.height(*motor), bed(*motor));
            }
        }
    }

    #[test]
    fn touches_in_one_line_tell_no_plane() {
        let touches = [[0.0, 0.0, 1.0], [50.0, 50.0, 1.1], [100.0, 100.0, 1.3]];
        assert!(Bed::through(&touches, &MOTORS[..3], Shape::Plane).is_none());
    }
}
