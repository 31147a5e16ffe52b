//! Checksums: the frame's own, and those of IP, TCP, UDP and ICMP that the checksum offload engine writes and
//! checks (RM0399 section 61.5.11, "IPv4 checksum offload").

/// Length of an Ethernet header.
const HEADER: usize = 14;
const VLAN: u16 = 0x8100;
const IPV4: u16 = 0x0800;
const IPV6: u16 = 0x86DD;
const TCP: u8 = 6;
const UDP: u8 = 17;
const ICMP: u8 = 1;
const ICMPV6: u8 = 58;
/// Extension headers of IPv6 that the engine steps over: hop by hop, routing, destination.
const STEPPED_OVER: [u8; 3] = [0, 43, 60];

/// Returns the frame check sequence of these bytes, IEEE 802.3 section 3.2.9; its lowest byte goes first.
pub(super) fn frame_check(bytes: &[u8]) -> u32 {
    const POLYNOMIAL: u32 = 0xEDB8_8320;
    let step = |crc: u32, &byte: &u8| {
        (0..8).fold(crc ^ u32::from(byte), |crc, _| crc >> 1 ^ if crc & 1 != 0 { POLYNOMIAL } else { 0 })
    };
    !bytes.iter().fold(u32::MAX, step)
}

/// Payload of an IP packet that has a checksum of its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Payload {
    Udp,
    Tcp,
    Icmp,
}

/// Verdict of the engine on a received frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Verdict {
    pub(super) is_ipv4: bool,
    pub(super) is_ipv6: bool,
    pub(super) header_is_wrong: bool,
    pub(super) payload: Option<Payload>,
    pub(super) payload_is_wrong: bool,
    /// Engine has left the payload alone: a fragment, or a protocol that it does not know.
    pub(super) bypassed: bool,
}

/// Place of an IP packet in a frame.
struct Packet {
    /// Start of the IP header, start of the payload and its end.
    ip: usize,
    payload: usize,
    end: usize,
    protocol: u8,
    is_fragment: bool,
    is_v6: bool,
    header_is_wrong: bool,
}

fn word(bytes: &[u8], at: usize) -> Option<u16> {
    Some(u16::from_be_bytes([*bytes.get(at)?, *bytes.get(at + 1)?]))
}

/// Returns the one's complement sum of these bytes as 16-bit words, on top of another.
fn sum(bytes: &[u8], start: u32) -> u32 {
    let pairs = bytes.chunks(2).map(|pair| u32::from(pair[0]) << 8 | pair.get(1).copied().map_or(0, u32::from));
    let total = pairs.fold(u64::from(start), |sum, pair| sum + u64::from(pair));
    let folded = (total & 0xFFFF) + (total >> 16 & 0xFFFF) + (total >> 32);
    ((folded & 0xFFFF) + (folded >> 16)) as u32
}

/// Finds the IP packet of a frame.
fn find(frame: &[u8]) -> Option<Packet> {
    let tagged = word(frame, HEADER - 2)? == VLAN;
    let ip = if tagged { HEADER + 4 } else { HEADER };
    match word(frame, ip - 2)? {
        IPV4 => find_v4(frame, ip),
        IPV6 => find_v6(frame, ip),
        _ => None,
    }
}

fn find_v4(frame: &[u8], ip: usize) -> Option<Packet> {
    let first = *frame.get(ip)?;
    let payload = ip + usize::from(first & 0xF) * 4;
    let end = ip + usize::from(word(frame, ip + 2)?);
    let whole = frame.get(ip..payload).filter(|header| header.len() >= 20);
    let checked = whole.is_some_and(|header| sum(header, 0) == 0xFFFF);
    Some(Packet {
        ip,
        payload,
        end,
        protocol: *frame.get(ip + 9)?,
        is_fragment: word(frame, ip + 6)? & 0x3FFF != 0,
        is_v6: false,
        header_is_wrong: first >> 4 != 4 || whole.is_none() || end > frame.len() || end < payload || !checked,
    })
}

fn find_v6(frame: &[u8], ip: usize) -> Option<Packet> {
    let end = ip + 40 + usize::from(word(frame, ip + 4)?);
    let mut protocol = *frame.get(ip + 6)?;
    let mut payload = ip + 40;
    while STEPPED_OVER.contains(&protocol) {
        protocol = *frame.get(payload)?;
        payload += 8 + usize::from(*frame.get(payload + 1)?) * 8;
    }
    let header_is_wrong = frame.get(ip)? >> 4 != 6 || end > frame.len() || end < payload;
    Some(Packet { ip, payload, end, protocol, is_fragment: protocol == 44, is_v6: true, header_is_wrong })
}

