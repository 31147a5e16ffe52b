//! Dialects of G-code, and the points in which they contradict each other.

/// Dialect of G-code. Each session has a dialect, and so has each file that is played. Rules that all
/// dialects share are not listed here.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Dialect {
    /// Dialect of Smoothieware v2, the default.
    #[default]
    Smoothie,
    /// Dialect of GRBL, for mills and lasers (`grbl_mode`).
    Grbl,
    /// Dialect of Marlin and Prusa.
    Marlin,
    /// Dialect of RepRapFirmware (Duet).
    RepRapFirmware,
    /// Dialect of the Klipper firmware.
    Klipper,
}

impl Dialect {
    /// All dialects, in order.
    pub const ALL: [Self; 5] = [Self::Smoothie, Self::Grbl, Self::Marlin, Self::RepRapFirmware, Self::Klipper];

    /// Returns the full name of the dialect.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Smoothie => "Smoothie",
            Self::Grbl => "GRBL",
            Self::Marlin => "Marlin",
            Self::RepRapFirmware => "RepRapFirmware",
            Self::Klipper => "Klipper",
        }
    }

    /// Returns the dialect for a name that people and slicers use, in upper or lower case. Ancestors and
    /// descendants of Marlin are read as Marlin.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        const NAMES: [(&str, Dialect); 18] = [
            ("smoothie", Dialect::Smoothie),
            ("smoothieware", Dialect::Smoothie),
            ("grbl", Dialect::Grbl),
            ("marlin", Dialect::Marlin),
            ("marlin2", Dialect::Marlin),
            ("marlin(volumetric)", Dialect::Marlin),
            ("marlin (legacy)", Dialect::Marlin),
            ("repetier", Dialect::Marlin),
            ("teacup", Dialect::Marlin),
            ("sprinter", Dialect::Marlin),
            ("griffin", Dialect::Marlin),
            ("cheetah", Dialect::Marlin),
            // Name in Slic3r for the ancestors of Marlin.
            ("reprap/sprinter", Dialect::Marlin),
            ("reprapfirmware", Dialect::RepRapFirmware),
            ("rrf", Dialect::RepRapFirmware),
            // Name that Cura uses.
            ("reprap", Dialect::RepRapFirmware),
            ("duet", Dialect::RepRapFirmware),
            ("klipper", Dialect::Klipper),
        ];
        NAMES.iter().find(|(known, _)| known.eq_ignore_ascii_case(name.trim())).map(|(_, dialect)| *dialect)
    }

    /// Returns the unit of G4 P, seconds.
    #[must_use]
    pub const fn dwell_unit(self) -> f64 {
        match self {
            Self::Grbl => 1.0,
            _ => 1e-3,
        }
    }

    /// Whether this subcode of G28 parks; of G28 and G28.2, the other one homes.
    #[must_use]
    pub const fn parks(self, subcode: u8) -> bool {
        match self {
            Self::Grbl => subcode == 0,
            _ => subcode == 2,
        }
    }

    /// Returns the words that G28 takes: axes, and in Marlin how to home (L, O, R; Prusa's W), which changes
    /// nothing here.
    #[must_use]
    pub const fn homing_words(self) -> &'static str {
        match self {
            Self::Marlin => "XYZABCLNOPRSW",
            _ => "XYZABC",
        }
    }

    /// Returns how G90 and G91 affect the extruder's coordinates. Sources: "E: places or distances" in
    /// `docs/dialects.md`.
    #[must_use]
    pub const fn extruder_follows(self) -> ExtruderFollows {
        match self {
            Self::Smoothie | Self::Grbl | Self::Marlin => ExtruderFollows::TheLast,
            Self::RepRapFirmware => ExtruderFollows::Nothing,
            Self::Klipper => ExtruderFollows::Both,
        }
    }

    /// Whether P of M106 and M107 selects a fan, so that P above 0 is not the part's fan, and S is out of 255
    /// on every kind of output.
    #[must_use]
    pub const fn numbers_fans(self) -> bool {
        self.is_other_printers()
    }

    /// Whether S of M106 up to 1 is a share of full speed.
    #[must_use]
    pub const fn takes_shares(self) -> bool {
        matches!(self, Self::RepRapFirmware)
    }

    /// Whether M109 S and M190 S also wait until a heater has cooled to its target.
    #[must_use]
    pub const fn waits_for_cooling(self) -> bool {
        matches!(self, Self::Klipper)
    }

    /// Whether the dialect belongs to printer firmware other than Smoothieware.
    #[inline]
    #[must_use]
    pub const fn is_other_printers(self) -> bool {
        matches!(self, Self::Marlin | Self::RepRapFirmware | Self::Klipper)
    }

    /// Whether the table of codes has other readings for this dialect.
    #[inline]
    #[must_use]
    pub const fn reads_otherwise(self) -> bool {
        !matches!(self, Self::Smoothie)
    }

    /// Whether F on a line of G0 sets the rate of G0; otherwise F sets the rate of G1, as everywhere.
    #[must_use]
    pub const fn seeks_by_f(self) -> bool {
        !matches!(self, Self::Grbl)
    }

    /// Whether G90 and G91 apply to the words of G38; otherwise the words are distances.
    #[must_use]
    pub const fn probes_by_distance_mode(self) -> bool {
        matches!(self, Self::Grbl)
    }

    /// Whether the codes of a line run in RS-274's order; otherwise in the written order.
    #[must_use]
    pub const fn orders_lines(self) -> bool {
        matches!(self, Self::Grbl)
    }

    /// Whether the words of a parking code give an intermediate position, as G90 and G91 say; otherwise a
    /// distance to move first.
    #[must_use]
    pub const fn parks_by_a_place(self) -> bool {
        matches!(self, Self::Grbl)
    }

    /// Whether G10 L2 replaces an offset in G91 too; otherwise G10 L2 adds to the offset in G91.
    #[must_use]
    pub const fn replaces_offsets(self) -> bool {
        matches!(self, Self::Grbl)
    }

    /// Whether G80 behind a cycle of G99 returns to the height before the series.
    #[must_use]
    pub const fn returns_at_g80(self) -> bool {
        matches!(self, Self::Smoothie)
    }

    /// Whether G81 and G82 peck when Q is given, as G83 does, and G81 dwells when P is given, as G82 does.
    #[must_use]
    pub const fn drills_by_words(self) -> bool {
        matches!(self, Self::Smoothie)
    }

    /// Whether text behind M0 and M1 is for the operator even if the text could be codes.
    #[must_use]
    pub const fn stops_say(self) -> bool {
        self.is_other_printers()
    }

    /// Whether M30 ends the program; otherwise M30 removes a file, or does nothing.
    #[must_use]
    pub const fn ends_by_m30(self) -> bool {
        matches!(self, Self::Grbl)
    }

    /// Whether the end of a program stops spindle and coolant and selects G17; otherwise they stay.
    #[must_use]
    pub const fn stops_spindle_at_end(self) -> bool {
        matches!(self, Self::Grbl)
    }

    /// Whether M20 lists the card.
    #[must_use]
    pub const fn lists_by_m20(self) -> bool {
        !matches!(self, Self::Grbl)
    }
}

