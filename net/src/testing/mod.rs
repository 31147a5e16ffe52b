//! A network for tests: a wire with faults, a desk at its other end, the board, all in virtual time.

mod bench;
mod desk;
mod dhcp;
mod line;
mod wire;

pub use bench::{BOARD, Bench, MS, SECOND};
pub use desk::DESK;
