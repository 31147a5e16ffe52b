//! A transfer: what a driver on the host asks for, made of as many transactions as it takes (USB 2.0 sections
//! 5.5 to 5.8 and 8.5).

use super::wire::Toggle;

/// Names a transfer to whoever asked for it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct TransferId(pub u64);

/// Which way data go.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Direction {
    /// To the host.
    In,
    /// To the device.
    Out,
}

/// What the host knows of an endpoint.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Endpoint {
    /// Of the device.
    pub device: u8,
    /// Without its direction.
    pub number: u8,
    /// Of the data; of a control endpoint it means nothing.
    pub direction: Direction,
    /// How the host schedules it.
    pub kind: Kind,
    /// Most bytes of a packet.
    pub max_packet: u16,
}

impl Endpoint {
    /// How many frames pass between two questions, 0 if that is not fixed.
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
    /// With a SETUP stage.
    Control,
    /// As there is room on the bus.
    Bulk,
    /// Every so many frames.
    Interrupt {
        /// bInterval, at least 1.
        frames: u16,
    },
}

/// What is asked for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Request {
    /// A control transfer; the data of a control write come with it. The host believes wLength and the
    /// direction in `setup`, whatever the length of `data`.
    Control {
        /// The eight bytes.
        setup: [u8; 8],
        /// Of a control write.
        data: Vec<u8>,
    },
    /// Up to this many bytes from the device, or until a short packet.
    In(usize),
    /// These bytes to the device; `zero` adds a packet without data after a full last one.
    Out {
        /// The bytes.
        data: Vec<u8>,
        /// Say by a packet without data that this is the end.
        zero: bool,
    },
    /// A control transfer that the host gives up after so many transactions that went through, as for a new
    /// SETUP.
    Abandoned {
        /// The eight bytes.
        setup: [u8; 8],
        /// Of a control write.
        data: Vec<u8>,
        /// Transactions, the one of the SETUP among them.
        after: u32,
    },
    /// One packet from the device, which the host does not understand and so does not acknowledge.
    Garbled,
}

/// How a transfer ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// As it should.
    Done,
    /// The device answered STALL.
    Stalled,
    /// Three times no answer, or not the right one.
    Failed,
    /// The device sent more than was asked for or fits into a packet.
    Babble,
    /// Whoever asked for it did not want it any more.
    Cancelled,
    /// The device has gone, or the bus was reset.
    Gone,
}

/// The end of a transfer.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Completion {
    /// Which.
    pub id: TransferId,
    /// How.
    pub outcome: Outcome,
    /// Bytes that came.
    pub data: Vec<u8>,
    /// Bytes that came or went.
    pub actual: usize,
    /// When, nanoseconds.
    pub at_ns: u64,
}

/// The next transaction of a transfer.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Step {
    Setup([u8; 8]),
    Out(Toggle, Vec<u8>),
    In,
}

/// What a transfer makes of an answer.
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
    /// Of the control transfer's data stage.
    toggle: Toggle,
    pub data: Vec<u8>,
    /// Bytes that came or went.
    pub moved: usize,
    /// A full last packet has gone, and the one without data is still to go.
    closed: bool,
    /// Transactions in a row without a proper answer.
    pub failures: u8,
    /// Transactions left until the host gives up.
    left: Option<u32>,
}

impl Transfer {
    pub fn new(id: TransferId, request: Request) -> Self {
        let (request, left) = match request {
            Request::Abandoned { setup, data, after } => (Request::Control { setup, data }, Some(after)),
            other => (other, None),
        };
        let stage = if matches!(request, Request::Control { .. }) { Stage::Setup } else { Stage::Data };
        Self { id, request, stage, toggle: Toggle::Data1, data: Vec::new(), moved: 0, closed: false, failures: 0, left }
    }

    /// Whether the host acknowledges what comes.
    pub const fn acknowledges(&self) -> bool {
        !matches!(self.request, Request::Garbled)
    }

    /// Bytes that the host wants at most, or has to send.
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

    /// The next transaction. `toggle` is the pipe's, of which control transfers take no notice.
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

    /// The data toggle that the host expects of an IN packet.
    pub fn expected(&self, toggle: Toggle) -> Toggle {
        match (self.stage, &self.request) {
            (Stage::Status, _) => Toggle::Data1,
            (_, Request::Control { .. }) => self.toggle,
            _ => toggle,
        }
    }

    /// A transaction went through; the host may have had enough by now.
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

    /// A SETUP or OUT transaction was acknowledged.
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

    /// A data packet came, with the right toggle.
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

    /// The end, for whoever asked.
    pub fn complete(self, outcome: Outcome, at_ns: u64) -> Completion {
        Completion { id: self.id, outcome, data: self.data, actual: self.moved, at_ns }
    }
}
