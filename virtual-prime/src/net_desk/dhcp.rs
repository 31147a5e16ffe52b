//! A DHCP server for one client, RFC 2131 and RFC 2132. It shares no code with the board's client.

use std::net::Ipv4Addr;

/// Fixed part of a message, and the four bytes after it that announce options.
const FIXED: usize = 236;
const MAGIC: [u8; 4] = [99, 130, 83, 99];
/// Options: subnet mask, router, name servers, host name, time servers, requested address, lease time, kind
/// of message, server, renewal time, rebinding time, end.
const MASK: u8 = 1;
const ROUTER: u8 = 3;
const NAME_SERVERS: u8 = 6;
const HOST_NAME: u8 = 12;
const TIME_SERVERS: u8 = 42;
const REQUESTED: u8 = 50;
const LEASE: u8 = 51;
const KIND: u8 = 53;
const SERVER: u8 = 54;
const RENEWAL: u8 = 58;
const REBINDING: u8 = 59;
const END: u8 = 255;

/// Kind of a DHCP message, option 53.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum DhcpKind {
    /// A client looks for servers.
    Discover = 1,
    /// A server offers an address.
    Offer,
    /// A client asks for an address, or for more time.
    Request,
    /// A client has found its address in use.
    Decline,
    /// A server gives the address.
    Ack,
    /// A server refuses.
    Nak,
    /// A client gives its address back.
    Release,
    /// A client that has an address asks for the rest.
    Inform,
}

impl DhcpKind {
    const ALL: [Self; 8] =
        [Self::Discover, Self::Offer, Self::Request, Self::Decline, Self::Ack, Self::Nak, Self::Release, Self::Inform];
}

/// A message that a client has sent.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DhcpMessage {
    /// Its kind.
    pub kind: DhcpKind,
    /// Host name that the client tells, option 12.
    pub name: Option<String>,
    /// Address that the client has, or asks for.
    pub address: Option<Ipv4Addr>,
    /// Hardware address of the client.
    pub hardware: [u8; 6],
}

/// What the server gives away, and how it behaves.
#[derive(Clone, Debug)]
pub struct DhcpServer {
    /// Whether it answers at all.
    pub is_on: bool,
    /// Whether it refuses requests, so that the client loses its address at the next renewal.
    pub refuses: bool,
    /// Address for the client.
    pub address: Ipv4Addr,
    /// Duration of a lease, seconds.
    pub lease_s: u32,
    /// Own address: also that of the router, the name server and the time server.
    pub own: Ipv4Addr,
    /// Messages of clients, oldest first.
    pub heard: Vec<DhcpMessage>,
}

/// An answer, and where it goes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DhcpAnswer {
    /// Its kind.
    pub kind: DhcpKind,
    /// Address of the client, or everybody's.
    pub to: Ipv4Addr,
    /// The message.
    pub bytes: Vec<u8>,
}

fn option(message: &[u8], sought: u8) -> Option<&[u8]> {
    let mut rest = message.get(FIXED + MAGIC.len()..)?;
    loop {
        match *rest.first()? {
            0 => rest = rest.get(1..)?,
            END => return None,
            code => {
                let length = usize::from(*rest.get(1)?);
                let value = rest.get(2..2 + length)?;
                if code == sought {
                    return Some(value);
                }
                rest = rest.get(2 + length..)?;
            }
        }
    }
}

fn address(bytes: &[u8]) -> Option<Ipv4Addr> {
    let octets: [u8; 4] = bytes.try_into().ok()?;
    Some(Ipv4Addr::from(octets)).filter(|address| !address.is_unspecified())
}

impl DhcpServer {
    /// Creates a server at this address that gives the client the other one.
    #[must_use]
    pub const fn new(own: Ipv4Addr, address: Ipv4Addr) -> Self {
        Self { is_on: true, refuses: false, address, lease_s: 3_600, own, heard: Vec::new() }
    }

    /// Answers a client's message.
    pub fn answer(&mut self, message: &[u8]) -> Option<DhcpAnswer> {
        if message.first() != Some(&1) || message.get(FIXED..FIXED + 4)? != MAGIC {
            return None;
        }
        let number = *option(message, KIND)?.first()?;
        let kind = DhcpKind::ALL.into_iter().find(|&kind| kind as u8 == number)?;
        let client = address(message.get(12..16)?);
        let asked = option(message, REQUESTED).and_then(address).or(client);
        self.heard.push(DhcpMessage {
            kind,
            name: option(message, HOST_NAME).map(|name| String::from_utf8_lossy(name).into_owned()),
            address: asked,
            hardware: message.get(28..34)?.try_into().ok()?,
        });
        if !self.is_on {
            return None;
        }
        let other_server = option(message, SERVER).and_then(address).is_some_and(|server| server != self.own);
        let answer = match kind {
            DhcpKind::Discover => DhcpKind::Offer,
            DhcpKind::Request if other_server => return None,
            DhcpKind::Request if self.refuses || asked != Some(self.address) => DhcpKind::Nak,
            DhcpKind::Request | DhcpKind::Inform => DhcpKind::Ack,
            _ => return None,
        };
        let to = client.filter(|_| answer != DhcpKind::Nak).unwrap_or(Ipv4Addr::BROADCAST);
        Some(DhcpAnswer { kind: answer, to, bytes: self.compose(answer, message) })
    }

