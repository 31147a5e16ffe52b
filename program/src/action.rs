//! What the machine is asked to do, one thing at a time.

use gcode::Code;
use units::{AxisSet, Celsius, HeaterId, Micros, MmPerSecond, PerAxis, Plane, SwitchId};

use crate::lights::LightChange;
use crate::words::Words;

/// One thing for the machine to do.
#[derive(Clone, Copy, Debug)]
pub enum Action<'b> {
    /// Go along a path. What follows does not wait for its end.
    Move(Move),
    /// Wait this long, once nothing moves.
    Dwell(Micros),
    /// Change an output where the path has come this far; nothing waits.
    Effect(Effect),
    /// Set a target once nothing moves, and wait until it is reached.
    HeatAndWait {
        /// Which temperature control.
        heater: HeaterId,
        /// The target; presets are resolved.
        target: Celsius,
        /// Also until it has come down to it (M109 R); else what is warmer is warm enough.
        cools: bool,
    },
    /// Find the switches of these axes, or of all that have one. The position comes back.
    Home(AxisSet),
    /// The machine is at these machine positions, mm. The position comes back.
    SetPosition {
        /// By axis; what is not given stays.
        to: PerAxis<Option<f64>>,
        /// Those given count as homed.
        homed: bool,
    },
    /// Forget that these axes are homed.
    ForgetHoming(AxisSet),
    /// Search for the bed. The contact comes back.
    ProbeDown(ProbeDown),
    /// Search along a line. The contact comes back.
    ProbeAlong(ProbeAlong),
    /// Wait until nothing moves.
    Finish,
    /// The program is over.
    EndProgram,
    /// Emergency stop.
    Halt,
    /// Clear a halt.
    Release,
    /// Pause the job, so that somebody can work at the machine.
    Suspend {
        /// Heaters keep their targets.
        heaters_stay: bool,
        /// How filament is changed this time.
        words: Words<'b>,
    },
    /// Go on with the suspended job.
    Resume,
    /// Show the operator a text of the program.
    Message(&'b str),
    /// Wait for the operator.
    Pause {
        /// Which code says so.
        why: Pause,
        /// How long it waits; `None`: until the operator goes on.
        time: Option<Micros>,
        /// What the operator is to read.
        text: Option<&'b str>,
    },
    /// Call a subroutine by its number, so many times (M98).
    Call {
        /// The number.
        number: u32,
        /// How often.
        times: u32,
    },
    /// The subroutine ends; the main program begins anew (M99).
    Return,
    /// Have the operator put in this tool.
    ChangeTool(u32),
    /// Whether the operator's overrides of feed and spindle count, once nothing moves.
    Overrides {
        /// That of feed rates.
        feed: bool,
        /// That of the spindle's speed.
        spindle: bool,
        /// Feed hold acts at once; else it waits until it may: a tap that stands while the spindle turns
        /// breaks.
        hold: bool,
    },
    /// Have the operator draw the tool out of the hole by hand (G88).
    RetractByHand,
    /// Wait for an input once nothing moves, or read it. What was found comes back.
    AwaitInput(AwaitInput),
    /// Go there as the spindle turns, and back as it turns the other way (G33.1).
    RigidTap {
        /// Where to.
        target: PerAxis<f64>,
        /// Travel of a turn, mm.
        pitch: f64,
        /// How many times faster the spindle turns on the way back.
        faster: f64,
    },
    /// Turn the spindle to an angle.
    Orient {
        /// Where to.
        degrees: f64,
        /// Which way.
        turning: Turning,
        /// How long at most.
        patience: Option<Micros>,
    },
    /// The spindle turns so that the surface has the speed S, no faster than this, 1/min; none: with S.
    SurfaceSpeed(Option<f64>),
    /// Read the tool table anew from the card.
    ReadTools,
    /// The program has changed what is kept on the card: offsets, the tool table.
    Keep,
    /// Tell whoever sent the line something about it.
    Note(&'static str),
    /// Moves accelerate with so much from now on, mm/s2.
    Acceleration(f64),
    /// Everything else, with its words.
    Function(Function, Words<'b>),
}

/// A wait for an input (M66, M226).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AwaitInput {
    /// Which.
    pub input: SwitchId,
    /// For what; none: it is read as it is.
    pub event: Option<InputEvent>,
    /// How long at most.
    pub patience: Micros,
}

/// What an input does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum InputEvent {
    /// It turns on.
    Rise,
    /// It turns off.
    Fall,
    /// It is on.
    High,
    /// It is off.
    Low,
    /// It is the other way than at first.
    Change,
}

