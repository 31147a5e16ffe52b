//! The machine: what happens between a line of text and a planned move, and everything that is not motion.
//!
//! A single executor reads lines, has crate `program` say what they mean, and carries that out with the
//! owners of the machine's parts: homing, heat, switches, jobs, sessions, alarms. The crate is pure: it sees
//! the world only through [`ports`], asks for the time instead of having it, and allocates nothing. Sequences
//! that take time (homing, waiting for a temperature) read top to bottom and wait by a call, which serves
//! everybody else.
//!
//! The crate knows no chip, no pin and no runtime, and computes no trajectory: that is `motion`'s.
#![cfg_attr(not(test), no_std)]
#![forbid(unsafe_code)]

mod alignment;
mod apart;
mod arms;
mod autotune;
mod axes;
mod bed;
mod brown_out;
mod buttons;
mod clock_time;
mod drawing;
mod driver_codes;
mod driver_tuning;
mod endstop_phase;
mod executor;
mod failure;
mod falling_supply;
mod fans;
mod filament;
mod files;
mod forecast;
mod gpio;
mod grbl;
mod hands;
mod heat_codes;
mod homing;
mod jobs;
mod jog;
mod journal;
mod least_squares;
mod leveling;
mod lights;
mod motion_codes;
pub mod motion_config;
mod motors;
mod needs;
mod outputs;
mod paper;
mod paths;
pub mod ports;
pub mod preflight;
mod probing;
mod procedures;
mod program_setup;
mod reason;
mod reports;
pub mod safe_file;
pub mod safety;
mod saved_settings;
mod saved_value;
pub mod sessions;
mod slow_turning;
mod spread;
mod stall_recovery;
mod stall_watch;
mod strips;
pub mod supervisor;
pub mod tasks;
mod thermal;
mod touches;
mod tuning;
mod wait;
pub mod watchdog;

pub use executor::{Lasting, run};
pub use failure::Texts;
pub use files::kept;
pub use jobs::Layers;
pub use leveling::{findings, form, map, profile_file};
pub use paths::CONFIG_PATH;
pub use program::{Dialect, State};
