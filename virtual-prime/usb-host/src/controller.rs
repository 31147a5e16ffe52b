//! The host controller with its one port, as the host's drivers use it.

use std::collections::VecDeque;

use super::transfer::{Completion, Direction, Endpoint, Kind, Outcome, Request, Step, Transfer, TransferId};
use super::wire::{Drive, Function, Reply, Toggle};

mod schedule;

/// Duration of a resume that the host drives: USB 2.0 section 7.1.7.7, 20 ms at least.
const RESUME_NS: u64 = 20_000_000;

/// State of the port.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Port {
    /// No cable is plugged in.
    Unplugged,
    /// A cable is plugged in, and no device pulls up.
    Empty,
    /// A device is connected, and was not reset yet.
    Connected,
    /// Bus reset until this instant, nanoseconds.
    Resetting(u64),
    /// Frames are being sent.
    Enabled,
    /// No frames are sent.
    Suspended,
    /// Resume is driven until this instant, nanoseconds.
    Resuming(u64),
}

/// Event at the port that the host has not caused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PortEvent {
    /// The device has pulled up.
    Connected,
    /// The device has stopped pulling up.
    Disconnected,
    /// The device has signalled remote wake-up for so many nanoseconds.
    Woken(u64),
}

#[derive(Debug)]
struct Pipe {
    endpoint: Endpoint,
    toggle: Toggle,
    queue: VecDeque<Transfer>,
    /// The endpoint has answered NAK, and nothing has changed since.
    parked: bool,
    /// Frame in which an interrupt endpoint is polled next.
    due: u64,
}

#[derive(Debug)]
struct Flight {
    pipe: usize,
    step: Step,
    /// Answer to an IN token, known from the transaction's start.
    reply: Option<Reply>,
    ends: u64,
    /// Whether the device has changed since the transaction's start, so that it may answer differently if
    /// asked again.
    outdated: bool,
}

/// Counts of traffic over the bus.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tally {
    /// Transactions that moved a packet.
    pub packets: u64,
    /// Bytes in these packets.
    pub bytes: u64,
    /// Transactions answered by NAK.
    pub naks: u64,
    /// Frames sent so far.
    pub frames: u64,
    /// IN packets with the wrong toggle, which the host took for repetitions.
    pub repeated: u64,
    /// Bytes that the device has acknowledged, by OUT endpoint; none of control transfers.
    pub sent: [u64; 16],
}

/// State of the controller.
#[derive(Debug)]
pub struct Controller {
    port: Port,
    pipes: Vec<Pipe>,
    turn: usize,
    flight: Option<Flight>,
    frame: u64,
    next_frame: u64,
    /// Instant at which the bus is free in this frame.
    free: u64,
    /// Instant of the last [`Self::run`].
    now: u64,
    woken_at: Option<u64>,
    next_id: u64,
    done: Vec<Completion>,
    events: Vec<PortEvent>,
    /// Counts of traffic over the bus.
    pub tally: Tally,
}

impl Default for Controller {
    fn default() -> Self {
        Self {
            port: Port::Unplugged,
            pipes: Vec::new(),
            turn: 0,
            flight: None,
            frame: 0,
            next_frame: 0,
            free: 0,
            now: 0,
            woken_at: None,
            next_id: 0,
            done: Vec::new(),
            events: Vec::new(),
            tally: Tally::default(),
        }
    }
}

impl Controller {
    /// Returns the state of the port.
    #[must_use]
    pub const fn port(&self) -> Port {
        self.port
    }

    /// Returns the number of the present frame, 11 bits.
    #[must_use]
    pub const fn frame(&self) -> u16 {
        (self.frame & 0x7FF) as u16
    }

    /// Plugs the cable in.
    pub fn plug(&mut self, now_ns: u64, device: &mut impl Function) {
        if self.port == Port::Unplugged {
            self.port = Port::Empty;
            device.port(now_ns, Drive::Idle);
        }
    }

