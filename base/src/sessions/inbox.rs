//! Queue between a session's receiver and the executor.
//!
//! There is a single writer (the receive task) and a single reader (the executor), and only atomics are used.
//! Bytes that act at once are taken out of the stream on the writing side, so a feed hold or an emergency
//! stop is seen even when the line queue is full.
//!
//! A transport that can hold its sender back (USB, TCP) asks for [`Inbox::room`] and never overfills it. A
//! UART without handshake cannot: bytes that do not fit are then lost by whole lines, never singly, for half
//! a line would be another command. Once a line is lost, so are all that follow until the reader has caught
//! up, so that lines stay in order; and each lost line is counted, so that each gets an answer.
//!
//! Depth: [`INBOX_BYTES`] hold a third of a second of a 115200 baud line, or some hundred lines that a person
//! pastes while the machine is busy. A quarter of that is enough where the sender can be held back.

use core::sync::atomic::{AtomicBool, AtomicU8, AtomicU32, Ordering};

use gcode::realtime::{Heard, Realtime, Receiver};

/// Bytes that the inbox of a serial line holds. A power of two.
pub const INBOX_BYTES: usize = 4_096;
/// Bytes that the inbox of a network console holds. TCP holds the sender back.
pub const NETWORK_INBOX_BYTES: usize = 1_024;
/// Greatest number of waiting `?`; more are dropped, as Smoothieware v2 does.
const MAX_QUERIES: u32 = 8;
/// Mark in the stream: forget the line so far, its rest is lost. Ctrl-X, which acts at once and is no part of
/// any line.
const FORGET_LINE: u8 = 0x18;
/// Mark in the stream: forget the line so far, and count it as lost. Ctrl-Y, which acts at once and is no
/// part of any line either.
const LOSE_LINE: u8 = 0x19;

/// Returns the bit of a request that is not counted.
const fn bit(request: Realtime) -> u32 {
    1 << request as u32
}

/// State of a receiver within its lines.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Place {
    #[default]
    LineStart,
    /// As `LineStart`; an LF still belongs to the line before.
    AfterReturn,
    InLine,
    /// Inside a line that is lost.
    Losing,
    /// Inside the rest of a line that has been counted as lost.
    Skipping,
}

/// State of the receive task of an inbox between two bytes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Intake {
    place: Place,
    receiver: Receiver,
}

impl Intake {
    /// Starts at the beginning of a line.
    #[must_use]
    pub const fn new() -> Self {
        Self { place: Place::LineStart, receiver: Receiver::new() }
    }
}

/// Next item of the stream.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Received {
    /// A byte of a line.
    Byte(u8),
    /// The line so far is to be forgotten: its rest did not fit.
    ForgetLine,
    /// The line so far is to be forgotten, and answered as lost.
    LoseLine,
}

/// Receive queue of a console. `&Inbox` is one of any size; [`InboxOf`] says how many bytes it holds.
#[derive(Debug)]
pub struct Inbox<B: ?Sized = [AtomicU8]> {
    /// Count of bytes ever received, wrapping. Written by the receive task only.
    received: AtomicU32,
    /// Count of bytes ever taken, wrapping. Written by the executor only.
    taken: AtomicU32,
    /// Pending realtime requests but `?`, one bit each.
    requests: AtomicU32,
    /// Number of pending `?` requests.
    queries: AtomicU32,
    /// Whether the session speaks GRBL's dialect, which has more bytes that act at once. Written by the
    /// executor.
    extended: AtomicBool,
    /// Whether every byte belongs to a file, and so none acts. Written by the executor.
    raw: AtomicBool,
    /// Whether lines are text, in which nothing acts but Ctrl-X and Ctrl-Y. Written by the executor.
    text: AtomicBool,
    /// Number of times that a peer came or went: even while a peer is there. Written by the transport.
    visits: AtomicU32,
    /// Count of bytes received before a peer came last. Written by the transport.
    opened_at: AtomicU32,
    /// Whether the peer that came last is the former one, and goes on with what it was sending. Written by
    /// the transport.
    is_back: AtomicBool,
    /// Value of `visits` while nothing is wanted of the sender, and one more; 0 before that. Written by the
    /// executor.
    forgotten: AtomicU32,
    /// Lost lines that the reader has not heard of. Raised by the receive task, cleared by the executor.
    lost: AtomicU32,
    /// Count of bytes received before the last Ctrl-X of GRBL's dialect. Written by the receive task only.
    reset_at: AtomicU32,
    /// Count of bytes received before the last byte that ends a jog: 0x85, Ctrl-Y, `!`.
    stopped_at: AtomicU32,
    /// Ring of bytes, whose length is a power of two.
    bytes: B,
}

