//! Schedule of the bus: frames of a millisecond, and in each as many transactions as full speed allows, round
//! robin over the endpoints that have transfers.
//!
//! A transaction takes the time that USB 2.0 section 5.11.3 counts: 13 bytes of overhead and its data, at 12
//! Mbit/s, so that 19 transactions of 64 bytes go into a frame. An endpoint that answers NAK is asked again
//! as soon as something has changed in the device, or in the next frame; a real host asks again and again in
//! between, with no visible effect.

use super::{Controller, Flight, Pipe};
use crate::transfer::{Kind, Outcome, Progress, Step, Transfer};
use crate::wire::{Address, Function, Handshake, Reply, Toggle};

/// Duration of a frame.
const FRAME_NS: u64 = 1_000_000;
/// Length of a SOF packet with its sync field and end of packet, bits.
const SOF_BITS: u64 = 35;
/// Overhead of a transaction, bytes: token, data packet, handshake and the pauses between them.
const OVERHEAD: u64 = 13;
/// Overhead of an IN transaction that is answered by a handshake.
const TOKEN: u64 = 9;
/// Silence towards the end of a frame, bits.
const END_BITS: u64 = 42;
/// Number of attempts until a transaction without an answer ends its transfer.
const ATTEMPTS: u8 = 3;

const fn bits_ns(bits: u64) -> u64 {
    bits * 250 / 3
}

const fn bytes_ns(bytes: u64) -> u64 {
    bits_ns(bytes * 8)
}

impl Controller {
    pub(super) fn begin_frame(&mut self, device: &mut impl Function) {
        self.frame += 1;
        self.tally.frames += 1;
        let start = self.next_frame;
        device.start_of_frame(start, self.frame());
        self.free = self.free.max(start + bits_ns(SOF_BITS));
        self.next_frame = start + FRAME_NS;
        self.pipes.iter_mut().for_each(|pipe| pipe.parked = false);
    }

    /// Longest duration of a pipe's next transaction.
    fn longest(&self, pipe: &Pipe) -> Option<u64> {
        let max_packet = usize::from(pipe.endpoint.max_packet);
        let bytes = match pipe.queue.front()?.step(pipe.toggle, max_packet) {
            Step::Setup(_) => 8,
            Step::Out(_, data) => data.len() as u64,
            Step::In => u64::from(pipe.endpoint.max_packet),
        };
        Some(bytes_ns(OVERHEAD + bytes))
    }

    /// Picks the next pipe on a bus that is free from `start` on: interrupt endpoints that are due, then the
    /// others in turn.
    pub(super) fn pick(&self, start: u64) -> Option<usize> {
        let end = self.next_frame.saturating_sub(bits_ns(END_BITS));
        let ready = |&place: &usize| {
            let pipe = &self.pipes[place];
            let due = !matches!(pipe.endpoint.kind, Kind::Interrupt { .. }) || pipe.due <= self.frame;
            !pipe.parked && due && self.longest(pipe).is_some_and(|time| start + time <= end)
        };
        let periodic = |place: &usize| matches!(self.pipes[*place].endpoint.kind, Kind::Interrupt { .. });
        let count = self.pipes.len();
        let mut order = (0..count).map(|step| (self.turn + step) % count);
        let interrupt = (0..count).filter(periodic).find(ready);
        interrupt.or_else(|| order.find(|place| !periodic(place) && ready(place)))
    }

    pub(super) fn take_off(&mut self, start: u64, place: usize, device: &mut impl Function) {
        let pipe = &self.pipes[place];
        let to = Address { device: pipe.endpoint.device, endpoint: pipe.endpoint.number };
        let Some(transfer) = pipe.queue.front() else { return };
        let step = transfer.step(pipe.toggle, usize::from(pipe.endpoint.max_packet));
        let reply = (step == Step::In).then(|| device.poll(to));
        let bytes = match (&step, &reply) {
            (Step::Setup(packet), _) => OVERHEAD + packet.len() as u64,
            (Step::Out(_, data), _) => OVERHEAD + data.len() as u64,
            (Step::In, Some(Reply::Data(_, data))) => OVERHEAD + data.len() as u64,
            (Step::In, _) => TOKEN,
        };
        if !matches!(pipe.endpoint.kind, Kind::Interrupt { .. }) {
            self.turn = place + 1;
        }
        self.flight = Some(Flight { pipe: place, step, reply, ends: start + bytes_ns(bytes), outdated: false });
    }

