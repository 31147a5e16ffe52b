//! Records of the board: its address, its service, and what leads there.

use core::fmt::Write as _;
use core::net::Ipv4Addr;

use heapless::String;

use super::message::{A, ANY, IN, NSEC, Name, PTR, Part, Record, SRV, TOP, TXT, Writer};
use crate::settings::HostName;

/// Lifetime of records that hold an address or a host's name, and of all others (RFC 6762 section 10).
const SHORT: u32 = 120;
const LONG: u32 = 4_500;
/// Lifetime in an answer to somebody who does not know mDNS (section 6.7).
const LEGACY: u32 = 10;
/// Kind of an IPv6 address.
const AAAA: u16 = 28;

const LOCAL: &str = ".local";
const SERVICE: &str = "_telnet._tcp.local";
const OF_SERVICE: &str = "._telnet._tcp.local";
const SERVICES: &str = "_services._dns-sd._udp.local";
/// Longest name: a host and the service.
const NAME: usize = 63 + OF_SERVICE.len();

/// Kind of record that the board has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Own {
    /// Address of the host.
    Host,
    /// Host that the address belongs to.
    Reverse,
    /// Instance of the service.
    Instance,
    /// The service itself, for who asks which there are.
    Kind,
    /// Host and port of the instance.
    Port,
    /// Texts of the instance.
    Text,
    /// Statement that the host has no other address.
    NoMore,
}

impl Own {
    /// All kinds.
    pub const ALL: [Self; 7] =
        [Self::Host, Self::Reverse, Self::Instance, Self::Kind, Self::Port, Self::Text, Self::NoMore];
}

/// Set of records.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Set(u8);

impl Set {
    /// The empty set.
    pub const NONE: Self = Self(0);
    /// Records that are announced.
    pub const ANNOUNCED: Self = Self(0b011_0111);

    const fn bit(own: Own) -> u8 {
        1 << own as u8
    }

    /// Adds a record.
    pub const fn add(&mut self, own: Own) {
        self.0 |= Self::bit(own);
    }

    /// Takes a record out.
    pub const fn remove(&mut self, own: Own) {
        self.0 &= !Self::bit(own);
    }

    /// Returns whether a record is in it.
    pub const fn has(self, own: Own) -> bool {
        self.0 & Self::bit(own) != 0
    }

    /// Returns both sets together.
    pub const fn with(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    /// Returns whether nothing is in it.
    pub const fn is_empty(self) -> bool {
        self.0 == 0
    }
}

/// Data of all records.
#[derive(Clone, Debug)]
pub struct Records {
    /// Name of the board, without `.local`.
    pub host: HostName,
    pub address: Ipv4Addr,
    /// Port of the telnet service, if there is one.
    pub telnet: Option<u16>,
    /// Port of the service in GRBL's dialect, if there is one.
    pub grbl: Option<u16>,
}

impl Records {
    /// Returns the name of a record.
    fn name(&self, own: Own) -> String<NAME> {
        let [a, b, c, d] = self.address.octets();
        let host = self.host.as_str();
        let mut name = String::new();
        let _fits = match own {
            Own::Host | Own::NoMore => write!(name, "{host}{LOCAL}"),
            Own::Instance => name.write_str(SERVICE),
            Own::Kind => name.write_str(SERVICES),
            Own::Port | Own::Text => write!(name, "{host}{OF_SERVICE}"),
            Own::Reverse => write!(name, "{}.in-addr.arpa", Ipv4Addr::new(d, c, b, a)),
        };
        name
    }

    /// Returns whether the board has such a record.
    const fn exists(&self, own: Own) -> bool {
        match own {
            Own::Host | Own::Reverse | Own::NoMore => true,
            Own::Instance | Own::Kind | Own::Port | Own::Text => self.telnet.is_some(),
        }
    }

    /// Returns whether the board alone may have such a record.
    pub const fn is_unique(own: Own) -> bool {
        !matches!(own, Own::Instance | Own::Kind)
    }

    const fn kind(own: Own) -> u16 {
        match own {
            Own::Host => A,
            Own::Reverse | Own::Instance | Own::Kind => PTR,
            Own::Port => SRV,
            Own::Text => TXT,
            Own::NoMore => NSEC,
        }
    }

    /// Returns the records that a question is for.
    pub fn asked(&self, name: Name<'_>, kind: u16) -> Set {
        let mut set = Set::NONE;
        for own in Own::ALL.into_iter().filter(|own| self.exists(*own)) {
            let is_kind = match own {
                Own::NoMore => matches!(kind, AAAA | NSEC),
                _ => kind == Self::kind(own) || kind == ANY,
            };
            if is_kind && name.is(&self.name(own)) {
                set.add(own);
            }
        }
        set
    }

