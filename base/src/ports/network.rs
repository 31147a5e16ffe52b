//! Access to the network.

use core::net::Ipv4Addr;

use config::NetworkConfig;
use heapless::{String, Vec};

/// Most bytes of a password's record; see [`Network::set_password_record`].
pub const PASSWORD_RECORD_BYTES: usize = 160;
/// Bytes of the name by which the network knows the machine, with the number that it may get.
pub const NETWORK_NAME_BYTES: usize = config::HOST_NAME_BYTES + 4;

/// Record of a password: how it is verified, and not the password.
pub type PasswordRecord = Vec<u8, PASSWORD_RECORD_BYTES>;

/// Most bytes of the record of all keys: eight lines of a role, a digest and a name.
pub const KEYS_RECORD_BYTES: usize = 536;

/// Record of the keys of programs: how they are verified, and not the keys.
pub type KeysRecord = Vec<u8, KEYS_RECORD_BYTES>;

/// Origin of the machine's address.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum AddressOrigin {
    /// The configuration gives the address.
    #[default]
    Configuration,
    /// A DHCP server gave the address.
    Dhcp,
    /// The machine chose the address, for want of a server (RFC 3927).
    LinkLocal,
}

impl AddressOrigin {
    /// Returns the origin in words.
    #[must_use]
    pub const fn words(self) -> &'static str {
        match self {
            Self::Configuration => "from config.ini",
            Self::Dhcp => "from DHCP",
            Self::LinkLocal => "chosen here, as no DHCP server answers",
        }
    }
}

/// An address of the machine, with what belongs to it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NetworkAddress {
    /// Address of the machine.
    pub address: Ipv4Addr,
    /// Length of the netmask, bits.
    pub mask_bits: u8,
    /// Router to other networks.
    pub gateway: Option<Ipv4Addr>,
    /// Server that knows names.
    pub dns: Option<Ipv4Addr>,
    /// Origin of the address.
    pub origin: AddressOrigin,
}

/// Speed and duplex of the link.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NetworkLink {
    /// Speed, Mbit/s.
    pub mbit: u16,
    /// Whether both ends may send at once.
    pub is_full_duplex: bool,
}

/// Counts of what has passed since the start.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct NetworkTraffic {
    /// Frames and bytes received.
    pub received: (u32, u64),
    /// Frames and bytes sent.
    pub sent: (u32, u64),
    /// Frames received with errors of the line.
    pub damaged: u32,
    /// Frames lost because none of the buffers was free.
    pub lost: u32,
    /// Broadcasts left out because there were too many.
    pub broadcasts_left_out: u32,
    /// Times that the link has come.
    pub links: u32,
}

/// A service that the network offers: a console, or the page.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NetworkService {
    /// Name of the service.
    pub name: &'static str,
    /// TCP port.
    pub port: u16,
    /// Connected peers.
    pub peers: u8,
}

/// State of the network.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct NetworkReport {
    /// Ethernet address.
    pub mac: [u8; 6],
    /// The link; none without a cable, or while both ends negotiate.
    pub link: Option<NetworkLink>,
    /// Address; none while it is looked for.
    pub address: Option<NetworkAddress>,
    /// Name in the local network, without `.local`; empty where names are switched off.
    pub name: String<NETWORK_NAME_BYTES>,
    /// Counts of what has passed.
    pub traffic: NetworkTraffic,
    /// Consoles that are offered, and the page.
    pub services: Vec<NetworkService, 3>,
    /// Whether a password is known.
    pub has_password: bool,
    /// Time since the clock was last set from the network, seconds; none before.
    pub clock_set_ago: Option<u32>,
}

/// Change of the network's state.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum NetworkNews {
    /// The machine has an address.
    Address(NetworkAddress),
    /// The machine has no address any more: the cable is out, or the lease is over.
    NoAddress,
    /// Another machine has the configured address.
    AddressTaken(Ipv4Addr),
    /// Another machine has the name; this one has another now.
    Renamed(String<NETWORK_NAME_BYTES>),
    /// Somebody at this address has given a wrong password.
    WrongPassword(Ipv4Addr),
    /// Somebody at this address wants to set the first password: the code is to be shown where only who
    /// stands at the machine can read it.
    Code(u32, Ipv4Addr),
    /// A visitor has changed the password: its record is to be kept, see [`Network::take_password_record`].
    NewPassword,
    /// A visitor has changed the keys of programs: their record is to be kept, see
    /// [`Network::take_keys_record`].
    NewKeys,
    /// The hardware has a fault: what it is, and what to do.
    Fault(&'static str),
    /// The time of the network, seconds since 1970, UTC.
    Time(u64),
}

/// Access to the network, beside its sessions. A board without a network leaves all of it out.
pub trait Network {
    /// Begins to use the network. Called once, when the configuration has been read, if it asks for that.
    ///
    /// # Errors
    /// When the network does not work: what is wrong, and what to do.
    fn join_network(&mut self, _config: &NetworkConfig) -> Result<(), &'static str> {
        Err("this machine has no network")
    }

    /// Returns the state of the network; none before it is used.
    fn network_report(&self) -> Option<NetworkReport> {
        None
    }

    /// Takes the next change.
    fn take_network_news(&mut self) -> Option<NetworkNews> {
        None
    }

    /// Sets the record by which passwords are verified; none: there is no password.
    ///
    /// # Errors
    /// The record is none.
    fn set_password_record(&mut self, _record: Option<&[u8]>) -> Result<(), &'static str> {
        Ok(())
    }

    /// Begins to make the record of a new password, which takes a second. False: there is no network, or the
    /// word cannot be a password.
    fn begin_password(&mut self, _password: &[u8]) -> bool {
        false
    }

    /// Takes the record of the new password when it is made.
    fn take_password_record(&mut self) -> Option<PasswordRecord> {
        None
    }

    /// Takes the record of the keys, where it is to be kept.
    fn take_keys_record(&mut self) -> Option<KeysRecord> {
        None
    }

    /// Sets the keys of programs, by their record.
    fn set_keys_record(&mut self, _record: &[u8]) {}

    /// Tells whether a visitor's change of password or keys is kept, or why not.
    fn tell_kept(&mut self, _kept: Result<(), &'static str>) {}
}
