//! Frames that no stack would send.

use std::net::Ipv4Addr;

use smoltcp::phy::ChecksumCapabilities;
use smoltcp::wire::{
    EthernetAddress, EthernetFrame, EthernetProtocol, EthernetRepr, Icmpv4Packet, Icmpv4Repr, IpAddress, IpProtocol,
    Ipv4Packet, Ipv4Repr, TcpControl, TcpPacket, TcpRepr, TcpSeqNumber, UDP_HEADER_LEN, UdpPacket, UdpRepr,
};

use super::bench::BOARD_MAC;
use super::desk::DESK_MAC;

/// Makes a frame of ARP.
pub fn arp(is_request: bool, mac: [u8; 6], sender: Ipv4Addr, target: Ipv4Addr) -> Vec<u8> {
    let mut frame = vec![0xFF; 6];
    frame.extend(mac);
    frame.extend([8, 6, 0, 1, 8, 0, 6, 4, 0, if is_request { 1 } else { 2 }]);
    frame.extend(mac);
    frame.extend(sender.octets());
    frame.extend([0; 6]);
    frame.extend(target.octets());
    frame
}

fn packet(to_mac: [u8; 6], ip: Ipv4Repr, write: impl FnOnce(&mut [u8])) -> Vec<u8> {
    let ethernet = EthernetRepr {
        src_addr: EthernetAddress(DESK_MAC),
        dst_addr: EthernetAddress(to_mac),
        ethertype: EthernetProtocol::Ipv4,
    };
    let mut bytes = vec![0; ethernet.buffer_len() + ip.buffer_len() + ip.payload_len];
    let mut frame = EthernetFrame::new_unchecked(&mut bytes[..]);
    ethernet.emit(&mut frame);
    let mut packet = Ipv4Packet::new_unchecked(frame.payload_mut());
    ip.emit(&mut packet, &ChecksumCapabilities::default());
    write(packet.payload_mut());
    bytes
}

/// Makes a request for an echo with so many bytes.
pub fn echo(from: Ipv4Addr, to: Ipv4Addr, length: usize) -> Vec<u8> {
    let data = vec![0x5A; length];
    let icmp = Icmpv4Repr::EchoRequest { ident: 1, seq_no: 2, data: &data };
    let payload_len = icmp.buffer_len();
    let ip = Ipv4Repr { src_addr: from, dst_addr: to, next_header: IpProtocol::Icmp, payload_len, hop_limit: 64 };
    packet(BOARD_MAC, ip, |bytes| {
        icmp.emit(&mut Icmpv4Packet::new_unchecked(bytes), &ChecksumCapabilities::default());
    })
}

/// Makes a datagram without content.
pub fn datagram(from: (Ipv4Addr, u16), to: (Ipv4Addr, u16)) -> Vec<u8> {
    let udp = UdpRepr { src_port: from.1, dst_port: to.1 };
    let payload_len = UDP_HEADER_LEN + 12;
    let ip = Ipv4Repr { src_addr: from.0, dst_addr: to.0, next_header: IpProtocol::Udp, payload_len, hop_limit: 64 };
    let (source, target) = (IpAddress::Ipv4(from.0), IpAddress::Ipv4(to.0));
    packet(BOARD_MAC, ip, |bytes| {
        let sums = ChecksumCapabilities::default();
        udp.emit(&mut UdpPacket::new_unchecked(bytes), &source, &target, 12, |_| {}, &sums);
    })
}

/// Makes a request for a connection.
pub fn syn(from: (Ipv4Addr, u16), to: (Ipv4Addr, u16)) -> Vec<u8> {
    let tcp = TcpRepr {
        src_port: from.1,
        dst_port: to.1,
        control: TcpControl::Syn,
        seq_number: TcpSeqNumber(77),
        ack_number: None,
        window_len: 1_000,
        window_scale: None,
        max_seg_size: Some(1_460),
        sack_permitted: false,
        sack_ranges: [None; 3],
        timestamp: None,
        payload: &[],
    };
    let payload_len = tcp.buffer_len();
    let ip = Ipv4Repr { src_addr: from.0, dst_addr: to.0, next_header: IpProtocol::Tcp, payload_len, hop_limit: 64 };
    let (source, target) = (IpAddress::Ipv4(from.0), IpAddress::Ipv4(to.0));
    packet(BOARD_MAC, ip, |bytes| {
        let sums = ChecksumCapabilities::default();
        tcp.emit(&mut TcpPacket::new_unchecked(bytes), &source, &target, &sums);
    })
}
