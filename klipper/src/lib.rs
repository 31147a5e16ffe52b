//! The board as a micro-controller of a Klipper host: the protocol, and the objects that a host configures.
#![cfg_attr(not(test), no_std)]

pub mod board;
mod reason;

pub use board::Board;
pub use reason::Reason;