impl AwaitInput {
    /// As long as it takes.
    pub const FOR_EVER: Micros = Micros(u64::MAX);
}

/// Which way the spindle turns to an angle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Turning {
    /// The shorter one.
    Shortest,
    /// As M3 turns it.
    Clockwise,
    /// As M4 does.
    CounterClockwise,
}

/// What rides on the path: it takes effect where the moves before it end, and stops nothing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Effect {
    /// A heater's target.
    Target {
        /// Which temperature control.
        heater: HeaterId,
        /// The target; presets are resolved.
        target: Celsius,
    },
    /// A switch output.
    Switch {
        /// Which.
        switch: SwitchId,
        /// On or off.
        on: bool,
        /// The S word.
        value: Option<f32>,
    },
    /// A rule that follows a temperature acts from now on, or no longer.
    Arm {
        /// Its place in the configuration's list.
        rule: u8,
        /// Whether it acts.
        armed: bool,
    },
    /// The colour of lights.
    Light(LightChange),
    /// Nothing: a word that its code does not take, and that changes nothing.
    Ignored {
        /// The code that does not take it.
        code: Code,
        /// Its letter.
        letter: char,
    },
}

/// A move from where the last one ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Move {
    /// Where it ends, in machine space: X Y Z in mm, A B C in mm of filament or degrees.
    pub target: PerAxis<f64>,
    /// The way there.
    pub shape: Shape,
    /// How fast.
    pub rate: Rate,
    /// S, for a laser.
    pub power: f32,
    /// The corner at its beginning.
    pub corner: Corner,
}

/// How fast a move goes, along the path of X Y Z; along A B C when these stand still.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Rate {
    /// Positioning (G0).
    Rapid(MmPerSecond),
    /// Working (G1 to G5).
    Feed(MmPerSecond),
    /// So far along the path with each turn of the spindle, mm (G33, G76, and after G95).
    PerRevolution(f64),
    /// Working, so that the whole move takes so many seconds (G1 to G3 after G93).
    Duration(f64),
}

/// The way of a move. Distances are in mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shape {
    /// Straight.
    Line {
        /// The program named X or Y: where lines are cut, this one is.
        names_xy: bool,
    },
    /// G2 and G3. Every axis that is not in the plane goes along evenly.
    Arc {
        /// Its plane.
        plane: Plane,
        /// Where its centre is.
        centre: Centre,
        /// From the plane's second axis towards its first one: G2, in the plane of X and Z G3.
        clockwise: bool,
        /// Turns begun: with 1 the end is reached at once.
        turns: u32,
        /// Column of the word that says where the centre is.
        column: u16,
    },
    /// G5, in the plane of X and Y: from the start to the first control point, from the end to the second.
    Cubic([(f64, f64); 2]),
    /// G5.1: from the start to the control point.
    Quadratic((f64, f64)),
    /// G5.2: of this order, through the control points of [`crate::Interpreter::control_points`].
    Nurbs {
        /// Its order.
        order: u8,
    },
}

/// Where an arc's centre is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Centre {
    /// This far from the start along the plane's two axes.
    At(f64, f64),
    /// At this radius; negative: the arc is more than half a turn.
    Radius(f64),
}

/// What becomes of the corner between two moves: the modal group of G61.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Corner {
    /// G61: it stays as sharp as it is.
    #[default]
    Sharp,
    /// G61.1: the machine stops in it.
    Stop,
    /// G64: it is rounded, leaving it by so many mm at most; by the junction deviation when none is given.
    Rounded(Option<f64>),
}

/// Most control points of a NURBS.
pub const MOST_POINTS: usize = 32;

/// A control point of a NURBS.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ControlPoint {
    /// Machine position, mm.
    pub x: f64,
    /// Machine position, mm.
    pub y: f64,
    /// Its weight, above zero.
    pub weight: f64,
}

/// Which change of the probe's contact ends a search.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Contact {
    /// It closes.
    Closes,
    /// It opens.
    Opens,
}

/// A search for the bed (G30).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProbeDown {
    /// How fast; the configured rate when none is given.
    pub rate: Option<MmPerSecond>,
    /// Against the usual direction.
    pub reversed: bool,
    /// Stay where the contact was; else return.
    pub stays: bool,
    /// What Z of the contact is to read, in work coordinates, mm.
    pub reads: Option<f64>,
}

