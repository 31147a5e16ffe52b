//! Files on the card, jobs that are played from them, and the journal that survives a power loss.
#![cfg_attr(not(test), no_std)]
#![forbid(unsafe_code)]

pub mod files;
pub mod journal;
pub mod player;
