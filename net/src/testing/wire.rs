//! Wire between two ports, with seeded faults.

use std::collections::VecDeque;

use smoltcp::phy::{Checksum, ChecksumCapabilities, Device, DeviceCapabilities, Medium, RxToken, TxToken};
use smoltcp::time::Instant;

use crate::random::Random;

/// Longest frame without its check sequence.
const MTU: usize = 1_514;

/// Faults of a wire, each in percent of the frames.
#[derive(Clone, Copy, Debug, Default)]
pub struct Faults {
    pub loss: u32,
    pub doubling: u32,
    /// Frames that are overtaken by later ones.
    pub reordering: u32,
    pub corruption: u32,
    /// Delay of every frame, and of some up to that much more, in microseconds.
    pub delay: u64,
    pub jitter: u64,
}

/// Port of a station.
pub struct Port {
    incoming: VecDeque<Vec<u8>>,
    outgoing: Vec<Vec<u8>>,
    /// Frames that may be sent before the wire takes them.
    pub depth: usize,
    /// Whether checksums of what comes are left unchecked, as if the hardware did that.
    pub is_trusting: bool,
}

impl Port {
    pub fn new(depth: usize) -> Self {
        Self { incoming: VecDeque::new(), outgoing: Vec::new(), depth, is_trusting: false }
    }

    /// Puts a frame into the port, as if it came by the wire.
    pub fn inject(&mut self, frame: &[u8]) {
        self.incoming.push_back(frame.to_vec());
    }

    pub fn waits(&self) -> bool {
        !self.incoming.is_empty()
    }

    pub fn clear(&mut self) {
        self.incoming.clear();
        self.outgoing.clear();
    }
}

pub struct Received(Vec<u8>);
pub struct ToSend<'a>(&'a mut Vec<Vec<u8>>);

impl RxToken for Received {
    fn consume<R, F: FnOnce(&[u8]) -> R>(self, read: F) -> R {
        read(&self.0)
    }
}

impl TxToken for ToSend<'_> {
    fn consume<R, F: FnOnce(&mut [u8]) -> R>(self, length: usize, write: F) -> R {
        assert!(length <= MTU);
        let mut frame = vec![0xEE; length];
        let result = write(&mut frame);
        self.0.push(frame);
        result
    }
}

impl Device for Port {
    type RxToken<'a> = Received;
    type TxToken<'a> = ToSend<'a>;

    fn receive(&mut self, _: Instant) -> Option<(Received, ToSend<'_>)> {
        if self.outgoing.len() >= self.depth {
            return None;
        }
        let frame = self.incoming.pop_front()?;
        Some((Received(frame), ToSend(&mut self.outgoing)))
    }

    fn transmit(&mut self, _: Instant) -> Option<ToSend<'_>> {
        (self.outgoing.len() < self.depth).then_some(ToSend(&mut self.outgoing))
    }

    fn capabilities(&self) -> DeviceCapabilities {
        let mut capabilities = DeviceCapabilities::default();
        capabilities.medium = Medium::Ethernet;
        capabilities.max_transmission_unit = MTU;
        if self.is_trusting {
            let mut sums = ChecksumCapabilities::default();
            (sums.ipv4, sums.tcp, sums.udp, sums.icmpv4) = (Checksum::Tx, Checksum::Tx, Checksum::Tx, Checksum::Tx);
            capabilities.checksum = sums;
        }
        capabilities
    }
}

/// A frame on its way.
struct Flight {
    lands: u64,
    to_board: bool,
    frame: Vec<u8>,
}

/// The wire.
pub struct Wire {
    pub faults: Faults,
    random: Random,
    flights: Vec<Flight>,
    /// Frames that the board sent, and those that the desk did, as long as nobody takes them.
    pub heard: Vec<Vec<u8>>,
    pub told: Vec<Vec<u8>>,
    /// Whether frames are kept.
    pub listens: bool,
}

impl Wire {
    pub fn new(seed: u64) -> Self {
        Self {
            faults: Faults::default(),
            random: Random::new(seed),
            flights: Vec::new(),
            heard: Vec::new(),
            told: Vec::new(),
            listens: false,
        }
    }

    /// Takes what both ports send.
    pub fn take(&mut self, now: u64, board: &mut Port, desk: &mut Port) {
        for frame in board.outgoing.drain(..) {
            if self.listens {
                self.heard.push(frame.clone());
            }
            self.send(now, frame, false);
        }
        for frame in desk.outgoing.drain(..) {
            if self.listens {
                self.told.push(frame.clone());
            }
            self.send(now, frame, true);
        }
    }

    fn send(&mut self, now: u64, mut frame: Vec<u8>, to_board: bool) {
        let chance = |random: &mut Random, percent: u32| percent > 0 && random.below(100) < percent;
        let Faults { loss, doubling, reordering, corruption, delay, jitter } = self.faults;
        if chance(&mut self.random, loss) {
            return;
        }
        let copies = 1 + usize::from(chance(&mut self.random, doubling));
        if chance(&mut self.random, corruption) {
            let bit = self.random.below(8 * frame.len() as u32) as usize;
            frame[bit / 8] ^= 1 << (bit % 8);
        }
        for _ in 0..copies {
            let mut lands = now + delay + if jitter > 0 { u64::from(self.random.below(jitter as u32)) } else { 0 };
            if chance(&mut self.random, reordering) {
                lands += 3_000;
            }
            self.flights.push(Flight { lands, to_board, frame: frame.clone() });
        }
    }

    /// Lets frames land.
    pub fn land(&mut self, now: u64, board: &mut Port, desk: &mut Port) {
        let mut landing: Vec<Flight> = self.flights.extract_if(.., |flight| flight.lands <= now).collect();
        landing.sort_by_key(|flight| flight.lands);
        for flight in landing {
            let port = if flight.to_board { &mut *board } else { &mut *desk };
            port.incoming.push_back(flight.frame);
        }
    }

    /// Time at which the next frame lands.
    pub fn next(&self) -> Option<u64> {
        self.flights.iter().map(|flight| flight.lands).min()
    }

    pub fn reseed(&mut self, seed: u64) {
        self.random = Random::new(seed);
    }

    pub fn cut(&mut self) {
        self.flights.clear();
    }
}
