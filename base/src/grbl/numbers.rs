//! GRBL 1.1's numbers of the reasons why a line is refused and why the machine halted.

use crate::reason::{Alarm, Reason};

impl Reason {
    /// All errors, each with its meaning.
    pub const ALL: [(Self, &str); 26] = [
        (Self::Letter, "no letter where one should be"),
        (Self::Number, "a number is missing, or none"),
        (Self::Statement, "a $ line that is not known, or a setting that is read only"),
        (Self::Negative, "negative, or below its bound"),
        (Self::NotEnabled, "homing is not configured"),
        (Self::Storage, "it acts, but the card did not take it"),
        (Self::NotIdle, "the machine is not idle"),
        (Self::Locked, "in an alarm, or while jogging"),
        (Self::NeedsHoming, "needs homing"),
        (Self::LineLength, "the line is too long, or there was no room for it"),
        (Self::StoredLength, "a startup line or the build's text is too long"),
        (Self::JogTravel, "a jog would leave the travel"),
        (Self::BadJog, "a word or code that no jog takes"),
        (Self::NoLaserOutput, "laser mode"),
        (Self::Unsupported, "a code that is not known, and whatever else is refused"),
        (Self::ModalGroup, "two codes of one modal group"),
        (Self::FeedRate, "no feed rate"),
        (Self::NotWhole, "a whole number is wanted"),
        (Self::AxesTwice, "two codes that both need the axes of the line"),
        (Self::WordTwice, "a word twice"),
        (Self::NoAxes, "no axis"),
        (Self::LineNumber, "the line's number, or its checksum"),
        (Self::MissingWord, "a word is missing"),
        (Self::CoordinateSystem, "no such coordinate system"),
        (Self::Target, "the target cannot be moved to, out of travel among them"),
        (Self::UnusedWord, "a word that nothing in the line takes"),
    ];

    /// Returns the number that senders get.
    #[must_use]
    pub const fn number(self) -> u8 {
        match self {
            Self::Letter => 1,
            Self::Number => 2,
            Self::Statement => 3,
            Self::Negative => 4,
            Self::NotEnabled => 5,
            Self::Storage => 7,
            Self::NotIdle => 8,
            Self::Locked => 9,
            Self::NeedsHoming => 10,
            Self::LineLength => 11,
            Self::StoredLength => 14,
            Self::JogTravel => 15,
            Self::BadJog => 16,
            Self::NoLaserOutput => 17,
            Self::Unsupported => 20,
            Self::ModalGroup => 21,
            Self::FeedRate => 22,
            Self::NotWhole => 23,
            Self::AxesTwice => 24,
            Self::WordTwice => 25,
            Self::NoAxes => 26,
            Self::LineNumber => 27,
            Self::MissingWord => 28,
            Self::CoordinateSystem => 29,
            Self::Target => 33,
            Self::UnusedWord => 36,
        }
    }
}

impl Alarm {
    /// All alarms, each with its meaning.
    pub const ALL: [(Self, &str); 8] = [
        (Self::HardLimit, "a limit switch"),
        (Self::SoftLimit, "a move would leave the travel"),
        (Self::Abort, "stopped in the middle: Ctrl-X, M112, the kill button, a fault of heaters, drivers or supplies"),
        (Self::ProbeState, "a search that cannot begin: the probe touches already, or there is none"),
        (Self::ProbeMiss, "the probe found nothing"),
        (Self::HomingReset, "Ctrl-X while homing"),
        (Self::HomingPullOff, "a switch does not open when homing backs off"),
        (Self::HomingSearch, "a switch was not found"),
    ];

    /// Returns the number that senders get.
    #[must_use]
    pub const fn number(self) -> u8 {
        match self {
            Self::HardLimit => 1,
            Self::SoftLimit => 2,
            Self::Abort => 3,
            Self::ProbeState => 4,
            Self::ProbeMiss => 5,
            Self::HomingReset => 6,
            Self::HomingPullOff => 8,
            Self::HomingSearch => 9,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_page_has_every_number() {
        let page = include_str!("../../../docs/grbl.md").replace('`', "");
        let errors = Reason::ALL.map(|(error, text)| (error.number(), text));
        for (number, text) in errors.into_iter().chain(Alarm::ALL.map(|(alarm, text)| (alarm.number(), text))) {
            assert!(page.contains(&format!("| {number} | {text} |")), "docs/grbl.md has no {number}, {text}");
        }
    }
}
