//! Signs of life of visitors, read off the wire and asked for past the stack.
//!
//! The stack asks a peer for a sign of life only while nothing else is under way: not while it waits for an
//! acknowledgement, whose repetitions come up to a minute apart after some losses, nor while the peer takes
//! nothing. A visitor would be given up who is well, or be kept who is dead. So the question is asked here: a
//! segment without data, one byte before those acknowledged, which any peer answers (RFC 9293 section 3.8.4).
//! Three such answers to what was lost have the stack repeat it at once, too.

use core::net::Ipv4Addr;

use smoltcp::phy::{ChecksumCapabilities, Device, TxToken};
use smoltcp::socket::tcp::Socket;
use smoltcp::time::{Duration, Instant};
use smoltcp::wire::{
    EthernetAddress, EthernetFrame, EthernetProtocol, EthernetRepr, IpAddress, IpProtocol, Ipv4Packet, Ipv4Repr,
    TcpControl, TcpPacket, TcpRepr, TcpSeqNumber,
};

/// Silence after which a peer is asked: one that owes an acknowledgement, and any other.
const OWING: Duration = Duration::from_secs(1);
const IDLE: Duration = Duration::from_secs(3);
/// Window that the question tells, to which nobody listens.
const WINDOW: u16 = 512;

/// Connection of a visitor, as seen from the wire.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Peer {
    /// Address of the visitor.
    pub address: Ipv4Addr,
    /// Port of the visitor.
    pub port: u16,
    /// Port of the board.
    pub own: u16,
    /// Whether the visitor owes an acknowledgement.
    pub owes: bool,
}

/// What the wire told of a peer last.
#[derive(Clone, Copy, Debug)]
struct Heard {
    mac: EthernetAddress,
    /// First byte that the peer has not acknowledged.
    acknowledged: TcpSeqNumber,
    /// Byte behind the last that the peer has sent.
    next: TcpSeqNumber,
}

/// Returns the address of a connection's peer.
pub fn remote(socket: &Socket<'static>) -> Ipv4Addr {
    match socket.remote_endpoint().map(|endpoint| endpoint.addr) {
        Some(IpAddress::Ipv4(address)) => address,
        None => Ipv4Addr::UNSPECIFIED,
    }
}

/// Watch over a peer.
#[derive(Clone, Copy, Debug)]
pub struct Watch {
    peer: Option<Peer>,
    heard: Option<Heard>,
    /// Time of the last segment of the peer, or question to him.
    at: Instant,
}

impl Watch {
    /// Watches nobody.
    pub const NONE: Self = Self { peer: None, heard: None, at: Instant::ZERO };

    /// Sets who is watched.
    pub fn set(&mut self, peer: Option<Peer>, now: Instant) {
        let identity = |peer: Peer| (peer.address, peer.port, peer.own);
        if self.peer.map(identity) != peer.map(identity) {
            *self = Self { peer, heard: None, at: now };
        }
        self.peer = peer;
    }

    /// Hears a segment. False if it is somebody else's.
    pub fn hear(
        &mut self,
        frame: &EthernetFrame<&[u8]>,
        ip: &Ipv4Packet<&[u8]>,
        tcp: &TcpPacket<&[u8]>,
        now: Instant,
    ) -> bool {
        let is_his = self
            .peer
            .is_some_and(|peer| (peer.address, peer.port, peer.own) == (ip.src_addr(), tcp.src_port(), tcp.dst_port()));
        if is_his && tcp.ack() && !tcp.rst() {
            let next = tcp.seq_number() + tcp.segment_len();
            self.heard = Some(Heard { mac: frame.src_addr(), acknowledged: tcp.ack_number(), next });
            self.at = now;
        }
        is_his
    }

    /// Asks the peer for a sign of life if he has been silent for long.
    pub fn ask(&mut self, device: &mut impl Device, mac: [u8; 6], address: Ipv4Addr, now: Instant) {
        let (Some(peer), Some(heard)) = (self.peer, self.heard) else { return };
        if now < self.at + if peer.owes { OWING } else { IDLE } {
            return;
        }
        if let Some(token) = device.transmit(now) {
            write(token, peer, heard, EthernetAddress(mac), address);
            self.at = now;
        }
    }
}

fn write(token: impl TxToken, peer: Peer, heard: Heard, mac: EthernetAddress, address: Ipv4Addr) {
    let ethernet = EthernetRepr { src_addr: mac, dst_addr: heard.mac, ethertype: EthernetProtocol::Ipv4 };
    let tcp = TcpRepr {
        src_port: peer.own,
        dst_port: peer.port,
        control: TcpControl::None,
        seq_number: heard.acknowledged - 1,
        ack_number: Some(heard.next),
        window_len: WINDOW,
        window_scale: None,
        max_seg_size: None,
        sack_permitted: false,
        sack_ranges: [None; 3],
        timestamp: None,
        payload: &[],
    };
    let ip = Ipv4Repr {
        src_addr: address,
        dst_addr: peer.address,
        next_header: IpProtocol::Tcp,
        payload_len: tcp.buffer_len(),
        hop_limit: 64,
    };
    let sums = ChecksumCapabilities::default();
    token.consume(ethernet.buffer_len() + ip.buffer_len() + ip.payload_len, |bytes| {
        let mut frame = EthernetFrame::new_unchecked(bytes);
        ethernet.emit(&mut frame);
        let mut packet = Ipv4Packet::new_unchecked(frame.payload_mut());
        ip.emit(&mut packet, &sums);
        let (from, to) = (IpAddress::Ipv4(address), IpAddress::Ipv4(peer.address));
        tcp.emit(&mut TcpPacket::new_unchecked(packet.payload_mut()), &from, &to, &sums);
    });
}
