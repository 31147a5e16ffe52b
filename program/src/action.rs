//! Actions that the interpreter asks the machine to carry out, one at a time.

use gcode::Code;
use units::{AxisSet, Celsius, HeaterId, Micros, MmPerSecond, PerAxis, Plane, PowerLaw, SwitchId};

use crate::function::Function;
use crate::lights::LightChange;
use crate::words::Words;

/// A single request of the program to the machine.
#[derive(Clone, Copy, Debug)]
pub enum Action<'b> {
    /// Move along a path; the next action does not wait for the end of the move.
    Move(Move),
    /// Dwell for a time after all motion has stopped.
    Dwell(Micros),
    /// Change an output at the point that the path has reached; no motion waits for the change.
    Effect(Effect),
    /// Set a temperature target once all motion has stopped, and wait until the heater reaches the target.
    HeatAndWait {
        /// Heater whose target is set.
        heater: HeaterId,
        /// Target temperature; presets are already resolved.
        target: Celsius,
        /// Whether a warmer heater must cool to the target, too (M109 R); otherwise any warmer temperature
        /// will do.
        cools: bool,
    },
    /// Home the given axes, or all axes with an end stop; the machine reports the position back.
    Home(AxisSet),
    /// Set the machine position, mm; the machine reports the position back.
    SetPosition {
        /// New position by axis; axes without a value keep theirs.
        to: PerAxis<Option<f64>>,
        /// Whether the given axes count as homed.
        homed: bool,
    },
    /// Mark the given axes as not homed.
    ForgetHoming(AxisSet),
    /// Probe downwards for the bed; the machine reports the contact back.
    ProbeDown(ProbeDown),
    /// Probe along a straight line; the machine reports the contact back.
    ProbeAlong(ProbeAlong),
    /// Wait until all motion has stopped.
    Finish,
    /// End of the program (M2, M30).
    EndProgram,
    /// Stop the machine at once (emergency stop).
    Halt,
    /// Clear a halt (M999).
    Release,
    /// Pause the job so that a person can work at the machine.
    Suspend {
        /// Whether heaters keep their targets.
        heaters_stay: bool,
        /// Words that say how to change filament in this pause.
        words: Words<'b>,
    },
    /// Resume the suspended job.
    Resume,
    /// Show a text of the program to the operator.
    Message(&'b str),
    /// Wait for the operator to go on.
    Pause {
        /// Code that causes the pause.
        why: Pause,
        /// Longest wait; `None` waits until the operator goes on.
        time: Option<Micros>,
        /// Text for the operator to read.
        text: Option<&'b str>,
    },
    /// Call a subroutine by its number, a number of times (M98).
    Call {
        /// Number of the called subroutine.
        number: u32,
        /// Number of calls in sequence.
        times: u32,
    },
    /// Return from a subroutine; a main program begins anew (M99).
    Return,
    /// Have the operator change to the tool of this number.
    ChangeTool(u32),
    /// Enable or disable the operator's overrides of feed and spindle once all motion has stopped.
    Overrides {
        /// Whether the override of feed rates counts.
        feed: bool,
        /// Whether the override of spindle speed counts.
        spindle: bool,
        /// Whether feed hold acts at once; otherwise feed hold is postponed, because a tap that stands still
        /// while the spindle turns breaks.
        hold: bool,
    },
    /// Have the operator draw the tool out of the hole by hand (G88).
    RetractByHand,
    /// Wait for an input once all motion has stopped, or read the input; the result comes back.
    AwaitInput(AwaitInput),
    /// Tap rigidly: move to the target in step with the spindle, and back with the spindle reversed (G33.1).
    RigidTap {
        /// Position at the bottom of the thread.
        target: PerAxis<f64>,
        /// Travel for each turn, mm.
        pitch: f64,
        /// Ratio of the spindle's speed on the way back to that on the way in.
        faster: f64,
    },
    /// Orient the spindle to an angle (M19).
    Orient {
        /// Angle of the spindle, degrees.
        degrees: f64,
        /// Direction of the turn to that angle.
        turning: Turning,
        /// Longest time that orienting may take.
        patience: Option<Micros>,
    },
    /// Keep the surface speed S constant, with the spindle at most this fast, 1/min (G96); `None`: constant S
    /// (G97).
    SurfaceSpeed(Option<f64>),
    /// Read the tool table again from the card.
    ReadTools,
    /// Save offsets and the tool table to the card, because the program has changed them.
    Keep,
    /// Tell the sender of the line a remark about the line.
    Note(&'static str),
    /// Acceleration of later moves, mm/s2.
    Acceleration(f64),
    /// Any other function of the machine, with the words of the block.
    Function(Function, Words<'b>),
}

impl Action<'_> {
    /// Whether the motors stand first.
    #[must_use]
    pub fn stands_first(&self) -> bool {
        match self {
            Self::Dwell(_) | Self::HeatAndWait { .. } | Self::Finish | Self::EndProgram => true,
            Self::Home(_) | Self::SetPosition { .. } | Self::ProbeDown(_) | Self::ProbeAlong(_) => true,
            Self::Suspend { .. } | Self::Pause { .. } | Self::ChangeTool(_) | Self::RetractByHand => true,
            Self::Overrides { .. } | Self::AwaitInput(_) | Self::RigidTap { .. } | Self::Orient { .. } => true,
            Self::Function(function, words) => function.stands_first(words),
            Self::Move(_) | Self::Effect(_) | Self::Acceleration(_) | Self::SurfaceSpeed(_) => false,
            Self::ForgetHoming(_) | Self::Call { .. } | Self::Return | Self::Resume => false,
            Self::Halt | Self::Release | Self::Message(_) | Self::Note(_) => false,
            Self::ReadTools | Self::Keep => false,
        }
    }
}

/// A wait for an input (M66, M226).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AwaitInput {
    /// Input to read or wait for.
    pub input: SwitchId,
    /// Event to wait for; `None` reads the input at once.
    pub event: Option<InputEvent>,
    /// Longest time to wait.
    pub patience: Micros,
}

