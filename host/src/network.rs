//! Boards in the network: found by mDNS, and talked to over TCP.

pub mod browser;