    /// Pulls the cable out, in the middle of anything that is under way.
    pub fn unplug(&mut self, now_ns: u64, device: &mut impl Function) {
        if self.port != Port::Unplugged {
            self.drop_all(now_ns);
            self.port = Port::Unplugged;
            device.port(now_ns, Drive::Unplugged);
        }
    }

    /// Resets the bus for `duration_ns`; the device has address 0 then, and no transfer is left. Without a
    /// device nothing happens.
    pub fn reset(&mut self, now_ns: u64, duration_ns: u64, device: &mut impl Function) {
        if !matches!(self.port, Port::Unplugged | Port::Empty) {
            self.drop_all(now_ns);
            self.port = Port::Resetting(now_ns + duration_ns);
            device.port(now_ns, Drive::Reset);
        }
    }

    /// Stops sending frames, while transfers stay pending.
    pub fn suspend(&mut self, now_ns: u64, device: &mut impl Function) {
        if self.port == Port::Enabled {
            self.flight = None;
            self.port = Port::Suspended;
            device.port(now_ns, Drive::Idle);
        }
    }

    /// Drives a resume of a suspended port.
    pub fn resume(&mut self, now_ns: u64, device: &mut impl Function) {
        if self.port == Port::Suspended {
            self.port = Port::Resuming(now_ns + RESUME_NS);
            device.port(now_ns, Drive::Resume);
        }
    }

    /// Submits a transfer. Without a device, or before its reset, it ends at once.
    pub fn submit(&mut self, now_ns: u64, endpoint: Endpoint, request: Request) -> TransferId {
        let id = TransferId(self.next_id);
        self.next_id += 1;
        let transfer = Transfer::new(id, request);
        if matches!(self.port, Port::Unplugged | Port::Empty | Port::Connected | Port::Resetting(_)) {
            self.done.push(transfer.complete(Outcome::Gone, now_ns));
            return id;
        }
        let place = self.pipe(endpoint);
        let pipe = &mut self.pipes[place];
        pipe.endpoint = endpoint;
        pipe.queue.push_back(transfer);
        id
    }

    /// Ends a transfer before its time. Returns whether it was still there.
    pub fn cancel(&mut self, now_ns: u64, id: TransferId) -> bool {
        for (place, pipe) in self.pipes.iter_mut().enumerate() {
            let Some(at) = pipe.queue.iter().position(|transfer| transfer.id == id) else { continue };
            if at == 0 && self.flight.as_ref().is_some_and(|flight| flight.pipe == place) {
                self.flight = None;
            }
            if let Some(transfer) = pipe.queue.remove(at) {
                self.done.push(transfer.complete(Outcome::Cancelled, now_ns));
            }
            return true;
        }
        false
    }

    /// Sets the data toggle of an endpoint, as its configuration or the clearing of its halt does.
    pub fn set_toggle(&mut self, endpoint: Endpoint, toggle: Toggle) {
        let place = self.pipe(endpoint);
        self.pipes[place].toggle = toggle;
    }

    /// Sets all toggles to DATA0, as SET_CONFIGURATION does.
    pub fn clear_toggles(&mut self) {
        self.pipes.iter_mut().for_each(|pipe| pipe.toggle = Toggle::Data0);
    }

    /// Takes the transfers that have ended since the last call.
    pub fn take_completions(&mut self) -> Vec<Completion> {
        std::mem::take(&mut self.done)
    }

    /// Whether transfers have ended that no driver has taken yet.
    #[must_use]
    pub fn has_completions(&self) -> bool {
        !self.done.is_empty()
    }

    /// Takes the events at the port since the last call.
    pub fn take_events(&mut self) -> Vec<PortEvent> {
        std::mem::take(&mut self.events)
    }