    fn compose(&self, kind: DhcpKind, request: &[u8]) -> Vec<u8> {
        let mut bytes = vec![0; FIXED];
        // BOOTREPLY; the rest of the head is the request's: kind of hardware, transaction, flags, hardware
        // address.
        bytes[1..12].copy_from_slice(&request[1..12]);
        bytes[28..44].copy_from_slice(&request[28..44]);
        bytes[0] = 2;
        bytes[3] = 0;
        if kind != DhcpKind::Nak {
            bytes[16..20].copy_from_slice(&self.address.octets());
        }
        bytes.extend(MAGIC);
        let mut put = |code: u8, value: &[u8]| {
            bytes.extend([code, value.len() as u8]);
            bytes.extend(value);
        };
        put(KIND, &[kind as u8]);
        put(SERVER, &self.own.octets());
        if kind != DhcpKind::Nak {
            put(MASK, &[255, 255, 255, 0]);
            put(ROUTER, &self.own.octets());
            put(NAME_SERVERS, &self.own.octets());
            put(TIME_SERVERS, &self.own.octets());
            put(LEASE, &self.lease_s.to_be_bytes());
            put(RENEWAL, &(self.lease_s / 2).to_be_bytes());
            put(REBINDING, &(self.lease_s / 8 * 7).to_be_bytes());
        }
        bytes.push(END);
        // Shortest message of BOOTP.
        bytes.resize(bytes.len().max(300), 0);
        bytes
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn message(kind: DhcpKind, options: &[u8]) -> Vec<u8> {
        let mut bytes = vec![0; FIXED];
        bytes[..4].copy_from_slice(&[1, 1, 6, 0]);
        bytes[4..8].copy_from_slice(&[9, 8, 7, 6]);
        bytes[28..34].copy_from_slice(&[2, 0, 0, 0, 0, 1]);
        bytes.extend(MAGIC);
        bytes.extend([KIND, 1, kind as u8]);
        bytes.extend(options);
        bytes.push(END);
        bytes
    }

    fn server() -> DhcpServer {
        DhcpServer::new(Ipv4Addr::new(10, 0, 2, 2), Ipv4Addr::new(10, 0, 2, 15))
    }

    fn kind_of(answer: &DhcpAnswer) -> Option<u8> {
        assert_eq!(option(&answer.bytes, KIND), Some(&[answer.kind as u8][..]));
        Some(answer.kind as u8)
    }

    #[test]
    fn a_client_gets_the_address_and_what_belongs_to_it() {
        let mut server = server();
        let offer = server.answer(&message(DhcpKind::Discover, &[HOST_NAME, 3, b'a', b'b', b'c'])).expect("an offer");
        assert_eq!((kind_of(&offer), offer.to), (Some(2), Ipv4Addr::BROADCAST));
        assert_eq!(offer.bytes[4..8], [9, 8, 7, 6]);
        assert_eq!(offer.bytes[16..20], [10, 0, 2, 15]);
        let ack = server.answer(&message(DhcpKind::Request, &[REQUESTED, 4, 10, 0, 2, 15])).expect("an answer");
        assert_eq!(kind_of(&ack), Some(5));
        assert_eq!(option(&ack.bytes, TIME_SERVERS), Some(&[10, 0, 2, 2][..]));
        assert_eq!(server.heard[0].name.as_deref(), Some("abc"));
    }

    #[test]
    fn an_address_can_be_withdrawn_and_the_server_be_gone() {
        let mut server = server();
        let request = message(DhcpKind::Request, &[REQUESTED, 4, 10, 0, 2, 15]);
        server.refuses = true;
        assert_eq!(server.answer(&request).as_ref().and_then(kind_of), Some(6));
        server.is_on = false;
        assert_eq!(server.answer(&request), None);
        assert_eq!(server.heard.len(), 2);
    }

    #[test]
    fn other_addresses_are_refused_and_rubbish_is_ignored() {
        let mut server = server();
        let request = message(DhcpKind::Request, &[REQUESTED, 4, 10, 0, 2, 16]);
        assert_eq!(server.answer(&request).as_ref().and_then(kind_of), Some(6));
        assert_eq!(server.answer(&request[..200]), None);
        assert_eq!(server.answer(&message(DhcpKind::Request, &[SERVER, 4, 1, 2, 3, 4])), None);
    }
}
