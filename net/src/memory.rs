//! Memory of all sockets.

use heapless::Vec;
use smoltcp::iface::SocketStorage;
use smoltcp::socket::{tcp, udp};
use smoltcp::wire::DhcpOption;

use crate::settings::{HOST_BYTES, HostName, LINES, Service};
use crate::streams::STREAMS;

/// Bytes that a console's connection holds of what came in.
pub const LINE_BYTES: usize = 1_024;
/// Bytes that a console's connection holds of what goes out.
const LINE_BYTES_OUT: usize = 768;
/// Bytes that the connection of a visitor holds who is turned away, each way.
const DOOR_BYTES: usize = 128;
/// Sockets: consoles, doors, web connections, DHCP, mDNS, and the one that asks for names and time.
const SOCKETS: usize = LINES + Service::ALL.len() + STREAMS + 3;
/// Bytes that a web connection holds each way: what comes in holds the head of a request.
pub const STREAM_BYTES: usize = 2_048;
/// Bytes that are looked at in one piece.
pub const SCRATCH_BYTES: usize = if LINE_BYTES > STREAM_BYTES { LINE_BYTES } else { STREAM_BYTES };
/// Option of DHCP that tells the board's name (RFC 2132 section 3.14).
const HOST_NAME: u8 = 12;

/// Buffers of a TCP socket.
#[derive(Debug)]
pub struct Buffers<const IN: usize, const OUT: usize> {
    incoming: [u8; IN],
    outgoing: [u8; OUT],
}

impl<const IN: usize, const OUT: usize> Buffers<IN, OUT> {
    const fn new() -> Self {
        Self { incoming: [0; IN], outgoing: [0; OUT] }
    }

    /// Makes a socket of the buffers.
    pub fn socket(&'static mut self) -> tcp::Socket<'static> {
        let Self { incoming, outgoing } = self;
        tcp::Socket::new(tcp::SocketBuffer::new(&mut incoming[..]), tcp::SocketBuffer::new(&mut outgoing[..]))
    }
}

/// Buffers of a UDP socket: for `M` datagrams each way, `N` bytes together that come in and `S` that go out.
#[derive(Debug)]
pub struct Datagrams<const M: usize, const N: usize, const S: usize> {
    incoming: [u8; N],
    outgoing: [u8; S],
    of_incoming: Vec<udp::PacketMetadata, M>,
    of_outgoing: Vec<udp::PacketMetadata, M>,
}

impl<const M: usize, const N: usize, const S: usize> Datagrams<M, N, S> {
    const fn new() -> Self {
        Self { incoming: [0; N], outgoing: [0; S], of_incoming: Vec::new(), of_outgoing: Vec::new() }
    }

    /// Makes a socket of the buffers.
    pub fn socket(&'static mut self) -> udp::Socket<'static> {
        let Self { incoming, outgoing, of_incoming, of_outgoing } = self;
        for metadata in [&mut *of_incoming, &mut *of_outgoing] {
            while metadata.push(udp::PacketMetadata::EMPTY).is_ok() {}
        }
        udp::Socket::new(
            udp::PacketBuffer::new(&mut of_incoming[..], &mut incoming[..]),
            udp::PacketBuffer::new(&mut of_outgoing[..], &mut outgoing[..]),
        )
    }
}

/// Memory of all sockets, for the one network.
///
/// A new one is all zero, so that it may lie in memory that is not loaded but cleared at the start.
#[derive(Debug)]
pub struct Memory {
    lines: [Buffers<LINE_BYTES, LINE_BYTES_OUT>; LINES],
    doors: [Buffers<DOOR_BYTES, DOOR_BYTES>; Service::ALL.len()],
    streams: [Buffers<STREAM_BYTES, STREAM_BYTES>; STREAMS],
    mdns: Datagrams<4, 1_536, 1_024>,
    asker: Datagrams<2, 640, 256>,
    sockets: Vec<SocketStorage<'static>, SOCKETS>,
    scratch: [u8; SCRATCH_BYTES],
    host: Vec<u8, HOST_BYTES>,
    options: Vec<DhcpOption<'static>, 1>,
}

impl Default for Memory {
    fn default() -> Self {
        Self::new()
    }
}

impl Memory {
    /// Makes the memory, all zero.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            lines: [const { Buffers::new() }; LINES],
            doors: [const { Buffers::new() }; Service::ALL.len()],
            streams: [const { Buffers::new() }; STREAMS],
            mdns: Datagrams::new(),
            asker: Datagrams::new(),
            sockets: Vec::new(),
            scratch: [0; SCRATCH_BYTES],
            host: Vec::new(),
            options: Vec::new(),
        }
    }

    /// Splits the memory into its parts.
    pub(crate) fn parts(&'static mut self, name: &HostName) -> Parts {
        let Self { lines, doors, streams, mdns, asker, sockets, scratch, host, options } = self;
        while sockets.push(SocketStorage::EMPTY).is_ok() {}
        host.clear();
        let _fits = host.extend_from_slice(name.as_str().as_bytes());
        options.clear();
        let _fits = options.push(DhcpOption { kind: HOST_NAME, data: host });
        let (mdns, asker) = (mdns.socket(), asker.socket());
        Parts { lines, doors, streams, mdns, asker, sockets: &mut sockets[..], scratch, options }
    }
}

/// Parts of the memory.
pub struct Parts {
    pub lines: &'static mut [Buffers<LINE_BYTES, LINE_BYTES_OUT>; LINES],
    pub doors: &'static mut [Buffers<DOOR_BYTES, DOOR_BYTES>; Service::ALL.len()],
    pub streams: &'static mut [Buffers<STREAM_BYTES, STREAM_BYTES>; STREAMS],
    pub mdns: udp::Socket<'static>,
    pub asker: udp::Socket<'static>,
    pub sockets: &'static mut [SocketStorage<'static>],
    pub scratch: &'static mut [u8; SCRATCH_BYTES],
    pub options: &'static [DhcpOption<'static>],
}
