//! Requests of a peer as transfers, and ended transfers as answers.

use super::message::{BulkHead, ControlHead, Message, Status};
use crate::hub::Hub;
use crate::request::{self, Setup};
use crate::transfer::{Completion, Direction, Endpoint, Kind, Outcome, Request};

/// Request that a transfer under way belongs to.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Pending {
    /// A control packet, with its identifier and head.
    Control(u64, ControlHead),
    /// A selection of a configuration or setting, which has a message of its own.
    Selection(u64, Setup),
    /// A bulk packet, with its identifier and head.
    Bulk(u64, BulkHead),
    /// A packet to an interrupt endpoint, with its identifier.
    Interrupt(u64, u8),
    /// Polling of this interrupt endpoint for its next packet.
    Receiving(u8),
}

impl Pending {
    /// Returns the identifier that has to be answered.
    pub const fn id(&self) -> Option<u64> {
        match self {
            Self::Control(id, _) | Self::Selection(id, _) | Self::Bulk(id, _) | Self::Interrupt(id, _) => Some(*id),
            Self::Receiving(_) => None,
        }
    }

    /// Returns the SETUP packet of a control transfer.
    pub const fn setup(&self) -> Option<Setup> {
        match self {
            Self::Control(_, head) => Some(setup_of(head)),
            Self::Selection(_, setup) => Some(*setup),
            _ => None,
        }
    }
}

/// Fate of a request.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Begun {
    /// The request becomes a transfer.
    Transfer(Endpoint, Request, Pending),
    /// The request is answered at once with this status.
    Refused(Status),
}

const fn setup_of(head: &ControlHead) -> Setup {
    Setup { kind: head.kind, request: head.request, value: head.value, index: head.index, length: head.length }
}

/// Returns the SETUP packet that a message for a selection stands for.
const fn selection(message: &Message) -> Option<Setup> {
    let (kind, request, value, index, length) = match message {
        Message::SetConfiguration { configuration } => {
            (request::DEVICE_OUT, request::SET_CONFIGURATION, *configuration, 0, 0)
        }
        Message::GetConfiguration => (request::DEVICE_IN, request::GET_CONFIGURATION, 0, 0, 1),
        Message::SetAltSetting { interface, alt } => {
            (request::INTERFACE_OUT, request::SET_INTERFACE, *alt, *interface, 0)
        }
        Message::GetAltSetting { interface } => (request::INTERFACE_IN, request::GET_INTERFACE, 0, *interface, 1),
        _ => return None,
    };
    Some(Setup { kind, request, value: value as u16, index: index as u16, length })
}

/// Turns a request into a transfer, or refuses it.
pub fn begin(hub: &Hub, id: u64, message: &Message) -> Begun {
    match message {
        Message::ControlPacket(head, data) => control(hub, id, head, data),
        Message::BulkPacket(head, data) => bulk(hub, id, head, data),
        Message::InterruptPacket { endpoint, length, data, .. } => {
            let known = hub.endpoint(*endpoint).filter(|one| matches!(one.kind, Kind::Interrupt { .. }));
            match known.filter(|one| one.direction == Direction::Out && data.len() == usize::from(*length)) {
                Some(known) => {
                    let request = Request::Out { data: data.clone(), zero: false };
                    Begun::Transfer(known, request, Pending::Interrupt(id, *endpoint))
                }
                None => Begun::Refused(Status::Invalid),
            }
        }
        _ => match (selection(message), hub.endpoint(0)) {
            (Some(setup), Some(endpoint)) => {
                let request = Request::Control { setup: setup.bytes(), data: Vec::new() };
                Begun::Transfer(endpoint, request, Pending::Selection(id, setup))
            }
            _ => Begun::Refused(Status::Invalid),
        },
    }
}

fn control(hub: &Hub, id: u64, head: &ControlHead, data: &[u8]) -> Begun {
    let setup = setup_of(head);
    if (setup.kind, setup.request) == (request::DEVICE_OUT, request::SET_ADDRESS) {
        // SET_ADDRESS is left to the hub, which has given the address.
        return Begun::Refused(Status::Success);
    }
    let expected = if setup.reads() { 0 } else { usize::from(setup.length) };
    let endpoint = hub.endpoint(0).filter(|_| head.endpoint & 0x7F == 0 && data.len() == expected);
    endpoint.map_or(Begun::Refused(Status::Invalid), |endpoint| {
        let request = Request::Control { setup: setup.bytes(), data: data.to_vec() };
        Begun::Transfer(endpoint, request, Pending::Control(id, *head))
    })
}

