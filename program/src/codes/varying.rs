//! Codes of one row that dialects carry out differently, in words for the documentation.
//!
//! The rules themselves are the functions of [`Dialect`] and what asks them. A code that a dialect reads with
//! other words or another meaning altogether has a row of its own instead, in `flavours.rs`.

use gcode::Code;

use gcode::{Dialect, Dialects};

/// How a dialect reads a code, against the text that begins the code's row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Reading {
    Same,
    Otherwise,
    Refused,
    LeftOut,
    Unknown,
}

impl Reading {
    /// Returns the mark in the dialect's column.
    pub(super) const fn mark(self) -> &'static str {
        match self {
            Self::Same => "=",
            Self::Otherwise => "≠",
            Self::Refused => "x",
            Self::LeftOut => "-",
            Self::Unknown => "?",
        }
    }
}

/// Difference of some codes in some dialects.
#[derive(Clone, Copy, Debug)]
pub(super) struct Varying {
    pub codes: &'static [Code],
    pub dialects: Dialects,
    pub reading: Reading,
    /// Difference in words; empty where the row's help says it already.
    pub text: &'static str,
}

const SMOOTHIE: Dialects = Dialects::of(Dialect::Smoothie);
const GRBL: Dialects = Dialects::of(Dialect::Grbl);
const MARLIN: Dialects = Dialects::of(Dialect::Marlin);
const REPRAP: Dialects = Dialects::of(Dialect::RepRapFirmware);
const KLIPPER: Dialects = Dialects::of(Dialect::Klipper);
const MARLIN_AND_REPRAP: Dialects = MARLIN.with(Dialect::RepRapFirmware);
const MARLIN_AND_KLIPPER: Dialects = MARLIN.with(Dialect::Klipper);
const REPRAP_AND_KLIPPER: Dialects = REPRAP.with(Dialect::Klipper);

const fn varies(codes: &'static [Code], dialects: Dialects, text: &'static str) -> Varying {
    Varying { codes, dialects, reading: Reading::Otherwise, text }
}

const MOVES: &[Code] = &[Code::g(0), Code::g(1)];
const CURVES: &[Code] = &[Code::g(2), Code::g(3), Code::g(5), Code::g(5).sub(1)];
const SEARCHES: &[Code] = &[Code::g(38).sub(2), Code::g(38).sub(3), Code::g(38).sub(4), Code::g(38).sub(5)];
const TARGETS: &[Code] = &[Code::m(104), Code::m(140), Code::m(141)];
const TARGETS_WAITED_FOR: &[Code] = &[Code::m(109), Code::m(190), Code::m(191)];

