//! The board as a micro-controller of a Klipper host: the protocol, and the objects that a host configures.
//!
//! Bytes come in by [`Framer`], blocks are executed by [`Controller::receive`], and [`Controller::run`] does
//! what is due: it is called by a timer's interrupt, with the lock that commands have as well. What a bus
//! takes its time for is handed out as a [`Job`]. Steps go into `motion`'s step queue, whose interrupt plays
//! them at their ticks.
//!
//! The protocol is described in Klipper's `docs/Protocol.md` and `docs/MCU_Commands.md`; nothing here is
//! taken from its source.
#![cfg_attr(not(any(test, feature = "desk")), no_std)]

mod args;
pub mod board;
mod controller;
#[cfg(any(test, feature = "desk"))]
pub mod desk;
mod dictionary;
mod moves;
mod numbers;
mod objects;
mod outbox;
mod reason;
mod steppers;
mod table;
#[cfg(test)]
mod tests;
mod timers;
mod wire;

pub use board::Board;
pub use controller::{Controller, Job};
pub use dictionary::DICTIONARY;
pub use moves::Moves;
pub use numbers::{CLOCK_HZ, RECEIVE_WINDOW};
pub use reason::Reason;
pub use table::{Command, Response};
pub use wire::{BLOCK_BYTES, Block, Framer, Incoming, crc16, read_integer, write_block, write_integer};
