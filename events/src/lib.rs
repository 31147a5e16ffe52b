//! Event log for diagnosis after a reset, even of a board that reset itself in the night: the last [`EVENTS`]
//! events, each with its time, in memory that a reset leaves alone.
//!
//! [`Slots`] is that memory. At start the slots may hold anything: random bits after a loss of power, the
//! data of another firmware, an entry that a reset met half written. So every entry carries its own number
//! and a sum over all of it, and an entry whose sum is wrong is no event. [`EventRing`] writes and reads the
//! slots: from any priority without a lock, at a cost that depends on the event alone.
//!
//! [`Event`] lists the possible events, whose variants hold numbers, or text if only other crates know the
//! details.
#![cfg_attr(not(test), no_std)]

mod codec;
mod date;
mod event;
mod ring;
mod text;

pub use date::DateTime;
pub use event::{Cause, Event, SILENT_TASKS};
pub use ring::{EVENTS, Entries, Entry, EventRing, SLOT_WORDS, Slots};
pub use text::{TEXT_BYTES, Text};
