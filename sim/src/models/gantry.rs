//! A gantry, or a bed, that several Z motors carry, each at its own place.

use units::Actuator;

/// Places of the motors that carry the gantry, X and Y, mm.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Gantry {
    /// Motors with their places, if two or more; a single motor, or none, carries the gantry everywhere.
    pub pivots: Vec<(Actuator, [f64; 2])>,
}

impl Gantry {
    /// Returns the height of the tool over X and Y, with the motors at these heights, mm: straight between
    /// two motors, a plane over three, a twisted surface over four.
    #[must_use]
    pub fn height(&self, [x, y]: [f64; 2], motor_mm: impl Fn(Actuator) -> f64) -> f64 {
        let row = |[x, y]: [f64; 2], along: [f64; 2]| match self.pivots.len() {
            0 | 1 => vec![1.0],
            2 => vec![1.0, x * along[0] + y * along[1]],
            3 => vec![1.0, x, y],
            _ => vec![1.0, x, y, x * y],
        };
        let along = match self.pivots.as_slice() {
            [(_, a), (_, b)] => [b[0] - a[0], b[1] - a[1]],
            _ => [0.0; 2],
        };
        let mut rows: Vec<Vec<f64>> = self
            .pivots
            .iter()
            .take(4)
            .map(|(motor, place)| {
                let mut row = row(*place, along);
                row.push(motor_mm(*motor));
                row
            })
            .collect();
        let count = rows.len();
        for column in 0..count {
            let best = (column..count).max_by(|a, b| rows[*a][column].abs().total_cmp(&rows[*b][column].abs()));
            rows.swap(column, best.unwrap_or(column));
            let pivot = rows[column].clone();
            for (_, other) in rows.iter_mut().enumerate().filter(|(index, _)| *index != column) {
                let share = other[column] / pivot[column];
                other.iter_mut().zip(&pivot).for_each(|(cell, from)| *cell -= share * from);
            }
        }
        let here = row([x, y], along);
        (0..count).map(|n| here[n] * rows[n][count] / rows[n][n]).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CORNERS: [[f64; 2]; 4] = [[0.0, 0.0], [200.0, 0.0], [200.0, 200.0], [0.0, 200.0]];

    #[test]
    fn it_hangs_on_its_motors_and_is_straight_between_them() {
        for count in 2..=4 {
            let pivots = Actuator::ALL.into_iter().zip(CORNERS).take(count).collect();
            let gantry = Gantry { pivots };
            let heights = [1.0, 2.0, 4.0, 2.5];
            for (corner, height) in CORNERS.iter().zip(heights).take(count) {
                assert!((gantry.height(*corner, |motor| heights[motor as usize]) - height).abs() < 1e-9);
            }
            let middle = gantry.height([100.0, 0.0], |motor| heights[motor as usize]);
            assert!((middle - 1.5).abs() < 1e-9, "{middle}");
        }
    }
}
