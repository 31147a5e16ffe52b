//! The computer against a second stack, which stands for the board.

use std::io::{ErrorKind, Read, Write};
use std::net::{Ipv4Addr, TcpStream};

use smoltcp::iface::{Config, Interface, SocketHandle, SocketSet};
use smoltcp::socket::tcp;
use smoltcp::time::Instant;
use smoltcp::wire::{EthernetAddress, IpAddress, IpCidr};

use super::forward::Forward;
use super::impairment::Impairment;
use super::peer::{GIVEN, OWN, Peer};
use super::port::Port;
use crate::peripherals::ethernet::Sent;

const ADDRESS: EthernetAddress = EthernetAddress([2, 0, 0, 0, 0, 1]);
const STEP_NS: u64 = 1_000_000;

/// A board with an echo on port 7.
struct Board {
    interface: Interface,
    port: Port,
    sockets: SocketSet<'static>,
    echo: SocketHandle,
    now_ns: u64,
}

impl Board {
    fn new(address: Ipv4Addr) -> Self {
        let mut port = Port::default();
        let mut interface = Interface::new(Config::new(ADDRESS.into()), &mut port, Instant::ZERO);
        interface.update_ip_addrs(|addresses| addresses.push(IpCidr::new(IpAddress::Ipv4(address), 24)).expect("room"));
        let mut sockets = SocketSet::new(Vec::new());
        let buffer = || tcp::SocketBuffer::new(vec![0; 4_096]);
        let mut echo = tcp::Socket::new(buffer(), buffer());
        echo.listen(7).expect("a port");
        let echo = sockets.add(echo);
        Self { interface, port, sockets, echo, now_ns: 0 }
    }

    /// Runs board and computer for a step.
    fn step(&mut self, peer: &mut Peer) {
        self.now_ns += STEP_NS;
        let now = Instant::from_micros((self.now_ns / 1_000) as i64);
        self.interface.poll(now, &mut self.port, &mut self.sockets);
        let socket = self.sockets.get_mut::<tcp::Socket<'_>>(self.echo);
        if socket.can_recv() && socket.can_send() {
            let room = socket.send_capacity() - socket.send_queue();
            let bytes = socket.recv(|bytes| (bytes.len().min(room), bytes[..bytes.len().min(room)].to_vec()));
            socket.send_slice(&bytes.expect("bytes")).expect("room");
        }
        self.interface.poll(now, &mut self.port, &mut self.sockets);
        let pad = |mut bytes: Vec<u8>| {
            bytes.resize(bytes.len().max(60), 0);
            bytes
        };
        let sent = std::mem::take(&mut self.port.sent).into_iter();
        let sent = sent.map(|bytes| Sent { at_ns: self.now_ns, bytes: pad(bytes) }).collect();
        self.port.arrived.extend(peer.turn(self.now_ns, sent));
    }
}

/// Echoes bytes through the line. Returns the instant at which all are back.
fn echoed(impairment: &Impairment, seed: u64) -> u64 {
    let mut peer = Peer::new(seed);
    let mut board = Board::new(GIVEN);
    peer.impair(impairment);
    let connection = peer.connect_to(GIVEN, 7).expect("a connection");
    let bytes: Vec<u8> = (0..60_000_u32).map(|place| (place * 31 % 251) as u8).collect();
    let (mut sent, mut back) = (0, Vec::new());
    while back.len() < bytes.len() {
        board.step(&mut peer);
        if peer.is_connected(connection) {
            sent += peer.send(connection, &bytes[sent..]);
        }
        back.extend(peer.receive(connection));
        assert!(board.now_ns < 300_000_000_000, "{} of {} bytes", back.len(), bytes.len());
    }
    assert_eq!(back, bytes);
    board.now_ns
}

#[test]
fn bytes_come_back_over_a_good_line() {
    assert!(echoed(&Impairment::default(), 1) < 200_000_000);
}

#[test]
fn bytes_come_back_over_a_bad_line_and_at_the_same_instant_with_the_same_seed() {
    let bad = Impairment {
        loss: 100,
        doubling: 30,
        reordering: 50,
        corruption: 20,
        delay_ns: 100_000..3_000_000,
        overtaken_ns: 5_000_000,
    };
    let instants: Vec<u64> = [7, 7, 8].iter().map(|&seed| echoed(&bad, seed)).collect();
    assert_eq!(instants[0], instants[1]);
    assert_ne!(instants[0], instants[2]);
}

#[test]
fn the_board_is_met_by_its_frames_in_whatever_network() {
    let elsewhere = Ipv4Addr::new(192, 168, 7, 2);
    let mut peer = Peer::new(1);
    let mut board = Board::new(elsewhere);
    assert_eq!(peer.board(), None);
    assert!(peer.connect(7).is_none());
    // An ARP request of the board's.
    let mut arp = [&[0xFF; 6][..], ADDRESS.as_bytes(), &[8, 6, 0, 1, 8, 0, 6, 4, 0, 1], ADDRESS.as_bytes()].concat();
    arp.extend(elsewhere.octets());
    arp.extend([0; 6]);
    arp.extend(OWN.octets());
    arp.resize(60, 0);
    peer.turn(0, vec![Sent { at_ns: 0, bytes: arp }]);
    assert_eq!(peer.board(), Some(elsewhere));
    let connection = peer.connect(7).expect("a connection");
    (0..10).for_each(|_| board.step(&mut peer));
    assert!(peer.is_connected(connection));
    peer.close(connection);
    (0..10).for_each(|_| board.step(&mut peer));
    peer.abort(connection);
    assert!(peer.is_over(connection));
}

#[test]
fn a_program_here_reaches_a_port_of_the_board() {
    let mut peer = Peer::new(1);
    let mut board = Board::new(GIVEN);
    let mut forward = Forward::listen(0, 7).expect("a port");
    let mut program = TcpStream::connect(forward.address().expect("an address")).expect("a connection");
    program.write_all(b"M115\n").expect("room");
    program.set_nonblocking(true).expect("a socket");
    let mut steps = 0;
    let mut turn = |peer: &mut Peer, forward: &mut Forward| {
        forward.serve(peer);
        board.step(peer);
        steps += 1;
        assert!(steps < 1_000_000, "no end");
    };
    // The program waits until the board has an address.
    (0..10).for_each(|_| turn(&mut peer, &mut forward));
    peer.turn(0, vec![Sent { at_ns: 0, bytes: [&[0; 12][..], &[8, 0], &[0; 12], &GIVEN.octets(), &[0; 30]].concat() }]);
    let mut answer = [0; 5];
    let mut have = 0;
    while have < answer.len() {
        turn(&mut peer, &mut forward);
        match program.read(&mut answer[have..]) {
            Ok(count) => have += count,
            Err(error) => assert_eq!(error.kind(), ErrorKind::WouldBlock),
        }
    }
    assert_eq!(&answer, b"M115\n");
    assert_eq!(forward.links(), 1);
    drop(program);
    // A connection that is reset is given up at both ends.
    for connection in forward.connections() {
        peer.abort(connection);
    }
    while forward.links() > 0 {
        turn(&mut peer, &mut forward);
    }
}
