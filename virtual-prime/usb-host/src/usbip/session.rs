//! A session with a USB/IP client: its commands become transfers, and ended transfers become answers.
//!
//! A client's virtual host controller keeps bus resets and SET_ADDRESS to itself. So the device gets both
//! when the cable goes in, which is for as long as a client is connected, and it looks freshly plugged in to
//! whoever imports it.

use std::collections::{HashMap, VecDeque};

use super::packet::{self, Command, Operation, Refusal, SHORT_NOT_OK, Submit, ZERO_PACKET};
use crate::hub::{Hub, Root};
use crate::request::{self, Setup};
use crate::transfer::{Completion, Direction, Kind, Outcome, Request, TransferId};
use crate::wire::Function;

/// Name (busid) of the only device.
pub const BUSID: &str = "1-1";
/// Time that a client's question waits for a device to appear.
const PATIENCE_NS: u64 = 1_000_000_000;
/// Type of class requests to a port of a hub, by which a client may reset the device.
const TO_PORT: u8 = 0x23;
const PORT_RESET: u16 = 4;

/// Linux error numbers of the answers.
mod error {
    pub const NOENT: i32 = -2;
    pub const INVAL: i32 = -22;
    pub const PIPE: i32 = -32;
    pub const PROTO: i32 = -71;
    pub const OVERFLOW: i32 = -75;
    pub const CONNRESET: i32 = -104;
    pub const SHUTDOWN: i32 = -108;
    pub const REMOTEIO: i32 = -121;
}

#[derive(Debug)]
struct Pending {
    sequence: u32,
    setup: Option<Setup>,
    /// Least number of bytes for the transfer to count as successful.
    needs: usize,
    /// Number of the command that has unlinked the transfer.
    unlinked: Option<u32>,
}

/// Stage of the session.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Stage {
    /// The client has not asked for a device yet.
    Asking,
    /// The client has the device.
    Imported,
    /// The client did not get the device; the rest of the output is to be sent.
    Refused,
    /// The client had the device, which has gone; the rest of the output is to be sent.
    Lost,
}

/// A session with a client.
#[derive(Debug)]
pub struct Session {
    stage: Stage,
    input: Vec<u8>,
    output: Vec<u8>,
    /// Instant at which the question is answered, even without a device.
    deadline_ns: Option<u64>,
    waiting: VecDeque<Submit>,
    pending: HashMap<TransferId, Pending>,
}

impl Default for Session {
    fn default() -> Self {
        let (waiting, pending) = (VecDeque::new(), HashMap::new());
        Self { stage: Stage::Asking, input: Vec::new(), output: Vec::new(), deadline_ns: None, waiting, pending }
    }
}

impl Session {
    /// Takes received bytes as input.
    pub fn receive(&mut self, bytes: &[u8]) {
        self.input.extend(bytes);
    }

    /// Received bytes that no packet has been read from yet.
    #[must_use]
    pub const fn unread(&self) -> usize {
        self.input.len()
    }

    /// Returns the bytes that are to go to the client.
    pub const fn output(&mut self) -> &mut Vec<u8> {
        &mut self.output
    }

    /// Whether the client has the device.
    #[must_use]
    pub fn has_device(&self) -> bool {
        self.stage == Stage::Imported
    }

    /// Whether the connection may be closed once everything is sent.
    #[must_use]
    pub fn is_over(&self) -> bool {
        matches!(self.stage, Stage::Refused | Stage::Lost)
    }

    /// Whether the device has gone while the client had it.
    #[must_use]
    pub fn had_device(&self) -> bool {
        self.stage == Stage::Lost
    }

    /// Answers a client that has no device. `others` is the refusal because another computer has the device.
    /// Returns whether the answer needs the cable plugged in.
    ///
    /// # Errors
    /// The client does not speak the protocol.
    pub fn answer(&mut self, hub: &Hub, now_ns: u64, others: Option<Refusal>) -> Result<bool, String> {
        if self.stage != Stage::Asking {
            return Ok(false);
        }
        let Some((operation, length)) = packet::operation(&self.input)? else { return Ok(false) };
        let found = hub.found().filter(|_| hub.is_ready());
        let deadline_ns = *self.deadline_ns.get_or_insert(now_ns + PATIENCE_NS);
        let refusal = match others {
            _ if hub.is_unusable() => Some(Refusal::Unusable),
            None if found.is_none() && now_ns >= deadline_ns => Some(Refusal::Absent),
            others => others,
        };
        let device = match (refusal, found) {
            (Some(refusal), _) => Err(refusal),
            (None, Some(found)) => Ok(found),
            (None, None) => return Ok(true),
        };
        let configuration = hub.configuration_value();
        let (answer, stage) = match operation {
            Operation::List => (packet::list(device.ok(), BUSID, configuration), Stage::Asking),
            Operation::Import(name) => {
                let device = if name == BUSID { device } else { Err(Refusal::Absent) };
                let stage = if device.is_ok() { Stage::Imported } else { Stage::Refused };
                (packet::imported(device, BUSID, configuration), stage)
            }
        };
        self.output.extend(answer);
        self.stage = stage;
        self.deadline_ns = None;
        self.input.drain(..length);
        Ok(false)
    }

