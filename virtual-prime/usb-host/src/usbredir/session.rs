//! A session with a usbredir peer: its messages become transfers, and ended transfers become messages.
//!
//! | rule of the protocol | here |
//! |---|---|
//! | nothing but HELLO before the peer's HELLO | [`Stream::send`] |
//! | every identifier is answered exactly once, and may come again after that | `pending` |
//! | cancel: a pending request is answered as cancelled, any other is not answered | `cancel` |
//! | reset has no answer, and drops all that is pending | `reset` |
//! | SET_ADDRESS stays on the peer's side; the hub gives the device its address | [`crate::hub`] |
//! | configurations and alternate settings are messages of their own | [`super::request`] |
//! | after a disconnect, everything is stale until it is acknowledged | `Link::Leaving` |
//! | an answer to a bulk request has no time-out: a NAK means that it waits | the host controller |

use std::collections::{BTreeMap, HashMap, VecDeque};

use super::announce;
use super::codec::Malformed;
use super::message::{Capabilities, Message, Status};
use super::request::{Begun, Pending, answer, begin, refuse};
use super::stream::Stream;
use crate::hub::Root;
use crate::transfer::{Completion, Kind, Outcome, Request, TransferId};
use crate::wire::Function;

/// State of the device as announced to the peer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Link {
    /// No device is announced.
    Idle,
    /// A device is announced.
    Announced,
    /// The device's departure is announced, and not acknowledged yet.
    Leaving,
}

/// A session with a peer.
#[derive(Debug)]
pub struct Session {
    stream: Stream,
    link: Link,
    /// Requests that wait until the device has been reset.
    waiting: VecDeque<(u64, Message)>,
    /// Transfers under way, with the request that each belongs to.
    pending: HashMap<TransferId, Pending>,
    /// Interrupt endpoints that are polled continuously: the next packet's identifier, by address.
    receiving: BTreeMap<u8, u64>,
    /// Whether the peer has refused the device.
    rejected: bool,
}

impl Default for Session {
    fn default() -> Self {
        let name = concat!("virtual-prime ", env!("CARGO_PKG_VERSION"));
        Self {
            stream: Stream::new(name, Capabilities::OURS),
            link: Link::Idle,
            waiting: VecDeque::new(),
            pending: HashMap::new(),
            receiving: BTreeMap::new(),
            rejected: false,
        }
    }
}

impl Session {
    /// Returns the connection's message stream.
    pub const fn stream(&mut self) -> &mut Stream {
        &mut self.stream
    }

    /// Whether the peer wants a device: it has sent HELLO, and has not refused ours.
    #[must_use]
    pub const fn wants_device(&self) -> bool {
        self.stream.agreed().is_some() && !self.rejected
    }

    /// Whether the peer has refused our device.
    #[must_use]
    pub const fn is_rejected(&self) -> bool {
        self.rejected
    }

    /// Reads the peer's HELLO, if that has come; before it, the peer wants no device.
    ///
    /// # Errors
    /// The peer does not speak the protocol.
    pub fn begin(&mut self) -> Result<(), Malformed> {
        if self.stream.agreed().is_none() {
            self.stream.take_message()?;
        }
        Ok(())
    }

    /// Serves the peer's messages, ended transfers and changes of the device.
    ///
    /// # Errors
    /// The peer does not speak the protocol: its connection is of no use any more.
    pub fn serve<F: Function>(
        &mut self,
        root: &mut Root<'_, F>,
        completions: Vec<Completion>,
    ) -> Result<(), Malformed> {
        for ended in completions {
            self.end(root, ended);
        }
        self.begin()?;
        self.follow_device(root);
        self.catch_up(root);
        while let Some((id, message)) = self.stream.take_message()? {
            self.hear(root, id, message)?;
            // An acknowledged departure lets the next device be announced.
            self.follow_device(root);
        }
        Ok(())
    }

    /// Tells the peer that the device is there, or that it has gone.
    fn follow_device<F: Function>(&mut self, root: &Root<'_, F>) {
        let Some(agreed) = self.stream.agreed() else { return };
        match (self.link, root.hub.found()) {
            (Link::Idle, Some(found)) if !self.rejected && root.hub.is_ready() => {
                self.link = Link::Announced;
                for message in announce::device(found, root.hub) {
                    self.stream.send(0, &message);
                }
            }
            (Link::Announced, None) => {
                self.refuse_waiting(Status::Cancelled);
                self.stream.send(0, &Message::DeviceDisconnect);
                let acknowledges = agreed.has(Capabilities::DISCONNECT_ACK);
                self.link = if acknowledges { Link::Leaving } else { Link::Idle };
            }
            _ => {}
        }
    }

    /// Starts the requests that have waited for the end of a reset.
    fn catch_up<F: Function>(&mut self, root: &mut Root<'_, F>) {
        while root.hub.is_ready()
            && let Some((id, message)) = self.waiting.pop_front()
        {
            self.start(root, id, &message);
        }
    }

    fn refuse_waiting(&mut self, status: Status) {
        for (id, message) in std::mem::take(&mut self.waiting) {
            self.send_refusal(id, &message, status);
        }
    }

    fn send_refusal(&mut self, id: u64, message: &Message, status: Status) {
        if let Some(answer) = refuse(message, status) {
            self.stream.send(id, &answer);
        }
    }