    /// Returns what is good to know beside these records.
    pub fn beside(&self, asked: Set) -> Set {
        let mut set = Set::NONE;
        if asked.has(Own::Instance) {
            [Own::Port, Own::Text].into_iter().for_each(|own| set.add(own));
        }
        if asked.has(Own::Instance) || asked.has(Own::Port) {
            set.add(Own::Host);
        }
        Own::ALL.into_iter().filter(|own| asked.has(*own)).for_each(|own| set.remove(own));
        set
    }

    /// Returns which record another machine's has the name and kind of, and whether it says the same.
    pub fn compare(&self, record: &Record<'_>) -> Option<(Own, bool)> {
        if record.class & !TOP != IN {
            return None;
        }
        let is_it =
            |own: &Own| Self::kind(*own) == record.kind && self.exists(*own) && record.name.is(&self.name(*own));
        let own = Own::ALL.into_iter().filter(|own| *own != Own::NoMore).find(is_it)?;
        let same = match own {
            Own::Host => record.data == self.address.octets(),
            Own::Reverse => record.target.is(&self.name(Own::Host)),
            Own::Instance => record.target.is(&self.name(Own::Port)),
            Own::Kind => record.target.is(SERVICE),
            Own::Port => record.data.get(4..6) == Some(&self.port()[..]) && record.target.is(&self.name(Own::Host)),
            Own::Text | Own::NoMore => true,
        };
        Some((own, same))
    }

    /// Returns whether a name is one that the board alone may have.
    pub fn is_own(&self, record: &Record<'_>) -> bool {
        let is_instance = self.telnet.is_some() && record.name.is(&self.name(Own::Port));
        is_instance || self.is_host(record.name)
    }

    /// Returns whether a name is the host's.
    pub fn is_host(&self, name: Name<'_>) -> bool {
        name.is(&self.name(Own::Host))
    }

    /// Returns the usual lifetime of a record, in seconds.
    pub const fn ttl(own: Own) -> u32 {
        if matches!(own, Own::Host | Own::Port | Own::Reverse | Own::NoMore) { SHORT } else { LONG }
    }

    fn port(&self) -> [u8; 2] {
        self.telnet.unwrap_or(0).to_be_bytes()
    }

    /// Writes the names that are to be the board's as questions, and what it would say of them.
    pub fn write_probe(&self, writer: &mut Writer<'_>) {
        for own in [Own::Host, Own::Port].into_iter().filter(|own| self.exists(*own)) {
            writer.add(Part::Questions, |writer| {
                writer.name(&self.name(own))?;
                writer.word(ANY)?;
                writer.word(IN | TOP)
            });
        }
        for own in [Own::Host, Own::Port, Own::Text].into_iter().filter(|own| self.exists(*own)) {
            writer.add(Part::Authorities, |writer| self.write(own, writer, Life::Probe));
        }
    }

    /// Writes records of a set.
    pub fn write_set(&self, set: Set, part: Part, life: Life, writer: &mut Writer<'_>) {
        for own in Own::ALL.into_iter().filter(|own| set.has(*own) && self.exists(*own)) {
            writer.add(part, |writer| self.write(own, writer, life));
        }
    }

    fn write(&self, own: Own, writer: &mut Writer<'_>, life: Life) -> Option<()> {
        writer.name(&self.name(own))?;
        let usual = Self::ttl(own);
        let (ttl, flush) = match life {
            Life::Usual => (usual, Self::is_unique(own)),
            Life::Probe => (usual, false),
            Life::Legacy => (LEGACY, false),
            Life::Over => (0, Self::is_unique(own)),
        };
        writer.word(Self::kind(own))?;
        writer.word(if flush { IN | TOP } else { IN })?;
        writer.bytes(&ttl.to_be_bytes())?;
        writer.data(|writer| match own {
            Own::Host => writer.bytes(&self.address.octets()),
            Own::Reverse => writer.name(&self.name(Own::Host)),
            Own::Instance => writer.name(&self.name(Own::Port)),
            Own::Kind => writer.name(SERVICE),
            Own::Port => {
                writer.bytes(&[0; 4])?;
                writer.bytes(&self.port())?;
                writer.name(&self.name(Own::Host))
            }
            Own::Text => self.write_texts(writer),
            // The host has a record of kind 1, and no other.
            Own::NoMore => {
                writer.name(&self.name(Own::Host))?;
                writer.bytes(&[0, 1, 0x40])
            }
        })
    }

    fn write_texts(&self, writer: &mut Writer<'_>) -> Option<()> {
        let mut text = |text: &[u8]| {
            writer.bytes(&[u8::try_from(text.len()).ok()?])?;
            writer.bytes(text)
        };
        text(b"firmware=velvet")?;
        let Some(port) = self.grbl else { return Some(()) };
        let mut grbl = String::<16>::new();
        let _fits = write!(grbl, "grbl={port}");
        text(grbl.as_bytes())
    }
}

/// How long others may keep a record.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Life {
    Usual,
    /// As long as usual; it is not the board's yet.
    Probe,
    /// Shortly, by who does not know mDNS.
    Legacy,
    /// No longer.
    Over,
}