/// A search along a straight line (G38).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProbeAlong {
    /// Where it ends without a contact, in machine space.
    pub target: PerAxis<f64>,
    /// How fast; the configured rate when none is given.
    pub rate: Option<MmPerSecond>,
    /// What ends it.
    pub until: Contact,
    /// Nothing found is an alarm.
    pub must_find: bool,
}

/// What machines do beside moving, by name. Each has its words, which its row in the table of codes
/// describes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs, reason = "the table of codes says what each does")]
pub enum Function {
    // Probing and leveling.
    ProbeStrategy,
    AlignZ,
    BedScrews,
    ProbeRepeatability,
    /// M401: bring the probe out.
    DeployProbe,
    /// M402: put it away.
    StowProbe,
    ProbeSettings,
    LevelingOff,
    SaveGrid,
    DeleteGrid,
    LoadGrid,
    ListMeshes,
    ShowGrid,
    ShowMap,
    UseGrid,
    FadeHeight,
    MeshOffset,
    MeasureBed,
    GridPoint,
    ProbePoint,
    BedPlane,
    ProbeOffset,
    /// M851.1 to M851.5: a person feels with paper where the bed is.
    PaperTest,
    /// M851.6: what the probe reads too high along an axis.
    AxisTwist,
    /// M851: the same as Marlin counts it.
    MarlinProbeOffset,
    Skew,
    // Motors and the machine's geometry.
    MotorsOn,
    MotorsOff,
    StepsPerMm,
    AxisSpeeds,
    MotorSpeeds,
    Accelerations,
    Jerk,
    InputShaping,
    CornerSettings,
    SpeedFactor,
    PressureAdvance,
    HomeOffsets,
    /// M875: the phases that motors have at their switches.
    EndstopPhase,
    SoftEndstops,
    ArmSettings,
    /// M665.1 to M665.3: distances measured on a printed part.
    MeasuredPart,
    Trims,
    MotorMilliamps,
    MotorAmps,
    DriverStatus,
    DriverChopper,
    DriverRegister,
    DriverOption,
    /// M912: what was told of drivers is news again.
    ForgetDriverTroubles,
    /// M913: up to which speed stealthChop drives.
    StealthThresholds,
    /// M569: stealthChop, or never.
    StealthMode,
    /// M914: what counts as a stall while an axis homes.
    HomingThresholds,
    Microsteps,
    MotorPositions,
    HomeOffsetsFromHere,
    AlignSlave,
    /// M290.1: what makes up for a frame that grows with its temperature.
    ThermalAdjust,
    // Extruders.
    FilamentDiameter,
    /// M78: what the machine has done.
    Statistics,
    /// M404 to M407, M412: the filament detector.
    FilamentDetector,
    /// M404.1 to M407.2: the sensor of the filament's width alone.
    FilamentWidth,
    /// M603: lengths of a change of filament.
    FilamentLengths,
    /// G27: lift the tool and go aside.
    Park,
    /// M701: push filament in.
    LoadFilament,
    /// M702: take filament out.
    UnloadFilament,
    RetractSettings,
    RecoverSettings,
    FlowFactor,
    // Heat.
    ReportTemperatures,
    MaximumTemperature,
    PidGains,
    HeaterModel,
    TunePid,
    Sensor,
    WaitForHeaters,
    /// M116 where it waits until what is too warm has cooled, too.
    WaitForTargets,
    /// M302: how warm a nozzle must be to extrude.
    ColdExtrusion,
    // Reports.
    ReportHoming,
    ReportPosition,
    ReportFirmware,
    ReportSwitches,
    ReportFans,
    /// M155: temperatures are said by themselves.
    AutoReport,
    /// M113: that a line is in work is said.
    Keepalive,
    SayToAll,
    LabelObject,
    // Files and settings.
    ListFiles,
    Mount,
    SelectFile,
    StartJob,
    PauseJob,
    RestartJob,
    /// M524: the job is over.
    AbortJob,
    PowerLoss,
    GoOnWithJob,
    ReportJob,
    ReportProgress,
    Upload,
    EndUpload,
    RemoveFile,
    StartFile,
    SaveSettings,
    LoadSettings,
    ForgetSettings,
    ShowSettings,
}

/// Why a program waits for the operator.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pause {
    /// M0.
    Program,
    /// M1.
    Optional,
    /// M60.
    Pallet,
}
