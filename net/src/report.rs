//! State of the network, for whoever asks.

use core::net::Ipv4Addr;

use crate::line::Visitor;
use crate::news::Origin;
use crate::settings::LINES;
use crate::wire::Counts;

/// Address in use and what belongs to it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AddressReport {
    /// The board's address.
    pub address: Ipv4Addr,
    /// Number of ones of its mask.
    pub prefix: u8,
    /// Origin of it.
    pub origin: Origin,
    /// Way out of the network.
    pub gateway: Option<Ipv4Addr>,
    /// Servers of names.
    pub dns: [Option<Ipv4Addr>; 2],
    /// DHCP server that gave it.
    pub server: Option<Ipv4Addr>,
}

/// State of the network.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Report<'a> {
    /// Whether the cable carries.
    pub is_up: bool,
    /// Address of the Ethernet controller.
    pub mac: [u8; 6],
    /// Name of the board, without `.local`: the configured one, or that with a number.
    pub name: &'a str,
    /// Whether `NAME.local` is answered for.
    pub is_named: bool,
    /// Address in use.
    pub address: Option<AddressReport>,
    /// Address that is being made sure of.
    pub candidate: Option<Ipv4Addr>,
    /// Visitors at the consoles.
    pub visitors: [Option<Visitor>; LINES],
    /// Number of web connections.
    pub web_peers: usize,
    /// Server of the time, once its address is known.
    pub time_server: Option<Ipv4Addr>,
    /// Time of its last answer, in microseconds as polls have it.
    pub time_at: Option<u64>,
    /// Frames since the start.
    pub counts: Counts,
}
