//! Foundation of all parts of the machine: the world as ports, sessions, safety, failures and their texts,
//! axes and motors, settings that codes change, and [`hands`], the machine as a sequence may use it.
#![cfg_attr(not(any(test, feature = "bench")), no_std)]
#![forbid(unsafe_code)]

pub mod axes;
pub mod bed;
#[cfg(any(test, feature = "bench"))]
pub mod bench;
pub mod brown_out;
pub mod clock_time;
mod code_context;
pub mod failure;
pub mod falling_supply;
pub mod grbl;
pub mod hands;
pub mod laser;
pub mod least_squares;
pub mod motion_config;
pub mod motors;
pub mod needs;
pub mod own_frame;
pub mod paths;
pub mod ports;
pub mod program_setup;
pub mod reason;
pub mod safe_file;
pub mod safety;
pub mod saved_value;
pub mod secrets;
pub mod sessions;
pub mod slicer;
pub mod slow_turning;
pub mod snapshot;
pub mod spread;
pub mod stall_watch;
pub mod supervisor;
pub mod taken_codes;
pub mod tasks;
pub mod touches;
pub mod tuning;
pub mod wait;
pub mod watchdog;
pub mod world;

pub use code_context::CodeContext;
pub use world::{Ports, World};