/// Receive queue of so many bytes, a power of two.
pub type InboxOf<const N: usize> = Inbox<[AtomicU8; N]>;

impl<const N: usize> Default for InboxOf<N> {
    fn default() -> Self {
        Self::new()
    }
}

impl<const N: usize> InboxOf<N> {
    /// Makes an empty inbox, open: a transport whose peers come and go closes it before the first one. All
    /// zero, so that it lies in memory that start-up clears.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            received: AtomicU32::new(0),
            taken: AtomicU32::new(0),
            requests: AtomicU32::new(0),
            queries: AtomicU32::new(0),
            extended: AtomicBool::new(false),
            raw: AtomicBool::new(false),
            text: AtomicBool::new(false),
            visits: AtomicU32::new(0),
            opened_at: AtomicU32::new(0),
            is_back: AtomicBool::new(false),
            forgotten: AtomicU32::new(0),
            lost: AtomicU32::new(0),
            reset_at: AtomicU32::new(0),
            stopped_at: AtomicU32::new(0),
            bytes: {
                assert!(N.is_power_of_two());
                [const { AtomicU8::new(0) }; N]
            },
        }
    }
}

impl Inbox {
    /// Returns how many bytes the inbox can hold at once.
    #[must_use]
    pub const fn capacity(&self) -> usize {
        // A place is kept for FORGET_LINE or LOSE_LINE.
        self.bytes.len() - 1
    }

    /// Returns the place of a byte in the ring, by its count.
    const fn place(&self, count: u32) -> usize {
        count as usize & (self.bytes.len() - 1)
    }

    /// Whether a difference of two counts is one of bytes that wait, and not of bytes taken since then.
    const fn is_within(&self, difference: u32) -> bool {
        difference as usize <= self.bytes.len()
    }

    /// Returns how many more bytes surely fit. A transport that can hold its sender back asks before it
    /// receives.
    #[must_use]
    pub fn room(&self) -> usize {
        let used = self.received.load(Ordering::Relaxed).wrapping_sub(self.taken.load(Ordering::Acquire));
        self.capacity().saturating_sub(used as usize)
    }

    /// Receives bytes as [`Self::receive`] does one by one, and most of a line at once. False when any had to
    /// be dropped.
    pub fn receive_all(&self, intake: &mut Intake, bytes: &[u8]) -> bool {
        let (mut left, mut all) = (bytes, true);
        while let Some((first, behind)) = left.split_first() {
            let plain = self.receive_plain(intake, left);
            left = if plain > 0 {
                left.get(plain..).unwrap_or_default()
            } else {
                all &= self.receive(intake, *first);
                behind
            };
        }
        all
    }

    /// Queues as many bytes as merely continue a line that is kept.
    fn receive_plain(&self, intake: &mut Intake, bytes: &[u8]) -> usize {
        let is_file_or_text = self.raw.load(Ordering::Relaxed) || self.text.load(Ordering::Relaxed);
        if intake.place != Place::InLine || is_file_or_text || self.is_forgotten() {
            return 0;
        }
        let fit = bytes.get(..bytes.len().min(self.room())).unwrap_or_default();
        let plain = intake.receiver.hear_plain(fit);
        self.push_all(fit.get(..plain).unwrap_or_default());
        plain
    }

    /// Returns whether nothing is wanted of the present sender.
    fn is_forgotten(&self) -> bool {
        let forgotten = self.forgotten.load(Ordering::Acquire);
        forgotten != 0 && forgotten == self.visits.load(Ordering::Relaxed).wrapping_add(1)
    }

    /// Receives one byte: leaves the request that it makes, else queues it. False when it had to be dropped.
    /// For the one receive task, which keeps `intake`.
    pub fn receive(&self, intake: &mut Intake, byte: u8) -> bool {
        if self.is_forgotten() {
            *intake = Intake::new();
            return false;
        }
        if self.raw.load(Ordering::Relaxed) {
            return self.receive_raw(intake, byte);
        }
        if self.text.load(Ordering::Relaxed) && !matches!(byte, 0x18 | 0x19) {
            intake.receiver = Receiver::new();
            return self.keep(intake, byte);
        }
        let extended = self.extended.load(Ordering::Relaxed);
        match intake.receiver.hear(byte, extended) {
            Heard::Request(request) => {
                self.act(intake, request, extended);
                return true;
            }
            Heard::Nothing => return true,
            Heard::Line(request) => self.request(request),
            // The byte 0xC2 was waiting for the next one.
            Heard::Letter => {
                let _with_its_second_byte = self.keep(intake, 0xC2);
            }
            Heard::Byte => {}
        }
        self.keep(intake, byte)
    }