/// Event of an input that ends a wait.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum InputEvent {
    /// Input turns from off to on.
    Rise,
    /// Input turns from on to off.
    Fall,
    /// Input is in the on state.
    High,
    /// Input is in the off state.
    Low,
    /// Input differs from its state at the beginning of the wait.
    Change,
}

impl AwaitInput {
    /// Wait without a time limit.
    pub const FOR_EVER: Micros = Micros(u64::MAX);
}

/// Direction in which the spindle turns to an angle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Turning {
    /// Direction with the smaller angle.
    Shortest,
    /// Direction of M3, clockwise.
    Clockwise,
    /// Direction of M4, counter-clockwise.
    CounterClockwise,
}

/// Change of an output that takes effect where the moves before it end, without stopping any motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Effect {
    /// Target temperature of a heater.
    Target {
        /// Heater whose target is set.
        heater: HeaterId,
        /// Target temperature; presets are already resolved.
        target: Celsius,
    },
    /// State of a switch output.
    Switch {
        /// Switch that is set.
        switch: SwitchId,
        /// Whether the output is on.
        on: bool,
        /// Value of the S word.
        value: Option<f32>,
    },
    /// Arm or disarm a rule of `[temperature switch]`.
    Arm {
        /// Index of the rule in the configuration's list.
        rule: u8,
        /// Whether the rule is armed.
        armed: bool,
    },
    /// Colour of the lights of a strip.
    Light(LightChange),
    /// Nothing to do: a word that its code does not take, and that changes nothing.
    Ignored {
        /// Code that does not take the word.
        code: Code,
        /// Letter of the ignored word.
        letter: char,
    },
}

