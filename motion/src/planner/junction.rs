//! The speed a corner allows: junction deviation, or a square corner velocity.
//!
//! Symbols: the unit directions p before and n after the corner, the deviation d, the acceleration a. A
//! circle that touches both lines and passes the corner at distance d has radius `R = d s / (1 - s)` where s
//! is the sine of half the angle between the lines: `s = sqrt((1 + p.n) / 2)`. Going round it at acceleration
//! a gives `v^2 = a R`. (Derivation: S. K. Jeon, "Improving Grbl: Cornering Algorithm", 2011.) The path
//! itself is not rounded: the corner is taken at this speed, as every firmware of this family does.
//!
//! A square corner velocity c (kept through a right angle at the default acceleration A) is the deviation `d
//! = c^2 (sqrt(2) - 1) / A`, for Z too. There, moreover, the circle may touch a line no farther from the
//! corner than the middle of either: `v^2 <= a L s / (2 sqrt(1 - s^2))`, where L is the length of the line
//! and a its acceleration.

use crate::{arithmetic::cube_root, config::Limits, greatest, least, square_root};

/// Cosine beyond which two directions count as opposite or as straight on.
const NEARLY_STRAIGHT: f64 = 0.999_9;
/// A curve may always be entered as if its bend began within so much of it, mm: without a junction deviation
/// it would be a stop.
const LEAST_DEVIATION: f64 = 1e-3;

/// Cosine of the greatest angle (26 degrees) at which a path counts as going on without a corner.
const SMOOTH: f64 = 0.9;

/// Whether the path goes straight on, as nearly as a finely cut curve does.
pub(crate) fn is_tangent(before: Option<[f64; 3]>, after: Option<[f64; 3]>) -> bool {
    let (Some(before), Some(after)) = (before, after) else { return false };
    before.iter().zip(after).map(|(p, n)| p * n).sum::<f64>() >= SMOOTH
}

/// Greatest squared speed through the corner, (mm/s)^2, before the cruise speeds of both blocks are
/// considered. `before` and `after` are unit directions of X Y Z, or `None` where only auxiliary axes move;
/// `gain_sq` is the lesser of both lines' length times acceleration.
pub(crate) fn corner_sq(
    before: Option<[f64; 3]>,
    after: Option<[f64; 3]>,
    acceleration: f64,
    gain_sq: f64,
    limits: &Limits,
) -> f64 {
    let slowest = limits.minimum_speed.get();
    let least_sq = slowest * slowest;
    let (Some(before), Some(after)) = (before, after) else { return least_sq };
    let along: f64 = before.iter().zip(after).map(|(p, n)| p * n).sum();
    if along < -NEARLY_STRAIGHT {
        return least_sq;
    }
    if along > NEARLY_STRAIGHT {
        return f64::INFINITY;
    }
    let sine = square_root(0.5 * (1.0 + along));
    if let Some(square) = limits.square_corner_velocity {
        let corner = acceleration * square_deviation(square.get(), limits) * sine / (1.0 - sine);
        let middle = gain_sq * sine / (2.0 * square_root(0.5 * (1.0 - along)));
        return greatest(least(corner, middle), least_sq);
    }
    let [x, y, _] = after;
    let deviation = match limits.z_junction_deviation {
        Some(z_deviation) if x == 0.0 && y == 0.0 => z_deviation,
        _ => limits.junction_deviation,
    };
    let corner = acceleration * deviation.get() * sine / (1.0 - sine);
    if corner > least_sq { corner } else { least_sq }
}

/// The deviation that a square corner velocity stands for.
fn square_deviation(square: f64, limits: &Limits) -> f64 {
    square * square * (core::f64::consts::SQRT_2 - 1.0) / limits.acceleration.get()
}

/// Greatest squared speed at a place where the bend changes at once, as between a line and an arc, (mm/s)^2:
/// infinite without jerk.
///
/// There the acceleration jumps by `v^2` times the change. A path whose bend changed evenly instead, within
/// the time T that the jerk J needs, would be `v T` long and stand off by `a T^2 / 24` (the shift of a
/// clothoid; a is the jump of the acceleration). With `T = a / J` that is no more than the junction deviation
/// d if `a^3 <= 24 d J^2`. As in a sharp corner, the path itself is not changed.
pub(crate) fn jump_sq(before: [f32; 3], after: [f64; 3], limits: &Limits) -> f64 {
    if !limits.has_jerk() {
        return f64::INFINITY;
    }
    let square = limits.square_corner_velocity.map(|square| square_deviation(square.get(), limits));
    let deviation = greatest(square.unwrap_or(limits.junction_deviation.get()), LEAST_DEVIATION);
    let [x, y, z] = [0, 1, 2].map(|n| after[n] - f64::from(before[n]));
    let mut most = f64::INFINITY;
    for (jump, jerk) in [square_root(x * x + y * y + z * z), x, y, z].into_iter().zip(limits.jerks()) {
        if jump != 0.0 && jerk.is_finite() {
            most = least(most, cube_root(24.0 * deviation * jerk * jerk) / libm::fabs(jump));
        }
    }
    let slowest = limits.minimum_speed.get();
    greatest(most, slowest * slowest)
}