    /// Returns the instant of the next step, if nothing else happens.
    #[must_use]
    pub fn next(&self) -> Option<u64> {
        match self.port {
            Port::Unplugged | Port::Empty | Port::Connected => None,
            Port::Suspended => None,
            Port::Resetting(until) | Port::Resuming(until) => Some(until),
            Port::Enabled => {
                let start = self.free.max(self.now);
                let start = self.pick(start).map(|_| start);
                let flight = self.flight.as_ref().map(|flight| flight.ends);
                [Some(self.next_frame), flight.or(start)].into_iter().flatten().min()
            }
        }
    }

    /// Carries out all steps that are due by now. To be called at each instant of [`Self::next`], and when
    /// the device may have changed.
    pub fn run(&mut self, now_ns: u64, device: &mut impl Function) {
        self.now = now_ns;
        self.notice(device);
        self.follow_device(now_ns, device);
        self.follow_time(now_ns, device);
        while self.port == Port::Enabled {
            if let Some(flight) = self.flight.take_if(|flight| flight.ends <= now_ns) {
                self.land(flight, device);
            } else if self.next_frame <= now_ns {
                self.begin_frame(device);
            } else if self.flight.is_none()
                && let start = self.free.max(now_ns)
                && let Some(pipe) = self.pick(start)
            {
                self.take_off(start, pipe, device);
            } else {
                break;
            }
        }
    }

    /// Lets endpoints that have answered NAK be polled again after a change of the device.
    fn notice(&mut self, device: &mut impl Function) {
        if device.stirred() {
            self.pipes.iter_mut().for_each(|pipe| pipe.parked = false);
            if let Some(flight) = &mut self.flight {
                flight.outdated = true;
            }
        }
    }

    fn follow_device(&mut self, now_ns: u64, device: &mut impl Function) {
        match (self.port, device.pulls_up()) {
            (Port::Unplugged, _) | (Port::Empty, false) => {}
            (Port::Empty, true) => {
                self.port = Port::Connected;
                self.events.push(PortEvent::Connected);
            }
            (_, true) => {}
            (_, false) => {
                self.drop_all(now_ns);
                self.port = Port::Empty;
                self.events.push(PortEvent::Disconnected);
                device.port(now_ns, Drive::Idle);
            }
        }
        match (self.woken_at, device.wakes()) {
            (None, true) if self.port == Port::Suspended => {
                self.woken_at = Some(now_ns);
                self.resume(now_ns, device);
            }
            (Some(since), false) => {
                self.woken_at = None;
                self.events.push(PortEvent::Woken(now_ns - since));
            }
            _ => {}
        }
    }

    fn follow_time(&mut self, now_ns: u64, device: &mut impl Function) {
        if let Port::Resetting(until) | Port::Resuming(until) = self.port
            && until <= now_ns
        {
            self.port = Port::Enabled;
            self.next_frame = until;
            self.free = until;
            device.port(until, Drive::Frames);
        }
    }

    /// Returns the pipe of an endpoint, and creates it at its first use.
    fn pipe(&mut self, endpoint: Endpoint) -> usize {
        let same = |pipe: &Pipe| {
            let known = pipe.endpoint;
            let way = known.kind == Kind::Control || known.direction == endpoint.direction;
            (known.device, known.number) == (endpoint.device, endpoint.number) && way
        };
        self.pipes.iter().position(same).unwrap_or_else(|| {
            let queue = VecDeque::new();
            self.pipes.push(Pipe { endpoint, toggle: Toggle::Data0, queue, parked: false, due: 0 });
            self.pipes.len() - 1
        })
    }

    /// Ends every transfer, and forgets all toggles.
    fn drop_all(&mut self, now_ns: u64) {
        self.flight = None;
        for pipe in self.pipes.drain(..) {
            let ended = pipe.queue.into_iter().map(|transfer| transfer.complete(Outcome::Gone, now_ns));
            self.done.extend(ended);
        }
        self.turn = 0;
    }

    /// Returns the endpoint's address as in its descriptor (bEndpointAddress).
    #[must_use]
    pub const fn endpoint_address(endpoint: Endpoint) -> u8 {
        endpoint.number | if matches!(endpoint.direction, Direction::In) { 0x80 } else { 0 }
    }
}