/// Codes that decide whether E is a position or a distance.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ExtruderFollows {
    /// Only M82 and M83 decide.
    Nothing,
    /// The last of G90, G91, M82 and M83 decides.
    TheLast,
    /// Both pairs: E is a distance after M83, and as long as G91 holds.
    Both,
}

/// Set of dialects, one bit each.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Dialects(u8);

impl Dialects {
    /// Dialects of printer firmwares other than Smoothieware.
    pub const PRINTERS: Self = Self::of(Dialect::Marlin).with(Dialect::RepRapFirmware).with(Dialect::Klipper);

    /// Returns a set of a single dialect.
    #[must_use]
    pub const fn of(dialect: Dialect) -> Self {
        Self(1 << dialect as u8)
    }

    /// Returns this set with a dialect added.
    #[must_use]
    pub const fn with(self, dialect: Dialect) -> Self {
        Self(self.0 | 1 << dialect as u8)
    }

    /// Whether the set contains a dialect.
    #[must_use]
    pub const fn has(self, dialect: Dialect) -> bool {
        self.0 & 1 << dialect as u8 != 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_dialect_is_found_by_its_name() {
        for dialect in Dialect::ALL {
            assert_eq!(Dialect::named(dialect.name()), Some(dialect));
        }
        assert_eq!(Dialect::named(" Marlin2 "), Some(Dialect::Marlin));
        assert_eq!(Dialect::named("makerware"), None);
    }
}
