//! A computer at the other end of the cable: a stack with TCP clients and UDP for tests, a DHCP server, a
//! name server and a time server, behind a line that can be bad. All of it lives in virtual time: the same
//! seed gives the same frames.

use std::net::Ipv4Addr;

use smoltcp::iface::{Config, Interface, SocketHandle, SocketSet};
use smoltcp::socket::{tcp, udp};
use smoltcp::time::Instant;
use smoltcp::wire::{EthernetAddress, IpAddress, IpCidr, IpEndpoint, IpListenEndpoint};

use super::answers::{Names, TimeServer};
use super::dhcp::{DhcpKind, DhcpServer};
use super::frames::End;
use super::impairment::{Impairment, Way};
use super::port::Port;
use crate::peripherals::ethernet::{Partner, Sent, Wire};
use crate::vm::{Span, Vm};

/// Address of the computer, and the one that it gives the board; hardware address of the computer.
pub const OWN: Ipv4Addr = Ipv4Addr::new(10, 0, 2, 2);
/// Address that the DHCP server gives the board.
pub const GIVEN: Ipv4Addr = Ipv4Addr::new(10, 0, 2, 15);
const HARDWARE: EthernetAddress = EthernetAddress([0x02, 0x00, 0x0A, 0x00, 0x02, 0x02]);
/// Ports of the services.
const DHCP: u16 = 67;
const DHCP_CLIENT: u16 = 68;
const DNS: u16 = 53;
const NTP: u16 = 123;
/// First of the ports for clients.
const FIRST_PORT: u16 = 49_152;
/// Bytes of a connection's buffers.
const TCP_BUFFER: usize = 65_536;
const UDP_BUFFER: usize = 16_384;
/// Virtual time between two rounds.
const STEP_NS: u64 = 250_000;

/// A TCP connection of the computer's.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Connection(SocketHandle);

/// A UDP port of the computer's.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Datagrams(SocketHandle);

/// The computer with its line.
pub struct Peer {
    interface: Interface,
    port: Port,
    sockets: SocketSet<'static>,
    services: [SocketHandle; 3],
    next_port: u16,
    /// Address of the board, as far as it has been seen or given, and its hardware address.
    board: Option<Ipv4Addr>,
    hardware: Option<[u8; 6]>,
    /// The way to the board.
    pub to_board: Way,
    /// The way from the board.
    pub from_board: Way,
    /// The DHCP server.
    pub dhcp: DhcpServer,
    /// The name server.
    pub names: Names,
    /// The time server.
    pub time: TimeServer,
    /// Connections that are given up, and forgotten once their last word is out.
    retired: Vec<SocketHandle>,
    /// Frames of the board's, when they are kept.
    seen: Option<Vec<Sent>>,
}

fn instant(now_ns: u64) -> Instant {
    Instant::from_micros((now_ns / 1_000) as i64)
}

fn datagrams(port: u16) -> udp::Socket<'static> {
    let buffer = || udp::PacketBuffer::new(vec![udp::PacketMetadata::EMPTY; 64], vec![0; UDP_BUFFER]);
    let mut socket = udp::Socket::new(buffer(), buffer());
    // Only a port of zero or one that is open already is refused.
    let _ = socket.bind(IpListenEndpoint::from(port));
    socket
}

impl Peer {
    /// Creates the computer with a good line. The seed is that of everything random.
    #[must_use]
    pub fn new(seed: u64) -> Self {
        let mut port = Port::default();
        let mut config = Config::new(HARDWARE.into());
        config.random_seed = seed;
        let mut interface = Interface::new(config, &mut port, instant(0));
        interface.update_ip_addrs(|addresses| {
            let _ = addresses.push(IpCidr::new(IpAddress::Ipv4(OWN), 24));
        });
        let mut sockets = SocketSet::new(Vec::new());
        let services = [DHCP, DNS, NTP].map(|port| sockets.add(datagrams(port)));
        let mut names = Names::default();
        names.known.insert("pool.ntp.org".into(), OWN);
        Self {
            interface,
            port,
            sockets,
            services,
            next_port: FIRST_PORT,
            board: None,
            hardware: None,
            to_board: Way::new(seed ^ 1),
            from_board: Way::new(seed ^ 2),
            dhcp: DhcpServer::new(OWN, GIVEN),
            names,
            time: TimeServer::default(),
            retired: Vec::new(),
            seen: None,
        }
    }

