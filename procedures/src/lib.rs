//! Sequences that move and measure: homing, probing, leveling, alignment, paper test, endstop phases, tuning
//! and jogging. Each is a function over [`base::hands::Hands`], and reads from top to bottom.
#![cfg_attr(not(test), no_std)]
#![forbid(unsafe_code)]

pub mod alignment;
pub mod arms;
pub mod autotune;
#[cfg(test)]
mod bench;
pub mod driver_tuning;
pub mod endstop_phase;
pub mod homing;
pub mod jog;
pub mod leveling;
pub mod paper;
pub mod probing;
pub mod stall_recovery;
