//! SD cards: identification, and the card's blocks for several users at once, as state machines that never
//! wait.
//!
//! Source: SD Specifications Part 1, Physical Layer Simplified Specification 6.00 (below: PL 6.00).
//!
//! | file | what |
//! |---|---|
//! | `host` | what a host controller has to do for it |
//! | `registers` | CSD, SCR, CID, card status and the answer of CMD6, read from bits |
//! | `identify` | from power-on to the transfer state, at the fastest clock that card and host allow |
//! | `block_transfer` | one transfer of blocks with its commands, tried again where it errs |
//! | `write_queue`, `read_ahead`, `recent_blocks` | blocks queued for the card, read ahead for one reader, kept for all |
//! | `service` | all of it: who may use the card next, and what is known of it |
//!
//! # Waiting
//!
//! A [`Service`] is moved on by [`Service::advance`], from the controller's interrupt and from a clock that
//! ticks at least a few times a millisecond. The service never waits, and an `advance` is some hundred
//! instructions.
//!
//! - **Writes** are put into a queue and go to the card strictly in the order they came in, so a power
//!   cut leaves the same as with writes that are waited for: all of them up to one. A block that is
//!   written again while it is the last of the queue replaces it there. Consecutive blocks go with one
//!   command. After a lasting failure of a write, those behind it are dropped, as if the power had gone
//!   there, and nothing is written until [`Service::forgive`].
//! - **Reads** are answered from the queue, from what is read ahead and from groups of blocks that were read
//!   lately. A missing block is asked for, and [`Read::NotYet`] is the answer until it has come.
//! - **Reading ahead** follows stretches of blocks that the reader of a file hands in ([`Service::follow`]):
//!   so it goes along the chain of a fragmented file as well.
//! - **Order**: first the blocks that somebody asked for, then reading ahead until half of its
//!   room is filled, then writes, then the rest of reading ahead. While a file is read ahead, writes go one
//!   block a command: a card may take a quarter of a second for each.
//! - [`Service::hold`] keeps writes back, so that somebody who reads and writes a few blocks by turns does
//!   not find the card busy with the first of them.
//!
//! # Mass storage
//!
//! Mass storage over USB has the whole card, while the file system has not: [`Service::lend`], then
//! [`Service::begin`] and [`Service::lent`] for each transfer of blocks between the card and memory that the
//! host's DMA reaches, and [`Service::take_back`].

mod block_transfer;
mod error;
mod host;
mod identify;
mod read_ahead;
mod recent_blocks;
mod registers;
mod service;
mod write_queue;

#[cfg(test)]
mod tests;

pub use error::{SdError, Unsupported};
pub use host::{Answer, Block, Command, Direction, Fault, Host, Place, Power, Progress, Transfer};
pub use read_ahead::Run;
pub use registers::{CardInfo, Cid, Kind};
pub use service::{Counters, Event, Lent, Read, Service, State};

/// Bytes of a block.
pub const BLOCK_BYTES: usize = 512;

/// Blocks that can wait to be written.
pub const QUEUE_BLOCKS: usize = 32;
/// Blocks read ahead for the current reader: 327 ms at 5,000 lines a second of 30 bytes each, and a card may
/// stall for 250 ms (PL 6.00 section 4.6.2).
pub const AHEAD_BLOCKS: usize = 96;
/// Number of groups of consecutive blocks kept for all users.
pub const GROUPS: usize = 2;
/// Blocks of a group.
pub const GROUP_BLOCKS: usize = 8;

/// Blocks of memory that the host's DMA reaches and that a [`Service`] needs; the last is for registers of
/// the card and for blocks read back.
pub const SLOTS: usize = QUEUE_BLOCKS + AHEAD_BLOCKS + GROUPS * GROUP_BLOCKS + 1;

/// First slots of the parts of that memory.
const QUEUE_SLOT: usize = 0;
const AHEAD_SLOT: usize = QUEUE_BLOCKS;
const GROUP_SLOT: usize = AHEAD_SLOT + AHEAD_BLOCKS;
const SCRATCH_SLOT: usize = SLOTS - 1;