    /// Makes the line bad both ways, or good again.
    pub fn impair(&mut self, impairment: &Impairment) {
        self.to_board.impairment = impairment.clone();
        self.from_board.impairment = impairment.clone();
    }

    /// Keeps the board's frames from now on, for [`Self::take_seen`].
    pub fn keep_frames(&mut self) {
        self.seen.get_or_insert_default();
    }

    /// Takes the board's frames since the last call, as they left it.
    pub fn take_seen(&mut self) -> Vec<Sent> {
        self.seen.as_mut().map(std::mem::take).unwrap_or_default()
    }

    /// Puts any frame on the line to the board at the next round.
    pub fn put(&mut self, frame: &[u8]) {
        self.port.sent.push(frame.to_vec());
    }

    /// Returns the board's address: the last one that it sent from, or was given.
    #[must_use]
    pub const fn board(&self) -> Option<Ipv4Addr> {
        self.board
    }

    /// Returns the board as the end of packets: its last address, and its hardware address.
    #[must_use]
    pub fn board_end(&self) -> Option<End> {
        Some(End { hardware: self.hardware?, address: self.board? })
    }

    /// Returns the computer as the end of packets.
    #[must_use]
    pub const fn own_end(&self) -> End {
        End { hardware: HARDWARE.0, address: OWN }
    }

    /// Plugs the computer into the board.
    pub fn plug(&self, vm: &mut Vm) {
        super::wire(vm, |wire| wire.plug(Partner::default()));
    }

    /// Pulls the cable out.
    pub fn unplug(&self, vm: &mut Vm) {
        super::wire(vm, Wire::unplug);
    }

    /// Runs board and computer for so many nanoseconds.
    pub fn run(&mut self, vm: &mut Vm, nanoseconds: u64) -> Span {
        let end_ns = vm.now_ns() + nanoseconds;
        while vm.now_ns() < end_ns {
            let span = vm.run_until(end_ns.min(vm.now_ns() + STEP_NS));
            if span != Span::Reached {
                return span;
            }
            self.serve(vm);
        }
        Span::Reached
    }

    /// Runs board and computer until something holds. Returns whether it did in time.
    pub fn run_until(&mut self, vm: &mut Vm, limit_ns: u64, mut holds: impl FnMut(&mut Self) -> bool) -> bool {
        let end_ns = vm.now_ns() + limit_ns;
        while vm.now_ns() < end_ns {
            if holds(self) {
                return true;
            }
            if self.run(vm, STEP_NS) != Span::Reached {
                return false;
            }
        }
        holds(self)
    }

    /// Serves the line once, at the instant at which the board is held.
    pub fn serve(&mut self, vm: &mut Vm) {
        let sent = super::wire(vm, Wire::take_all).unwrap_or_default();
        let frames = self.turn(vm.now_ns(), sent);
        if !frames.is_empty() {
            super::wire(vm, move |wire| frames.iter().for_each(|frame| wire.put(frame)));
        }
    }

    /// Takes the board's frames. Returns those that have arrived at the board.
    pub(super) fn turn(&mut self, now_ns: u64, sent: Vec<Sent>) -> Vec<Vec<u8>> {
        for frame in sent {
            if let Some(seen) = &mut self.seen {
                seen.push(frame.clone());
            }
            self.learn(&frame.bytes);
            self.from_board.enter(frame.at_ns, frame.bytes);
        }
        self.port.arrived.extend(self.from_board.arrived(now_ns));
        self.interface.poll(instant(now_ns), &mut self.port, &mut self.sockets);
        if self.answer(now_ns) {
            self.interface.poll(instant(now_ns), &mut self.port, &mut self.sockets);
        }
        for retired in std::mem::take(&mut self.retired) {
            self.sockets.remove(retired);
        }
        for frame in std::mem::take(&mut self.port.sent) {
            self.to_board.enter(now_ns, frame);
        }
        self.to_board.arrived(now_ns)
    }

