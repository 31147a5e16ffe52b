//! What a word means to whom: the dialects of G-code, where they contradict each other.

/// A dialect. Each session has one; what both share is the rule and has no place here.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Dialect {
    /// Smoothieware's, which is that of RepRap printers.
    #[default]
    Smoothie,
    /// GRBL's, for mills and lasers (`grbl_mode`).
    Grbl,
}

impl Dialect {
    /// Seconds that one unit of G4 P lasts.
    pub(crate) const fn dwell_unit(self) -> f64 {
        match self {
            Self::Smoothie => 1e-3,
            Self::Grbl => 1.0,
        }
    }

    /// Whether G28 and G28.2 park; of the two, the other one homes.
    pub(crate) const fn parks(self, subcode: u8) -> bool {
        match self {
            Self::Smoothie => subcode == 2,
            Self::Grbl => subcode == 0,
        }
    }

    /// Whether the words of G38 follow G90 and G91; else they are distances.
    pub(crate) const fn probes_by_distance_mode(self) -> bool {
        matches!(self, Self::Grbl)
    }

    /// Whether the codes of a line are carried out in RS-274's order; else as they stand.
    #[must_use]
    pub const fn orders_lines(self) -> bool {
        matches!(self, Self::Grbl)
    }

    /// Whether G10 L2 replaces an offset in G91 too; else it adds to it then.
    pub(crate) const fn replaces_offsets(self) -> bool {
        matches!(self, Self::Grbl)
    }

    /// Whether G80 behind a cycle of G99 goes up to where the axis was before the series.
    pub(crate) const fn returns_at_g80(self) -> bool {
        matches!(self, Self::Smoothie)
    }

    /// Whether G81 and G82 peck with a Q, and G81 dwells with a P, as G83 and G82 do.
    pub(crate) const fn drills_by_words(self) -> bool {
        matches!(self, Self::Smoothie)
    }

    /// Whether M30 ends the program; else it removes a file, or does nothing.
    pub(crate) const fn ends_by_m30(self) -> bool {
        matches!(self, Self::Grbl)
    }

    /// Whether M20 lists the card.
    pub(crate) const fn lists_by_m20(self) -> bool {
        matches!(self, Self::Smoothie)
    }
}
