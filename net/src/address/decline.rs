//! DHCPDECLINE (RFC 2131 section 4.4.4): tells a server that another machine has the address that it gave.
//! The DHCP client of the stack never sends it.

use core::net::Ipv4Addr;

use smoltcp::phy::{ChecksumCapabilities, Device, TxToken};
use smoltcp::time::Instant;
use smoltcp::wire::{
    DhcpMessageType, DhcpPacket, DhcpRepr, EthernetAddress, EthernetFrame, EthernetProtocol, EthernetRepr, IpAddress,
    IpProtocol, Ipv4Packet, Ipv4Repr, UDP_HEADER_LEN, UdpPacket, UdpRepr,
};

use crate::random::Random;

/// Refusal of an address.
#[derive(Clone, Debug)]
pub struct Decline {
    pub mac: [u8; 6],
    pub address: Ipv4Addr,
    pub server: Ipv4Addr,
}

impl Decline {
    /// Sends it. False while the device takes nothing.
    pub fn send(&self, device: &mut impl Device, random: &mut Random, now: Instant) -> bool {
        let Some(token) = device.transmit(now) else { return false };
        let dhcp = self.message(random.next() as u32);
        let udp = UdpRepr { src_port: 68, dst_port: 67 };
        let ip = Ipv4Repr {
            src_addr: Ipv4Addr::UNSPECIFIED,
            dst_addr: Ipv4Addr::BROADCAST,
            next_header: IpProtocol::Udp,
            payload_len: UDP_HEADER_LEN + dhcp.buffer_len(),
            hop_limit: 64,
        };
        let ethernet = EthernetRepr {
            src_addr: EthernetAddress(self.mac),
            dst_addr: EthernetAddress::BROADCAST,
            ethertype: EthernetProtocol::Ipv4,
        };
        let sums = ChecksumCapabilities::default();
        let (from, to) = (IpAddress::Ipv4(ip.src_addr), IpAddress::Ipv4(ip.dst_addr));
        token.consume(ethernet.buffer_len() + ip.buffer_len() + ip.payload_len, |bytes| {
            let mut frame = EthernetFrame::new_unchecked(bytes);
            ethernet.emit(&mut frame);
            let mut packet = Ipv4Packet::new_unchecked(frame.payload_mut());
            ip.emit(&mut packet, &sums);
            let write = |payload: &mut [u8]| {
                let _fits = dhcp.emit(&mut DhcpPacket::new_unchecked(payload));
            };
            let mut datagram = UdpPacket::new_unchecked(packet.payload_mut());
            udp.emit(&mut datagram, &from, &to, dhcp.buffer_len(), write, &sums);
        });
        true
    }

    fn message(&self, transaction_id: u32) -> DhcpRepr<'static> {
        let mac = EthernetAddress(self.mac);
        DhcpRepr {
            message_type: DhcpMessageType::Decline,
            transaction_id,
            secs: 0,
            client_hardware_address: mac,
            client_ip: Ipv4Addr::UNSPECIFIED,
            your_ip: Ipv4Addr::UNSPECIFIED,
            server_ip: Ipv4Addr::UNSPECIFIED,
            router: None,
            subnet_mask: None,
            relay_agent_ip: Ipv4Addr::UNSPECIFIED,
            broadcast: false,
            requested_ip: Some(self.address),
            client_identifier: Some(mac),
            server_identifier: Some(self.server),
            parameter_request_list: None,
            dns_servers: None,
            max_size: None,
            lease_duration: None,
            renew_duration: None,
            rebind_duration: None,
            additional_options: &[],
        }
    }
}
