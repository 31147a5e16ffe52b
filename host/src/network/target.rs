//! Target of a connection, as it is typed: a board's name or address, and a port where it is not the usual
//! one.

use std::net::{IpAddr, SocketAddr, ToSocketAddrs};
use std::time::Duration;

use anyhow::{Result, bail};

use super::browser::{ADVICE, Browser, Machine, Mdns, table};

/// TCP port of a console where none is given (RFC 854).
const TELNET_PORT: u16 = 23;
/// Time in which the boards answer among which there has to be one alone.
const SEEKING: Duration = Duration::from_secs(2);
/// Domain of names that machines give themselves.
const LOCAL: &str = ".local";
const PORTS: &str = "a port is a number from 1 to 65535, as in velvet.local:23";

/// Board that a command talks to.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Target {
    /// The only board that answers by mDNS.
    Only,
    /// Board at an IP address, with the port of its console if it is not the usual one.
    Address(IpAddr, Option<u16>),
    /// Board of a host name, with the port of its console if one is given.
    Name(String, Option<u16>),
}

impl Target {
    /// Reads `NAME`, `ADDRESS`, or either with `:PORT`.
    pub fn read(text: &str) -> Result<Self> {
        if let Ok(address) = text.parse::<IpAddr>() {
            return Ok(Self::Address(address, None));
        }
        if let Ok(address) = text.parse::<SocketAddr>() {
            return match address.port() {
                0 => bail!("{text}: {PORTS}"),
                port => Ok(Self::Address(address.ip(), Some(port))),
            };
        }
        let (name, port) = match text.rsplit_once(':') {
            None => (text, None),
            Some((name, port)) => match port.parse() {
                Ok(0) | Err(_) => bail!("{text}: {PORTS}"),
                Ok(port) => (name, Some(port)),
            },
        };
        if let Ok(address) = name.parse() {
            return Ok(Self::Address(address, port));
        }
        let name = name.strip_suffix('.').unwrap_or(name);
        let is_label = |label: &str| {
            let is_sign = |sign: char| sign.is_alphanumeric() || sign == '-' || sign == '_';
            (1..64).contains(&label.len()) && label.chars().all(is_sign)
        };
        let is_address = name.bytes().all(|byte| byte.is_ascii_digit() || byte == b'.');
        if is_address || name.len() > 250 || !name.split('.').all(is_label) {
            bail!("{text} is neither a name nor an address in the network: velvet.local and 192.168.1.20:23 are");
        }
        Ok(Self::Name(name.to_owned(), port))
    }

    /// Reads a target where a serial port may stand too; none if it is one.
    pub fn read_unless_serial(text: &str) -> Option<Self> {
        // `COM3` and `/dev/tty...` hold no colon and no point.
        match Self::read(text).ok()? {
            Self::Name(name, None) if !name.to_lowercase().ends_with(LOCAL) => None,
            target => Some(target),
        }
    }

    /// Finds the addresses of the target. A name of the local network is asked for by mDNS, for not every
    /// system does that, then the system is asked.
    pub fn resolve(&self, mdns: &Mdns) -> Result<Vec<SocketAddr>> {
        let (name, port) = match self {
            Self::Only => return only(Browser::new(mdns)?.machines(SEEKING)?).map(|found| vec![found]),
            Self::Address(address, port) => return Ok(vec![(*address, port.unwrap_or(TELNET_PORT)).into()]),
            Self::Name(name, port) => (name, *port),
        };
        let host = name.to_lowercase().strip_suffix(LOCAL).unwrap_or(name).to_owned();
        let is_local = !host.contains('.') && host != "localhost";
        // Whoever cannot ask the network may still be told by the system.
        let asked = if is_local { ask(&format!("{host}{LOCAL}"), port, mdns) } else { Ok(None) };
        if let Ok(Some(found)) = asked {
            return Ok(vec![found]);
        }
        let known = (name.as_str(), port.unwrap_or(TELNET_PORT)).to_socket_addrs().map(Iterator::collect::<Vec<_>>);
        match (known, asked) {
            (Ok(known), _) if !known.is_empty() => Ok(known),
            (_, Err(error)) => Err(error.context(format!("{name} is not known to this system"))),
            _ if is_local => bail!(
                "{name}: no machine with a console answers to {host}.local (mDNS), and this system does not know the \
                 name either: `velvet boards` lists what answers, and `net` on a USB console says the board's address"
            ),
            _ => bail!("{name}: this system does not know the name: is it right?"),
        }
    }
}

/// Returns the console of the only board.
fn only(machines: Vec<Machine>) -> Result<SocketAddr> {
    let boards: Vec<Machine> = machines.into_iter().filter(Machine::is_board).collect();
    match boards.as_slice() {
        [board] => Ok((board.address, board.telnet).into()),
        [] => bail!("no board of Velvet's answers by mDNS. {ADVICE}"),
        boards => bail!("several boards answer, say which one:\n{}", table(boards).trim_end()),
    }
}

/// Asks the local network for a machine's address, and for the port of its console where none is given.
fn ask(name: &str, port: Option<u16>, mdns: &Mdns) -> Result<Option<SocketAddr>> {
    let browser = Browser::new(mdns)?;
    Ok(match port {
        Some(port) => browser.address(name)?.map(|address| (address, port).into()),
        None => browser.machine(name)?.map(|machine| (machine.address, machine.telnet).into()),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn name(name: &str, port: Option<u16>) -> Target {
        Target::Name(name.to_owned(), port)
    }

    #[test]
    fn names_and_addresses_are_told_apart() {
        let address = IpAddr::from([192, 168, 1, 20]);
        for (text, target) in [
            ("velvet", name("velvet", None)),
            ("velvet.local.", name("velvet.local", None)),
            ("mill.example.org:2323", name("mill.example.org", Some(2323))),
            ("192.168.1.20", Target::Address(address, None)),
            ("192.168.1.20:24", Target::Address(address, Some(24))),
            ("[::1]:23", Target::Address([0, 0, 0, 0, 0, 0, 0, 1].into(), Some(23))),
        ] {
            assert_eq!(Target::read(text).unwrap(), target, "{text}");
        }
    }

    #[test]
    fn what_is_wrong_is_said_with_an_example() {
        for text in ["velvet:", "velvet:0", "1.2.3.4:0", "velvet:telnet", "1.2.3.4:99999"] {
            let error = Target::read(text).unwrap_err().to_string();
            assert!(error.starts_with(text) && error.contains("1 to 65535"), "{error}");
        }
        for text in ["", "/dev/ttyACM0", "a b", "192.168.1", "192.168.1.256", "a..b", ":23", &"x".repeat(64)] {
            let error = Target::read(text).unwrap_err().to_string();
            assert!(error.contains("neither a name nor an address"), "{error}");
        }
    }

    #[test]
    fn serial_ports_are_told_from_boards_in_the_network() {
        for text in ["/dev/ttyACM0", "COM3", "ttyS0", "/dev/serial/by-id/usb-Velvet_1:2"] {
            assert_eq!(Target::read_unless_serial(text), None, "{text}");
        }
        for text in ["velvet.local", "Velvet.LOCAL", "velvet:23", "10.0.0.9", "localhost:5770"] {
            assert!(Target::read_unless_serial(text).is_some(), "{text}");
        }
    }

    proptest! {
        #[test]
        fn no_text_makes_the_reader_fail(text in "\\PC{0,80}") {
            let _whether = Target::read(&text).is_ok();
        }
    }
}