/// A move that begins at the end of the previous move.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Move {
    /// End position in machine coordinates: X Y Z in mm, A B C in mm of filament or degrees.
    pub target: PerAxis<f64>,
    /// Shape of the path.
    pub shape: Shape,
    /// Speed along the path.
    pub rate: Rate,
    /// Laser power, the S word.
    pub power: f32,
    /// Whether a laser burns along the move, and how its power depends on the speed (M3, M4, M5).
    pub power_law: PowerLaw,
    /// Treatment of the corner at the beginning of the move.
    pub corner: Corner,
}

/// Speed of a move along the path of X Y Z, or of A B C when X Y Z stand still.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Rate {
    /// Rapid traverse rate of G0.
    Rapid(MmPerSecond),
    /// Feed rate of G1 to G5.
    Feed(MmPerSecond),
    /// Feed per revolution of the spindle, mm (G33, G76, and after G95).
    PerRevolution(f64),
    /// Duration of the whole move, seconds (G1 to G3 after inverse time mode, G93).
    Duration(f64),
}

/// Shape of a move's path; distances are in mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shape {
    /// Straight line (G0, G1).
    Line {
        /// Whether the program named X or Y, which can decide whether the line is cut into segments.
        names_xy: bool,
    },
    /// Arc or helix (G2, G3); every axis outside the plane moves linearly along with the arc.
    Arc {
        /// Plane of the arc.
        plane: Plane,
        /// Centre of the arc, or its radius.
        centre: Centre,
        /// Direction from the plane's second axis towards its first: G2, but G3 in the plane of X and Z.
        clockwise: bool,
        /// Number of turns begun; 1 ends at the first arrival at the target.
        turns: u32,
        /// Column of the word that gives the centre, for messages.
        column: u16,
    },
    /// Cubic Bezier in X and Y (G5): offsets of the control points from the start and from the end.
    Cubic([(f64, f64); 2]),
    /// Quadratic Bezier (G5.1): offset of the control point from the start.
    Quadratic((f64, f64)),
    /// NURBS (G5.2) through the control points of [`crate::Interpreter::control_points`].
    Nurbs {
        /// Order of the curve.
        order: u8,
    },
}

/// Centre of an arc.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Centre {
    /// Offset of the centre from the start along the plane's two axes.
    At(f64, f64),
    /// Radius of the arc; a negative radius means more than half a turn.
    Radius(f64),
}

/// Treatment of the corner between two moves: the modal group of G61.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Corner {
    /// G61, exact path: the corner stays sharp.
    #[default]
    Sharp,
    /// G61.1, exact stop: the machine stops in the corner.
    Stop,
    /// G64, rounded within this tolerance, mm; without one, the junction deviation applies.
    Rounded(Option<f64>),
}

/// Change of the probe's contact that ends a probing move.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Contact {
    /// Probe contact closes (touches).
    Closes,
    /// Probe contact opens (releases).
    Opens,
}

/// Probing for the bed (G30).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProbeDown {
    /// Probing rate; `None` uses the configured rate.
    pub rate: Option<MmPerSecond>,
    /// Whether to move against the usual direction.
    pub reversed: bool,
    /// Whether to stay at the contact; otherwise the tool returns.
    pub stays: bool,
    /// Z of the contact in work coordinates, mm, to set the work offset by.
    pub reads: Option<f64>,
}

/// Probing along a straight line (G38).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProbeAlong {
    /// End of the line without a contact, in machine coordinates.
    pub target: PerAxis<f64>,
    /// Probing rate; `None` uses the configured rate.
    pub rate: Option<MmPerSecond>,
    /// Contact change that ends the move.
    pub until: Contact,
    /// Whether a line without a contact is an alarm.
    pub must_find: bool,
}

/// Code by which a program waits for the operator.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pause {
    /// M0, unconditional program stop.
    Program,
    /// M1, optional program stop.
    Optional,
    /// M60, pallet change stop.
    Pallet,
}
