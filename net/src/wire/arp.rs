//! ARP (RFC 826) past the stack: frames that probe, announce and defend an address (RFC 5227), which the
//! stack neither sends nor hears.

use core::net::Ipv4Addr;

use smoltcp::phy::{Device, TxToken};
use smoltcp::time::Instant;
use smoltcp::wire::{ArpOperation, ArpPacket, ArpRepr, EthernetAddress, EthernetFrame, EthernetProtocol, EthernetRepr};

/// What an ARP frame says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Arp {
    /// Whether it asks, rather than answers.
    pub is_request: bool,
    /// Ethernet address of its sender.
    pub mac: [u8; 6],
    /// Address of its sender, 0.0.0.0 in a probe.
    pub sender: Ipv4Addr,
    /// Address that it is about.
    pub target: Ipv4Addr,
    /// Ethernet address that it is for.
    pub target_mac: [u8; 6],
}

impl Arp {
    /// Reads an Ethernet frame, if it is of ARP.
    pub fn read(frame: &[u8]) -> Option<Self> {
        let ethernet = EthernetFrame::new_checked(frame).ok()?;
        if ethernet.ethertype() != EthernetProtocol::Arp {
            return None;
        }
        let packet = ArpPacket::new_checked(ethernet.payload()).ok()?;
        let ArpRepr::EthernetIpv4 {
            operation,
            source_hardware_addr,
            source_protocol_addr,
            target_hardware_addr,
            target_protocol_addr,
        } = ArpRepr::parse(&packet).ok()?
        else {
            return None;
        };
        Some(Self {
            is_request: operation == ArpOperation::Request,
            mac: source_hardware_addr.0,
            sender: source_protocol_addr,
            target: target_protocol_addr,
            target_mac: target_hardware_addr.0,
        })
    }

    /// Returns the question whether anybody has an address.
    pub const fn probe(mac: [u8; 6], address: Ipv4Addr) -> Self {
        Self { is_request: true, mac, sender: Ipv4Addr::UNSPECIFIED, target: address, target_mac: [0; 6] }
    }

    /// Returns the announcement of having an address.
    pub const fn announcement(mac: [u8; 6], address: Ipv4Addr) -> Self {
        Self { is_request: true, mac, sender: address, target: address, target_mac: [0; 6] }
    }

    /// Returns the answer to a request for `self.target`.
    pub const fn answer(&self, mac: [u8; 6]) -> Self {
        Self { is_request: false, mac, sender: self.target, target: self.sender, target_mac: self.mac }
    }
}

/// Sends a frame. False while the device takes none.
pub fn send_arp(device: &mut impl Device, now: Instant, arp: Arp) -> bool {
    let Some(token) = device.transmit(now) else { return false };
    let is_broadcast = arp.is_request || arp.target.is_unspecified();
    let ethernet = EthernetRepr {
        src_addr: EthernetAddress(arp.mac),
        dst_addr: if is_broadcast { EthernetAddress::BROADCAST } else { EthernetAddress(arp.target_mac) },
        ethertype: EthernetProtocol::Arp,
    };
    let packet = ArpRepr::EthernetIpv4 {
        operation: if arp.is_request { ArpOperation::Request } else { ArpOperation::Reply },
        source_hardware_addr: EthernetAddress(arp.mac),
        source_protocol_addr: arp.sender,
        target_hardware_addr: EthernetAddress(arp.target_mac),
        target_protocol_addr: arp.target,
    };
    let length = ethernet.buffer_len() + packet.buffer_len();
    token.consume(length, |bytes| {
        let mut frame = EthernetFrame::new_unchecked(bytes);
        ethernet.emit(&mut frame);
        packet.emit(&mut ArpPacket::new_unchecked(frame.payload_mut()));
    });
    true
}
