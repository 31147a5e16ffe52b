//! What a word means to whom: the dialects of G-code, where they contradict each other.

/// A dialect. Each session has one, and each file that is played; what all share is the rule and has no place
/// here.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Dialect {
    /// Smoothieware's.
    #[default]
    Smoothie,
    /// GRBL's, for mills and lasers (`grbl_mode`).
    Grbl,
    /// Marlin's, and Prusa's.
    Marlin,
    /// RepRapFirmware's.
    RepRapFirmware,
    /// Klipper's.
    Klipper,
}

impl Dialect {
    /// Every dialect.
    pub const ALL: [Self; 5] = [Self::Smoothie, Self::Grbl, Self::Marlin, Self::RepRapFirmware, Self::Klipper];

    /// Its name in full.
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

    /// By the names that people and slicers give it, in upper or lower case. What descends from Marlin, or
    /// Marlin from it, is read as Marlin.
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
            // Slic3r's word for the firmwares that Marlin comes from.
            ("reprap/sprinter", Dialect::Marlin),
            ("reprapfirmware", Dialect::RepRapFirmware),
            ("rrf", Dialect::RepRapFirmware),
            // Cura's word.
            ("reprap", Dialect::RepRapFirmware),
            ("duet", Dialect::RepRapFirmware),
            ("klipper", Dialect::Klipper),
        ];
        NAMES.iter().find(|(known, _)| known.eq_ignore_ascii_case(name.trim())).map(|(_, dialect)| *dialect)
    }

    /// Seconds that one unit of G4 P lasts.
    pub(crate) const fn dwell_unit(self) -> f64 {
        match self {
            Self::Grbl => 1.0,
            _ => 1e-3,
        }
    }

    /// Whether G28 and G28.2 park; of the two, the other one homes.
    pub(crate) const fn parks(self, subcode: u8) -> bool {
        match self {
            Self::Grbl => subcode == 0,
            _ => subcode == 2,
        }
    }

    /// Words that G28 takes: axes, and in Marlin how to home (L, O, R; Prusa's W), which changes nothing
    /// here.
    pub(crate) const fn homing_words(self) -> &'static str {
        match self {
            Self::Marlin => "XYZABCLNOPRSW",
            _ => "XYZABC",
        }
    }

    /// What G90 and G91 do to the extruder's coordinates. Sources: "E: places or distances" in
    /// `docs/dialects.md`.
    pub(crate) const fn extruder_follows(self) -> ExtruderFollows {
        match self {
            Self::Smoothie | Self::Grbl | Self::Marlin => ExtruderFollows::TheLast,
            Self::RepRapFirmware => ExtruderFollows::Nothing,
            Self::Klipper => ExtruderFollows::Both,
        }
    }

    /// Whether the P of M106 and M107 says which fan, so that one above 0 is not for the part's fan, and
    /// its S is of 255 on every kind of output.
    #[must_use]
    pub const fn numbers_fans(self) -> bool {
        self.is_other_printers()
    }

    /// Whether S of M106 up to 1 is a share of full speed.
    pub(crate) const fn takes_shares(self) -> bool {
        matches!(self, Self::RepRapFirmware)
    }

    /// Whether M109 S and M190 S wait until a heater has cooled to its target, too.
    pub(crate) const fn waits_for_cooling(self) -> bool {
        matches!(self, Self::Klipper)
    }

    /// Whether it is that of printers' firmwares other than Smoothieware.
    #[inline]
    pub(crate) const fn is_other_printers(self) -> bool {
        matches!(self, Self::Marlin | Self::RepRapFirmware | Self::Klipper)
    }

    /// Whether it reads codes otherwise than Smoothieware, which the table knows.
    #[inline]
    pub(crate) const fn reads_otherwise(self) -> bool {
        !matches!(self, Self::Smoothie)
    }

    /// Whether an F on a line of G0 is the rate of G0; else it is that of G1, as everywhere.
    pub(crate) const fn seeks_by_f(self) -> bool {
        !matches!(self, Self::Grbl)
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

    /// Whether the words of a code that parks say by which place it goes, as G90 and G91 say; else how far it
    /// goes first.
    pub(crate) const fn parks_by_a_place(self) -> bool {
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

    /// Whether what follows M0 and M1 is a text for the operator even where it could be codes.
    #[must_use]
    pub const fn stops_say(self) -> bool {
        self.is_other_printers()
    }

    /// Whether M30 ends the program; else it removes a file, or does nothing.
    pub(crate) const fn ends_by_m30(self) -> bool {
        matches!(self, Self::Grbl)
    }

    /// Whether the end of a program stops spindle and coolant, and goes back to G17; else they stay.
    pub(crate) const fn stops_spindle_at_end(self) -> bool {
        matches!(self, Self::Grbl)
    }

    /// Whether M20 lists the card.
    pub(crate) const fn lists_by_m20(self) -> bool {
        !matches!(self, Self::Grbl)
    }
}

/// Which codes say whether E is a place or a distance.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ExtruderFollows {
    /// M82 and M83 alone.
    Nothing,
    /// G90, G91, M82 and M83, whichever came last.
    TheLast,
    /// E is a distance after M83, and as long as G91 holds.
    Both,
}

/// A set of dialects.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Dialects(u8);

impl Dialects {
    /// Those of printers' firmwares other than Smoothieware.
    pub const PRINTERS: Self = Self::of(Dialect::Marlin).with(Dialect::RepRapFirmware).with(Dialect::Klipper);

    /// One.
    #[must_use]
    pub const fn of(dialect: Dialect) -> Self {
        Self(1 << dialect as u8)
    }

    /// This set and a dialect.
    #[must_use]
    pub const fn with(self, dialect: Dialect) -> Self {
        Self(self.0 | 1 << dialect as u8)
    }

    /// Whether a dialect is in it.
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
