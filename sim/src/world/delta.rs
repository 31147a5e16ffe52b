//! Where three diagonal rods hold the tool of a linear delta.

/// Tool position for carriage heights on towers at 210, 330 and 90 degrees: the lower intersection of three
/// spheres of the rods' length around the carriages, shifted in by the effector (so all towers stand at
/// `radius_mm`).
pub(super) fn tool(heights_mm: [f64; 3], arm_mm: f64, radius_mm: f64) -> [f64; 3] {
    let towers = [210.0_f64, 330.0, 90.0].map(|degrees| {
        let angle = degrees.to_radians();
        [radius_mm * angle.cos(), radius_mm * angle.sin()]
    });
    let p: [[f64; 3]; 3] = std::array::from_fn(|n| [towers[n][0], towers[n][1], heights_mm[n]]);
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
    // All spheres have the same radius, so the foot of the tool in the carriages' plane is their
    // circumcentre.
    let x = d / 2.0;
    let y = (i * i + j * j) / (2.0 * j) - i / j * x;
    let z = -(arm_mm * arm_mm - x * x - y * y).max(0.0).sqrt();
    std::array::from_fn(|n| p[0][n] + ex[n] * x + ey[n] * y + ez[n] * z)
}

#[cfg(test)]
mod tests {
    use super::tool;

    #[test]
    fn every_rod_spans_its_length() {
        let (arm, radius) = (250.0, 124.0);
        for heights in [[300.0; 3], [310.0, 300.0, 295.0], [280.0, 320.0, 330.0]] {
            let at = tool(heights, arm, radius);
            for (degrees, height) in [(210.0_f64, heights[0]), (330.0, heights[1]), (90.0, heights[2])] {
                let (dx, dy) =
                    (at[0] - radius * degrees.to_radians().cos(), at[1] - radius * degrees.to_radians().sin());
                let length = (dx * dx + dy * dy + (at[2] - height).powi(2)).sqrt();
                assert!((length - arm).abs() < 1e-9, "{length}");
            }
            assert!(at[2] < heights[0]);
        }
    }
}
