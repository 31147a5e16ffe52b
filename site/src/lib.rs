//! Velvet's site: its page, and an API over HTTP and WebSocket that tells how the machine is and has it work.
//!
//! The API is JSON-RPC 2.0 in Moonraker's words. Bytes come in and go out, the time is an argument; sockets
//! are outside this crate, and so is the machine: it is shown as a [`base::snapshot::Snapshot`], takes lines
//! from the site's console, and answers there.
#![cfg_attr(not(test), no_std)]
#![forbid(unsafe_code)]

mod access;
mod assets;
mod batch;
mod calls;
mod client;
mod console;
mod files;
mod help;
mod incoming;
mod jog;
mod macros;
mod memory;
mod mesh;
mod messages;
mod objects;
mod path;
mod questions;
mod remedies;
mod reply;
mod requests;
mod role_names;
mod routes;
mod script;
mod serving;
mod site;
mod temperatures;
#[cfg(test)]
mod tests;
mod visitors;

pub use access::{Random, Verdict, Word};
pub use calls::SCRIPT_BYTES;
pub use http::{Life, Role};
pub use memory::Memory;
pub use site::{CLIENTS, EmergencyStop, PERIOD_MS, Site};
