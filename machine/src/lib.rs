//! The machine: what happens between a line of text and a planned move, and everything that is not motion.
//!
//! Modal state, dispatch, homing, heat, switches, player, consoles, alarms. It is pure: it sees the world only through
//! [`ports`], asks for the time instead of having it, allocates nothing and never blocks. Sequences that wait (homing,
//! waiting for a temperature) are `async fn` that read top to bottom; at each waiting point consoles are served.
//!
//! It knows no chip, no pin and no executor, and it computes no trajectory: that is `motion`'s.
#![cfg_attr(not(test), no_std)]
#![forbid(unsafe_code)]

mod arcs;
mod arms;
mod autotune;
mod boot;
mod console;
pub mod controller;
mod dispatch;
mod failure;
mod files;
mod halt;
pub mod heat;
mod heat_codes;
mod help;
mod homing;
mod jog;
mod levelling;
mod limits;
mod modal;
pub mod motion_config;
mod motors;
mod moves;
mod offsets;
mod out_of_service;
mod overrides;
mod overrides_text;
mod park;
mod player;
pub mod ports;
mod probing;
mod punctuality;
mod report;
pub mod safe_file;
mod serve;
mod settings_commands;
mod shell;
pub mod splines;
mod state;
mod stopping;
pub mod supervisor;
mod suspend;
mod switches;
mod tools;
mod tuning;
pub mod wait;
pub mod watchdog;

pub use boot::CONFIG_PATH;
pub use controller::Controller;
pub use state::State;
