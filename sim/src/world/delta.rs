//! The tool position of a linear delta, held by three pairs of diagonal rods.

use units::LinearDeltaGeometry;

/// The frame of a delta as it was built.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DeltaFrame {
    /// X and Y of the towers, shifted in by the effector, millimetres.
    pub towers_mm: [[f64; 2]; 3],
    /// Length of each tower's rods, millimetres.
    pub arms_mm: [f64; 3],
}

impl DeltaFrame {
    /// Makes the frame of its drawing: towers at 210, 330 and 90 degrees, each as far off as its own
    /// figures have it.
    #[must_use]
    pub fn of(arms: &LinearDeltaGeometry) -> Self {
        let towers_mm = std::array::from_fn(|n| {
            let angle = ([210.0, 330.0, 90.0][n] + arms.tower_angle[n]).to_radians();
            let radius = arms.arm_radius + arms.tower_offset[n];
            [radius * angle.cos(), radius * angle.sin()]
        });
        Self { towers_mm, arms_mm: std::array::from_fn(|n| arms.arm_length + arms.arm_offset[n]) }
    }

    /// Returns the height of a tower's carriage over the tool, with the tool at X0 Y0, millimetres.
    #[must_use]
    pub fn rise(&self, tower: usize) -> f64 {
        let [x, y] = self.towers_mm[tower];
        (self.arms_mm[tower].powi(2) - x * x - y * y).sqrt()
    }

    /// Returns the tool position for these heights of the carriages: the lower intersection of three
    /// spheres around them.
    #[must_use]
    pub fn tool(&self, heights_mm: [f64; 3]) -> [f64; 3] {
        let p: [[f64; 3]; 3] = std::array::from_fn(|n| [self.towers_mm[n][0], self.towers_mm[n][1], heights_mm[n]]);
        let [r, s, t] = self.arms_mm.map(|arm| arm * arm);
        // Local frame: ex from tower 1 to 2, ey towards 3, ez up. Classic trilateration.
        let sub = |a: [f64; 3], b: [f64; 3]| [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
        let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        let along = |a: [f64; 3], k: f64| a.map(|x| x * k);
        let p12 = sub(p[1], p[0]);
        let d = dot(p12, p12).sqrt();
        let ex = along(p12, 1.0 / d);
        let p13 = sub(p[2], p[0]);
        let i = dot(ex, p13);
        let rest = sub(p13, along(ex, i));
        let j = dot(rest, rest).sqrt();
        let ey = along(rest, 1.0 / j);
        let ez = [ex[1] * ey[2] - ex[2] * ey[1], ex[2] * ey[0] - ex[0] * ey[2], ex[0] * ey[1] - ex[1] * ey[0]];
        let x = (r - s + d * d) / (2.0 * d);
        let y = (r - t + i * i + j * j) / (2.0 * j) - i / j * x;
        let z = -(r - x * x - y * y).max(0.0).sqrt();
        std::array::from_fn(|n| p[0][n] + ex[n] * x + ey[n] * y + ez[n] * z)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_rod_spans_its_length() {
        let even = LinearDeltaGeometry { arm_length: 250.0, arm_radius: 124.0, ..LinearDeltaGeometry::default() };
        let crooked = LinearDeltaGeometry {
            arm_offset: [0.8, -0.5, 0.1],
            tower_offset: [0.4, 0.0, -0.7],
            tower_angle: [0.6, -0.4, 0.0],
            ..even
        };
        for frame in [DeltaFrame::of(&even), DeltaFrame::of(&crooked)] {
            for heights in [[300.0; 3], [310.0, 300.0, 295.0], [280.0, 320.0, 330.0]] {
                let at = frame.tool(heights);
                for (n, height) in heights.into_iter().enumerate() {
                    let [x, y] = frame.towers_mm[n];
                    let length = ((at[0] - x).powi(2) + (at[1] - y).powi(2) + (at[2] - height).powi(2)).sqrt();
                    assert!((length - frame.arms_mm[n]).abs() < 1e-9, "{length}");
                }
                assert!(at[2] < heights[0]);
            }
        }
    }
}
