//! Transfers: requests of drivers on the host, made of as many transactions as it takes (USB 2.0 sections 5.5
//! to 5.8 and 8.5).

use super::wire::Toggle;

/// Name of a transfer for the driver that submitted it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct TransferId(pub u64);

/// Direction of data on the bus.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Direction {
    /// From device to host.
    In,
    /// From host to device.
    Out,
}

/// Properties of an endpoint for the host's schedule.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Endpoint {
    /// Address of the device.
    pub device: u8,
    /// Number of the endpoint, without direction.
    pub number: u8,
    /// Direction of the data; without meaning for a control endpoint.
    pub direction: Direction,
    /// Transfer type, which decides the schedule.
    pub kind: Kind,
    /// Greatest packet size, bytes.
    pub max_packet: u16,
}

impl Endpoint {
    /// Returns the frames between two polls, 0 if their number is not fixed.
    #[must_use]
    pub const fn frames(self) -> u16 {
        match self.kind {
            Kind::Interrupt { frames } => frames,
            Kind::Control | Kind::Bulk => 0,
        }
    }
}

/// The type of a transfer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Control transfer, with a SETUP stage.
    Control,
    /// Bulk transfer, as there is room on the bus.
    Bulk,
    /// Interrupt transfer, every so many frames.
    Interrupt {
        /// Polling interval in frames (bInterval), at least 1.
        frames: u16,
    },
}

/// Request for a transfer.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Request {
    /// A control transfer; the data of a control write come with it. The host believes wLength and the
    /// direction in `setup`, whatever the length of `data`.
    Control {
        /// The eight bytes of the SETUP packet.
        setup: [u8; 8],
        /// Data of a control write.
        data: Vec<u8>,
    },
    /// Up to this many bytes from the device, or until a short packet.
    In(usize),
    /// Data for the device; `zero` adds a packet without data after a full last one.
    Out {
        /// The bytes to send.
        data: Vec<u8>,
        /// Whether a packet without data marks the end.
        zero: bool,
    },
    /// A control transfer that the host gives up after so many transactions that went through, as for a new
    /// SETUP.
    Abandoned {
        /// The eight bytes of the SETUP packet.
        setup: [u8; 8],
        /// Data of a control write.
        data: Vec<u8>,
        /// Number of transactions until then, the SETUP among them.
        after: u32,
    },
    /// A packet from the device that the host receives garbled, and so does not acknowledge.
    Garbled,
}

/// Result of a transfer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// The transfer was carried out.
    Done,
    /// The device answered STALL.
    Stalled,
    /// The device did not answer, or answered wrongly, three times.
    Failed,
    /// The device sent more than was asked for or fits into a packet.
    Babble,
    /// The driver cancelled the transfer.
    Cancelled,
    /// The device has gone, or the bus was reset.
    Gone,
}

/// The end of a transfer.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Completion {
    /// Name of the ended transfer.
    pub id: TransferId,
    /// Result of the transfer.
    pub outcome: Outcome,
    /// Bytes from the device.
    pub data: Vec<u8>,
    /// Number of bytes sent or received.
    pub actual: usize,
    /// Instant of the end, nanoseconds.
    pub at_ns: u64,
}

/// The next transaction of a transfer.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Step {
    Setup([u8; 8]),
    Out(Toggle, Vec<u8>),
    In,
}

/// Effect of an answer on its transfer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Progress {
    Goes,
    Ends(Outcome),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Stage {
    Setup,
    Data,
    Status,
}

/// A transfer under way.
#[derive(Clone, Debug)]
pub(super) struct Transfer {
    pub id: TransferId,
    request: Request,
    stage: Stage,
    /// Data toggle of the control transfer's data stage.
    toggle: Toggle,
    pub data: Vec<u8>,
    /// Number of bytes sent or received.
    pub moved: usize,
    /// Whether a full last packet has gone, and the packet without data is still to go.
    closed: bool,
    /// Transactions in a row without a proper answer.
    pub failures: u8,
    /// Transactions left until the host gives up.
    left: Option<u32>,
}

impl Transfer {
    /// Creates a transfer that has not begun.
    pub fn new(id: TransferId, request: Request) -> Self {
        let (request, left) = match request {
            Request::Abandoned { setup, data, after } => (Request::Control { setup, data }, Some(after)),
            other => (other, None),
        };
        let stage = if matches!(request, Request::Control { .. }) { Stage::Setup } else { Stage::Data };
        Self { id, request, stage, toggle: Toggle::Data1, data: Vec::new(), moved: 0, closed: false, failures: 0, left }
    }

    /// Whether the host acknowledges the device's packets.
    pub const fn acknowledges(&self) -> bool {
        !matches!(self.request, Request::Garbled)
    }

