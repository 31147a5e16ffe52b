//! Heaters, sensors, fans and every other switched output, and the heat safety that watches over them.
//!
//! [`HeatControl`] reads sensors, runs control laws and turns duties into on and off; [`safety`] judges from
//! raw readings and from the commands to the pins alone whether heating may go on. Whoever reviews what keeps
//! a heater from burning reads this crate and nothing else.
//!
//! Pure: no pin, no chip, no clock and no allocation; readings, levels and the time are handed in.
#![cfg_attr(not(test), no_std)]
#![forbid(unsafe_code)]

mod chip_faults;
mod combined;
mod control;
mod effects;
mod fan_drive;
mod filter;
pub mod flow;
mod heater;
mod heater_settings;
pub mod io;
mod law;
mod model;
mod modulator;
mod pulses;
pub mod safety;
mod sensor;
mod step_test;
pub mod surplus;
mod switch_outputs;

pub use combined::{Parts, Rule, read as read_sensor};
pub use config::{LawSettings, ModelSettings, PidGains};
pub use control::{EXECUTOR_TIMEOUT, HeatControl, STALE_MODULATION_TICKS};
pub use effects::{Effects, Full, Output};
pub use heater::{Heater, TargetRefused, Work};
pub use heater_settings::HeaterSettings;
pub use law::{BangBang, Law, Pid};
pub use model::{AIR_C, Model, Surroundings};
pub use modulator::{MODULATION_HZ, Modulators};
pub use safety::{HeatCause, HeatFault, OFF_BELOW, SafetyLimits};
pub use sensor::{Sensor, SensorFault};
pub use step_test::{Answer, Gains, StepTest, TestFailed};
