//! The speed a corner allows: junction deviation.
//!
//! Symbols: the unit directions p before and n after the corner, the deviation d, the acceleration a. A circle that
//! touches both lines and passes the corner at distance d has radius `R = d s / (1 - s)` where s is the sine of half the
//! angle between the lines: `s = sqrt((1 + p.n) / 2)`. Going round it at acceleration a gives `v^2 = a R`. (Derivation:
//! S. K. Jeon, "Improving Grbl: Cornering Algorithm", 2011.) The path itself is not rounded: the corner is taken at
//! this speed, as every firmware of this family does.

use crate::config::Limits;

/// Cosine beyond which two directions count as opposite or as straight on.
const NEARLY_STRAIGHT: f64 = 0.999_9;

/// Greatest squared speed through the corner, (mm/s)^2, before the cruise speeds of both blocks are considered.
/// `before` and `after` are unit directions of X Y Z, or `None` where only auxiliary axes move.
pub(crate) fn corner_sq(before: Option<[f64; 3]>, after: Option<[f64; 3]>, acceleration: f64, limits: &Limits) -> f64 {
    let least = limits.minimum_speed.get();
    let least_sq = least * least;
    let (Some(before), Some(after)) = (before, after) else { return least_sq };
    let along: f64 = before.iter().zip(after).map(|(p, n)| p * n).sum();
    if along < -NEARLY_STRAIGHT {
        return least_sq;
    }
    if along > NEARLY_STRAIGHT {
        return f64::INFINITY;
    }
    let [x, y, _] = after;
    let deviation = match limits.z_junction_deviation {
        Some(z_deviation) if x == 0.0 && y == 0.0 => z_deviation,
        _ => limits.junction_deviation,
    };
    let sine = libm::sqrt(0.5 * (1.0 + along));
    let corner = acceleration * deviation.get() * sine / (1.0 - sine);
    if corner > least_sq { corner } else { least_sq }
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
        assert!((corner_sq(X, Y, 1_000.0, &limits) - expected).abs() < 1e-9);
    }

    #[test]
    fn straight_on_is_free_and_a_reversal_takes_the_least_speed() {
        let limits = Limits { minimum_speed: MmPerSecond(3.0), ..Limits::DEFAULT };
        assert_eq!(corner_sq(X, X, 1_000.0, &limits), f64::INFINITY);
        assert_eq!(corner_sq(X, Some([-1.0, 0.0, 0.0]), 1_000.0, &limits), 9.0);
        assert_eq!(corner_sq(None, X, 1_000.0, &limits), 9.0, "after an extruder move");
        assert_eq!(corner_sq(X, None, 1_000.0, &limits), 9.0, "into an extruder move");
    }

    #[test]
    fn z_alone_has_its_own_deviation() {
        let z = Some([0.0, 0.0, 1.0]);
        let limits = Limits { z_junction_deviation: Some(Mm(0.0)), ..Limits::DEFAULT };
        assert_eq!(corner_sq(X, z, 1_000.0, &limits), 0.0);
        assert!(corner_sq(z, X, 1_000.0, &limits) > 0.0, "the corner belongs to the block it enters");
    }
}