    /// Learns the board's address from a frame of its own: the sender of a packet, or of an ARP message.
    fn learn(&mut self, frame: &[u8]) {
        self.hardware = frame.get(6..12).and_then(|bytes| bytes.try_into().ok());
        let place = match frame.get(12..14) {
            Some([0x08, 0x00]) => 26,
            Some([0x08, 0x06]) => 28,
            _ => return,
        };
        let octets: Option<[u8; 4]> = frame.get(place..place + 4).and_then(|bytes| bytes.try_into().ok());
        if let Some(address) = octets.map(Ipv4Addr::from).filter(|address| !address.is_unspecified()) {
            self.meet(address);
        }
    }

    /// Follows an address of the board's. Outside of the own network the computer takes one near it.
    fn meet(&mut self, address: Ipv4Addr) {
        if self.board == Some(address) {
            return;
        }
        self.board = Some(address);
        let [a, b, c, _] = address.octets();
        let near = |last: u8| Ipv4Addr::new(a, b, c, last);
        let (own, length) = if address.is_link_local() { (Ipv4Addr::new(169, 254, 2, 2), 16) } else { (near(2), 24) };
        let own = if own == address { near(3) } else { own };
        self.interface.update_ip_addrs(|addresses| {
            addresses.truncate(1);
            if [a, b, c] != OWN.octets()[..3] {
                let _ = addresses.push(IpCidr::new(IpAddress::Ipv4(own), length));
            }
        });
    }

    /// Answers what the board has asked the services. Returns whether there was anything.
    fn answer(&mut self, now_ns: u64) -> bool {
        let [dhcp, dns, ntp] = self.services;
        let mut answered = false;
        while let Some((bytes, from)) = take(&mut self.sockets, dhcp) {
            if let Some(answer) = self.dhcp.answer(&bytes) {
                let to = IpEndpoint::new(IpAddress::Ipv4(answer.to), DHCP_CLIENT);
                if answer.kind == DhcpKind::Ack {
                    self.meet(self.dhcp.address);
                }
                send(&mut self.sockets, dhcp, to, &answer.bytes);
            }
            answered |= from.port == DHCP_CLIENT;
        }
        while let Some((bytes, from)) = take(&mut self.sockets, dns) {
            if let Some(answer) = self.names.answer(&bytes) {
                send(&mut self.sockets, dns, from, &answer);
            }
            answered = true;
        }
        while let Some((bytes, from)) = take(&mut self.sockets, ntp) {
            if let Some(answer) = self.time.answer(&bytes, now_ns) {
                send(&mut self.sockets, ntp, from, &answer);
            }
            answered = true;
        }
        answered
    }

    fn free_port(&mut self) -> u16 {
        let port = self.next_port;
        self.next_port = port.checked_add(1).unwrap_or(FIRST_PORT);
        port
    }

    /// Begins a connection to a port of the board's. `None` while its address is not known.
    pub fn connect(&mut self, port: u16) -> Option<Connection> {
        let to = self.board?;
        self.connect_to(to, port)
    }

    /// Begins a connection to any address.
    pub fn connect_to(&mut self, to: Ipv4Addr, port: u16) -> Option<Connection> {
        let buffer = || tcp::SocketBuffer::new(vec![0; TCP_BUFFER]);
        let mut socket = tcp::Socket::new(buffer(), buffer());
        socket.set_nagle_enabled(false);
        let from = self.free_port();
        socket.connect(self.interface.context(), (IpAddress::Ipv4(to), port), from).ok()?;
        Some(Connection(self.sockets.add(socket)))
    }

