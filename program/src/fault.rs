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

/// Declares the problems, each with its text: first those whose text is always the same, then those with
/// values, whose text is as for [`write!`].
macro_rules! problems {
    (
        { $( $(#[$fixed_doc:meta])* $fixed:ident = $text:literal, )* }
        { $( $(#[$doc:meta])* $name:ident($($value:ident: $kind:ty),+) = $format:literal $(, $argument:expr)*; )* }
    ) => {
        /// Problem with a block.
        #[derive(Clone, Copy, Debug, PartialEq)]
        #[allow(missing_docs, reason = "their texts say it")]
        pub enum Problem {
            $( $(#[$fixed_doc])* $fixed, )*
            $( $(#[$doc])* $name($($kind),+), )*
        }

        impl fmt::Display for Problem {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                let text = match *self {
                    $( Self::$fixed => $text, )*
                    $( Self::$name($($value),+) => return write!(f, $format $(, $argument)*), )*
                };
                f.write_str(text)
            }
        }
    };
}

problems! {
    {
        NegativeFeedRate = "feed rate < 0",
        NegativeSpeed = "S is 0 or more",
        NoFeedRate = "Undefined feed rate: F is 0 or missing",
        NoExtruder = "no extruder is configured for E",
        NotHomed = "Cannot set predefined position unless axis are homed",
        ParkUnknown = "cannot move to predefined position as axis are not homed and MCS is unknown",
        DwellRange = "a dwell lasts 0 to 86400 seconds",
        OffsetKind = "G10 takes L0, L1, L2, L10, L11 or L20",
        ToolOfOffset = "G10 L1: P must be the number of a tool plus one",
        CoordinateSystem = "G10: P selects coordinate system 1 to 9, or 0 for the active one",
        RotationHere = "G10 L20 takes no R: G10 L2 turns a coordinate system",
        TurnedPlane = "in a turned coordinate system (G10 L2 R) this lies in the plane of G17",
        CornerTolerance = "P is a distance, zero or more",
        Turns = "P is the number of turns, a whole number above zero",
        NurbsIsOpen = "G5.2 is not closed: G5.3 must come first",
        NurbsIsNotOpen = "G5.3 without G5.2",
        SplinePlane = "splines lie in the plane of G17",
        CubicStart = "G5 needs I and J where no other G5 goes before",
        CubicEnd = "G5 needs P and Q",
        QuadraticPoint = "G5.1 needs I or J",
        Weight = "P is a weight above zero",
        SavedTooOften = "M120 was used 8 times without M121",
        NothingSaved = "M121 without M120",
        FlowRange = "M221: S must be above 0",
        ProbeAxis = "only X Y and Z can be probed along",
        ProbeNothing = "at least one of X Y or Z must be specified",
        ProbeZWithXy = "Z cannot be probed at the same time as X or Y",
        ProbeNoWay = "the way to probe along has no length",
        ProbeRate = "the feed rate of a search must be above zero",
        ProbeSubcode = "Only G38.2 to G38.5 are supported",
        NoSecondPark = "cannot move to predefined position as it is not defined (Use G30.1 to define it)",
        CyclesOff = "canned cycles are switched off: [drillingcycles] enable",
        CycleInMachineCoordinates = "G53 and canned cycles do not go together",
        TooManyPecks = "Q makes more than 10000 pecks of the hole",
        NoPlace = "that is no place",
        NoMotionCode = "no motion code is in force: G0, G1, ... must come first",
        NeedsFeedPerMinute = "this needs G94: canned cycles, splines and searches take F as length a minute",
        InverseTime = "G93: each such line needs F, 60 for a second, above zero",
        CentreAbsolute = "after G90.1 an arc needs both words of its centre",
        NoName = "the name of a file is missing",
        /// Tools are extruders, so there is no tool table.
        NoSpindleTools = "the tools of this machine are extruders: T selects them, G10 L1 places them",
        ToolOrAxes = "G43.2 takes H, or X Y Z, not both",
        ToolNumber = "P is the number of a tool, 1 to 65535",
        NothingOfTool = "G10: nothing is said of the tool: X Y Z, R, I J, Q",
        NoRotaryOffset = "offsets along A B C can be set by L1 alone",
        Orientation = "Q is the orientation of a tool, 0 to 9",
        TableFull = "the tool table is full",
        NoSavedModes = "M72 without M70 or M73 in this subroutine",
        HoldStays = "M53 P0: feed hold cannot be switched off",
        NoAnalogInput = "M66: there are no analog inputs",
        DigitalOrAnalog = "M66 takes P or E, not both",
        NoPatience = "M66: Q says how long to wait, in seconds, above 0",
        NoWay = "nothing says where to",
        PolarAndCartesian = "@ and ^ do not go together with X and Y",
        PolarAtOrigin = "the tool is at the origin: from there @ and ^ have no direction",
        SpindleStands = "the spindle stands: M3 or M4 must come first",
        /// M4 on a machine whose spindle cannot turn counter-clockwise.
        NoReverse = "this spindle has no M4: see input_reverse_command of [switch]",
        /// A list of powers where none can be.
        Pixels = "S with : or @ takes 32 powers of 1 to 65535 pixels at most, on a straight G1 (G94), with a laser",
        ThreadPlane = "G76 threads in the plane of G18",
        NoThreadSide = "G76: I is below 0 for an external thread, above 0 for an internal one",
        ThreadHeight = "G76: K, the height of the thread, must be above J, the first cut",
        TaperTooLong = "G76: E is more than half of the thread",
        TooManyPasses = "G76: J and R make more than 1000 passes",
    }
    {
        SameGroup(one: Code, other: Code) = "{one} and {other} exclude each other in one line";
        AxesTwice(one: Code, other: Code) = "{one} and {other} both need the axes of the line";
        UnusedWord(letter: char) = "nothing in the line takes {letter}";
        WordTwice(letter: char) = "{letter} stands twice in one line";
        ExtruderAxis(axis: Axis) = "axis {} is an extruder: use E", axis.letter();
        NoSuchTool(word: f64) = "no extruder has tool_id {word}";
        ToolWithoutHeater(code: u16, tool: ToolId) = "M{code}: the active tool T{tool} has no heater";
        NoHeaterOf(code: Code, word: f64) = "{code}: no heater answers to T{word}";
        /// Part that is off. The machine knows its configuration, and prints a more detailed message.
        PartIsOff(_part: Part) = "that part is off: see config.ini";
        NotHomable(letter: char) = "G28: {letter} is no axis that can be homed";
        NotParkable(letter: char) = "{letter} has no park position";
        MustSupply(letter: char) = "Must supply {letter}";
        BelongTogether(one: char, other: char) = "{one} and {other} belong together";
        NurbsWord(letter: char) = "G5.2 takes X Y P L only, not {letter}";
        Order(least: u8, most: u8) = "L is the order, {least} to {most}";
        /// Greatest number of control points.
        ControlPoints(most: usize) = "G5.2 takes {most} control points at most";
        TooFewPoints(order: u8) = "a spline of order {order} needs as many control points";
        /// Word below the minimum of its row of the table.
        TooLittle(code: Code, letter: char, least: f64) = "{code}: {letter} is {least} or more";
        /// Word above the maximum of its row.
        TooMuch(code: Code, letter: char, most: f64) = "{code}: {letter} is {most} at most";
        /// Word that is not above its row's exclusive bound.
        MustExceed(code: Code, letter: char, bound: f64) = "{code}: {letter} must be above {bound}";
        NotWhole(code: Code, letter: char) = "{code}: {letter} must be a whole number";
        /// Letter that names a heater or an output in another firmware's way.
        NotTaken(code: Code, letter: char) = "{code} takes no {letter} here: nothing is changed";
        /// Code that sets up the hardware in another firmware.
        SetsUp(code: Code) = "{code} sets the printer up in this dialect: here config.ini does";
        /// G30 of another firmware, which does more, and the codes to write instead.
        ProbesOtherwise(instead: &'static str) = "G30: {instead}";
        /// Code, and the equipment that the machine lacks for the code.
        Needs(code: Code, what: &'static str) = "{code} needs {what} (not there yet)";
        /// Number of the G-code that stores the parking place.
        NoParkZ(number: u16) = "no Z is stored to park at: go to a safe height and store it with G{number}.1";
        /// Number of a cycle's G-code, and the word that the cycle needs.
        CycleNeeds(number: u16, letter: char) = "G{number} needs {letter}";
        /// Number of a cycle's G-code, and a word that the cycle does not use.
        NotOfCycle(number: u16, letter: char) = "G{number} takes no {letter}: G83 pecks (Q), G82 dwells (P)";
        CycleNowhere(number: u16) = "G{number} needs X, Y or Z";
        NotInCycle(letter: char) = "{letter} cannot move in a canned cycle";
        RetractBelow(axis: Axis) = "R is below {}", axis.letter();
        NotInTable(tool: u16) = "tool {tool} is not in tool.tbl";
        /// Tool whose offset along this rotary axis has no effect.
        RotaryOffset(tool: u16, letter: char) =
            "tool {tool} has an offset along {letter}: only X Y and Z have one here";
        /// Number for which no switch is an output, an output with a value, or an input.
        NoOutput(number: u8) = "no output has io_number = {number} in [switch]";
        NoAnalogOutput(number: u8) = "no output that takes a value has io_number = {number} in [switch]";
        NoInput(number: u8) = "no input has io_number = {number} in [switch]";
        /// Number for which there is no strip of lights.
        NoStrip(number: f64) = "no strip has number {number} in [led strip]";
        /// Number of lights of the strip, which the line exceeds.
        NoLight(lights: u16) = "the strip has {lights} lights, from 0 on";
        /// Number of a cycle's G-code, and of the M-code for the spindle direction that the cycle needs.
        SpindleTurns(number: u16, code: u16) = "G{number} needs the spindle turning by M{code}: that must come first";
        /// Number of a cycle's G-code, and of an M-code that no output listens to.
        NothingListens(number: u16, code: u16) = "G{number} needs an output that listens to M{code}: see [switch]";
        /// Parameter that cannot be set.
        Parameter(problem: gcode::Problem) = "{problem}";
    }
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
