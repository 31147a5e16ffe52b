//! The interpreter: translates lines of G-code into [`Action`]s for the machine to carry out.
//!
//! Crate `gcode` parses text into words, this crate turns words into actions, and the executor in `machine`
//! carries the actions out. No code here waits, moves or does I/O: an [`Interpreter`] takes a block and the
//! necessary facts about the machine, and returns actions. The machine reports results (a contact, a position
//! after a stop) back.
//!
//! A table, [`codes`], lists the codes with their words, permitted states and kinds of waiting; another,
//! [`commands`], lists the console commands; a third, [`extended`], Klipper's commands by name. Dispatch,
//! `help` and the documentation use these tables.
#![cfg_attr(not(any(test, feature = "docs")), no_std)]
#![forbid(unsafe_code)]

mod action;
mod action_text;
pub mod codes;
pub mod commands;
mod context;
mod control_flow;
mod cycles;
mod dispatch;
pub mod dry_run;
pub mod extended;
mod fault;
mod file_start;
mod flow;
mod function;
mod interpreter;
mod kept_modes;
pub mod laser;
mod lights;
mod meaning;
mod named_parameters;
mod order;
mod parameters;
mod program_copy;
mod remark;
mod resume;
mod script_modes;
pub mod speed_factor;
mod state;
mod states;
mod word;
mod words;
mod words_not_taken;

pub use action::{
    Action, AwaitInput, Centre, Contact, Corner, Effect, InputEvent, Move, Pause, ProbeAlong, ProbeDown, Rate, Shape,
    Turning,
};
pub use codes::{CodeInfo, Waits};
pub use context::{Facts, Meaning};
pub use cycles::{LeftHole, ToCome};
pub use fault::{Fault, Part, Problem};
pub use file_start::{BEGINNING_BYTES, begin_again, beginning, set_flow, standing};
pub use flow::{Flow, FlowFault, FlowProblem, Next, Place};
pub use function::{FileFunction, Function, Geometry, LimitCode, Report, Sequence, Setting, Standing};
pub use gcode::{Dialect, Dialects};
pub use interpreter::Interpreter;
pub use kept_modes::{come_back_to_modes, modes};
pub use lights::{LightChange, Lights};
pub use meaning::objects;
pub use meaning::printers::said_by_m118;
pub use order::{Part as LinePart, Parts as LineParts, arrange};
pub use program_copy::copy_program;
pub use remark::{Remark, write_values};
pub use resume::{go_on_from, same_work_place, take_up_tool};
pub use script_modes::{OperatorModes, ScriptModes};
pub use state::auxiliary::{Auxiliary, Spindle};
pub use state::claims::{Claim, Claims};
pub use state::cycle::{Cycle, Retract};
pub use state::kept::Kept;
pub use state::modal::{COORDINATE_SYSTEMS, FeedMode, Modal, MotionMode, Saved, write_system_name};
pub use state::park::ParkPosition;
pub use state::setup::{
    CycleSetup, HeaterSetup, IoKind, IoSetup, LaserSetup, PulseSetup, ServoSetup, Setup, SpindleSetup, StripSetup,
    ToolSettings,
};
pub use state::tool_table::{MOST_TOOLS, ToolEntry, ToolLineFlaw, ToolTable};
pub use state::tools::{MAX_TOOLS, Tool, Tools};
pub use states::{State, States};
pub use words::Words;
