//! GRBL 1.1's numbers of errors and alarms, and their assignment to this firmware's faults.

use gcode::Refusal;
use program::Problem;

/// Reason why a line is refused, by GRBL 1.1's number.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(u8)]
pub enum Error {
    /// A letter is missing where one should be.
    Letter = 1,
    /// A number is missing, or none.
    Number = 2,
    /// A `$` line that is not known.
    Statement = 3,
    /// A value is negative, or below its bound.
    Negative = 4,
    /// Homing is not configured, or a setting is read only.
    NotEnabled = 5,
    /// The card keeps nothing.
    Storage = 7,
    /// The machine is not idle.
    NotIdle = 8,
    /// The machine is halted, or jogging.
    Locked = 9,
    /// Soft limits need homing.
    NeedsHoming = 10,
    /// The line is too long.
    LineLength = 11,
    /// A startup line, or the build's text, is too long.
    StoredLength = 14,
    /// A jog would leave the travel.
    JogTravel = 15,
    /// A jog without feed rate or axis, or with a code that no jog takes.
    BadJog = 16,
    /// Laser mode needs an output on a timer.
    NoLaserOutput = 17,
    /// A code is not known, or cannot be carried out here; also any fault without a number of its own.
    #[default]
    Unsupported = 20,
    /// Two codes of one modal group.
    ModalGroup = 21,
    /// The feed rate is missing.
    FeedRate = 22,
    /// A whole number is wanted.
    NotWhole = 23,
    /// Two codes that both need the line's axes.
    AxesTwice = 24,
    /// A word that stands twice.
    WordTwice = 25,
    /// A code without the axes that it needs.
    NoAxes = 26,
    /// The line's number is wrong.
    LineNumber = 27,
    /// A word that the code needs is missing.
    MissingWord = 28,
    /// No such coordinate system.
    CoordinateSystem = 29,
    /// The target cannot be moved to.
    Target = 33,
    /// A word that nothing in the line takes.
    UnusedWord = 36,
}

/// Reason why the machine halted, by GRBL 1.1's number.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(u8)]
pub enum Alarm {
    /// A limit switch was hit.
    HardLimit = 1,
    /// A target beyond the travel.
    SoftLimit = 2,
    /// Stopped in the middle; also any alarm without a number of its own, as it too means to home before
    /// going on.
    #[default]
    Abort = 3,
    /// The probe is not as a search begins with.
    ProbeState = 4,
    /// The probe found nothing.
    ProbeMiss = 5,
    /// Homing was stopped before its end.
    HomingReset = 6,
    /// A switch stayed closed when homing backed off.
    HomingPullOff = 8,
    /// A switch was not found.
    HomingSearch = 9,
}

impl Error {
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
        self as u8
    }

    /// Returns the error of a line that cannot be read.
    #[must_use]
    pub const fn of_refusal(refusal: &Refusal) -> Self {
        use gcode::Problem as P;
        let Refusal::Syntax(error) = refusal else { return Self::LineNumber };
        match error.problem {
            P::MissingNumber(_) | P::NoDigits(_) | P::SecondPoint(_) | P::BadChecksum => Self::Number,
            P::NoValue | P::TwoPoints | P::NotFinite | P::DivisionByZero | P::NoParameter => Self::Number,
            P::BadCode(_) | P::BadSubcode(_) => Self::NotWhole,
            P::BadLineNumber => Self::LineNumber,
            _ => Self::Letter,
        }
    }

    /// Returns the error of a block that the program refuses.
    #[must_use]
    pub const fn of_problem(problem: &Problem) -> Self {
        use Problem as P;
        match problem {
            P::NegativeFeedRate
            | P::NegativeSpeed
            | P::TooLittle(..)
            | P::MustExceed(..)
            | P::CornerTolerance
            | P::Weight
            | P::FlowRange => Self::Negative,
            P::NotWhole(..) | P::Turns => Self::NotWhole,
            P::MustSupply(_) | P::BelongTogether(..) | P::NoName | P::CubicStart | P::CubicEnd | P::QuadraticPoint => {
                Self::MissingWord
            }
            P::CoordinateSystem => Self::CoordinateSystem,
            P::SameGroup(..) => Self::ModalGroup,
            P::AxesTwice(..) => Self::AxesTwice,
            P::WordTwice(_) => Self::WordTwice,
            P::UnusedWord(_) => Self::UnusedWord,
            P::ProbeRate | P::NoFeedRate => Self::FeedRate,
            P::NotHomed | P::ParkUnknown => Self::NeedsHoming,
            P::ProbeNothing => Self::NoAxes,
            P::ProbeNoWay => Self::Target,
            _ => Self::Unsupported,
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
        self as u8
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_page_has_every_number() {
        let page = include_str!("../../../docs/grbl.md").replace('`', "");
        let errors = Error::ALL.map(|(error, text)| (error.number(), text));
        for (number, text) in errors.into_iter().chain(Alarm::ALL.map(|(alarm, text)| (alarm.number(), text))) {
            assert!(page.contains(&format!("| {number} | {text} |")), "docs/grbl.md has no {number}, {text}");
        }
    }
}