    /// Returns the number of bytes that the host wants at most, or has to send.
    fn wanted(&self) -> usize {
        match &self.request {
            Request::Control { setup, .. } => usize::from(u16::from_le_bytes([setup[6], setup[7]])),
            Request::In(wanted) => *wanted,
            Request::Out { data, .. } => data.len(),
            Request::Garbled | Request::Abandoned { .. } => 0,
        }
    }

    fn reads(&self) -> bool {
        match &self.request {
            Request::Control { setup, .. } => setup[0] & 0x80 != 0,
            Request::In(_) | Request::Garbled => true,
            Request::Out { .. } | Request::Abandoned { .. } => false,
        }
    }

    fn payload(&self, max_packet: usize) -> Vec<u8> {
        let (Request::Control { data, .. } | Request::Out { data, .. }) = &self.request else { return Vec::new() };
        let end = (self.moved + max_packet).min(self.wanted());
        // A control write whose data are fewer than it announced goes on with zeros.
        (self.moved..end).map(|index| data.get(index).copied().unwrap_or(0)).collect()
    }

    /// Returns the next transaction. `toggle` is the pipe's, of which control transfers take no notice.
    pub fn step(&self, toggle: Toggle, max_packet: usize) -> Step {
        match (self.stage, &self.request) {
            (Stage::Setup, Request::Control { setup, .. }) => Step::Setup(*setup),
            // The status stage goes the other way, and its packet is a DATA1 without data.
            (Stage::Status, _) if self.reads() && self.wanted() > 0 => Step::Out(Toggle::Data1, Vec::new()),
            (Stage::Status, _) => Step::In,
            _ if self.reads() => Step::In,
            (_, Request::Control { .. }) => Step::Out(self.toggle, self.payload(max_packet)),
            _ => Step::Out(toggle, self.payload(max_packet)),
        }
    }

    /// Returns the data toggle that the host expects of an IN packet.
    pub fn expected(&self, toggle: Toggle) -> Toggle {
        match (self.stage, &self.request) {
            (Stage::Status, _) => Toggle::Data1,
            (_, Request::Control { .. }) => self.toggle,
            _ => toggle,
        }
    }

    /// Counts a completed transaction; the host may give the transfer up now.
    fn counted(&mut self, progress: Progress) -> Progress {
        match &mut self.left {
            Some(1) => Progress::Ends(Outcome::Done),
            Some(left) => {
                *left -= 1;
                progress
            }
            None => progress,
        }
    }

    /// Takes note of an acknowledged SETUP or OUT transaction.
    pub fn sent(&mut self, max_packet: usize) -> Progress {
        self.failures = 0;
        let progress = self.advance_sent(max_packet);
        self.counted(progress)
    }

    fn advance_sent(&mut self, max_packet: usize) -> Progress {
        match self.stage {
            Stage::Setup => {
                self.stage = if self.wanted() > 0 { Stage::Data } else { Stage::Status };
                Progress::Goes
            }
            Stage::Status => Progress::Ends(Outcome::Done),
            Stage::Data => {
                let length = self.payload(max_packet).len();
                self.moved += length;
                self.toggle = self.toggle.flipped();
                if self.moved < self.wanted() {
                    return Progress::Goes;
                }
                if let Request::Control { .. } = self.request {
                    self.stage = Stage::Status;
                    return Progress::Goes;
                }
                let zero = matches!(self.request, Request::Out { zero: true, .. });
                if zero && length == max_packet && !self.closed {
                    self.closed = true;
                    return Progress::Goes;
                }
                Progress::Ends(Outcome::Done)
            }
        }
    }

    /// Takes a data packet that came with the right toggle.
    pub fn received(&mut self, packet: &[u8], max_packet: usize) -> Progress {
        self.failures = 0;
        if self.request == Request::Garbled {
            self.data = packet.to_vec();
            return Progress::Ends(Outcome::Done);
        }
        let progress = self.advance_received(packet, max_packet);
        self.counted(progress)
    }

    fn advance_received(&mut self, packet: &[u8], max_packet: usize) -> Progress {
        if self.stage == Stage::Status {
            return Progress::Ends(if packet.is_empty() { Outcome::Done } else { Outcome::Babble });
        }
        let room = self.wanted() - self.moved;
        if packet.len() > max_packet || packet.len() > room {
            self.data.extend_from_slice(&packet[..room.min(packet.len())]);
            self.moved = self.data.len();
            return Progress::Ends(Outcome::Babble);
        }
        self.data.extend_from_slice(packet);
        self.moved = self.data.len();
        self.toggle = self.toggle.flipped();
        if packet.len() < max_packet || self.moved == self.wanted() {
            if let Request::Control { .. } = self.request {
                self.stage = Stage::Status;
                return Progress::Goes;
            }
            return Progress::Ends(Outcome::Done);
        }
        Progress::Goes
    }

    /// Returns the completion for the driver that submitted the transfer.
    pub fn complete(self, outcome: Outcome, at_ns: u64) -> Completion {
        Completion { id: self.id, outcome, data: self.data, actual: self.moved, at_ns }
    }
}
