//! Functions of the machine apart from motion, by name and by how they are carried out.
//!
//! The table of codes describes the words of each. A function's group says when it acts, so that whoever
//! carries functions out has a match without a catch-all for each group. Facts about functions stand here
//! too.

use crate::words::Words;

/// Function of the machine apart from motion, in its group.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Function {
    /// Sets at once how far or how fast the machine goes.
    Limit(LimitCode),
    /// Sets something else at once.
    Setting(Setting),
    /// Says something at once.
    Report(Report),
    /// Deals with files, jobs and saved settings at once.
    File(FileFunction),
    /// Needs motors that stand.
    Standing(Standing),
    /// Changes where the program's places lie.
    Geometry(Geometry),
    /// Takes time.
    Sequence(Sequence),
}

impl Function {
    /// Whether the motors stand first where the words change anything.
    #[must_use]
    pub fn stands_first(self, words: &Words<'_>) -> bool {
        match self {
            Self::Limit(_) | Self::Setting(_) | Self::Report(_) | Self::File(_) => false,
            Self::Standing(Standing::PressureAdvance) => words.has('K') || words.has('S') || words.has('W'),
            Self::Standing(
                Standing::StepsPerMm
                | Standing::Microsteps
                | Standing::StealthThresholds
                | Standing::InputShaping
                | Standing::Laser,
            ) => !words.is_bare(),
            Self::Standing(
                Standing::StealthMode
                | Standing::MotorsOff
                | Standing::MotorPositions
                | Standing::HomeOffsetsFromHere
                | Standing::DriverRegister,
            ) => true,
            Self::Sequence(
                Sequence::Statistics
                | Sequence::SaveSettings
                | Sequence::SaveGrid
                | Sequence::ListMeshes
                | Sequence::AbortJob
                | Sequence::GoOnWithJob,
            ) => false,
            Self::Geometry(_) | Self::Sequence(_) => true,
        }
    }

    /// Whether check mode (`$C`) carries the function out: whatever neither needs standing motors, nor takes
    /// time, nor deletes what is on the card.
    #[must_use]
    pub fn counts_in_check_mode(self, words: &Words<'_>) -> bool {
        use FileFunction as F;
        match self {
            Self::Limit(_) | Self::Setting(_) | Self::Report(_) => true,
            Self::File(file) => !matches!(file, F::RemoveFile | F::ForgetSettings | F::DeleteGrid),
            Self::Standing(_) => !self.stands_first(words),
            Self::Geometry(_) | Self::Sequence(_) => false,
        }
    }

    /// Whether a job that begins in the middle of its file needs the function of a line before: settings of
    /// limits, motors, filters and gains, and labels of objects.
    #[must_use]
    pub fn counts_in_fast_forward(self, words: &Words<'_>) -> bool {
        match self {
            Self::Setting(setting) => setting != Setting::MotorsOn,
            // M306 T measures a heater.
            Self::Standing(Standing::HomeOffsetsFromHere) => !words.has('T'),
            Self::Standing(setting) => setting != Standing::MotorsOff,
            Self::File(function) => function == FileFunction::LabelObject,
            Self::Limit(_) => true,
            Self::Report(_) | Self::Geometry(_) | Self::Sequence(_) => false,
        }
    }

    /// Whether the function writes or deletes what is kept on the card: only the machine's owner may.
    #[must_use]
    pub const fn is_for_owner(self) -> bool {
        use {FileFunction as F, Sequence as S};
        match self {
            Self::File(file) => matches!(file, F::Upload | F::RemoveFile | F::ForgetSettings | F::DeleteGrid),
            Self::Sequence(what) => matches!(what, S::SaveSettings | S::SaveGrid),
            Self::Limit(_) | Self::Setting(_) | Self::Report(_) | Self::Standing(_) | Self::Geometry(_) => false,
        }
    }

    /// Whether the function reads or changes files of the card.
    #[must_use]
    pub const fn needs_card(self) -> bool {
        use {FileFunction as F, Geometry as G, Sequence as S};
        match self {
            Self::File(file) => matches!(
                file,
                F::SelectFile
                    | F::StartFile
                    | F::StartJob
                    | F::Upload
                    | F::RemoveFile
                    | F::LoadSettings
                    | F::ForgetSettings
                    | F::DeleteGrid
            ),
            Self::Geometry(what) => matches!(what, G::LoadGrid | G::Skew),
            Self::Sequence(what) => {
                matches!(what, S::SaveSettings | S::SaveGrid | S::ListMeshes | S::UseGrid | S::GoOnWithJob)
            }
            Self::Limit(_) | Self::Setting(_) | Self::Report(_) | Self::Standing(_) => false,
        }
    }
}

