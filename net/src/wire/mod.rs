//! Ethernet frames on their way between device and stack: what is counted, looked at or dropped there, and
//! what is sent past the stack.

mod arp;
mod tap;
mod watch;

pub use arp::{Arp, send_arp};
pub use tap::{Counts, Filter, Tap};
pub use watch::{Peer, remote};
