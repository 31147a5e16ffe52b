//! Faults of blocks, with messages for the author of the block.

use core::fmt;

use gcode::Code;
use units::{Axis, HeaterId, SwitchId, ToolId};

/// Part of the machine that an error in the configuration keeps off.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs, reason = "the names are the meaning")]
pub enum Part {
    Probe,
    ZAlignment,
    BedScrews,
    Lathe,
    DrillingCycles,
    Laser,
    Player,
    Extruder(ToolId),
    Heater(HeaterId),
    Switch(SwitchId),
}

/// Reason why a block was not carried out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fault {
    /// Problem with the block.
    pub problem: Problem,
    /// Column of the wrong word, from 1; 0 when no single word is wrong.
    pub column: u16,
    /// Whether the machine halts, so that nothing that follows is carried out.
    pub halts: bool,
}

/// Problem with a block.
#[derive(Clone, Copy, Debug, PartialEq)]
#[allow(missing_docs, reason = "their texts say it")]
pub enum Problem {
    NegativeFeedRate,
    NegativeSpeed,
    NoFeedRate,
    SameGroup(Code, Code),
    AxesTwice(Code, Code),
    UnusedWord(char),
    WordTwice(char),
    ExtruderAxis(Axis),
    NoExtruder,
    NoSuchTool(f64),
    ToolWithoutHeater(u16, ToolId),
    NoHeaterOf(Code, f64),
    PartIsOff(Part),
    NotHomable(char),
    NotParkable(char),
    NotHomed,
    ParkUnknown,
    MustSupply(char),
    DwellRange,
    OffsetKind,
    ToolOfOffset,
    CoordinateSystem,
    RotationHere,
    TurnedPlane,
    CornerTolerance,
    Turns,
    NurbsIsOpen,
    NurbsIsNotOpen,
    SplinePlane,
    BelongTogether(char, char),
    CubicStart,
    CubicEnd,
    QuadraticPoint,
    NurbsWord(char),
    Weight,
    Order(u8, u8),
    ControlPoints,
    TooFewPoints(u8),
    SavedTooOften,
    NothingSaved,
    FlowRange,
    ProbeAxis,
    ProbeNothing,
    ProbeZWithXy,
    ProbeNoWay,
    ProbeRate,
    ProbeSubcode,
    /// Word below the minimum of its row of the table.
    TooLittle(Code, char, f64),
    /// Word above the maximum of its row.
    TooMuch(Code, char, f64),
    /// Word that is not above its row's exclusive bound.
    MustExceed(Code, char, f64),
    NotWhole(Code, char),
    /// Letter that names a heater or an output in another firmware's way.
    NotTaken(Code, char),
    /// Code that sets up the hardware in another firmware.
    SetsUp(Code),
    /// G30 of another firmware, which does more, and the codes to write instead.
    ProbesOtherwise(&'static str),
    /// Code, and the equipment that the machine lacks for the code.
    Needs(Code, &'static str),
    NoSecondPark,
    /// Number of the G-code that stores the parking place.
    NoParkZ(u16),
    CyclesOff,
    /// Number of a cycle's G-code, and the word that the cycle needs.
    CycleNeeds(u16, char),
    /// Number of a cycle's G-code, and a word that the cycle does not use.
    NotOfCycle(u16, char),
    CycleNowhere(u16),
    NotInCycle(char),
    CycleInMachineCoordinates,
    RetractBelow(Axis),
    TooManyPecks,
    NoPlace,
    NoMotionCode,
    NeedsFeedPerMinute,
    InverseTime,
    CentreAbsolute,
    NoName,
    /// Tools are extruders, so there is no tool table.
    NoSpindleTools,
    NotInTable(u16),
    /// Tool whose offset along this rotary axis has no effect.
    RotaryOffset(u16, char),
    ToolOrAxes,
    ToolNumber,
    NothingOfTool,
    NoRotaryOffset,
    Orientation,
    TableFull,
    NoSavedModes,
    HoldStays,
    /// Number for which no switch is an output, an output with a value, or an input.
    NoOutput(u8),
    NoAnalogOutput(u8),
    NoInput(u8),
    NoAnalogInput,
    /// Number for which there is no strip of lights.
    NoStrip(f64),
    /// Number of lights of the strip, which the line exceeds.
    NoLight(u16),
    DigitalOrAnalog,
    NoPatience,
    NoWay,
    PolarAndCartesian,
    PolarAtOrigin,
    SpindleStands,
    /// M4 on a machine whose spindle cannot turn counter-clockwise.
    NoReverse,
    /// Number of a cycle's G-code, and of the M-code for the spindle direction that the cycle needs.
    SpindleTurns(u16, u16),
    /// Number of a cycle's G-code, and of an M-code that no output listens to.
    NothingListens(u16, u16),
    ThreadPlane,
    NoThreadSide,
    ThreadHeight,
    TaperTooLong,
    TooManyPasses,
    /// Parameter that cannot be set.
    Parameter(gcode::Problem),
}

impl Problem {
    /// Returns a fault that refuses the block; other blocks may follow.
    #[must_use]
    pub const fn refused(self, column: u16) -> Fault {
        Fault { problem: self, column, halts: false }
    }

    /// Returns a fault that halts the machine.
    #[must_use]
    pub const fn alarm(self, column: u16) -> Fault {
        Fault { problem: self, column, halts: true }
    }
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.problem.fmt(f)?;
        if self.column > 0 { write!(f, ", column {}", self.column) } else { Ok(()) }
    }
}

impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let text = match *self {
            Self::SameGroup(one, other) => return write!(f, "{one} and {other} exclude each other in one line"),
            Self::AxesTwice(one, other) => return write!(f, "{one} and {other} both need the axes of the line"),
            Self::WordTwice(letter) => return write!(f, "{letter} stands twice in one line"),
            Self::UnusedWord(letter) => return write!(f, "nothing in the line takes {letter}"),
            Self::ExtruderAxis(axis) => return write!(f, "axis {} is an extruder: use E", axis.letter()),
            Self::NoSuchTool(word) => return write!(f, "no extruder has tool_id {word}"),
            Self::ToolWithoutHeater(code, tool) => return write!(f, "M{code}: the active tool T{tool} has no heater"),
            Self::NoHeaterOf(code, word) => return write!(f, "{code}: no heater answers to T{word}"),
            Self::NotHomable(letter) => return write!(f, "G28: {letter} is no axis that can be homed"),
            Self::NotParkable(letter) => return write!(f, "{letter} has no park position"),
            Self::MustSupply(letter) => return write!(f, "Must supply {letter}"),
            Self::BelongTogether(one, other) => return write!(f, "{one} and {other} belong together"),
            Self::NurbsWord(letter) => return write!(f, "G5.2 takes X Y P L only, not {letter}"),
            Self::Order(least, most) => return write!(f, "L is the order, {least} to {most}"),
            Self::ControlPoints => {
                return write!(f, "G5.2 takes {} control points at most", crate::action::MOST_POINTS);
            }
            Self::TooFewPoints(order) => {
                return write!(f, "a spline of order {order} needs as many control points");
            }
            Self::TooLittle(code, letter, least) => return write!(f, "{code}: {letter} is {least} or more"),
            Self::TooMuch(code, letter, most) => return write!(f, "{code}: {letter} is {most} at most"),
            Self::MustExceed(code, letter, bound) => return write!(f, "{code}: {letter} must be above {bound}"),
            Self::NotWhole(code, letter) => return write!(f, "{code}: {letter} must be a whole number"),
            Self::NotTaken(code, letter) => return write!(f, "{code} takes no {letter} here: nothing is changed"),
            Self::SetsUp(code) => return write!(f, "{code} sets the printer up in this dialect: here config.ini does"),
            Self::Parameter(problem) => return problem.fmt(f),
            Self::ProbesOtherwise(instead) => return write!(f, "G30: {instead}"),
            Self::Needs(code, what) => return write!(f, "{code} needs {what} (not there yet)"),
            Self::CycleNeeds(number, letter) => return write!(f, "G{number} needs {letter}"),
            Self::NotOfCycle(number, letter) => {
                return write!(f, "G{number} takes no {letter}: G83 pecks (Q), G82 dwells (P)");
            }
            Self::SpindleTurns(number, code) => {
                return write!(f, "G{number} needs the spindle turning by M{code}: that must come first");
            }
            Self::NothingListens(number, code) => {
                return write!(f, "G{number} needs an output that listens to M{code}: see [switch]");
            }
            Self::CycleNowhere(number) => return write!(f, "G{number} needs X, Y or Z"),
            Self::NotInCycle(letter) => return write!(f, "{letter} cannot move in a canned cycle"),
            Self::RetractBelow(axis) => return write!(f, "R is below {}", axis.letter()),
            Self::NoOutput(number) => return write!(f, "no output has io_number = {number} in [switch]"),
            Self::NoAnalogOutput(number) => {
                return write!(f, "no output that takes a value has io_number = {number} in [switch]");
            }
            Self::NoInput(number) => return write!(f, "no input has io_number = {number} in [switch]"),
            Self::NoStrip(number) => return write!(f, "no strip has number {number} in [led strip]"),
            Self::NoLight(lights) => return write!(f, "the strip has {lights} lights, from 0 on"),
            Self::NotInTable(tool) => return write!(f, "tool {tool} is not in tool.tbl"),
            Self::RotaryOffset(tool, letter) => {
                return write!(f, "tool {tool} has an offset along {letter}: only X Y and Z have one here");
            }
            Self::CyclesOff => "canned cycles are switched off: [drillingcycles] enable",
            Self::CycleInMachineCoordinates => "G53 and canned cycles do not go together",
            Self::TooManyPecks => "Q makes more than 10000 pecks of the hole",
            Self::NoPlace => "that is no place",
            Self::NoMotionCode => "no motion code is in force: G0, G1, ... must come first",
            Self::NeedsFeedPerMinute => "this needs G94: canned cycles, splines and searches take F as length a minute",
            Self::InverseTime => "G93: each such line needs F, 60 for a second, above zero",
            Self::CentreAbsolute => "after G90.1 an arc needs both words of its centre",
            Self::NegativeFeedRate => "feed rate < 0",
            Self::NegativeSpeed => "S is 0 or more",
            Self::NoFeedRate => "Undefined feed rate: F is 0 or missing",
            Self::NoExtruder => "no extruder is configured for E",
            // The machine knows its configuration, and prints a more detailed message.
            Self::PartIsOff(_) => "that part is off: see config.ini",
            Self::NotHomed => "Cannot set predefined position unless axis are homed",
            Self::NoParkZ(number) => {
                return write!(f, "no Z is stored to park at: go to a safe height and store it with G{number}.1");
            }
            Self::NoSecondPark => "cannot move to predefined position as it is not defined (Use G30.1 to define it)",
            Self::ParkUnknown => "cannot move to predefined position as axis are not homed and MCS is unknown",
            Self::DwellRange => "a dwell lasts 0 to 86400 seconds",
            Self::OffsetKind => "G10 takes L0, L1, L2, L10, L11 or L20",
            Self::ToolOfOffset => "G10 L1: P must be the number of a tool plus one",
            Self::CoordinateSystem => "G10: P selects coordinate system 1 to 9, or 0 for the active one",
            Self::RotationHere => "G10 L20 takes no R: G10 L2 turns a coordinate system",
            Self::TurnedPlane => "in a turned coordinate system (G10 L2 R) this lies in the plane of G17",
            Self::CornerTolerance => "P is a distance, zero or more",
            Self::Turns => "P is the number of turns, a whole number above zero",
            Self::NurbsIsOpen => "G5.2 is not closed: G5.3 must come first",
            Self::NurbsIsNotOpen => "G5.3 without G5.2",
            Self::SplinePlane => "splines lie in the plane of G17",
            Self::CubicStart => "G5 needs I and J where no other G5 goes before",
            Self::CubicEnd => "G5 needs P and Q",
            Self::QuadraticPoint => "G5.1 needs I or J",
            Self::Weight => "P is a weight above zero",
            Self::SavedTooOften => "M120 was used 8 times without M121",
            Self::NothingSaved => "M121 without M120",
            Self::FlowRange => "M221: S must be above 0",
            Self::ProbeAxis => "only X Y and Z can be probed along",
            Self::ProbeNothing => "at least one of X Y or Z must be specified",
            Self::ProbeZWithXy => "Z cannot be probed at the same time as X or Y",
            Self::ProbeNoWay => "the way to probe along has no length",
            Self::ProbeRate => "the feed rate of a search must be above zero",
            Self::ProbeSubcode => "Only G38.2 to G38.5 are supported",
            Self::NoSpindleTools => "the tools of this machine are extruders: T selects them, G10 L1 places them",
            Self::ToolOrAxes => "G43.2 takes H, or X Y Z, not both",
            Self::ToolNumber => "P is the number of a tool, 1 to 65535",
            Self::NothingOfTool => "G10: nothing is said of the tool: X Y Z, R, I J, Q",
            Self::NoRotaryOffset => "offsets along A B C can be set by L1 alone",
            Self::Orientation => "Q is the orientation of a tool, 0 to 9",
            Self::TableFull => "the tool table is full",
            Self::PolarAndCartesian => "@ and ^ do not go together with X and Y",
            Self::PolarAtOrigin => "the tool is at the origin: from there @ and ^ have no direction",
            Self::NoWay => "nothing says where to",
            Self::NoReverse => "this spindle has no M4: see input_reverse_command of [switch]",
            Self::SpindleStands => "the spindle stands: M3 or M4 must come first",
            Self::ThreadPlane => "G76 threads in the plane of G18",
            Self::NoThreadSide => "G76: I is below 0 for an external thread, above 0 for an internal one",
            Self::ThreadHeight => "G76: K, the height of the thread, must be above J, the first cut",
            Self::TaperTooLong => "G76: E is more than half of the thread",
            Self::TooManyPasses => "G76: J and R make more than 1000 passes",
            Self::NoSavedModes => "M72 without M70 or M73 in this subroutine",
            Self::HoldStays => "M53 P0: feed hold cannot be switched off",
            Self::NoAnalogInput => "M66: there are no analog inputs",
            Self::DigitalOrAnalog => "M66 takes P or E, not both",
            Self::NoPatience => "M66: Q says how long to wait, in seconds, above 0",
            Self::NoName => "the name of a file is missing",
        };
        f.write_str(text)
    }
}