/// All differences. No dialect stands twice for one code.
pub(super) static VARYING: &[Varying] = &[
    varies(
        MOVES,
        MARLIN_AND_REPRAP,
        "one F for G0 and G1, without `compliant_seek_rate`; F of 0 and below is passed over; E in inches after G20",
    ),
    varies(
        MOVES,
        KLIPPER,
        "one F for G0 and G1, without `compliant_seek_rate`; F of 0 and below is refused; E in inches after G20",
    ),
    varies(CURVES, Dialects::PRINTERS, "F and E as in G1"),
    varies(&[Code::g(5).sub(2)], Dialects::PRINTERS, "F as in G1"),
    varies(&[Code::g(0)], GRBL, "F sets the rate of G1"),
    varies(&[Code::g(4)], GRBL, "P in s"),
    varies(&[Code::g(4)], Dialects::PRINTERS, "S alone where both are written"),
    varies(&[Code::g(10)], GRBL, "L2 after G91 too replaces the offset, and adds nothing to it"),
    varies(&[Code::g(10)], MARLIN_AND_KLIPPER, "L2 and L20 without P: of the coordinate system in force"),
    varies(&[Code::g(28), Code::g(28).sub(2)], GRBL, ""),
    varies(&[Code::g(28)], MARLIN, "L, N, O, P, R, S and W have nothing to do"),
    varies(&[Code::g(30)], GRBL, "parks where `nist_G30` says so; G90 and G91 count for the words then"),
    varies(SEARCHES, GRBL, "G90 and G91 count for the words, and lines of words alone go on searching"),
    varies(&[Code::g(43)], GRBL, "without H and without a `tool.tbl` too: no tool offset, as G49"),
    varies(&[Code::g(43).sub(1), Code::g(43).sub(2)], GRBL, ""),
    varies(&[Code::g(80)], SMOOTHIE, "behind a cycle of G99 goes up to where the series began"),
    varies(&[Code::g(81), Code::g(82), Code::g(83)], SMOOTHIE, "one code: Q pecks and P dwells, where it is written"),
    varies(&[Code::g(90), Code::g(91)], REPRAP, "not E: M82 and M83 alone decide"),
    varies(&[Code::g(90)], KLIPPER, "E is a place only where M82 holds too"),
    varies(&[Code::m(82)], KLIPPER, "only while G90 holds"),
    varies(&[Code::m(0), Code::m(1)], MARLIN_AND_KLIPPER, "shows text that could be codes, too"),
    varies(&[Code::m(2)], GRBL, "G17 too, and spindle and coolant off"),
    varies(&[Code::m(30)], GRBL, "G17 too, and spindle and coolant off"),
    Varying { codes: &[Code::m(20)], dialects: GRBL, reading: Reading::Unknown, text: "" },
    varies(&[Code::m(27), Code::m(113), Code::m(155)], GRBL, "S is refused: ask with `?`"),
    varies(&[Code::m(42)], REPRAP, "S up to 1 is a share of full power"),
    varies(TARGETS, MARLIN_AND_REPRAP, "0 where no heater listens is left out; other firmware's letters are refused"),
    varies(TARGETS, KLIPPER, "S left out is 0; 0 where no heater listens is left out"),
    varies(
        TARGETS_WAITED_FOR,
        MARLIN_AND_REPRAP,
        "0 where no heater listens is left out; other firmware's letters are refused",
    ),
    varies(
        TARGETS_WAITED_FOR,
        KLIPPER,
        "S left out is 0, and S waits for cooling too; 0 where no heater listens is left out",
    ),
    varies(&[Code::m(106)], MARLIN_AND_KLIPPER, "P: which fan, M106.1 for P1; S of 255 on every output"),
    varies(
        &[Code::m(106)],
        REPRAP,
        "P: which fan, M106.1 for P1; S up to 1 is a share of full speed; without S a question",
    ),
    varies(&[Code::m(107)], Dialects::PRINTERS, "P: which fan, M107.1 for P1"),
    varies(&[Code::m(114)], REPRAP_AND_KLIPPER, "in that firmware's form"),
    varies(&[Code::m(115)], GRBL, "no `Cap:` lines"),
    varies(&[Code::m(200)], Dialects::PRINTERS, "S counts"),
    varies(&[Code::m(280)], Dialects::PRINTERS, "P: which servo, M280.1 for P1"),
    varies(&[Code::m(108), Code::m(112), Code::m(410)], GRBL, "in its turn"),
    varies(&[Code::m(110)], SMOOTHIE, "of `N0 M110 N5` the first N"),
    varies(&[Code::m(113)], MARLIN, "every 2 s until it says otherwise"),
];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::codes::{find, find_in};

    #[test]
    fn each_difference_is_of_a_row_that_its_dialects_share() {
        for (place, varying) in VARYING.iter().enumerate() {
            for code in varying.codes {
                assert!(find(*code).is_some(), "{code} has no row");
                for dialect in Dialect::ALL.into_iter().filter(|dialect| varying.dialects.has(*dialect)) {
                    let is_twice = VARYING[..place]
                        .iter()
                        .any(|before| before.dialects.has(dialect) && before.codes.contains(code));
                    let has_its_own = find_in(*code, dialect).is_some();
                    assert!(!is_twice && !has_its_own, "{code} in {}", dialect.name());
                }
            }
        }
    }
}
