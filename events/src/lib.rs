//! What happened lately, for whoever looks at a board that reset itself in the night: the last [`EVENTS`]
//! events, each with its time, in memory that a reset leaves alone.
//!
//! [`Slots`] is that memory. It may hold anything at start: what lost power, what another firmware left, an
//! entry that a reset met half written. So every entry carries its own number and a sum over all of it, and
//! what does not add up is no event. [`EventRing`] writes and reads it: from any priority without a lock, at
//! a cost that depends on the event alone.
//!
//! [`Event`] is what can be said. Its variants hold numbers, or words where only others know them.
#![cfg_attr(not(test), no_std)]

mod codec;
mod event;
mod ring;
mod text;

pub use event::{Cause, Date, Event, SILENT_TASKS};
pub use ring::{EVENTS, Entries, Entry, EventRing, SLOT_WORDS, Slots};
pub use text::{TEXT_BYTES, Text};
