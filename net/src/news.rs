//! Events that the rest of the machine may want to know.

use core::net::Ipv4Addr;

use heapless::Deque;

use crate::line::Visitor;
use crate::settings::HostName;

/// Origin of the address that the board has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Origin {
    /// From a DHCP server.
    Dhcp,
    /// Chosen by the board itself, of 169.254.0.0/16.
    LinkLocal,
    /// From the configuration.
    Static,
}

/// Cause of an address being given up.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Loss {
    /// The cable is out, or the other end is off.
    LinkDown,
    /// The server did not prolong the lease.
    LeaseOver,
    /// Another machine has the address.
    Taken,
    /// There is a better address now.
    Replaced,
}

/// Event of the network.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum News {
    /// The board has an address, and is reachable.
    Address {
        /// The address.
        address: Ipv4Addr,
        /// Origin of the address.
        origin: Origin,
    },
    /// The board has its address no more; all visitors are gone.
    AddressLost {
        /// The address.
        address: Ipv4Addr,
        /// Cause of it.
        loss: Loss,
    },
    /// Another machine has an address that the board uses or wants.
    AddressTaken {
        /// The address.
        address: Ipv4Addr,
        /// Ethernet address of the other machine.
        by: [u8; 6],
    },
    /// The board is announced as `NAME.local`.
    Named(HostName),
    /// The name belongs to another machine; a name with a number is tried.
    NameTaken(HostName),
    /// The time that a server has told, of this moment, in milliseconds since 1970.
    Time {
        /// Milliseconds since 1970-01-01 00:00 UTC.
        unix_ms: u64,
    },
    /// The time server does not answer.
    NoTime,
    /// A visitor has come.
    Came(Visitor),
    /// A visitor has gone.
    Left(Visitor),
    /// A wrong password was given.
    WrongPassword {
        /// Address that it came from.
        from: Ipv4Addr,
    },
}

/// Most events that wait.
const WAITING: usize = 8;

/// Events that wait; the oldest are dropped where nobody takes them.
#[derive(Debug)]
pub struct Inform {
    waiting: Deque<News, WAITING>,
}

impl Inform {
    /// Makes an empty list.
    pub const fn new() -> Self {
        Self { waiting: Deque::new() }
    }

    /// Adds an event, in place of the oldest if there is no room.
    pub fn tell(&mut self, news: News) {
        if self.waiting.is_full() {
            self.waiting.pop_front();
        }
        let _has_room = self.waiting.push_back(news);
    }

    /// Takes the oldest event.
    pub fn take(&mut self) -> Option<News> {
        self.waiting.pop_front()
    }
}
