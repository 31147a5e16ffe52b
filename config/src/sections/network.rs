//! The network: Ethernet, addresses and names, and what the board serves there.

use core::net::Ipv4Addr;

use crate::setting::build::{bool, integer, number, text, word};
use crate::setting::declare::{settings, words};
use heapless::String;

use super::to_come::NOT_YET_HARMLESS;

/// Most letters of the machine's name: what a label of the domain name system may have, less room for the
/// number that a name gets when another machine has it already.
pub const HOST_NAME_BYTES: usize = 32;
/// Most letters of the name of a host that is asked for something.
pub const SERVER_NAME_BYTES: usize = 96;

words! {
    /// Speed of the Ethernet link.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
    pub enum LinkSpeed {
        /// What both ends can do best.
        #[default]
        Auto = "auto",
        /// At most 100 Mbit/s.
        Fast = "100",
        /// 10 Mbit/s, which radio interference disturbs less.
        Slow = "10",
    }
}

/// An IPv4 address as the file gives it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Address {
    /// The network says it (`auto`), or there is none.
    #[default]
    Auto,
    /// This address.
    Given(Ipv4Addr),
    /// The text is no address.
    Flawed,
}

impl Address {
    /// Reads `auto`, an empty text or four numbers with dots between. The library's reader takes ten times
    /// the code, as it knows IPv6 too.
    #[must_use]
    pub fn read(text: &str) -> Self {
        if text.is_empty() || text.eq_ignore_ascii_case("auto") {
            return Self::Auto;
        }
        let (mut octets, mut count) = ([0; 4], 0);
        for number in text.split('.') {
            let is_plain = number.bytes().all(|byte| byte.is_ascii_digit());
            match (octets.get_mut(count), number.parse()) {
                (Some(octet), Ok(number)) if is_plain => *octet = number,
                _ => return Self::Flawed,
            }
            count += 1;
        }
        if count == octets.len() { Self::Given(octets.into()) } else { Self::Flawed }
    }

    /// Returns the address that the file gives.
    #[must_use]
    pub const fn given(self) -> Option<Ipv4Addr> {
        match self {
            Self::Given(address) => Some(address),
            Self::Auto | Self::Flawed => None,
        }
    }
}

settings! {
    /// Ethernet and what it serves. Nothing listens that is not named here.
    #[derive(Clone, Debug, Default)]
    pub struct NetworkConfig {
        /// Use Ethernet.
        enable: bool = bool("false").v1("network.enable");
        /// Speed of the link: as both ends agree, at most 100, or 10 Mbit/s.
        link: LinkSpeed = word("auto", LinkSpeed::WORDS).velvet();
        /// Fixed address, or auto for DHCP; without a server the machine gives itself one (169.254.x.x).
        "ip_address" address: Address = text("auto", 96).v1("network.ip_address")
            => |text: &str| Address::read(text);
        /// Netmask used with a fixed address.
        "ip_mask" mask: Address = text("255.255.255.0", 96).v1("network.ip_mask") => |text: &str| Address::read(text);
        /// Gateway used with a fixed address; empty: none.
        "ip_gateway" gateway: Address = text("192.168.1.1", 96).v1("network.ip_gateway")
            => |text: &str| Address::read(text);
        /// DNS server; auto: as DHCP says.
        "dns_server" dns: Address = text("auto", 96) => |text: &str| Address::read(text);
        /// Name of the machine in the network: velvet is found as velvet.local.
        "hostname" host_name: String<HOST_NAME_BYTES> = text("velvet", HOST_NAME_BYTES);
        /// Answer who asks for the name in the local network (mDNS), and say which services there are.
        mdns: bool = bool("true").velvet();
        /// A console over Telnet.
        "shell_enable" shell: bool = bool("false");
        /// TCP port of that console.
        shell_port: u16 = integer("23", &(1, 65_535)).velvet();
        /// A console in GRBL's dialect, for senders to mills and lasers.
        "grbl_enable" grbl: bool = bool("false").velvet();
        /// TCP port of that console.
        grbl_port: u16 = integer("2323", &(1, 65_535)).velvet();
        /// The page for browsers, and its API over HTTP and WebSocket.
        "webserver_enable" web: bool = bool("false");
        /// TCP port of the page.
        "webserver_port" web_port: u16 = integer("80", &(1, 65_535)).velvet();
        /// Consoles of the network want the password that the command password has set. false: who has
        /// none may operate the machine, but not change its files, settings or firmware.
        password_required: bool = bool("true").velvet();
        /// Who has no password may watch the machine on the page, and stop it. Where password_required is
        /// false, everybody may do more than that anyway.
        watch_without_password: bool = bool("false").velvet();
        /// Set the clock from the network.
        "ntp_enable" ntp: bool = bool("true");
        /// Host to ask for the time.
        ntp_server: String<SERVER_NAME_BYTES> = text("pool.ntp.org", SERVER_NAME_BYTES);
        /// Hours added to UTC, half and quarter hours too.
        "timezone" timezone_minutes: i16 = number("0", &(-12.0, 14.0)).unit("h") => |hours: f64| (hours * 60.0) as i16;
    rows NetworkToCome:
        /// File transfer on TCP port 21.
        "ftp_enable" = bool("false").support(NOT_YET_HARMLESS);
        /// Where the update command looks; ends with a slash.
        "firmware_url" = text("http://download.smoothieware.org/", 96).dormant();
    }
}

impl NetworkConfig {
    /// Returns the length of the netmask in bits; none when its ones are not together.
    #[must_use]
    pub fn mask_bits(&self) -> Option<u8> {
        let mask = self.mask.given()?.to_bits();
        (mask.leading_ones() + mask.trailing_zeros() == u32::BITS).then_some(mask.leading_ones() as u8)
    }

    /// Returns whether the machine's name can be one in the network (RFC 1123 section 2.1).
    #[must_use]
    pub fn has_good_name(&self) -> bool {
        let is_good = |byte: u8| byte.is_ascii_alphanumeric() || byte == b'-';
        let name = self.host_name.as_str();
        !name.is_empty() && name.bytes().all(is_good) && !name.starts_with('-') && !name.ends_with('-')
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_address_has_four_numbers() {
        assert_eq!(Address::read("192.168.0.255"), Address::Given(Ipv4Addr::new(192, 168, 0, 255)));
        for text in ["1.2.3", "1.2.3.4.5", "1.2.3.256", "1.2.3.x", "1..2.3", "1.2.3.+4", "pool.ntp.org", "."] {
            assert_eq!(Address::read(text), Address::Flawed, "{text}");
        }
        assert_eq!([Address::read(""), Address::read("Auto")], [Address::Auto; 2]);
    }
}