impl Packet {
    fn kind(&self) -> Option<(Payload, usize)> {
        match self.protocol {
            TCP => Some((Payload::Tcp, 16)),
            UDP => Some((Payload::Udp, 6)),
            ICMP if !self.is_v6 => Some((Payload::Icmp, 2)),
            ICMPV6 if self.is_v6 => Some((Payload::Icmp, 2)),
            _ => None,
        }
    }

    /// Returns the sum of the pseudo header; ICMP of IPv4 has none.
    fn pseudo_header(&self, frame: &[u8]) -> u32 {
        if self.protocol == ICMP {
            return 0;
        }
        let addresses = if self.is_v6 { self.ip + 8..self.ip + 40 } else { self.ip + 12..self.ip + 20 };
        let rest = u32::from(self.protocol) + (self.end - self.payload) as u32;
        sum(frame.get(addresses).unwrap_or(&[]), rest)
    }
}

/// Checks a received frame, without its frame check sequence.
pub(super) fn check(frame: &[u8]) -> Verdict {
    let Some(packet) = find(frame) else { return Verdict::default() };
    let mut verdict = Verdict {
        is_ipv4: !packet.is_v6,
        is_ipv6: packet.is_v6,
        header_is_wrong: packet.header_is_wrong,
        ..Verdict::default()
    };
    let kind = packet.kind().filter(|_| !packet.is_fragment && !packet.header_is_wrong);
    let Some((payload, field)) = kind else {
        verdict.bypassed = true;
        return verdict;
    };
    verdict.payload = Some(payload);
    let bytes = frame.get(packet.payload..packet.end).unwrap_or(&[]);
    let Some(written) = word(bytes, field) else {
        verdict.payload_is_wrong = true;
        return verdict;
    };
    // A sender of UDP over IPv4 may leave the checksum out.
    let left_out = payload == Payload::Udp && !packet.is_v6 && written == 0;
    verdict.payload_is_wrong = !left_out && sum(bytes, packet.pseudo_header(frame)) != 0xFFFF;
    verdict
}

/// Extent of insertion: CIC of a transmit descriptor's DES3.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Insertion {
    Nothing,
    Header,
    /// Sum of the pseudo header is in the checksum's field already.
    Payload,
    /// Pseudo header as well.
    Everything,
}

impl Insertion {
    pub(super) const fn of(des3: u32) -> Self {
        match des3 >> 16 & 3 {
            0 => Self::Nothing,
            1 => Self::Header,
            2 => Self::Payload,
            _ => Self::Everything,
        }
    }
}

/// Failure of an insertion: the frame goes out as it is, and the descriptor says why.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Inserted {
    pub(super) header_error: bool,
    pub(super) payload_error: bool,
}

/// Writes checksums into a frame to be sent, without its frame check sequence.
pub(super) fn insert(frame: &mut [u8], extent: Insertion) -> Inserted {
    let mut done = Inserted::default();
    let Some(mut packet) = find(frame).filter(|_| extent != Insertion::Nothing) else { return done };
    if !packet.is_v6 {
        if let Some(header) = frame.get_mut(packet.ip..packet.payload).filter(|header| header.len() >= 20) {
            header[10..12].fill(0);
            let checksum = !(sum(header, 0) as u16);
            header[10..12].copy_from_slice(&checksum.to_be_bytes());
        }
        let Some(again) = find(frame) else { return done };
        packet = again;
    }
    if packet.header_is_wrong {
        done.header_error = true;
        return done;
    }
    let Some((payload, field)) = packet.kind().filter(|_| !packet.is_fragment && extent != Insertion::Header) else {
        return done;
    };
    let start = if extent == Insertion::Everything { packet.pseudo_header(frame) } else { 0 };
    let Some(bytes) = frame.get_mut(packet.payload..packet.end).filter(|bytes| bytes.len() >= field + 2) else {
        done.payload_error = true;
        return done;
    };
    if extent == Insertion::Everything {
        bytes[field..field + 2].fill(0);
    }
    let checksum = match !(sum(bytes, start) as u16) {
        0 if payload == Payload::Udp => 0xFFFF,
        other => other,
    };
    bytes[field..field + 2].copy_from_slice(&checksum.to_be_bytes());
    done
}
