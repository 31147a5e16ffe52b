//! Frames made by hand, for floods and for senders that do not exist: pings, datagrams, connection requests,
//! ARP.

use std::net::Ipv4Addr;

/// Hardware address of everybody.
pub const EVERYBODY: [u8; 6] = [0xFF; 6];

const IPV4: u16 = 0x0800;
const ARP: u16 = 0x0806;
const ICMP: u8 = 1;
const TCP: u8 = 6;
const UDP: u8 = 17;
/// Kinds of ICMP messages.
const ECHO_REPLY: u8 = 0;
const ECHO: u8 = 8;
/// Flag of a TCP segment that asks for a connection.
const SYN: u8 = 2;
/// Head of a frame, and of a packet without options.
const FRAME_HEAD: usize = 14;
const PACKET_HEAD: usize = 20;

/// One end of a packet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct End {
    /// Hardware address.
    pub hardware: [u8; 6],
    /// Address.
    pub address: Ipv4Addr,
}

/// Returns the Internet checksum of these bytes, RFC 1071.
fn checksum(bytes: &[u8]) -> u16 {
    let words = bytes.chunks(2).map(|pair| u32::from(pair[0]) << 8 | pair.get(1).copied().map_or(0, u32::from));
    let sum = words.fold(0_u64, |sum, word| sum + u64::from(word));
    let folded = (sum & 0xFFFF) + (sum >> 16);
    !((folded & 0xFFFF) + (folded >> 16)) as u16
}

/// Makes a frame.
#[must_use]
pub fn frame(from: [u8; 6], to: [u8; 6], kind: u16, payload: &[u8]) -> Vec<u8> {
    [&to[..], &from, &kind.to_be_bytes(), payload].concat()
}

/// Makes a frame with a packet.
#[must_use]
pub fn packet(from: End, to: End, protocol: u8, payload: &[u8]) -> Vec<u8> {
    let length = (PACKET_HEAD + payload.len()) as u16;
    let mut head = [&[0x45, 0][..], &length.to_be_bytes(), &[0, 0, 0x40, 0, 64, protocol, 0, 0]].concat();
    head.extend(from.address.octets());
    head.extend(to.address.octets());
    let sum = checksum(&head);
    head[10..12].copy_from_slice(&sum.to_be_bytes());
    head.extend(payload);
    frame(from.hardware, to.hardware, IPV4, &head)
}

/// Writes a checksum with the pseudo header into a segment or datagram.
fn seal(from: End, to: End, protocol: u8, bytes: &mut [u8], field: usize) {
    let length = (bytes.len() as u16).to_be_bytes();
    let whole = [&from.address.octets()[..], &to.address.octets(), &[0, protocol], &length, bytes].concat();
    let sum = checksum(&whole).to_be_bytes();
    bytes[field..field + 2].copy_from_slice(&sum);
}

/// Makes a ping.
#[must_use]
pub fn ping(from: End, to: End, identifier: u16, number: u16, payload: &[u8]) -> Vec<u8> {
    let mut message = [&[ECHO, 0, 0, 0][..], &identifier.to_be_bytes(), &number.to_be_bytes(), payload].concat();
    let sum = checksum(&message);
    message[2..4].copy_from_slice(&sum.to_be_bytes());
    packet(from, to, ICMP, &message)
}

/// Reads the answer to a ping: identifier, number, payload.
#[must_use]
pub fn pong(frame: &[u8]) -> Option<(u16, u16, &[u8])> {
    let head = frame.get(FRAME_HEAD..FRAME_HEAD + PACKET_HEAD)?;
    let length = usize::from(u16::from_be_bytes([head[2], head[3]]));
    let message = frame.get(FRAME_HEAD + PACKET_HEAD..FRAME_HEAD + length)?;
    let is_reply = frame[12..14] == IPV4.to_be_bytes() && head[9] == ICMP && *message.first()? == ECHO_REPLY;
    let word = |at: usize| Some(u16::from_be_bytes([*message.get(at)?, *message.get(at + 1)?]));
    (is_reply && checksum(message) == 0).then_some((word(4)?, word(6)?, message.get(8..)?))
}

