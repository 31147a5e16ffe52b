//! Tests of packets against their bytes, and of a session with a client on one side and a device on the
//! other.

mod bytes;
mod transfers;

use super::packet::Refusal;
use super::session::{BUSID, Session};
use crate::controller::Controller;
use crate::hub::{Hub, Root};
use crate::mock::{Mock, pass};
use crate::request::{self, Setup};

const MS: u64 = 1_000_000;
/// Operation OP_REQ_DEVLIST as bytes.
const LIST: [u8; 8] = [1, 0x11, 0x80, 5, 0, 0, 0, 0];

/// Encodes operation OP_REQ_IMPORT of a device.
fn import(name: &str) -> Vec<u8> {
    let mut bytes = vec![1, 0x11, 0x80, 3, 0, 0, 0, 0];
    bytes.extend(name.bytes());
    bytes.resize(40, 0);
    bytes
}

/// Encodes words as they go over the wire, big-endian.
fn words(words: &[u32]) -> Vec<u8> {
    words.iter().flat_map(|word| word.to_be_bytes()).collect()
}

/// Encodes a command USBIP_CMD_SUBMIT.
fn submit(sequence: u32, input: bool, endpoint: u32, flags: u32, length: u32, setup: [u8; 8]) -> Vec<u8> {
    let head = [1, sequence, 0x0001_0002, u32::from(input), endpoint, flags, length, 0, u32::MAX, 0];
    [words(&head), setup.to_vec()].concat()
}

/// Takes an answer apart: command, sequence, status and actual length; and the bytes after its head.
fn answer(bytes: &[u8]) -> ([i32; 4], &[u8]) {
    let word = |at: usize| i32::from_be_bytes(bytes[at..at + 4].try_into().unwrap());
    ([word(0), word(4), word(20), word(24)], &bytes[48..])
}

/// A client, the session that looks after it, and a device.
struct Bench {
    session: Session,
    hub: Hub,
    controller: Controller,
    device: Mock,
    now_ns: u64,
    others: Option<Refusal>,
}

impl Bench {
    fn new(device: Mock) -> Self {
        let (hub, controller) = (Hub::default(), Controller::default());
        Self { session: Session::default(), hub, controller, device, now_ns: 0, others: None }
    }

    /// Lets the client import the device.
    fn imported() -> Self {
        let mut bench = Self::new(Mock::connected());
        bench.session.receive(&import(BUSID));
        bench.pass_ms(200);
        assert_eq!(bench.take()[..8], [1, 0x11, 0, 3, 0, 0, 0, 0]);
        assert!(bench.session.has_device());
        bench
    }

    /// Like [`Self::imported`], with configuration 1 selected.
    fn configured() -> Self {
        let mut bench = Self::imported();
        bench.control(1, Setup { kind: 0, request: request::SET_CONFIGURATION, value: 1, index: 0, length: 0 }, &[]);
        bench.pass_ms(2);
        assert_eq!(answer(&bench.take()).0, [3, 1, 0, 0]);
        bench
    }

    fn pass_ms(&mut self, ms: u64) {
        for _ in 0..ms {
            pass(&mut self.controller, &mut self.device, &mut self.now_ns, MS);
            let Self { hub, controller, device, now_ns, session, others } = self;
            let needs_cable = session.answer(hub, *now_ns, *others).unwrap();
            let mut root = Root { hub, controller, device, now_ns: *now_ns };
            if needs_cable {
                root.plug();
            }
            let (_, completions) = root.run();
            session.serve(&mut root, completions).unwrap();
        }
    }

    fn control(&mut self, sequence: u32, setup: Setup, data: &[u8]) {
        let (input, length) = (setup.reads(), u32::from(setup.length));
        self.session.receive(&[submit(sequence, input, 0, 0, length, setup.bytes()), data.to_vec()].concat());
    }

    fn read(&mut self, sequence: u32, flags: u32, length: u32) {
        self.session.receive(&submit(sequence, true, 1, flags, length, [0; 8]));
    }

    fn write(&mut self, sequence: u32, flags: u32, data: &[u8]) {
        let head = submit(sequence, false, 1, flags, data.len() as u32, [0; 8]);
        self.session.receive(&[head, data.to_vec()].concat());
    }

    fn unlink(&mut self, sequence: u32, of: u32) {
        self.session.receive(&words(&[2, sequence, 0x0001_0002, 0, 0, of, 0, 0, 0, 0, 0, 0]));
    }

    /// Takes the bytes for the client.
    fn take(&mut self) -> Vec<u8> {
        std::mem::take(self.session.output())
    }

    /// Takes the bytes for the client, as answers with their data.
    fn answers(&mut self) -> Vec<([i32; 4], Vec<u8>)> {
        let all = self.take();
        let mut rest = &all[..];
        let mut answers = Vec::new();
        while !rest.is_empty() {
            let (head, after) = answer(rest);
            // Data come with answers to IN transfers, whose numbers are from 100 on here.
            let length = if head[0] == 3 && head[1] >= 100 { head[3] as usize } else { 0 };
            answers.push((head, after[..length].to_vec()));
            rest = &after[length..];
        }
        answers
    }
}
