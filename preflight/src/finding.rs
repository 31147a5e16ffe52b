//! Findings of a preflight, in words for the author of the file.

use core::fmt;

use base::failure::ShortText;

use super::limits::Limit;

/// The name of a subroutine.
pub type SubName = gcode::expression::Name;

/// Severity of a finding.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Severity {
    /// The job goes on, but makes something else than the file says, or makes it more slowly.
    Warning,
    /// The job stops there.
    Stop,
}

/// Kind of a finding.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// A move leaves the travel of an axis.
    OutOfTravel,
    /// A place that arms do not reach.
    Unreachable,
    /// A move before homing, where `[motion control] must_be_homed` is set.
    MustHome,
    /// A word with which the machine halts.
    Halts,
    /// A move before the machine knows where it is.
    NotHomed,
    /// A code that nobody knows, or whose part the machine has not.
    Unknown,
    /// A code that is known and not carried out.
    PassedOver,
    /// A code that levels the bed, on a machine that cannot.
    Unleveled,
    /// A word of a code is wrong.
    Word,
    /// A tool that does not exist.
    Tool,
    /// A part that an error in the configuration keeps off.
    Off,
    /// A temperature above the heater's maximum.
    TooHot,
    /// Filament is fed by a cold nozzle.
    Cold,
    /// Filament is fed by a cold nozzle, where that is refused.
    TooCold,
    /// A move of an extruder alone that is longer than it may be.
    TooLong,
    /// A speed that a limit cuts.
    Speed,
    /// An acceleration that a limit cuts.
    Acceleration,
    /// An S beyond the scale of a laser.
    Power,
    /// A rapid with the S of a laser, which is dark.
    DarkRapid,
    /// A laser outside laser mode, whose moves do not burn.
    LaserMode,
    /// M3 on a machine that has nothing to turn on with it.
    NothingBurns,
    /// The line cannot be read.
    Text,
    /// Bytes that no text has, or a wrong checksum.
    Damage,
    /// Subroutines and loops do not fit together.
    Flow,
    /// A macro that the machine would refuse.
    Macro,
    /// Something that only the job can know.
    Unforeseen,
}

impl Kind {
    /// Returns why nothing of the file is made, when the machine would stop there by itself or halt and lose
    /// its place.
    #[must_use]
    pub const fn spoils_the_job(self) -> Option<&'static str> {
        match self {
            Self::OutOfTravel | Self::Unreachable => Some("it would leave the travel"),
            Self::MustHome => Some("it moves before it homes"),
            Self::Halts => Some("a line of it would halt the machine"),
            _ => None,
        }
    }

    /// Returns the advice on a finding.
    #[must_use]
    pub const fn fix(self) -> &'static str {
        match self {
            Self::OutOfTravel => "place the part elsewhere, or correct [soft endstop] or the work offset",
            Self::Unreachable => "place the part where the arms reach it",
            Self::NotHomed | Self::MustHome => "begin with G28",
            Self::Unknown => "leave it out, or choose this machine's firmware in the slicer",
            Self::PassedOver => "nothing need be done",
            Self::Unleveled => "level the bed by hand; [player] without_leveling = pause would stop there",
            Self::Word | Self::Halts => "correct the line",
            Self::Tool => "slice for the extruders that there are, or add an [extruder] section",
            Self::Off => "mend config.ini",
            Self::TooHot => "lower the temperature, or raise max_temp if the hardware bears it",
            Self::Cold | Self::TooCold => "set the temperature and wait for it (M109) before",
            Self::TooLong => "feed it in shorter moves, or raise the limit",
            Self::Speed => "slice for that speed, or raise the limit",
            Self::Acceleration => "slice for that acceleration, or raise the limit",
            Self::Power => "give the sender and [laser] maximum_s_value (M452 R, $30) the same S of full power",
            Self::DarkRapid => "write G1 where it is to burn",
            Self::LaserMode => "turn it on with M452 S1 or $32=1",
            Self::NothingBurns => "describe it in [laser] or [switch], or turn it on by hand",
            Self::Text => "correct the line",
            Self::Damage => "the file may be damaged: copy it anew",
            Self::Flow => "close what is open",
            Self::Macro => "correct the macro",
            Self::Unforeseen => "watch the job there",
        }
    }

    /// Returns the severity of a finding.
    #[must_use]
    pub const fn severity(self) -> Severity {
        match self {
            Self::NotHomed
            | Self::PassedOver
            | Self::Unleveled
            | Self::Cold
            | Self::Speed
            | Self::Acceleration
            | Self::Power
            | Self::DarkRapid
            | Self::LaserMode
            | Self::NothingBurns
            | Self::Unforeseen => Severity::Warning,
            _ => Severity::Stop,
        }
    }
}

/// A fault found in a file.
#[derive(Clone, Debug, PartialEq)]
pub struct Finding {
    /// Subroutine in whose file the fault is; none in the job's own.
    pub sub: Option<SubName>,
    /// Number of the line, from 1.
    pub line: u32,
    /// Kind of the finding.
    pub kind: Kind,
    /// Text about the fault.
    pub what: ShortText,
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let word = if self.kind.severity() == Severity::Stop { "stops" } else { "warning" };
        if let Some(sub) = &self.sub {
            write!(f, "{sub}.ngc, ")?;
        }
        write!(f, "line {}: {word}: {} ({})", self.line, self.what, self.kind.fix())
    }
}

/// Findings that are said once of a file, however often they occur.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Once {
    pub not_homed: bool,
    pub cold: [bool; units::MAX_AXES],
    /// Limits that the file asks for more than, as in [`Limit::ALL`].
    pub limits: [bool; Limit::COUNT],
    pub unforeseen: bool,
    /// An S that the spindle cannot turn with.
    pub spindle_speed: bool,
    /// Kinds of power that is not what the file asks for, as [`Kind`] has them.
    pub full_power: bool,
    pub dark_rapid: bool,
    pub laser_mode: bool,
    pub unheard: bool,
    /// Number of findings said, of kinds that may come in thousands.
    pub out_of_travel: u32,
    pub passed_over: u32,
    pub guesses: u32,
}

/// Greatest number said of findings that may come with every line.
pub(super) const MOST_ALIKE: u32 = 5;
