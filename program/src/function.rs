//! Functions of the machine apart from motion, by name and by how they are carried out.
//!
//! The table of codes describes the words of each. A function's group says when it acts, so that whoever
//! carries functions out has a match without a catch-all for each group.

/// Function of the machine apart from motion, in its group.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Function {
    /// Sets something at once.
    Setting(Setting),
    /// Says something at once.
    Report(Report),
    /// Deals with files, jobs and saved settings at once.
    File(FileFunction),
    /// Needs motors that stand.
    Standing(Standing),
    /// Takes time.
    Sequence(Sequence),
}

/// Functions that set something and say what is set. They are carried out at once, and never wait.
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
    AxisSpeeds,
    MotorSpeeds,
    Accelerations,
    Jerk,
    CornerSettings,
    SpeedFactor,
    HomeOffsets,
    /// M875: motor phases at the end stops.
    EndstopPhase,
    SoftEndstops,
    Trims,
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
    /// M302: lowest nozzle temperature for extrusion.
    ColdExtrusion,
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
    LoadGrid,
    ListMeshes,
    UseGrid,
    FadeHeight,
    MeshOffset,
    MeasureBed,
    GridPoint,
    BedPlane,
    /// M851.1 to M851.5: find the bed's height by hand with a sheet of paper.
    PaperTest,
    Skew,
    ArmSettings,
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
