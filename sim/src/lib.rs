//! The simulated machine around the board: driver chips, carriages, heaters, switches and supplies, and the
//! record of what the firmware made them do.
//!
//! Three layers, each knowing only the ones before it:
//!
//! 1. [`models`]: one chip or one piece of physics each, written from its datasheet;
//! 2. [`world`]: all of them put together as one machine, with pins on one side and matter on the other;
//! 3. [`trace`] and [`output`]: what happened, and the files a run leaves; [`session`]: the operator at the
//!    console.
//!
//! Nothing here knows of an emulator or of our firmware: `virtual-prime` drives a [`world::World`] from the
//! pins of an emulated board, the native runner from the machine's step queue. Time is always an argument, in
//! nanoseconds since power-on; the same calls give the same machine, to the bit.
#![forbid(unsafe_code)]

pub mod models;
pub mod output;
#[cfg(feature = "runner")]
pub mod runner;
pub mod session;
pub mod trace;
pub mod world;