    /// Leaves a request, and notes which bytes it is about.
    fn act(&self, intake: &mut Intake, request: Realtime, extended: bool) {
        if extended && request == Realtime::Abort {
            // GRBL's reset drops the bytes sent before it.
            *intake = Intake::new();
            self.reset_at.store(self.received.load(Ordering::Relaxed), Ordering::Relaxed);
        }
        if matches!(request, Realtime::Stop | Realtime::JogCancel | Realtime::Hold) {
            self.note_stop();
        }
        self.request(request);
    }

    /// Queues a byte of a line.
    fn keep(&self, intake: &mut Intake, byte: u8) -> bool {
        let at = intake.place;
        let ended = match byte {
            // CR LF is a single line end.
            b'\n' if at == Place::AfterReturn => {
                intake.place = Place::LineStart;
                return true;
            }
            b'\n' => Some(Place::LineStart),
            b'\r' => Some(Place::AfterReturn),
            _ => None,
        };
        let kept = match at {
            Place::Losing | Place::Skipping => false,
            Place::InLine => self.room() > 0,
            // Whole lines wait until the reader has heard of those lost before them.
            Place::LineStart | Place::AfterReturn => self.room() > 0 && self.lost.load(Ordering::Acquire) == 0,
        };
        match (kept, at) {
            (true, _) => self.push(byte),
            (false, Place::InLine) => self.push(FORGET_LINE),
            _ => {}
        }
        if !kept && ended.is_some() && at != Place::Skipping {
            self.lost.fetch_add(1, Ordering::Release);
        }
        intake.place = ended.unwrap_or(match at {
            Place::Skipping => Place::Skipping,
            _ if kept => Place::InLine,
            _ => Place::Losing,
        });
        kept
    }

    /// Queues a byte of a file, without meaning. A byte that does not fit is counted.
    fn receive_raw(&self, intake: &mut Intake, byte: u8) -> bool {
        *intake = Intake::new();
        let fits = self.room() > 0;
        if fits {
            self.push(byte);
        } else {
            self.lost.fetch_add(1, Ordering::Release);
        }
        fits
    }

    /// Sets whether bytes belong to a file, and none acts.
    pub fn set_raw(&self, raw: bool) {
        self.raw.store(raw, Ordering::Relaxed);
    }

    /// Sets whether lines are text, in which nothing acts but Ctrl-X and Ctrl-Y.
    pub fn set_text(&self, text: bool) {
        self.text.store(text, Ordering::Relaxed);
    }

    /// Notes that a peer has come, or gone. For the transport.
    pub fn set_open(&self, open: bool) {
        let visits = self.visits.load(Ordering::Relaxed);
        if visits.is_multiple_of(2) != open {
            self.visits.store(visits.wrapping_add(1), Ordering::Release);
        }
    }

    /// Notes that a peer has come, perhaps in place of another: whole lines of the former peer are carried
    /// out first, half a line is forgotten. For the transport, whose `intake` it is.
    pub fn open(&self, intake: &mut Intake) {
        self.is_back.store(false, Ordering::Relaxed);
        if intake.place == Place::InLine {
            self.push(FORGET_LINE);
        }
        *intake = Intake::new();
        self.opened_at.store(self.received.load(Ordering::Relaxed), Ordering::Relaxed);
        self.set_open(true);
    }

    /// Notes that the former peer has come back, and goes on with what it was sending: the rest of a line
    /// whose beginning is forgotten is no line either, and the line is answered as lost.
    pub fn open_again(&self, intake: &mut Intake) {
        let place = intake.place;
        *intake = Intake::new();
        self.open(intake);
        self.is_back.store(true, Ordering::Relaxed);
        match place {
            Place::InLine => {
                self.push(LOSE_LINE);
                intake.place = Place::Skipping;
            }
            Place::Losing | Place::Skipping => intake.place = place,
            Place::LineStart | Place::AfterReturn => {}
        }
    }

    /// Returns whether bytes wait that came before the present peer.
    pub fn has_from_before(&self) -> bool {
        let before = self.opened_at.load(Ordering::Relaxed).wrapping_sub(self.taken.load(Ordering::Relaxed));
        before != 0 && self.is_within(before)
    }

    /// Returns whether the peer that came last is the former one.
    pub fn is_back(&self) -> bool {
        self.is_back.load(Ordering::Relaxed)
    }

    /// Drops what has come up to this value of `visits`, and what may still come during it; bytes of a peer
    /// that has come since then stay. For the reader.
    pub fn forget_visit(&self, visits: u32) {
        self.forgotten.store(visits.wrapping_add(1), Ordering::Release);
        // Read before `visits`, so that no byte of the next peer is among it.
        let received = self.received();
        let is_last = self.visits() == visits;
        let end = if is_last { received } else { self.opened_at.load(Ordering::Relaxed) };
        let taken = self.taken.load(Ordering::Relaxed);
        if self.is_within(end.wrapping_sub(taken)) {
            self.taken.store(end, Ordering::Release);
        }
        if is_last {
            self.lost.store(0, Ordering::Release);
        }
    }

