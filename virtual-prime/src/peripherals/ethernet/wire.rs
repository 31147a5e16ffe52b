//! The cable and what hangs at its other end, for tests and for people: frames both ways.
//!
//! Frames are given and taken without preamble and frame check sequence. Those for the board queue up and
//! arrive one after another at the speed of the link; without a link they are lost, as on any cable.

use std::collections::VecDeque;

use super::link::{Cable, Link, Partner};

/// Octets before a frame, its check sequence, and the gap after it: IEEE 802.3 sections 3.1 and 4.4.2.
pub(super) const PREAMBLE: u64 = 8;
pub(super) const CHECK: u64 = 4;
pub(super) const GAP: u64 = 12;
/// Shortest frame without its check sequence; a sender fills up to it.
pub(super) const SHORTEST: usize = 60;

/// A frame that the board has sent.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Sent {
    /// Instant of its last bit.
    pub at_ns: u64,
    /// Its bytes, filled up to 60.
    pub bytes: Vec<u8>,
}

/// A frame on its way to the board.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Coming {
    pub(super) bytes: Vec<u8>,
    /// Whether its check sequence is right.
    pub(super) is_intact: bool,
}

/// Number of frames that went each way, and what became of the others.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counters {
    /// Frames that the board has sent and the partner heard.
    pub sent: u64,
    /// Frames that the receive queue took.
    pub received: u64,
    /// Frames that the address filter kept out.
    pub filtered: u64,
    /// Frames that the MAC dropped for errors: check sequence, length, checksums.
    pub damaged: u64,
    /// Frames that found the receive queue full.
    pub overflowed: u64,
    /// Frames that arrived while the receiver was off.
    pub unheard: u64,
    /// Frames lost for lack of a link, either way.
    pub without_link: u64,
    /// Frames lost because MAC and PHY are set to different speeds, either way.
    pub at_wrong_speed: u64,
    /// Frames of the board that no partner takes: too short, or with a wrong check sequence.
    pub malformed: u64,
}

/// The cable with its far end.
#[derive(Debug)]
pub struct Wire {
    cable: Cable,
    has_phy: bool,
    has_clock: bool,
    coming: VecDeque<Coming>,
    /// Frame on the line to the board, and the instant of its last bit.
    arriving: Option<(Coming, u64)>,
    /// Instant from which the line to the board is free.
    free_ns: u64,
    sent: VecDeque<Sent>,
    pub(super) counters: Counters,
}

impl Default for Wire {
    fn default() -> Self {
        Self {
            cable: Cable::default(),
            has_phy: true,
            has_clock: true,
            coming: VecDeque::new(),
            arriving: None,
            free_ns: 0,
            sent: VecDeque::new(),
            counters: Counters::default(),
        }
    }
}

impl Wire {
    /// Plugs the cable in, with this partner at its other end; or replaces the partner.
    pub fn plug(&mut self, partner: Partner) {
        self.cable = Cable { is_plugged: true, partner };
    }

    /// Pulls the cable out. A frame on the line is lost.
    pub fn unplug(&mut self) {
        self.cable.is_plugged = false;
    }

    /// Whether a cable is plugged in.
    #[must_use]
    pub const fn is_plugged(&self) -> bool {
        self.cable.is_plugged
    }

    /// Breaks the PHY, or repairs it: nobody answers on the management lines.
    pub const fn set_phy(&mut self, there: bool) {
        self.has_phy = there;
    }

    /// Stops the PHY's 50 MHz, or starts them.
    pub const fn set_clock(&mut self, runs: bool) {
        self.has_clock = runs;
    }

    /// Puts a frame on the line to the board, filled up to the shortest length.
    pub fn put(&mut self, frame: &[u8]) {
        let mut bytes = frame.to_vec();
        bytes.resize(bytes.len().max(SHORTEST), 0);
        self.put_as_it_is(bytes, true);
    }

    /// Puts any bytes on the line as a frame: too short, too long, or damaged on the way, when `is_intact` is
    /// false.
    pub fn put_as_it_is(&mut self, bytes: Vec<u8>, is_intact: bool) {
        self.coming.push_back(Coming { bytes, is_intact });
    }

    /// Returns the number of frames that wait for the line to the board.
    #[must_use]
    pub fn waiting(&self) -> usize {
        self.coming.len() + usize::from(self.arriving.is_some())
    }

    /// Takes the next frame that the board has sent.
    pub fn take(&mut self) -> Option<Sent> {
        self.sent.pop_front()
    }

    /// Takes all frames that the board has sent.
    pub fn take_all(&mut self) -> Vec<Sent> {
        self.sent.drain(..).collect()
    }

    /// Returns the counters since power-on.
    #[must_use]
    pub const fn counters(&self) -> Counters {
        self.counters
    }

    pub(super) const fn cable(&self) -> Cable {
        self.cable
    }

    pub(super) const fn has_phy(&self) -> bool {
        self.has_phy
    }

    pub(super) const fn has_clock(&self) -> bool {
        self.has_clock
    }

    /// Puts a frame of the board's on the line, or back to the board in loopback.
    pub(super) fn hear(&mut self, at_ns: u64, bytes: Vec<u8>) {
        self.counters.sent += 1;
        self.sent.push_back(Sent { at_ns, bytes });
    }

    /// Returns the instant of the last bit of the frame that is arriving.
    pub(super) fn due(&self) -> Option<u64> {
        self.arriving.as_ref().map(|&(_, ends_ns)| ends_ns)
    }

    /// Begins the next frame. Without a link all frames are lost, the one under way as well.
    pub(super) fn begin(&mut self, now_ns: u64, link: Option<Link>) {
        let Some(link) = link else {
            self.counters.without_link += self.waiting() as u64;
            self.coming.clear();
            self.arriving = None;
            return;
        };
        if self.arriving.is_none()
            && let Some(frame) = self.coming.pop_front()
        {
            let bits = |octets: u64| Link::bits_ns(link.is_fast, octets * 8);
            let ends_ns = now_ns.max(self.free_ns) + bits(PREAMBLE + frame.bytes.len() as u64 + CHECK);
            self.free_ns = ends_ns + bits(GAP);
            self.arriving = Some((frame, ends_ns));
        }
    }

    /// Takes the frame whose last bit has arrived.
    pub(super) fn arrive(&mut self, now_ns: u64) -> Option<Coming> {
        let (frame, _) = self.arriving.take_if(|&mut (_, ends_ns)| ends_ns <= now_ns)?;
        Some(frame)
    }
}