/// Functions that set how far or how fast the machine goes, and say what is set. They are carried out at once
/// and never wait; a dry run carries them out as well.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs, reason = "the table of codes says what each does")]
pub enum LimitCode {
    AxisSpeeds,
    MotorSpeeds,
    Accelerations,
    Jerk,
    CornerSettings,
    SpeedFactor,
    HomeOffsets,
    SoftEndstops,
    Trims,
    /// M302: lowest nozzle temperature for extrusion.
    ColdExtrusion,
}

/// Functions that set something else and say what is set. They are carried out at once, and never wait.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs, reason = "the table of codes says what each does")]
pub enum Setting {
    ProbeSettings,
    ProbePoint,
    ProbeOffset,
    /// M851.6: axis twist, the probe's height error along an axis.
    AxisTwist,
    /// M851: probe offset with Marlin's sign convention.
    MarlinProbeOffset,
    MotorsOn,
    /// M875: motor phases at the end stops.
    EndstopPhase,
    MotorMilliamps,
    MotorAmps,
    DriverChopper,
    DriverOption,
    /// M912: forget reported driver faults, so that each is reported again.
    ForgetDriverTroubles,
    /// M914: stall detection threshold for homing an axis.
    HomingThresholds,
    /// M290.1: compensation of the frame's thermal expansion in Z.
    ThermalAdjust,
    MaximumTemperature,
    PidGains,
    HeaterModel,
    Sensor,
}

/// Functions that say something, or set what later answers and flows depend on. They never wait.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs, reason = "the table of codes says what each does")]
pub enum Report {
    ShowGrid,
    ShowMap,
    DriverStatus,
    FilamentDiameter,
    /// M404 to M407, M412: the filament detector.
    FilamentDetector,
    /// M404.1 to M407.2: the filament width sensor alone.
    FilamentWidth,
    /// M603: filament lengths for a filament change.
    FilamentLengths,
    RetractSettings,
    RecoverSettings,
    FlowFactor,
    ReportTemperatures,
    ReportHoming,
    ReportPosition,
    ReportFirmware,
    ReportSwitches,
    ReportFans,
    SayToAll,
    ShowSettings,
}

/// Functions of files, jobs and saved settings. They never wait for the machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs, reason = "the table of codes says what each does")]
pub enum FileFunction {
    DeleteGrid,
    /// M155: report temperatures at an interval.
    AutoReport,
    /// M113: keepalive messages during a long line.
    Keepalive,
    LabelObject,
    ListFiles,
    Mount,
    SelectFile,
    StartJob,
    PauseJob,
    RestartJob,
    PowerLoss,
    ReportJob,
    ReportProgress,
    Upload,
    EndUpload,
    RemoveFile,
    StartFile,
    LoadSettings,
    ForgetSettings,
}

/// Functions that change the meaning of every step or filter, or of every place: the motors stand first where
/// the words change anything.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs, reason = "the table of codes says what each does")]
pub enum Standing {
    MotorsOff,
    StepsPerMm,
    InputShaping,
    PressureAdvance,
    DriverRegister,
    /// M913: speed up to which stealthChop is used.
    StealthThresholds,
    /// M569: enable or disable stealthChop.
    StealthMode,
    Microsteps,
    MotorPositions,
    HomeOffsetsFromHere,
    /// M452, and M221 on a machine with a laser: scale and law of a laser's power.
    Laser,
}

/// Functions that change where places of the program lie, all but what is measured for it: a dry run carries
/// them out as well.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs, reason = "the table of codes says what each does")]
pub enum Geometry {
    LoadGrid,
    FadeHeight,
    BedPlane,
    Skew,
    ArmSettings,
}

/// Functions that take time: they move, heat, write long files, or count on all that came before having been
/// made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs, reason = "the table of codes says what each does")]
pub enum Sequence {
    ProbeStrategy,
    AlignZ,
    BedScrews,
    ProbeRepeatability,
    /// M401: deploy the probe.
    DeployProbe,
    /// M402: stow the probe.
    StowProbe,
    LevelingOff,
    SaveGrid,
    ListMeshes,
    UseGrid,
    MeshOffset,
    MeasureBed,
    GridPoint,
    /// M851.1 to M851.5: find the bed's height by hand with a sheet of paper.
    PaperTest,
    /// M665.1 to M665.3: calibration by distances measured on a printed part.
    MeasuredPart,
    AlignSlave,
    /// M78: statistics of the machine's work.
    Statistics,
    /// G27: lift the tool and move to the parking place.
    Park,
    /// M701: load filament into the extruder.
    LoadFilament,
    /// M702: unload filament from the extruder.
    UnloadFilament,
    TunePid,
    WaitForHeaters,
    /// M116 in a form that also waits for heaters that are too warm to cool.
    WaitForTargets,
    /// M524: abort the job.
    AbortJob,
    GoOnWithJob,
    SaveSettings,
}
