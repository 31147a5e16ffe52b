//! The station at the other end of the wire: a stack of its own.

use std::net::Ipv4Addr;

use smoltcp::iface::{Config, Interface, SocketHandle, SocketSet, SocketStorage};
use smoltcp::socket::{tcp, udp};
use smoltcp::time::Instant;
use smoltcp::wire::{EthernetAddress, HardwareAddress, IpAddress, IpCidr, IpEndpoint, Ipv4Cidr};

use super::dhcp::DhcpServer;
use super::wire::Port;

/// Address of the desk.
pub const DESK: Ipv4Addr = Ipv4Addr::new(10, 0, 0, 1);
/// Ethernet address of the desk.
pub const DESK_MAC: [u8; 6] = [2, 0, 0, 0, 0, 0xDE];

/// The desk.
pub struct Desk {
    pub port: Port,
    pub interface: Interface,
    pub sockets: SocketSet<'static>,
    pub dhcp: DhcpServer,
    /// Whether it is switched off.
    pub is_deaf: bool,
    dhcp_socket: SocketHandle,
    next_port: u16,
}

fn leak<T>(items: Vec<T>) -> &'static mut [T] {
    Box::leak(items.into_boxed_slice())
}

/// Makes a UDP socket for some datagrams.
pub fn datagrams() -> udp::Socket<'static> {
    let buffer = || udp::PacketBuffer::new(leak(vec![udp::PacketMetadata::EMPTY; 16]), leak(vec![0; 16_384]));
    udp::Socket::new(buffer(), buffer())
}

impl Desk {
    pub fn new(board: Ipv4Addr) -> Self {
        let mut port = Port::new(64);
        let mut config = Config::new(HardwareAddress::Ethernet(EthernetAddress(DESK_MAC)));
        config.random_seed = 7;
        let mut interface = Interface::new(config, &mut port, Instant::ZERO);
        interface.update_ip_addrs(|addresses| {
            addresses.push(IpCidr::Ipv4(Ipv4Cidr::new(DESK, 24))).expect("room");
            addresses.push(IpCidr::Ipv4(Ipv4Cidr::new(Ipv4Addr::new(169, 254, 9, 9), 16))).expect("room");
        });
        let mut sockets = SocketSet::new(leak((0..1_200).map(|_| SocketStorage::EMPTY).collect()));
        let mut socket = datagrams();
        socket.bind(67).expect("a port");
        let dhcp_socket = sockets.add(socket);
        Self { port, interface, sockets, dhcp: DhcpServer::new(board), is_deaf: false, dhcp_socket, next_port: 40_000 }
    }

    /// Adds a UDP socket at a port, which hears mDNS too.
    pub fn bind(&mut self, port: u16) -> SocketHandle {
        let mut socket = datagrams();
        socket.bind(port).expect("a port");
        socket.set_hop_limit(Some(255));
        let _twice = self.interface.join_multicast_group(Ipv4Addr::new(224, 0, 0, 251));
        self.sockets.add(socket)
    }

    pub fn udp(&mut self, handle: SocketHandle) -> &mut udp::Socket<'static> {
        self.sockets.get_mut(handle)
    }

    /// Sends a datagram.
    pub fn tell(&mut self, handle: SocketHandle, to: (Ipv4Addr, u16), bytes: &[u8]) {
        self.udp(handle).send_slice(bytes, (IpAddress::Ipv4(to.0), to.1)).expect("room");
    }

    /// Reads the next datagram, and where it came from.
    pub fn datagram(&mut self, handle: SocketHandle) -> Option<(Vec<u8>, IpEndpoint)> {
        let (bytes, from) = self.udp(handle).recv().ok()?;
        Some((bytes.to_vec(), from.endpoint))
    }

    /// Begins a connection.
    pub fn connect(&mut self, to: Ipv4Addr, port: u16) -> SocketHandle {
        let buffer = || tcp::SocketBuffer::new(leak(vec![0; 4_096]));
        let mut socket = tcp::Socket::new(buffer(), buffer());
        self.next_port = if self.next_port == 65_000 { 40_000 } else { self.next_port + 1 };
        socket.connect(self.interface.context(), (IpAddress::Ipv4(to), port), self.next_port).expect("a way");
        self.sockets.add(socket)
    }

    pub fn tcp(&mut self, handle: SocketHandle) -> &mut tcp::Socket<'static> {
        self.sockets.get_mut(handle)
    }

    /// Sends as much as fits.
    pub fn send(&mut self, handle: SocketHandle, bytes: &[u8]) -> usize {
        self.tcp(handle).send_slice(bytes).unwrap_or(0)
    }

    /// Reads all that has come.
    pub fn read(&mut self, handle: SocketHandle) -> Vec<u8> {
        let mut into = vec![0; 4_096];
        let count = self.tcp(handle).recv_slice(&mut into).unwrap_or(0);
        into.truncate(count);
        into
    }

    pub fn text(&mut self, handle: SocketHandle) -> String {
        String::from_utf8_lossy(&self.read(handle)).into_owned()
    }

    pub fn run(&mut self, now: Instant) {
        if self.is_deaf {
            self.port.clear();
            return;
        }
        let _changed = self.interface.poll(now, &mut self.port, &mut self.sockets);
        self.dhcp.run(self.sockets.get_mut(self.dhcp_socket));
        let _changed = self.interface.poll(now, &mut self.port, &mut self.sockets);
    }
}
