//! Wrapper around the device: what comes in is looked at before the stack sees it, and what goes out is
//! counted.

use core::cell::Cell;
use core::net::Ipv4Addr;

use heapless::Deque;
use smoltcp::phy::{Device, DeviceCapabilities, PacketMeta, RxToken, TxToken};
use smoltcp::time::Instant;
use smoltcp::wire::{EthernetFrame, EthernetProtocol, IpProtocol, Ipv4Packet, TcpPacket};

use super::arp::Arp;
use super::watch::{Peer, Watch};
use crate::settings::LINES;

/// ARP frames that wait for the owner of the address.
const ARPS: usize = 4;
/// Ports whose connections may have to wait.
pub const PORTS: usize = 3;

/// Frames since the start.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Frames that came in.
    pub received: u32,
    /// Frames that were sent.
    pub sent: u32,
    /// Requests for a connection that were dropped, as nobody listened at that moment.
    pub held_off: u32,
}

/// State of the wrapper between two polls.
#[derive(Debug)]
pub struct Filter {
    incoming: Incoming,
    sent: Cell<u32>,
}

/// State of the way in.
#[derive(Debug)]
struct Incoming {
    received: u32,
    held_off: u32,
    /// ARP frames that the owner of the address has not seen.
    heard: Deque<Arp, ARPS>,
    /// Ports at which nobody listens at this moment, and somebody will.
    waiting: [Option<u16>; PORTS],
    /// Visitor of each line.
    watches: [Watch; LINES],
}

impl Filter {
    /// Makes a filter that has counted nothing.
    pub const fn new() -> Self {
        let incoming = Incoming {
            received: 0,
            held_off: 0,
            heard: Deque::new(),
            waiting: [None; PORTS],
            watches: [Watch::NONE; LINES],
        };
        Self { incoming, sent: Cell::new(0) }
    }

    /// Returns the counts since the start.
    pub const fn counts(&self) -> Counts {
        let Incoming { received, held_off, .. } = self.incoming;
        Counts { received, sent: self.sent.get(), held_off }
    }

    /// Takes the next ARP frame that was heard.
    pub fn take_arp(&mut self) -> Option<Arp> {
        self.incoming.heard.pop_front()
    }

    /// Forgets what was heard on a wire that is not there any more.
    pub fn forget(&mut self) {
        self.incoming.heard.clear();
    }

    /// Sets who the visitor of each line is.
    pub fn watch(&mut self, peers: [Option<Peer>; LINES], now: Instant) {
        for (watch, peer) in self.incoming.watches.iter_mut().zip(peers) {
            watch.set(peer, now);
        }
    }

    /// Sets the ports at which nobody listens at this moment.
    pub const fn hold_off(&mut self, ports: [Option<u16>; PORTS]) {
        self.incoming.waiting = ports;
    }
}

impl Incoming {
    /// Returns whether the stack may see a frame.
    fn lets(&mut self, frame: &[u8], now: Instant) -> bool {
        self.received = self.received.wrapping_add(1);
        let Ok(ethernet) = EthernetFrame::new_checked(frame) else { return false };
        if ethernet.ethertype() == EthernetProtocol::Arp {
            if let Some(arp) = Arp::read(frame) {
                let _has_room = self.heard.push_back(arp);
            }
            return true;
        }
        if ethernet.ethertype() != EthernetProtocol::Ipv4 {
            return true;
        }
        self.lets_segment(&ethernet, now).unwrap_or(true)
    }

    /// Returns whether the stack may see a TCP segment; `None` if the frame is none.
    fn lets_segment(&mut self, frame: &EthernetFrame<&[u8]>, now: Instant) -> Option<bool> {
        let ip = Ipv4Packet::new_checked(frame.payload()).ok()?;
        if ip.next_header() != IpProtocol::Tcp || ip.frag_offset() != 0 {
            return None;
        }
        let tcp = TcpPacket::new_checked(ip.payload()).ok()?;
        if tcp.syn() && !tcp.ack() && self.waiting.contains(&Some(tcp.dst_port())) {
            self.held_off = self.held_off.wrapping_add(1);
            return Some(false);
        }
        let _his = self.watches.iter_mut().any(|watch| watch.hear(frame, &ip, &tcp, now));
        Some(true)
    }
}

