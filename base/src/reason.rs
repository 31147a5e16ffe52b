//! Reasons why a line is refused and why the machine halted. Senders in GRBL's dialect get each as a number
//! (`grbl/numbers.rs`); nothing else knows the numbers.

use gcode::Refusal;
use program::Problem;

/// Reason why a line is refused.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Reason {
    /// A letter is missing where one should be.
    Letter,
    /// A number is missing, or none.
    Number,
    /// A `$` line that is not known.
    Statement,
    /// A value is negative, or below its bound.
    Negative,
    /// Homing is not configured, or a setting is read only.
    NotEnabled,
    /// The card keeps nothing.
    Storage,
    /// The machine is not idle.
    NotIdle,
    /// The machine is halted, or jogging.
    Locked,
    /// Soft limits need homing.
    NeedsHoming,
    /// The line is too long.
    LineLength,
    /// A startup line, or the build's text, is too long.
    StoredLength,
    /// A jog would leave the travel.
    JogTravel,
    /// A jog without feed rate or axis, or with a code that no jog takes.
    BadJog,
    /// Laser mode needs an output on a timer.
    NoLaserOutput,
    /// A code is not known, or cannot be carried out here; also any fault without a number of its own.
    #[default]
    Unsupported,
    /// Two codes of one modal group.
    ModalGroup,
    /// The feed rate is missing.
    FeedRate,
    /// A whole number is wanted.
    NotWhole,
    /// Two codes that both need the line's axes.
    AxesTwice,
    /// A word that stands twice.
    WordTwice,
    /// A code without the axes that it needs.
    NoAxes,
    /// The line's number is wrong.
    LineNumber,
    /// A word that the code needs is missing.
    MissingWord,
    /// No such coordinate system.
    CoordinateSystem,
    /// The target cannot be moved to.
    Target,
    /// A word that nothing in the line takes.
    UnusedWord,
}

/// Reason why the machine halted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Alarm {
    /// A limit switch was hit.
    HardLimit,
    /// A target beyond the travel.
    SoftLimit,
    /// Stopped in the middle; also any alarm without a number of its own, as it too means to home before
    /// going on.
    #[default]
    Abort,
    /// The probe is not as a search begins with.
    ProbeState,
    /// The probe found nothing.
    ProbeMiss,
    /// Homing was stopped before its end.
    HomingReset,
    /// A switch stayed closed when homing backed off.
    HomingPullOff,
    /// A switch was not found.
    HomingSearch,
}

impl Reason {
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_problem_that_grbl_numbers_has_its_own_reason() {
        use Problem as P;
        let (one, other) = (gcode::Code::g(1), gcode::Code::g(2));
        for (problem, reason) in [
            (P::NegativeFeedRate, Reason::Negative),
            (P::MustSupply('X'), Reason::MissingWord),
            (P::CoordinateSystem, Reason::CoordinateSystem),
            (P::SameGroup(one, other), Reason::ModalGroup),
            (P::AxesTwice(one, other), Reason::AxesTwice),
            (P::WordTwice('X'), Reason::WordTwice),
            (P::UnusedWord('X'), Reason::UnusedWord),
            (P::NoFeedRate, Reason::FeedRate),
            (P::NotHomed, Reason::NeedsHoming),
            (P::ProbeNothing, Reason::NoAxes),
            (P::ProbeNoWay, Reason::Target),
        ] {
            assert_eq!(Reason::of_problem(&problem), reason, "{problem:?}");
        }
    }
}
