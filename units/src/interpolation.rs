//! Interpolations of a bed mesh, as settings, codes and the compensation of motion name them.

/// Most points of a grid along X or Y.
pub const MOST_SIDE: usize = 50;

/// Law by which heights between measured points follow from the measured ones.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Interpolation {
    /// The natural bicubic spline: height, slope and bend are continuous.
    #[default]
    Spline,
    /// Straight between neighbours, along X and along Y; the kinks at the points are rounded.
    Bilinear,
    /// A single polynomial through all points of a line (Lagrange).
    Lagrange,
}

impl Interpolation {
    /// All interpolations, in the order of [`Self::WORDS`].
    pub const ALL: &'static [Self] = &[Self::Spline, Self::Bilinear, Self::Lagrange];
    /// Names in configurations and commands, in the order of [`Self::ALL`].
    pub const WORDS: &'static [&'static str] = &[Self::Spline.name(), Self::Bilinear.name(), Self::Lagrange.name()];

    /// Returns the name in configurations and commands.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Spline => "spline",
            Self::Bilinear => "bilinear",
            Self::Lagrange => "lagrange",
        }
    }

    /// Returns the interpolation of that name in upper or lower case, if there is one.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|way| way.name().eq_ignore_ascii_case(name))
    }

    /// Returns the greatest number of points along a side. Straight lines need a finer grid of twice as many
    /// cells; a polynomial through more points swings between them (Runge 1901).
    #[must_use]
    pub const fn most_points(self) -> usize {
        match self {
            Self::Spline => MOST_SIDE,
            Self::Bilinear => MOST_SIDE / 2,
            Self::Lagrange => 6,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_interpolation_is_found_by_its_name() {
        for way in Interpolation::ALL {
            assert_eq!(Interpolation::named(&way.name().to_uppercase()), Some(*way));
        }
        assert_eq!(Interpolation::named("cubic"), None);
    }

    #[test]
    fn no_interpolation_takes_more_points_than_a_grid_has() {
        assert!(Interpolation::ALL.iter().all(|way| (2..=MOST_SIDE).contains(&way.most_points())));
    }
}
