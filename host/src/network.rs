//! Boards in the network: found by mDNS, and talked to over TCP.

pub mod access;
pub mod browser;
pub mod connection;
pub mod target;
mod telnet;
pub mod terminal;