    /// Ends a transaction on the bus.
    pub(super) fn land(&mut self, flight: Flight, device: &mut impl Function) {
        let place = flight.pipe;
        self.free = flight.ends;
        let endpoint = self.pipes[place].endpoint;
        let to = Address { device: endpoint.device, endpoint: endpoint.number };
        let progress = match (flight.step, flight.reply) {
            (Step::Setup(packet), _) => self.sent(place, 8, device.setup(to, packet)),
            (Step::Out(toggle, data), _) => self.sent(place, data.len(), device.out(to, toggle, &data)),
            (Step::In, Some(Reply::Data(toggle, data))) => {
                let understood = self.pipes[place].queue.front().is_some_and(Transfer::acknowledges);
                if understood {
                    device.acknowledge(to);
                }
                self.received(place, toggle, &data, understood)
            }
            (Step::In, Some(Reply::Nak)) => self.refused(place),
            (Step::In, Some(Reply::Stall)) => Progress::Ends(Outcome::Stalled),
            (Step::In, _) => self.unanswered(place),
        };
        let pipe = &mut self.pipes[place];
        pipe.parked &= !flight.outdated;
        if let Kind::Interrupt { frames } = endpoint.kind {
            pipe.due = self.frame + u64::from(frames.max(1));
        }
        if let Progress::Ends(outcome) = progress
            && let Some(transfer) = pipe.queue.pop_front()
        {
            self.done.push(transfer.complete(outcome, flight.ends));
        }
    }

    fn sent(&mut self, place: usize, bytes: usize, handshake: Handshake) -> Progress {
        let pipe = &mut self.pipes[place];
        match (handshake, pipe.queue.front_mut()) {
            (Handshake::Ack, Some(transfer)) => {
                self.tally.packets += 1;
                self.tally.bytes += bytes as u64;
                let progress = transfer.sent(usize::from(pipe.endpoint.max_packet));
                if pipe.endpoint.kind != Kind::Control {
                    pipe.toggle = pipe.toggle.flipped();
                    self.tally.sent[usize::from(pipe.endpoint.number & 0xF)] += bytes as u64;
                }
                progress
            }
            (Handshake::Nak, _) => self.refused(place),
            (Handshake::Stall, _) => Progress::Ends(Outcome::Stalled),
            _ => self.unanswered(place),
        }
    }

    fn received(&mut self, place: usize, toggle: Toggle, data: &[u8], understood: bool) -> Progress {
        let pipe = &mut self.pipes[place];
        let Some(transfer) = pipe.queue.front_mut() else { return Progress::Goes };
        if understood && toggle != transfer.expected(pipe.toggle) {
            self.tally.repeated += 1;
            return Progress::Goes;
        }
        self.tally.packets += 1;
        self.tally.bytes += data.len() as u64;
        if understood && pipe.endpoint.kind != Kind::Control {
            pipe.toggle = pipe.toggle.flipped();
        }
        transfer.received(data, usize::from(pipe.endpoint.max_packet))
    }

    fn refused(&mut self, place: usize) -> Progress {
        self.tally.naks += 1;
        let pipe = &mut self.pipes[place];
        pipe.parked = true;
        if let Some(transfer) = pipe.queue.front_mut() {
            transfer.failures = 0;
        }
        Progress::Goes
    }

    fn unanswered(&mut self, place: usize) -> Progress {
        let Some(transfer) = self.pipes[place].queue.front_mut() else { return Progress::Goes };
        transfer.failures += 1;
        if transfer.failures < ATTEMPTS { Progress::Goes } else { Progress::Ends(Outcome::Failed) }
    }
}