/// The device as the stack sees it, for one poll.
pub struct Tap<'d, D: Device> {
    device: &'d mut D,
    filter: &'d mut Filter,
    /// Frames that may still be sent.
    may_send: Cell<u32>,
}

impl<'d, D: Device> Tap<'d, D> {
    /// Wraps a device, for as many frames out as `may_send` says.
    pub const fn new(device: &'d mut D, filter: &'d mut Filter, may_send: u32) -> Self {
        Self { device, filter, may_send: Cell::new(may_send) }
    }

    /// Returns the state that lasts.
    pub const fn filter(&mut self) -> &mut Filter {
        self.filter
    }

    /// Asks visitors for a sign of life who have been silent for long.
    pub fn probe(&mut self, mac: [u8; 6], address: Ipv4Addr, now: Instant) {
        let mut watches = self.filter.incoming.watches;
        for watch in &mut watches {
            watch.ask(self, mac, address, now);
        }
        self.filter.incoming.watches = watches;
    }

    /// Returns how many frames may still be sent.
    pub const fn may_send(&self) -> u32 {
        self.may_send.get()
    }

    /// Sets how many frames may be sent from now on.
    pub fn allow(&self, may_send: u32) {
        self.may_send.set(may_send);
    }
}

impl<D: Device> Device for Tap<'_, D> {
    type RxToken<'a>
        = Heard<'a, D::RxToken<'a>>
    where
        Self: 'a;
    type TxToken<'a>
        = Sent<'a, D::TxToken<'a>>
    where
        Self: 'a;

    fn receive(&mut self, now: Instant) -> Option<(Self::RxToken<'_>, Self::TxToken<'_>)> {
        if self.may_send.get() == 0 {
            return None;
        }
        let (heard, answer) = self.device.receive(now)?;
        let Filter { incoming, sent } = &mut *self.filter;
        let heard = Heard { token: heard, incoming, now };
        Some((heard, Sent { token: answer, may_send: &self.may_send, sent }))
    }

    fn transmit(&mut self, now: Instant) -> Option<Self::TxToken<'_>> {
        if self.may_send.get() == 0 {
            return None;
        }
        let token = self.device.transmit(now)?;
        Some(Sent { token, may_send: &self.may_send, sent: &self.filter.sent })
    }

    fn capabilities(&self) -> DeviceCapabilities {
        self.device.capabilities()
    }
}

/// Frame that came in, before the stack sees it.
pub struct Heard<'a, T> {
    token: T,
    incoming: &'a mut Incoming,
    now: Instant,
}

impl<T: RxToken> RxToken for Heard<'_, T> {
    fn consume<R, F: FnOnce(&[u8]) -> R>(self, read: F) -> R {
        let Self { token, incoming, now } = self;
        // The stack makes nothing of an empty frame.
        token.consume(|frame| if incoming.lets(frame, now) { read(frame) } else { read(&[]) })
    }

    fn meta(&self) -> PacketMeta {
        self.token.meta()
    }
}

/// Frame that may go out.
pub struct Sent<'a, T> {
    token: T,
    may_send: &'a Cell<u32>,
    sent: &'a Cell<u32>,
}

impl<T: TxToken> TxToken for Sent<'_, T> {
    fn consume<R, F: FnOnce(&mut [u8]) -> R>(self, length: usize, write: F) -> R {
        self.may_send.set(self.may_send.get().saturating_sub(1));
        self.sent.set(self.sent.get().wrapping_add(1));
        self.token.consume(length, write)
    }

    fn set_meta(&mut self, meta: PacketMeta) {
        self.token.set_meta(meta);
    }
}