    /// Serves the client's commands and ended transfers, while it has the device.
    ///
    /// # Errors
    /// The client does not speak the protocol.
    pub fn serve<F: Function>(&mut self, root: &mut Root<'_, F>, completions: Vec<Completion>) -> Result<(), String> {
        for ended in completions {
            self.end(root, ended);
        }
        if self.stage != Stage::Imported {
            return Ok(());
        }
        if root.hub.found().is_none() {
            // Waiting transfers end as well. A client takes the end of the connection for the device's.
            for submit in std::mem::take(&mut self.waiting) {
                self.output.extend(packet::submitted(submit.sequence, error::SHUTDOWN, 0, &[]));
            }
            self.stage = Stage::Lost;
            return Ok(());
        }
        self.catch_up(root);
        while let Some((command, length)) = packet::command(&self.input)? {
            self.input.drain(..length);
            match command {
                Command::Submit(submit) => self.waiting.push_back(submit),
                Command::Unlink(sequence, of) => self.unlink(root, sequence, of),
            }
            self.catch_up(root);
        }
        Ok(())
    }

    fn catch_up<F: Function>(&mut self, root: &mut Root<'_, F>) {
        while root.hub.is_ready()
            && let Some(submit) = self.waiting.pop_front()
        {
            let sequence = submit.sequence;
            if let Err(status) = self.start(root, submit) {
                self.output.extend(packet::submitted(sequence, status, 0, &[]));
            }
        }
    }

    /// Starts a transfer, or returns the error number it has ended with already.
    fn start<F: Function>(&mut self, root: &mut Root<'_, F>, submit: Submit) -> Result<(), i32> {
        let length = submit.length as usize;
        let address = submit.endpoint | if submit.input { 0x80 } else { 0 };
        let endpoint = root.hub.endpoint(address).ok_or(error::NOENT)?;
        if submit.isochronous {
            return Err(error::INVAL);
        }
        let setup = (endpoint.kind == Kind::Control).then_some(Setup::parse(submit.setup));
        let needs = if submit.input && submit.flags & SHORT_NOT_OK != 0 { length } else { 0 };
        let request = match setup {
            Some(Setup { kind: request::DEVICE_OUT, request: request::SET_ADDRESS, .. }) => return Err(0),
            Some(Setup { kind: TO_PORT, request: request::SET_FEATURE, value: PORT_RESET, .. }) => {
                root.reset();
                return Err(0);
            }
            Some(setup) if usize::from(setup.length) != length || setup.reads() && !submit.input => {
                return Err(error::INVAL);
            }
            Some(_) => Request::Control { setup: submit.setup, data: submit.data },
            None if endpoint.direction == Direction::In => Request::In(length),
            None => Request::Out { data: submit.data, zero: submit.flags & ZERO_PACKET != 0 },
        };
        let transfer = root.submit(endpoint, request);
        self.pending.insert(transfer, Pending { sequence: submit.sequence, setup, needs, unlinked: None });
        Ok(())
    }

    fn unlink<F: Function>(&mut self, root: &mut Root<'_, F>, sequence: u32, of: u32) {
        if let Some(place) = self.waiting.iter().position(|submit| submit.sequence == of) {
            self.waiting.remove(place);
            return self.output.extend(packet::unlinked(sequence, error::CONNRESET));
        }
        match self.pending.iter_mut().find(|(_, pending)| pending.sequence == of) {
            Some((transfer, pending)) => {
                pending.unlinked = Some(sequence);
                root.cancel(*transfer);
            }
            // The transfer has ended before the unlink.
            None => self.output.extend(packet::unlinked(sequence, 0)),
        }
    }

    /// Answers the command of an ended transfer.
    fn end<F: Function>(&mut self, root: &mut Root<'_, F>, ended: Completion) {
        let Some(pending) = self.pending.remove(&ended.id) else { return };
        if ended.outcome == Outcome::Done
            && let Some(setup) = pending.setup
        {
            root.follow(setup);
        }
        match pending.unlinked {
            // An unlinked transfer gets no answer of its own, only the unlink command does.
            Some(sequence) if ended.outcome == Outcome::Cancelled => {
                self.output.extend(packet::unlinked(sequence, error::CONNRESET));
            }
            unlinked => {
                let status = status_of(ended.outcome, ended.actual < pending.needs);
                let answer = packet::submitted(pending.sequence, status, ended.actual as u32, &ended.data);
                self.output.extend(answer);
                if let Some(sequence) = unlinked {
                    self.output.extend(packet::unlinked(sequence, 0));
                }
            }
        }
    }
}

const fn status_of(outcome: Outcome, short: bool) -> i32 {
    match outcome {
        Outcome::Done if short => error::REMOTEIO,
        Outcome::Done => 0,
        Outcome::Stalled => error::PIPE,
        Outcome::Failed => error::PROTO,
        Outcome::Babble => error::OVERFLOW,
        Outcome::Cancelled => error::CONNRESET,
        Outcome::Gone => error::SHUTDOWN,
    }
}
