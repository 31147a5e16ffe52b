//! Vocabulary that every Velvet crate shares: quantities with their unit in the type, the sets of axes and
//! actuators of a machine, and the clock of step times.
//!
//! A single internal system of units: millimetre, second, degree Celsius, ampere. Minutes and inches end in
//! the G-code interpreter. The crate does no I/O and knows nothing of G-code, configuration or hardware.
#![cfg_attr(not(test), no_std)]

mod arms;
mod axis;
mod axis_set;
mod coil;
mod colour;
mod control_point;
pub mod convert;
mod cutting;
mod heater;
mod interpolation;
mod plane;
mod power_law;
mod quantity;
mod shaper;
mod short_ring;
mod sort;
mod steps;
mod thermocouple;
mod tick_time;
mod time;
mod tool;
mod tool_settings;
mod within;

pub use arms::{Deltesian, LinearDeltaGeometry, Morgan, RotaryDelta};
pub use axis::{Actuator, Axis, MAX_ACTUATORS, MAX_AXES, PerActuator, PerAxis};
pub use axis_set::AxisSet;
pub use coil::{ChopperFit, Coil};
pub use colour::{Colour, ColourOrder};
pub use control_point::{ControlPoint, MOST_CONTROL_POINTS};
pub use cutting::{ArcSettings, LineSettings};
pub use heater::{HeaterId, MAX_HEATERS, SwitchId};
pub use interpolation::{Interpolation, MOST_SIDE};
pub use plane::Plane;
pub use power_law::PowerLaw;
pub use quantity::{Amps, Celsius, Duty, Mm, MmPerSecond, MmPerSecond2, MmPerSecond3, Ohms, Volts};
pub use shaper::ShaperKind;
pub use short_ring::Ring;
pub use sort::sort_short;
pub use steps::{Direction, StepCount, StepPosition};
pub use thermocouple::Thermocouple;
pub use tick_time::{TickTime, at_tick, seconds_between, seconds_of, tick_time, whole_ticks};
pub use time::{Micros, STEP_CLOCK_HZ, TICK_NANOSECONDS, Ticks};
pub use tool::ToolId;
pub use tool_settings::{CycleSetup, ServoSetup, ToolSettings};
pub use within::within;
