//! The machine in three rooms: `machine`, its owners and the services that all work needs; `features`; and
//! `executor`, the one loop over all of it.
//!
//! The executor reads lines, has crate `program` say what they mean, and carries that out with the owners of
//! the machine's parts, which stand in crates of their own: `base`, `thermal`, `parts`, `jobs`, `procedures`,
//! `preflight`. The crate is pure: it sees the world only through [`base::Ports`], asks for the time instead
//! of having it, and allocates nothing. Sequences that take time (homing, waiting for a temperature) read top
//! to bottom and wait by a call, which serves everybody else.
//!
//! The crate knows no chip, no pin and no runtime, and computes no trajectory: that is `motion`'s.
#![cfg_attr(not(test), no_std)]
#![forbid(unsafe_code)]

mod executor;
mod features;
mod machine;

pub use executor::{Lasting, run};
/// Memory of macros, as the board gives it.
pub use printer_cfg::{
    CODE_BYTES as MACRO_CODE_BYTES, LINES_BYTES as MACRO_LINES_BYTES, Memory as MacroMemory, Scratch as MacroText,
    Store as MacroStore, Variables as MacroVariables,
};
