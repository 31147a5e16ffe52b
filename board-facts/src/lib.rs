//! The Smoothieboard v2 Prime on paper: facts from its schematic (proto10 with TMC2590, proto9 with TMC2660),
//! from data sheets, from the reference manual, and from firmware that is known to run on it. No fact here
//! was taken from Velvet's own firmware.
//!
//! [`wiring`] has the facts by which the simulated machine is wired. [`signals`] and [`figures`] are the
//! conventions: for each signal its level in every state of the machine, for each bus and converter its
//! figures, with the origin of each and the tests that look for it at the pins of the real image.
//! `docs/hardware.md` shows them; a test writes that part of the page.
//!
//! The firmware does not use this crate: its own tables stand in `bsp-prime`, so that a mistake in either is
//! found by the other.
#![cfg_attr(not(test), no_std)]

pub mod figures;
pub mod signal;
pub mod signals;
pub mod wiring;

#[cfg(test)]
mod page;

/// A test that looks for a fact: function and file, from the repository's root.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Proof {
    /// Name of the test function.
    pub test: &'static str,
    /// File of the test function.
    pub file: &'static str,
}
