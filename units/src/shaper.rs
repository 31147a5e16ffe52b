//! Kinds of input shapers, as settings, codes and the filters of motion name them.

/// Kind of input shaper.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ShaperKind {
    /// Zero vibration: the shortest.
    Zv,
    /// Zero vibration in three pulses over three quarters of a period.
    #[default]
    Mzv,
    /// Zero vibration and derivative.
    Zvd,
    /// Extra insensitive, with one hump.
    Ei,
    /// Extra insensitive with two humps.
    TwoHumpEi,
    /// Extra insensitive with three humps: the widest and longest.
    ThreeHumpEi,
}

impl ShaperKind {
    /// All kinds, in the order of [`Self::WORDS`].
    pub const ALL: &'static [Self] = &[Self::Zv, Self::Mzv, Self::Zvd, Self::Ei, Self::TwoHumpEi, Self::ThreeHumpEi];
    /// Names in configurations, in the order of [`Self::ALL`].
    pub const WORDS: &'static [&'static str] = &["zv", "mzv", "zvd", "ei", "2hump_ei", "3hump_ei"];

    /// Returns the greatest damping ratio that the shaper's formulas hold for.
    #[must_use]
    pub const fn max_damping(self) -> f64 {
        match self {
            Self::Zv | Self::Mzv | Self::Zvd => 0.99,
            Self::Ei => 0.4,
            Self::TwoHumpEi => 0.3,
            Self::ThreeHumpEi => 0.2,
        }
    }
}
