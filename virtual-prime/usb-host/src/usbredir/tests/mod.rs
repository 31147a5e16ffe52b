//! Tests of messages against their bytes, and of a session with a peer on one side and a device on the other.

mod bytes;
mod device;
mod faults;
mod transfers;

use super::message::{BulkHead, Capabilities, ControlHead, Message};
use super::session::Session;
use super::stream::Stream;
use crate::controller::Controller;
use crate::hub::{Hub, Root};
use crate::mock::{Mock, pass};
use crate::request::{self, Setup};

const MS: u64 = 1_000_000;
/// Capabilities of QEMU 7.2.
const QEMU: Capabilities = Capabilities(0xFF);

/// A peer, the session that looks after it, and a device.
struct Bench {
    session: Session,
    peer: Stream,
    hub: Hub,
    controller: Controller,
    device: Mock,
    now_ns: u64,
    /// Messages to the peer that no test has looked at yet.
    told: Vec<(u64, Message)>,
}

impl Bench {
    /// Starts with no message sent by either side.
    fn new(device: Mock) -> Self {
        Self::of(device, QEMU)
    }

    fn of(device: Mock, peer: Capabilities) -> Self {
        Self {
            session: Session::default(),
            peer: Stream::new("peer", peer),
            hub: Hub::default(),
            controller: Controller::default(),
            device,
            now_ns: 0,
            told: Vec::new(),
        }
    }

    /// Plugs the device in, and announces it to the peer.
    fn announced() -> Self {
        let mut bench = Self::new(Mock::connected());
        bench.root().plug();
        bench.pass_ms(200);
        assert_eq!(bench.kinds(), [4, 5, 1], "interfaces, endpoints, connection");
        bench
    }

    /// Like [`Self::announced`], with configuration 1 selected.
    fn configured() -> Self {
        let mut bench = Self::announced();
        bench.say(1, &Message::SetConfiguration { configuration: 1 });
        bench.pass_ms(3);
        assert_eq!(bench.kinds(), [4, 5, 8], "interfaces, endpoints, status");
        bench
    }

    fn root(&mut self) -> Root<'_, Mock> {
        let Self { hub, controller, device, now_ns, .. } = self;
        Root { hub, controller, device, now_ns: *now_ns }
    }

    fn try_pass(&mut self, ms: u64) -> Result<(), String> {
        for _ in 0..ms {
            pass(&mut self.controller, &mut self.device, &mut self.now_ns, MS);
            self.session.stream().receive(&std::mem::take(self.peer.output()));
            let Self { hub, controller, device, now_ns, session, .. } = self;
            let mut root = Root { hub, controller, device, now_ns: *now_ns };
            let (_, completions) = root.run();
            session.serve(&mut root, completions).map_err(|why| why.to_string())?;
            self.peer.receive(&std::mem::take(self.session.stream().output()));
            while let Some(message) = self.peer.take_message().map_err(|why| why.to_string())? {
                if !matches!(message.1, Message::Hello(..)) {
                    self.told.push(message);
                }
            }
        }
        Ok(())
    }

    #[track_caller]
    fn pass_ms(&mut self, ms: u64) {
        self.try_pass(ms).expect("both speak the protocol");
    }

    fn say(&mut self, id: u64, message: &Message) {
        self.peer.send(id, message);
    }

    fn read(&mut self, id: u64, length: u32) {
        let head = BulkHead { endpoint: 0x81, status: 0xEE, length, stream: 0 };
        self.say(id, &Message::BulkPacket(head, Vec::new()));
    }

    fn write(&mut self, id: u64, data: &[u8]) {
        let head = BulkHead { endpoint: 1, status: 0xEE, length: data.len() as u32, stream: 0 };
        self.say(id, &Message::BulkPacket(head, data.to_vec()));
    }

    fn control(&mut self, id: u64, setup: Setup, data: &[u8]) {
        let Setup { kind, request, value, index, length } = setup;
        let head = ControlHead { endpoint: kind & 0x80, request, kind, status: 0xEE, value, index, length };
        self.say(id, &Message::ControlPacket(head, data.to_vec()));
    }

    /// Returns the kinds of all messages to the peer and forgets the messages.
    fn kinds(&mut self) -> Vec<u32> {
        self.told.drain(..).map(|(_, message)| message.kind()).collect()
    }

    /// Returns the answers with an identifier: identifier, status, bytes.
    fn answers(&mut self) -> Vec<(u64, u8, Vec<u8>)> {
        let bare = |(id, message)| match message {
            Message::ControlPacket(head, data) => (id, head.status, data),
            Message::BulkPacket(head, data) => (id, head.status, data),
            Message::InterruptPacket { status, data, .. } => (id, status, data),
            Message::ConfigurationStatus { status, configuration } => (id, status, vec![configuration]),
            Message::AltSettingStatus { status, interface, alt } => (id, status, vec![interface, alt]),
            Message::InterruptReceivingStatus { status, endpoint } => (id, status, vec![endpoint]),
            other => panic!("{other:?}"),
        };
        self.told.drain(..).map(bare).collect()
    }
}

/// Builds a request for a descriptor.
const fn descriptor(kind: u8, length: u16) -> Setup {
    let value = (kind as u16) << 8;
    Setup { kind: request::DEVICE_IN, request: request::GET_DESCRIPTOR, value, index: 0, length }
}