    /// Returns whether a peer is at the other end.
    pub fn is_open(&self) -> bool {
        self.visits().is_multiple_of(2)
    }

    /// Returns how often a peer came or went: even while a peer is there.
    #[inline]
    pub fn visits(&self) -> u32 {
        self.visits.load(Ordering::Acquire)
    }

    /// Sets whether bytes of GRBL's dialect act at once.
    pub fn set_extended(&self, extended: bool) {
        self.extended.store(extended, Ordering::Relaxed);
    }

    fn push(&self, byte: u8) {
        self.push_all(&[byte]);
    }

    fn push_all(&self, bytes: &[u8]) {
        let mut received = self.received.load(Ordering::Relaxed);
        for byte in bytes {
            if let Some(slot) = self.bytes.get(self.place(received)) {
                slot.store(*byte, Ordering::Relaxed);
            }
            received = received.wrapping_add(1);
        }
        self.received.store(received, Ordering::Release);
    }

    /// Leaves a realtime request, as its character would.
    pub fn request(&self, request: Realtime) {
        if request == Realtime::Status {
            if self.queries.load(Ordering::Relaxed) < MAX_QUERIES {
                self.queries.fetch_add(1, Ordering::Relaxed);
            }
        } else {
            self.requests.fetch_or(bit(request), Ordering::AcqRel);
        }
    }

    /// Returns the count of bytes ever received, wrapping.
    #[must_use]
    pub fn received(&self) -> u32 {
        self.received.load(Ordering::Acquire)
    }

    /// Takes the next item of the stream, of the bytes received when [`Self::received`] was `end`.
    pub fn take(&self, end: u32) -> Option<Received> {
        let taken = self.taken.load(Ordering::Relaxed);
        if taken == end {
            return None;
        }
        let byte = self.bytes.get(self.place(taken))?.load(Ordering::Relaxed);
        self.taken.store(taken.wrapping_add(1), Ordering::Release);
        Some(match byte {
            FORGET_LINE => Received::ForgetLine,
            LOSE_LINE => Received::LoseLine,
            _ => Received::Byte(byte),
        })
    }

    /// Returns the count of bytes ever taken, wrapping.
    pub(super) fn taken(&self) -> u32 {
        self.taken.load(Ordering::Relaxed)
    }

    /// Returns the count of bytes received before the last byte that ends a jog. For the one who takes its
    /// request.
    pub(super) fn stopped_at(&self) -> u32 {
        self.stopped_at.load(Ordering::Relaxed)
    }

    /// Drops the bytes received before the last Ctrl-X of GRBL's dialect. For the one who takes its request.
    pub fn drop_before_reset(&self) {
        let (reset_at, taken) = (self.reset_at.load(Ordering::Relaxed), self.taken.load(Ordering::Relaxed));
        // Bytes received since then may have been taken already.
        if self.is_within(reset_at.wrapping_sub(taken)) {
            self.taken.store(reset_at, Ordering::Release);
        }
        self.lost.store(0, Ordering::Release);
    }

    /// Takes the most urgent pending request.
    pub fn take_request(&self) -> Option<Realtime> {
        if self.requests.load(Ordering::Relaxed) != 0 {
            for request in Realtime::ALL {
                if self.requests.load(Ordering::Relaxed) & bit(request) != 0 {
                    self.requests.fetch_and(!bit(request), Ordering::AcqRel);
                    return Some(request);
                }
            }
        }
        if self.queries.load(Ordering::Relaxed) > 0 {
            self.queries.fetch_sub(1, Ordering::Relaxed);
            return Some(Realtime::Status);
        }
        None
    }

    /// Returns whether anything waits to be taken: bytes, requests or the news of lost lines.
    #[must_use]
    #[inline(always)]
    pub fn has_news(&self) -> bool {
        self.taken.load(Ordering::Relaxed) != self.received.load(Ordering::Acquire)
            || self.requests.load(Ordering::Relaxed) != 0
            || self.queries.load(Ordering::Relaxed) != 0
            || self.lost.load(Ordering::Relaxed) != 0
    }

    /// Takes the number of lines lost since the last call, once everything that came before them has been
    /// taken.
    pub fn take_lost(&self) -> u32 {
        let caught_up = self.taken.load(Ordering::Relaxed) == self.received.load(Ordering::Acquire);
        if caught_up { self.lost.swap(0, Ordering::AcqRel) } else { 0 }
    }
}

mod held_back;
mod jogs;
#[cfg(test)]
mod tests;
