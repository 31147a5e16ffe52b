//! Names: the board's own in the local network (RFC 6762, RFC 6763), and the messages of DNS.

pub mod message;
pub mod records;
mod responder;

pub use responder::{MDNS_ADDRESS, MDNS_PORT, Means, Responder, bind};