/// Makes a datagram.
#[must_use]
pub fn datagram(from: End, to: End, ports: (u16, u16), payload: &[u8]) -> Vec<u8> {
    let length = (8 + payload.len()) as u16;
    let mut bytes =
        [&ports.0.to_be_bytes()[..], &ports.1.to_be_bytes(), &length.to_be_bytes(), &[0, 0], payload].concat();
    seal(from, to, UDP, &mut bytes, 6);
    packet(from, to, UDP, &bytes)
}

/// Makes a request for a connection, which its sender may never follow up.
#[must_use]
pub fn connection_request(from: End, to: End, ports: (u16, u16), sequence: u32) -> Vec<u8> {
    let mut bytes = [&ports.0.to_be_bytes()[..], &ports.1.to_be_bytes(), &sequence.to_be_bytes(), &[0; 4]].concat();
    // Head of five words; a window of 4 KB.
    bytes.extend([5 << 4, SYN, 0x10, 0, 0, 0, 0, 0]);
    seal(from, to, TCP, &mut bytes, 16);
    packet(from, to, TCP, &bytes)
}

/// Makes an ARP message: a request, or an answer to `to`.
#[must_use]
pub fn arp(from: End, to: End, is_answer: bool) -> Vec<u8> {
    let mut message = vec![0, 1, 8, 0, 6, 4, 0, if is_answer { 2 } else { 1 }];
    message.extend(from.hardware);
    message.extend(from.address.octets());
    message.extend(if is_answer { to.hardware } else { [0; 6] });
    message.extend(to.address.octets());
    frame(from.hardware, if is_answer { to.hardware } else { EVERYBODY }, ARP, &message)
}

#[cfg(test)]
mod tests {
    use smoltcp::phy::ChecksumCapabilities;
    use smoltcp::wire::{
        ArpPacket, ArpRepr, EthernetFrame, Icmpv4Packet, IpAddress, Ipv4Packet, Ipv4Repr, TcpControl, TcpPacket,
        TcpRepr, UdpPacket,
    };

    use super::*;

    const HERE: End = End { hardware: [2, 0, 0, 0, 0, 9], address: Ipv4Addr::new(10, 0, 2, 9) };
    const THERE: End = End { hardware: [2, 0, 0, 0, 0, 1], address: Ipv4Addr::new(10, 0, 2, 15) };

    fn payload(frame: &[u8]) -> Vec<u8> {
        let ip =
            Ipv4Packet::new_checked(EthernetFrame::new_checked(frame).expect("a frame").payload()).expect("a packet");
        Ipv4Repr::parse(&ip, &ChecksumCapabilities::default()).expect("a right head");
        ip.payload().to_vec()
    }

    #[test]
    fn a_stack_takes_what_is_made_by_hand() {
        let ends = [HERE, THERE].map(|end| IpAddress::Ipv4(end.address));
        let bytes = payload(&ping(HERE, THERE, 7, 8, b"hello"));
        let icmp = Icmpv4Packet::new_checked(&bytes).expect("a message");
        assert!(icmp.verify_checksum() && icmp.echo_seq_no() == 8);
        let bytes = payload(&datagram(HERE, THERE, (1, 2), b"odd"));
        assert!(UdpPacket::new_checked(&bytes).expect("a datagram").verify_checksum(&ends[0], &ends[1]));
        let bytes = payload(&connection_request(HERE, THERE, (40_000, 23), 5));
        let tcp = TcpPacket::new_checked(&bytes[..]).expect("a segment");
        let tcp = TcpRepr::parse(&tcp, &ends[0], &ends[1], &ChecksumCapabilities::default()).expect("a right segment");
        assert_eq!((tcp.control, tcp.dst_port), (TcpControl::Syn, 23));
        let frame = arp(HERE, THERE, false);
        let arp =
            ArpPacket::new_checked(EthernetFrame::new_checked(&frame[..]).expect("a frame").payload()).expect("ARP");
        let ArpRepr::EthernetIpv4 { target_protocol_addr, .. } = ArpRepr::parse(&arp).expect("a request") else {
            panic!("another kind")
        };
        assert_eq!(target_protocol_addr, THERE.address);
    }

    #[test]
    fn an_answer_to_a_ping_is_read_and_a_ping_is_not() {
        let mut frame = ping(HERE, THERE, 7, 8, b"hello");
        assert_eq!(pong(&frame), None);
        frame[34] = 0;
        // One less in the first word, one more in the sum.
        frame[36] += 8;
        assert_eq!(pong(&frame), Some((7, 8, &b"hello"[..])));
    }
}