    fn hear<F: Function>(&mut self, root: &mut Root<'_, F>, id: u64, message: Message) -> Result<(), Malformed> {
        match message {
            Message::DeviceDisconnectAck if self.link == Link::Leaving => self.link = Link::Idle,
            Message::Hello(..) | Message::DeviceDisconnectAck | Message::FilterFilter(_) | Message::Other(_) => {}
            Message::FilterReject => {
                self.rejected = true;
                self.refuse_waiting(Status::Cancelled);
            }
            message if is_of_hosts(&message) => {
                return Err(Malformed(format!("message {} is for the other side to send", message.kind())));
            }
            // The peer sent the message before it knew that the device has gone.
            _ if self.link != Link::Announced => {}
            Message::Reset => {
                self.refuse_waiting(Status::Cancelled);
                root.reset();
            }
            Message::CancelDataPacket => self.cancel(root, id),
            message if root.hub.is_ready() => self.start(root, id, &message),
            message => self.waiting.push_back((id, message)),
        }
        Ok(())
    }

    fn cancel<F: Function>(&mut self, root: &mut Root<'_, F>, id: u64) {
        if let Some(place) = self.waiting.iter().position(|(waiting, _)| *waiting == id)
            && let Some((id, message)) = self.waiting.remove(place)
        {
            return self.send_refusal(id, &message, Status::Cancelled);
        }
        // The cancelled answer is sent with the next completions.
        if let Some((transfer, _)) = self.pending.iter().find(|(_, pending)| pending.id() == Some(id)) {
            root.cancel(*transfer);
        }
    }

    fn start<F: Function>(&mut self, root: &mut Root<'_, F>, id: u64, message: &Message) {
        match message {
            Message::StartInterruptReceiving { endpoint } => self.start_receiving(root, id, *endpoint),
            Message::StopInterruptReceiving { endpoint } => self.stop_receiving(root, id, *endpoint),
            _ => match begin(root.hub, id, message) {
                Begun::Transfer(endpoint, request, pending) => {
                    let transfer = root.submit(endpoint, request);
                    self.pending.insert(transfer, pending);
                }
                Begun::Refused(status) => self.send_refusal(id, message, status),
            },
        }
    }

    fn start_receiving<F: Function>(&mut self, root: &mut Root<'_, F>, id: u64, endpoint: u8) {
        let known = endpoint & 0x80 != 0 && self.ask_for_packet(root, endpoint);
        let status = if known { Status::Success } else { Status::Invalid } as u8;
        self.stream.send(id, &Message::InterruptReceivingStatus { status, endpoint });
    }

    /// Asks an interrupt endpoint for its next packet, unless that has been done. Returns whether there is
    /// such an endpoint.
    fn ask_for_packet<F: Function>(&mut self, root: &mut Root<'_, F>, address: u8) -> bool {
        let Some(endpoint) = root.hub.endpoint(address) else { return false };
        if !matches!(endpoint.kind, Kind::Interrupt { .. }) {
            return false;
        }
        let asked = self.pending.values().any(|pending| *pending == Pending::Receiving(address));
        if !asked {
            let transfer = root.submit(endpoint, Request::In(usize::from(endpoint.max_packet)));
            self.pending.insert(transfer, Pending::Receiving(address));
            self.receiving.entry(address).or_default();
        }
        true
    }

    fn stop_receiving<F: Function>(&mut self, root: &mut Root<'_, F>, id: u64, endpoint: u8) {
        self.receiving.remove(&endpoint);
        if let Some((transfer, _)) = self.pending.iter().find(|(_, one)| **one == Pending::Receiving(endpoint)) {
            root.cancel(*transfer);
        }
        let status = Status::Success as u8;
        self.stream.send(id, &Message::InterruptReceivingStatus { status, endpoint });
    }

    /// Answers the request of an ended transfer.
    fn end<F: Function>(&mut self, root: &mut Root<'_, F>, ended: Completion) {
        match self.pending.remove(&ended.id) {
            Some(Pending::Receiving(endpoint)) => self.receive(root, endpoint, ended),
            Some(pending) => {
                if ended.outcome == Outcome::Done
                    && let Some(setup) = pending.setup()
                {
                    root.follow(setup);
                    for message in announce::selection(setup, root.hub) {
                        self.stream.send(0, &message);
                    }
                }
                if let Some((id, message)) = answer(pending, ended) {
                    self.stream.send(id, &message);
                }
            }
            None => {}
        }
    }

    /// Sends the packet of an interrupt endpoint, and asks for the next.
    fn receive<F: Function>(&mut self, root: &mut Root<'_, F>, endpoint: u8, ended: Completion) {
        // The peer has stopped receiving in the meantime.
        let Some(next) = self.receiving.get_mut(&endpoint) else { return };
        match ended.outcome {
            Outcome::Done => {
                let id = *next;
                *next += 1;
                let (status, length) = (Status::Success as u8, ended.data.len() as u16);
                let packet = Message::InterruptPacket { endpoint, status, length, data: ended.data };
                self.stream.send(id, &packet);
                self.ask_for_packet(root, endpoint);
            }
            Outcome::Cancelled | Outcome::Gone => drop(self.receiving.remove(&endpoint)),
            // The error is told as a stall, as a peer asks again only after a stall.
            Outcome::Stalled | Outcome::Failed | Outcome::Babble => {
                self.receiving.remove(&endpoint);
                let status = Status::Stall as u8;
                self.stream.send(0, &Message::InterruptReceivingStatus { status, endpoint });
            }
        }
    }
}

/// Whether only the side with the device sends this message.
const fn is_of_hosts(message: &Message) -> bool {
    matches!(
        message,
        Message::DeviceConnect(_)
            | Message::DeviceDisconnect
            | Message::InterfaceInfo(_)
            | Message::EpInfo(_)
            | Message::ConfigurationStatus { .. }
            | Message::AltSettingStatus { .. }
            | Message::IsoStreamStatus { .. }
            | Message::InterruptReceivingStatus { .. }
    )
}
