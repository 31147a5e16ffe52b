//! A network for tests: a wire with faults, a desk at its other end, the board, all in virtual time.

mod bench;
mod desk;
mod dhcp;
mod frames;
mod line;
mod streams;
mod wire;

pub use bench::{BOARD, BOARD_MAC, Bench, MS, SECOND, time_server};
pub use desk::{DESK, DESK_MAC};
pub use frames::{arp, datagram, echo, syn};
pub use wire::Faults;