#[cfg(test)]
mod tests {
    use super::*;
    use units::{Mm, MmPerSecond};

    const X: Option<[f64; 3]> = Some([1.0, 0.0, 0.0]);
    const Y: Option<[f64; 3]> = Some([0.0, 1.0, 0.0]);

    #[test]
    fn a_right_angle_is_taken_at_the_speed_of_its_virtual_arc() {
        let limits = Limits { junction_deviation: Mm(0.05), ..Limits::DEFAULT };
        let half = libm::sqrt(0.5);
        let expected = 1_000.0 * 0.05 * half / (1.0 - half);
        assert!((corner_sq(X, Y, 1_000.0, 1e9, &limits) - expected).abs() < 1e-9);
    }

    #[test]
    fn straight_on_is_free_and_a_reversal_takes_the_least_speed() {
        let limits = Limits { minimum_speed: MmPerSecond(3.0), ..Limits::DEFAULT };
        assert_eq!(corner_sq(X, X, 1_000.0, 1e9, &limits), f64::INFINITY);
        assert_eq!(corner_sq(X, Some([-1.0, 0.0, 0.0]), 1_000.0, 1e9, &limits), 9.0);
        assert_eq!(corner_sq(None, X, 1_000.0, 1e9, &limits), 9.0, "after an extruder move");
        assert_eq!(corner_sq(X, None, 1_000.0, 1e9, &limits), 9.0, "into an extruder move");
    }

    #[test]
    fn a_square_corner_velocity_is_the_speed_of_a_right_angle() {
        let limits = Limits {
            square_corner_velocity: Some(MmPerSecond(7.0)),
            acceleration: units::MmPerSecond2(1_000.0),
            junction_deviation: Mm(0.0),
            z_junction_deviation: Some(Mm(0.0)),
            ..Limits::DEFAULT
        };
        let z = Some([0.0, 0.0, 1.0]);
        assert!((corner_sq(X, Y, 1_000.0, 1e9, &limits) - 49.0).abs() < 1e-9);
        assert!((corner_sq(X, z, 1_000.0, 1e9, &limits) - 49.0).abs() < 1e-9, "in whatever plane");
        assert!((corner_sq(X, Y, 500.0, 1e9, &limits) - 24.5).abs() < 1e-9, "less with less acceleration");
        // A circle round the corner that touches both lines 0.005 mm from it has that radius.
        assert!((corner_sq(X, Y, 1_000.0, 1_000.0 * 0.01, &limits) - 5.0).abs() < 1e-9);
        let blunt = Some([0.8, 0.6, 0.0]);
        let deviation = 49.0 * (core::f64::consts::SQRT_2 - 1.0) / 1_000.0;
        let as_deviation = Limits { square_corner_velocity: None, junction_deviation: Mm(deviation), ..limits };
        let (square, plain) =
            (corner_sq(X, blunt, 800.0, 1e9, &limits), corner_sq(X, blunt, 800.0, 1e9, &as_deviation));
        assert!((square - plain).abs() < 1e-9, "{square} is not {plain}");
    }

    #[test]
    fn z_alone_has_its_own_deviation() {
        let z = Some([0.0, 0.0, 1.0]);
        let limits = Limits { z_junction_deviation: Some(Mm(0.0)), ..Limits::DEFAULT };
        assert_eq!(corner_sq(X, z, 1_000.0, 1e9, &limits), 0.0);
        assert!(corner_sq(z, X, 1_000.0, 1e9, &limits) > 0.0, "the corner belongs to the block it enters");
    }

    #[test]
    fn a_jump_of_the_bend_takes_a_clothoid_within_the_deviation() {
        let limits = Limits { junction_deviation: Mm(0.05), ..Limits::DEFAULT };
        let bend = [0.1, 0.0, 0.0];
        assert_eq!(jump_sq([0.0; 3], bend, &limits), f64::INFINITY, "without a limit of jerk");
        let limits = Limits { jerk: Some(units::MmPerSecond3(10_000.0)), ..limits };
        let acceleration = 0.1 * jump_sq([0.0; 3], bend, &limits);
        // The shift of the clothoid, a T^2 / 24 with T = a / J, is the deviation.
        let seconds = acceleration / 10_000.0;
        assert!((acceleration * seconds * seconds / 24.0 - 0.05).abs() < 1e-9);
        assert_eq!(jump_sq([0.1, 0.0, 0.0], [f64::from(0.1_f32), 0.0, 0.0], &limits), f64::INFINITY, "no jump");
        let limits = Limits { axis_jerk: [Some(units::MmPerSecond3(1_000.0)), None, None], ..limits };
        assert!(0.1 * jump_sq([0.0; 3], bend, &limits) < acceleration, "the axis has less");
    }
}
