//! DHCP server of the desk.

use std::net::Ipv4Addr;

use smoltcp::socket::udp;
use smoltcp::wire::{DhcpMessageType, DhcpPacket, DhcpRepr, IpAddress};

use super::desk::DESK;

/// Server with one address to give.
pub struct DhcpServer {
    pub is_on: bool,
    pub address: Ipv4Addr,
    pub router: Ipv4Addr,
    pub lease: u32,
    /// Messages that came.
    pub heard: Vec<DhcpMessageType>,
    /// Name that the client told.
    pub host: Option<String>,
}

impl DhcpServer {
    pub fn new(address: Ipv4Addr) -> Self {
        Self { is_on: true, address, router: DESK, lease: 3_600, heard: Vec::new(), host: None }
    }

    /// Answers what came.
    pub fn run(&mut self, socket: &mut udp::Socket<'static>) {
        while let Ok((bytes, _)) = socket.recv() {
            let bytes = bytes.to_vec();
            let packet = DhcpPacket::new_checked(&bytes[..]).expect("a message");
            let asked = DhcpRepr::parse(&packet).expect("a message");
            if !self.is_on {
                continue;
            }
            self.heard.push(asked.message_type);
            let host = packet.options().find(|option| option.kind == 12);
            self.host = host.map(|option| String::from_utf8_lossy(option.data).into_owned());
            let message_type = match asked.message_type {
                DhcpMessageType::Discover => DhcpMessageType::Offer,
                DhcpMessageType::Request => {
                    let wanted = asked.requested_ip.unwrap_or(asked.client_ip);
                    if wanted == self.address { DhcpMessageType::Ack } else { DhcpMessageType::Nak }
                }
                _ => continue,
            };
            let answer = self.answer(message_type, &asked);
            let mut into = vec![0; answer.buffer_len()];
            answer.emit(&mut DhcpPacket::new_unchecked(&mut into[..])).expect("fits");
            socket.send_slice(&into, (IpAddress::Ipv4(Ipv4Addr::BROADCAST), 68)).expect("room");
        }
    }

    fn answer(&self, message_type: DhcpMessageType, asked: &DhcpRepr<'_>) -> DhcpRepr<'static> {
        DhcpRepr {
            message_type,
            transaction_id: asked.transaction_id,
            secs: 0,
            client_hardware_address: asked.client_hardware_address,
            client_ip: Ipv4Addr::UNSPECIFIED,
            your_ip: self.address,
            server_ip: DESK,
            router: Some(self.router),
            subnet_mask: Some(Ipv4Addr::new(255, 255, 255, 0)),
            relay_agent_ip: Ipv4Addr::UNSPECIFIED,
            broadcast: true,
            requested_ip: None,
            client_identifier: None,
            server_identifier: Some(DESK),
            parameter_request_list: None,
            dns_servers: Some([DESK].into_iter().collect()),
            max_size: None,
            lease_duration: Some(self.lease),
            renew_duration: None,
            rebind_duration: None,
            additional_options: &[],
        }
    }
}
