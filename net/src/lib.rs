//! The board on a network: everything between Ethernet frames and the bytes of consoles.
//!
//! An address comes from a DHCP server, from the configuration, or is made up (RFC 3927), and is never used
//! while another machine has it (RFC 5227). The board answers to `NAME.local` (RFC 6762), asks a server for
//! the time (RFC 4330), and lets visitors in by telnet (RFC 854), by a password where one is required.
//!
//! The crate is generic over smoltcp's device trait, and over [`Line`], the console that a visitor is
//! connected to. No code here waits or allocates: [`Network::poll`] does a bounded piece of work, with the
//! time as an argument. TCP, IP and the DHCP client are smoltcp's.
//!
//! Driver, machine and card are outside this crate.
#![cfg_attr(not(test), no_std)]

mod address;
mod clock;
mod consoles;
mod line;
mod memory;
mod names;
mod network;
mod news;
mod password;
mod random;
mod report;
mod settings;
mod streams;
#[cfg(test)]
mod testing;
#[cfg(test)]
mod tests;
mod wire;

pub use line::{Line, Role, Visitor};
pub use memory::{Memory, STREAM_BYTES};
pub use network::{Network, Peers};
pub use news::{Loss, News, Origin};
pub use password::{RECORD_BYTES, Record, SALT_BYTES, WORD_BYTES};
pub use report::{AddressReport, Report};
pub use settings::{
    Addressing, HOST_BYTES, HostName, LINES, LINES_EACH, SERVER_BYTES, Service, Settings, StaticAddress, TELNET_PORT,
    TimeServer, service_of,
};
pub use streams::{STREAMS, Streams, Verdict, Wish, Word};
pub use wire::Counts;
