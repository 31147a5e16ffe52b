//! The machine description: INI text in, a typed [`MachineConfig`] and located findings out.
//!
//! A single table, [`schema::SECTIONS`], names every setting once, with its type, unit, default, range and
//! meaning. The reader, the checks, the generated reference and the editor all read that table. The reader
//! takes the file in pieces of any size, uses fixed memory and never panics.
//!
//! The crate does no I/O, owns no pin and knows nothing of G-code or motion: it only describes a machine.
#![cfg_attr(not(any(test, feature = "std")), no_std)]
#![allow(rustdoc::broken_intra_doc_links, reason = "help names the sections of a file as in [switch]")]

mod board;
mod check;
mod derive;
mod diagnostic;
pub mod edit;
mod ledger;
mod machine;
mod module;
mod names;
mod off;
mod pin;
mod reader;
#[cfg(any(test, feature = "std"))]
mod render;
mod report;
pub mod schema;
mod sections;
mod setting;
mod suggest;
#[cfg(test)]
mod tests;
mod text;

pub use board::{driven_by, reserved_for};
pub use diagnostic::{Diagnostic, Severity, Sink};
pub use gcode::Code;
pub use machine::*;
pub use off::{MAX_OFF, OffModule};
pub use pin::{OutputPin, Pin, PinFlaw, PinName, Pull, PwmOutput, ThermistorInput, VoltageInput, parse_pin};
pub use reader::{READING_BYTES, Reader, parse};
#[cfg(any(test, feature = "std"))]
pub use render::{render, render_all, to_json};
pub use report::Summary;
pub use schema::Scope;
