//! Motors that move by a fixed combination of the axes. A linear map is its own derivative everywhere.

/// Gearing of a CoreXZ machine: alpha = x X + z Z, beta = x X - z Z, gamma = Y.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CoreXz {
    /// Reduction of X (`x_reduction`).
    pub x: f64,
    /// Reduction of Z (`z_reduction`).
    pub z: f64,
}

impl Default for CoreXz {
    fn default() -> Self {
        Self { x: 1.0, z: 3.0 }
    }
}

impl CoreXz {
    /// Returns the motors' positions at a point.
    pub(super) fn motors(&self, [x, y, z]: [f64; 3]) -> [f64; 3] {
        [self.x * x + self.z * z, self.x * x - self.z * z, y]
    }

    /// Returns the point for the motors' positions.
    pub(super) fn axes(&self, [alpha, beta, gamma]: [f64; 3]) -> [f64; 3] {
        [(alpha + beta) / (2.0 * self.x), gamma, (alpha - beta) / (2.0 * self.z)]
    }
}

/// Alpha, beta and gamma as any combination of X, Y and Z, with the way back already worked out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Generic {
    /// Millimetres of each motor for a millimetre of X, Y, Z.
    rows: [[f64; 3]; 3],
    /// The (pseudo-)inverse of `rows`.
    back: [[f64; 3]; 3],
}

fn product(rows: &[[f64; 3]; 3], [x, y, z]: [f64; 3]) -> [f64; 3] {
    rows.map(|[a, b, c]| a * x + b * y + c * z)
}

fn transposed([[a, b, c], [d, e, f], [g, h, i]]: [[f64; 3]; 3]) -> [[f64; 3]; 3] {
    [[a, d, g], [b, e, h], [c, f, i]]
}

/// The inverse by cofactors; `None` when the determinant is below `1e-9`.
fn inverse([[a, b, c], [d, e, f], [g, h, i]]: [[f64; 3]; 3]) -> Option<[[f64; 3]; 3]> {
    let (p, q, r) = (e * i - f * h, f * g - d * i, d * h - e * g);
    let determinant = a * p + b * q + c * r;
    let scaled = |value: f64| value / determinant;
    // A NaN compares false, so it is refused.
    (libm::fabs(determinant) > 1e-9).then(|| {
        [
            [p, c * h - b * i, b * f - c * e].map(scaled),
            [q, a * i - c * g, c * d - a * f].map(scaled),
            [r, b * g - a * h, a * e - b * d].map(scaled),
        ]
    })
}

impl Generic {
    /// Creates the map from the rows of alpha, beta and gamma. `None` when they cannot tell the axes that
    /// take part apart.
    ///
    /// An axis that no motor moves, and a motor that no axis moves, are allowed: they stay at zero. The
    /// inverse then is the pseudo-inverse of Moore and Penrose, `(R'R)^-1 R'` on the axes that take part.
    #[must_use]
    pub fn new(rows: [[f64; 3]; 3]) -> Option<Self> {
        let columns = transposed(rows);
        let mut normal = columns.map(|column| product(&columns, column));
        let mut idle = [false; 3];
        for (index, (row, column)) in normal.iter_mut().zip(columns).enumerate() {
            // A one on the diagonal of an axis that does not take part leaves it at zero.
            if let (true, Some(own), Some(is_idle)) =
                (column.iter().all(|part| *part == 0.0), row.get_mut(index), idle.get_mut(index))
            {
                (*own, *is_idle) = (1.0, true);
            }
        }
        if idle == [true; 3] {
            return None;
        }
        let solve = inverse(normal)?;
        let back = transposed(rows.map(|row| product(&solve, row)));
        Some(Self { rows, back })
    }

    /// Millimetres of alpha, beta and gamma for a millimetre of X, Y, Z.
    #[must_use]
    pub const fn rows(&self) -> &[[f64; 3]; 3] {
        &self.rows
    }

    /// Returns the motors' positions at a point.
    pub(super) fn motors(&self, axes: [f64; 3]) -> [f64; 3] {
        product(&self.rows, axes)
    }

    /// Returns the point for the motors' positions.
    pub(super) fn axes(&self, motors: [f64; 3]) -> [f64; 3] {
        product(&self.back, motors)
    }

    /// Motors that this axis (0 to 2) turns, one bit each.
    pub(super) fn motors_of(&self, axis: usize) -> u8 {
        let turns = |row: &[f64; 3]| row.get(axis).is_some_and(|part| *part != 0.0);
        self.rows.iter().enumerate().filter(|(_, row)| turns(row)).fold(0, |mask, (index, _)| mask | 1 << index)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn rows_that_say_the_same_thing_twice_are_refused() {
        assert!(Generic::new([[1.0, 1.0, 0.0], [2.0, 2.0, 0.0], [0.0, 0.0, 1.0]]).is_none());
        assert!(Generic::new([[0.0; 3]; 3]).is_none());
        assert!(Generic::new([[f64::NAN, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]).is_none());
    }

    #[test]
    fn an_axis_without_a_motor_stays_where_it_is() {
        let lathe = Generic::new([[1.0, 0.0, 0.0], [0.0, 0.0, 2.0], [0.0; 3]]).expect("two motors");
        assert_eq!(lathe.axes(lathe.motors([3.0, 99.0, 4.0])), [3.0, 0.0, 4.0]);
        assert_eq!([0, 1, 2].map(|axis| lathe.motors_of(axis)), [1, 0, 2]);
    }

    proptest! {
        #[test]
        fn the_pseudo_inverse_undoes_any_independent_rows(
            rows in prop::array::uniform3(prop::array::uniform3(-2.0..2.0_f64)),
            axes in prop::array::uniform3(-300.0..300.0_f64),
        ) {
            let determinant = inverse(rows).is_some();
            if let Some(map) = Generic::new(rows) {
                prop_assert!(determinant);
                let back = map.axes(map.motors(axes));
                // Condition of the rows, squared by the normal equations.
                let size: f64 = map.back.iter().flatten().map(|part| part.abs()).sum();
                for (there, here) in back.into_iter().zip(axes) {
                    prop_assert!((there - here).abs() < 1e-9 * (1.0 + size * size), "{there} is not {here}");
                }
            }
        }
    }
}