fn bulk(hub: &Hub, id: u64, head: &BulkHead, data: &[u8]) -> Begun {
    let length = head.length as usize;
    let Some(endpoint) = hub.endpoint(head.endpoint).filter(|one| one.kind == Kind::Bulk && head.stream == 0) else {
        return Begun::Refused(Status::Invalid);
    };
    let request = match endpoint.direction {
        Direction::In if data.is_empty() => Request::In(length),
        Direction::Out if data.len() == length => Request::Out { data: data.to_vec(), zero: false },
        _ => return Begun::Refused(Status::Invalid),
    };
    Begun::Transfer(endpoint, request, Pending::Bulk(id, *head))
}

/// Returns the answer to a request that does not become a transfer; none if the message has no answer.
pub fn refuse(message: &Message, status: Status) -> Option<Message> {
    let status = status as u8;
    Some(match *message {
        Message::ControlPacket(head, _) => {
            Message::ControlPacket(ControlHead { status, length: 0, ..head }, Vec::new())
        }
        Message::BulkPacket(head, _) => Message::BulkPacket(BulkHead { status, length: 0, ..head }, Vec::new()),
        Message::InterruptPacket { endpoint, .. } => {
            Message::InterruptPacket { endpoint, status, length: 0, data: Vec::new() }
        }
        Message::SetConfiguration { configuration } => Message::ConfigurationStatus { status, configuration },
        Message::GetConfiguration => Message::ConfigurationStatus { status, configuration: 0 },
        Message::SetAltSetting { interface, alt } => Message::AltSettingStatus { status, interface, alt },
        Message::GetAltSetting { interface } => Message::AltSettingStatus { status, interface, alt: 0 },
        Message::StartIsoStream { endpoint } | Message::StopIsoStream { endpoint } => {
            Message::IsoStreamStatus { status, endpoint }
        }
        Message::StartInterruptReceiving { endpoint } | Message::StopInterruptReceiving { endpoint } => {
            Message::InterruptReceivingStatus { status, endpoint }
        }
        _ => return None,
    })
}

const fn status_of(outcome: Outcome) -> Status {
    match outcome {
        Outcome::Done => Status::Success,
        Outcome::Stalled => Status::Stall,
        Outcome::Failed => Status::IoError,
        Outcome::Babble => Status::Babble,
        Outcome::Cancelled | Outcome::Gone => Status::Cancelled,
    }
}

/// Returns the answer to a request whose transfer has ended.
pub fn answer(pending: Pending, ended: Completion) -> Option<(u64, Message)> {
    let status = status_of(ended.outcome) as u8;
    let said = ended.data.first().copied().unwrap_or(0);
    Some(match pending {
        Pending::Control(id, head) => {
            let head = ControlHead { status, length: ended.actual as u16, ..head };
            (id, Message::ControlPacket(head, ended.data))
        }
        Pending::Bulk(id, head) => {
            let head = BulkHead { status, length: ended.actual as u32, ..head };
            (id, Message::BulkPacket(head, ended.data))
        }
        Pending::Interrupt(id, endpoint) => {
            let length = ended.actual as u16;
            (id, Message::InterruptPacket { endpoint, status, length, data: Vec::new() })
        }
        Pending::Selection(id, setup) => (id, selected(setup, status, said)),
        Pending::Receiving(_) => return None,
    })
}

/// Returns the answer to a request that has messages of its own.
const fn selected(setup: Setup, status: u8, said: u8) -> Message {
    let (interface, told) = (setup.index as u8, setup.value as u8);
    match setup.request {
        request::SET_CONFIGURATION => Message::ConfigurationStatus { status, configuration: told },
        request::GET_CONFIGURATION => Message::ConfigurationStatus { status, configuration: said },
        request::SET_INTERFACE => Message::AltSettingStatus { status, interface, alt: told },
        _ => Message::AltSettingStatus { status, interface, alt: said },
    }
}
