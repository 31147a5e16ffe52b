//! The Smoothieboard v2 Prime on paper: facts from its schematic (proto10 with TMC2590, proto9 with TMC2660), from data sheets, from the
//! reference manual, and from firmware that is known to run on it. No fact here was taken from Velvet's own firmware.
//!
//! [`wiring`] is what the simulated machine is wired by.
//!
//! The firmware does not use this crate: its own tables stand in `bsp-prime`, so that a mistake in one of the two is found by the other.
#![cfg_attr(not(test), no_std)]

pub mod wiring;
