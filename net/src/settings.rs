//! Settings of the network, as the configuration has them.

use core::fmt::Write as _;
use core::net::Ipv4Addr;

use heapless::String;

/// Longest host name: a number may have to follow, and all is one label of DNS.
pub const HOST_BYTES: usize = 52;
/// Longest label of DNS.
const LABEL_BYTES: usize = 63;
/// Longest name of a time server.
pub const SERVER_BYTES: usize = 96;

/// Port of telnet, which Smoothieware v2 listens on.
pub const TELNET_PORT: u16 = 23;

/// Name of the board in the network: one label of letters, digits and hyphens.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct HostName(String<LABEL_BYTES>);

impl HostName {
    /// Makes a legal name of what was asked for: other signs become hyphens, and an empty name is `velvet`.
    #[must_use]
    pub fn new(asked: &str) -> Self {
        let mut name = String::new();
        let asked = asked.trim_ascii();
        for sign in asked.strip_suffix(".local").unwrap_or(asked).bytes().take(HOST_BYTES) {
            let legal = if sign.is_ascii_alphanumeric() { char::from(sign) } else { '-' };
            if legal != '-' || !name.is_empty() {
                let _fits = name.push(legal);
            }
        }
        while name.ends_with('-') {
            name.pop();
        }
        if name.is_empty() {
            let _fits = name.push_str("velvet");
        }
        Self(name)
    }

    /// Returns the name with a number behind it.
    pub(crate) fn numbered(&self, number: u32) -> Self {
        let mut name = self.0.clone();
        let _fits = write!(name, "-{number}");
        Self(name)
    }

    /// Returns the name without `.local`.
    #[must_use]
    pub fn as_str(&self) -> &str {
        &self.0
    }
}

/// Address that the board always has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StaticAddress {
    /// The board's own address.
    pub address: Ipv4Addr,
    /// Mask of its network.
    pub mask: Ipv4Addr,
    /// Way out of the network, if there is one.
    pub gateway: Option<Ipv4Addr>,
    /// Server of names, if there is one.
    pub dns: Option<Ipv4Addr>,
}

impl StaticAddress {
    /// Returns the number of ones of the mask; `None` if that or the address is none.
    #[must_use]
    pub fn prefix(&self) -> Option<u8> {
        let mask = self.mask.to_bits();
        let is_mask = mask.leading_ones() + mask.trailing_zeros() == 32;
        (is_mask && is_host(self.address) && !self.address.is_loopback()).then_some(mask.leading_ones() as u8)
    }
}

/// Origin of the board's address.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Addressing {
    /// A DHCP server's; one of 169.254.0.0/16 while there is no server.
    Dhcp,
    /// A given one.
    Static(StaticAddress),
}

/// Server that is asked for the time.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum TimeServer {
    /// By its address.
    Address(Ipv4Addr),
    /// By its name, which DNS knows.
    Name(String<SERVER_BYTES>),
}

impl TimeServer {
    /// Returns the server of this name; `None` for an empty one and one that is too long.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        let name = name.trim_ascii();
        let name = name.strip_suffix('.').unwrap_or(name);
        String::try_from(name).ok().filter(|name| !name.is_empty()).map(Self::Name)
    }
}

/// Returns whether an address can be a single machine's. The stack fails on a way out that is none.
pub(crate) const fn is_host(address: Ipv4Addr) -> bool {
    !(address.is_unspecified() || address.is_multicast() || address.is_broadcast())
}

/// Service over TCP that ends in consoles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Service {
    /// Lines and answers as on a serial console.
    Telnet,
    /// The same in GRBL's dialect, for senders of CNC programs.
    Grbl,
}

impl Service {
    /// All services, in the order of their lines.
    pub const ALL: [Self; 2] = [Self::Telnet, Self::Grbl];
}

/// Consoles that each service has.
pub const LINES_EACH: usize = 2;
/// Consoles of all services: those of [`Service::Telnet`] first, then those of [`Service::Grbl`].
pub const LINES: usize = LINES_EACH * Service::ALL.len();

/// Returns the service that a line belongs to.
#[must_use]
pub const fn service_of(line: usize) -> Service {
    if line < LINES_EACH { Service::Telnet } else { Service::Grbl }
}

/// All settings.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Settings {
    /// Address of the board's Ethernet controller.
    pub mac: [u8; 6],
    /// Name of the board.
    pub host: HostName,
    /// Origin of the board's address.
    pub addressing: Addressing,
    /// Server of the time, if the clock is to be set.
    pub time_server: Option<TimeServer>,
    /// Port of the telnet service, if there is one.
    pub telnet: Option<u16>,
    /// Port of the service in GRBL's dialect, if there is one.
    pub grbl: Option<u16>,
    /// Port of web connections, if they are served.
    pub web: Option<u16>,
    /// Whether `NAME.local` is answered for.
    pub mdns: bool,
    /// Whether visitors have to know the password.
    pub password_required: bool,
}

impl Settings {
    /// Returns the settings of a board with this address of its controller, with no service.
    #[must_use]
    pub fn new(mac: [u8; 6]) -> Self {
        Self {
            mac,
            host: HostName::new(""),
            addressing: Addressing::Dhcp,
            time_server: None,
            telnet: None,
            grbl: None,
            web: None,
            mdns: true,
            password_required: true,
        }
    }

    /// Returns the port of a service, if there is one.
    #[must_use]
    pub const fn port(&self, service: Service) -> Option<u16> {
        match service {
            Service::Telnet => self.telnet,
            Service::Grbl => self.grbl,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_host_name_is_made_legal() {
        let name = |text: &str| HostName::new(text).as_str().to_owned();
        assert_eq!(name("Velvet"), "Velvet");
        assert_eq!(name(" my printer.local"), "my-printer");
        assert_eq!(name("--a_b--"), "a-b");
        assert_eq!(name(""), "velvet");
        assert_eq!(name("***"), "velvet");
        assert_eq!(name(&"x".repeat(99)).len(), HOST_BYTES);
    }

    #[test]
    fn an_address_and_its_mask_are_judged() {
        let of = |address: [u8; 4], mask: [u8; 4]| {
            StaticAddress { address: address.into(), mask: mask.into(), gateway: None, dns: None }.prefix()
        };
        assert_eq!(of([192, 168, 1, 9], [255, 255, 255, 0]), Some(24));
        assert_eq!(of([192, 168, 1, 9], [255, 0, 255, 0]), None);
        assert_eq!(of([224, 0, 0, 1], [255, 255, 255, 0]), None);
        assert_eq!(of([0, 0, 0, 0], [255, 255, 255, 0]), None);
    }

    #[test]
    fn a_time_server_has_a_name_that_fits() {
        assert!(matches!(TimeServer::named(" pool.ntp.org. "), Some(TimeServer::Name(name)) if name == "pool.ntp.org"));
        assert_eq!(TimeServer::named(" "), None);
        assert_eq!(TimeServer::named(&"x".repeat(200)), None);
    }
}