    fn tcp(&mut self, connection: Connection) -> &mut tcp::Socket<'static> {
        self.sockets.get_mut(connection.0)
    }

    /// Returns the socket of a connection, for its options and its state.
    pub fn socket(&mut self, connection: Connection) -> &mut tcp::Socket<'static> {
        self.tcp(connection)
    }

    /// Whether a connection stands.
    pub fn is_connected(&mut self, connection: Connection) -> bool {
        self.tcp(connection).may_send()
    }

    /// Whether a connection is over, in whatever way.
    pub fn is_over(&mut self, connection: Connection) -> bool {
        !self.tcp(connection).is_active()
    }

    /// Whether the board has ended its direction of a connection, and everything is read.
    pub fn has_ended(&mut self, connection: Connection) -> bool {
        let socket = self.tcp(connection);
        !socket.may_recv() && socket.recv_queue() == 0 && socket.state() != tcp::State::SynSent
    }

    /// Sends bytes. Returns how many the connection takes now.
    pub fn send(&mut self, connection: Connection, bytes: &[u8]) -> usize {
        self.tcp(connection).send_slice(bytes).unwrap_or(0)
    }

    /// Returns the bytes that the board has not acknowledged yet.
    pub fn unsent(&mut self, connection: Connection) -> usize {
        self.tcp(connection).send_queue()
    }

    /// Takes the bytes that have arrived.
    pub fn receive(&mut self, connection: Connection) -> Vec<u8> {
        self.receive_at_most(connection, usize::MAX)
    }

    /// Takes so many bytes at most; the rest holds the board back.
    pub fn receive_at_most(&mut self, connection: Connection, count: usize) -> Vec<u8> {
        let socket = self.tcp(connection);
        let mut bytes = vec![0; socket.recv_queue().min(count)];
        let taken = socket.recv_slice(&mut bytes).unwrap_or(0);
        bytes.truncate(taken);
        bytes
    }

    /// Ends the own direction of a connection, once everything is sent.
    pub fn close(&mut self, connection: Connection) {
        self.tcp(connection).close();
    }

    /// Resets a connection.
    pub fn abort(&mut self, connection: Connection) {
        self.tcp(connection).abort();
    }

    /// Resets a connection if it still stands, and forgets it.
    pub fn retire(&mut self, connection: Connection) {
        self.abort(connection);
        self.retired.push(connection.0);
    }

    /// Forgets a connection without a word, as a computer that dies.
    pub fn forget(&mut self, connection: Connection) {
        self.sockets.remove(connection.0);
    }

    /// Opens a UDP port; zero takes a free one.
    pub fn open(&mut self, port: u16) -> Datagrams {
        let port = if port == 0 { self.free_port() } else { port };
        Datagrams(self.sockets.add(datagrams(port)))
    }

    /// Joins a group, so that its packets arrive.
    pub fn join(&mut self, group: Ipv4Addr) {
        // Only a full table and an address that is no group are refused.
        let _ = self.interface.join_multicast_group(IpAddress::Ipv4(group));
    }

    /// Sends a datagram.
    pub fn send_to(&mut self, datagrams: Datagrams, to: Ipv4Addr, port: u16, bytes: &[u8]) {
        send(&mut self.sockets, datagrams.0, IpEndpoint::new(IpAddress::Ipv4(to), port), bytes);
    }

    /// Takes the next datagram, with its sender.
    pub fn receive_from(&mut self, datagrams: Datagrams) -> Option<(Vec<u8>, Ipv4Addr, u16)> {
        let (bytes, from) = take(&mut self.sockets, datagrams.0)?;
        let IpAddress::Ipv4(address) = from.addr;
        Some((bytes, address, from.port))
    }
}

fn take(sockets: &mut SocketSet<'static>, handle: SocketHandle) -> Option<(Vec<u8>, IpEndpoint)> {
    let (bytes, about) = sockets.get_mut::<udp::Socket<'_>>(handle).recv().ok()?;
    Some((bytes.to_vec(), about.endpoint))
}

fn send(sockets: &mut SocketSet<'static>, handle: SocketHandle, to: IpEndpoint, bytes: &[u8]) {
    // A full buffer loses the datagram, as a full buffer does.
    let _ = sockets.get_mut::<udp::Socket<'_>>(handle).send_slice(bytes, to);
}
