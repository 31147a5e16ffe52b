//! A controller on the desk: a board of memory, and a host at its line. For tests, of this crate and of
//! others.
#![allow(clippy::expect_used, clippy::panic, reason = "a test that cannot go on ends so")]

mod bench;
mod chip;
mod wires;

pub use bench::{Bench, Said};
pub use chip::I2cChip;
pub use wires::{Desk, LineAnswer, Wires};
