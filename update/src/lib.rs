//! Firmware images: how one looks, whether it may run, and how it replaces the one that is in flash so that
//! the power may fail at any moment. Pure: flash and card are traits. The boot stage carries installs out,
//! the application asks for them by the log.
//!
//! Flash of the board: the boot stage in the first sector, the image behind it, the log of what was asked and
//! done in the last one.
#![cfg_attr(not(test), no_std)]

mod boot;
mod flash;
mod install;
mod log;
mod manifest;
mod policy;
mod receive;
mod seal;
#[cfg(test)]
mod tests;
mod verify;

pub use boot::{Card, Next, PREVIOUS_FILES, RECOVERY_FILES, REQUESTED_FILE, TRIALS, may_recover, settle};
pub use flash::{ERASED, Failed, Flash, Layout, PRIME, Sector, Unreadable, WORD, Word};
pub use install::{Download, NotInstalled};
pub use log::{Arrival, Ended, Entry, Half, Known, Log, Origin, Pending, Refusal, State};
pub use manifest::{BOARD_MAGIC, Flaw, MANIFEST_BYTES, Manifest, VECTOR_TABLE};
pub use policy::{Policy, signed};
pub use receive::Receiving;
pub use seal::{public_key, seal, sign_file, trailer};
pub use verify::{Bytes, FileCheck, Image, check_file, check_flash};
