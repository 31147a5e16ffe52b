//! A mock device for the tests of the host's side: a serial port without an image, which takes the bytes it
//! has room for, and sends the packets it is given.

use std::collections::VecDeque;

use super::controller::Controller;
use super::request::{self, Setup};
use super::wire::{Address, Drive, Function, Handshake, Reply, Toggle};

/// Device descriptor: 1D50:6015, release 1.02.
pub const DEVICE: [u8; 18] = [18, 1, 0, 2, 0xEF, 2, 1, 64, 0x50, 0x1D, 0x15, 0x60, 2, 1, 0, 0, 0, 1];
/// Configuration descriptor: bulk 0x01 and 0x81, interrupt 0x82.
pub const CONFIGURATION: [u8; 48] = [
    9, 2, 48, 0, 2, 1, 0, 0xC0, 50, // configuration 1
    9, 4, 0, 0, 1, 2, 2, 1, 0, // interface 0, communication
    7, 5, 0x82, 3, 16, 0, 16, // notifications
    9, 4, 1, 0, 2, 10, 0, 0, 0, // interface 1, data
    7, 5, 0x01, 2, 64, 0, 0, 7, 5, 0x81, 2, 64, 0, 0,
];
/// A vendor request that the mock device accepts and never completes.
pub const FOR_EVER: Setup = Setup { kind: 0x40, request: 0x7F, value: 0, index: 0, length: 0 };

/// The mock device's state.
#[derive(Debug, Default)]
pub struct Mock {
    /// Whether D+ is pulled up.
    pub connected: bool,
    /// Bytes that the bulk OUT endpoint still takes.
    pub room: usize,
    /// Bytes that the bulk OUT endpoint took.
    pub heard: Vec<u8>,
    /// Packets for the bulk IN endpoint.
    pub to_say: VecDeque<Vec<u8>>,
    /// Packets for the interrupt IN endpoint.
    pub to_notify: VecDeque<Vec<u8>>,
    /// Whether both bulk endpoints answer STALL.
    pub halted: bool,
    /// The device answers nothing at all.
    pub dead: bool,
    /// The selected configuration's number.
    pub configuration: u8,
    /// Number of bus resets seen.
    pub resets: u32,
    /// Data of the control writes.
    pub written: Vec<u8>,
    address: u8,
    setup: Option<Setup>,
    answer: Option<VecDeque<u8>>,
    toggles: [Toggle; 4],
    stirred: bool,
}

/// Places of the endpoints in `toggles`.
const CONTROL: usize = 0;
const OUT: usize = 1;
const IN: usize = 2;
const NOTIFY: usize = 3;

impl Mock {
    /// Returns a device that pulls up D+.
    pub fn connected() -> Self {
        Self { connected: true, room: usize::MAX, ..Self::default() }
    }

    fn obey(&mut self, setup: Setup) -> Option<VecDeque<u8>> {
        let [kind, index] = setup.value.to_be_bytes();
        let said: Vec<u8> = match (setup.kind, setup.request) {
            (request::DEVICE_IN, request::GET_DESCRIPTOR) => match (kind, index) {
                (request::DEVICE, 0) => DEVICE.to_vec(),
                (request::CONFIGURATION, 0) => CONFIGURATION.to_vec(),
                _ => return None,
            },
            (request::DEVICE_IN, request::GET_CONFIGURATION) => vec![self.configuration],
            (request::INTERFACE_IN, request::GET_INTERFACE) => vec![0],
            (request::DEVICE_OUT, request::SET_ADDRESS) => Vec::new(),
            (request::DEVICE_OUT, request::SET_CONFIGURATION) if setup.value <= 1 => {
                self.configuration = index;
                self.toggles = [Toggle::Data0; 4];
                Vec::new()
            }
            (request::ENDPOINT_OUT, request::CLEAR_FEATURE) => {
                self.halted = false;
                self.toggles[OUT] = Toggle::Data0;
                self.toggles[IN] = Toggle::Data0;
                Vec::new()
            }
            (request::INTERFACE_OUT, request::SET_INTERFACE) => Vec::new(),
            (request::CLASS_OUT, _) => Vec::new(),
            _ if setup == FOR_EVER => Vec::new(),
            _ => return None,
        };
        Some(said.into_iter().take(usize::from(setup.length)).collect())
    }

    fn next_packet(&self, endpoint: u8) -> Option<Vec<u8>> {
        match endpoint {
            0 => {
                let setup = self.setup.filter(|setup| *setup != FOR_EVER)?;
                let answer = self.answer.as_ref()?;
                Some(if setup.reads() { answer.iter().take(64).copied().collect() } else { Vec::new() })
            }
            1 => self.to_say.front().cloned(),
            2 => self.to_notify.front().cloned(),
            _ => None,
        }
    }
}

impl Function for Mock {
    fn pulls_up(&self) -> bool {
        self.connected
    }

    fn wakes(&self) -> bool {
        false
    }

    fn port(&mut self, _: u64, drive: Drive) {
        if drive == Drive::Reset {
            self.resets += 1;
            self.address = 0;
            self.configuration = 0;
            self.setup = None;
        }
    }

    fn start_of_frame(&mut self, _: u64, _: u16) {}

    fn setup(&mut self, to: Address, packet: [u8; 8]) -> Handshake {
        if to.device != self.address || self.dead {
            return Handshake::Nothing;
        }
        let setup = Setup::parse(packet);
        self.toggles[CONTROL] = Toggle::Data1;
        self.answer = self.obey(setup);
        self.setup = Some(setup);
        self.written.clear();
        self.stirred = true;
        Handshake::Ack
    }

    fn out(&mut self, to: Address, toggle: Toggle, data: &[u8]) -> Handshake {
        match to.endpoint {
            _ if to.device != self.address || self.dead => Handshake::Nothing,
            0 if self.answer.is_none() => Handshake::Stall,
            0 => {
                self.written.extend(data);
                Handshake::Ack
            }
            _ if self.configuration == 0 => Handshake::Nothing,
            _ if self.halted => Handshake::Stall,
            _ if data.len() > self.room => Handshake::Nak,
            _ => {
                if toggle == self.toggles[OUT] {
                    self.toggles[OUT] = toggle.flipped();
                    self.room -= data.len();
                    self.heard.extend(data);
                }
                Handshake::Ack
            }
        }
    }

    fn poll(&mut self, from: Address) -> Reply {
        let place = [CONTROL, IN, NOTIFY][usize::from(from.endpoint)];
        if from.device != self.address || self.dead || (place != CONTROL && self.configuration == 0) {
            return Reply::Nothing;
        }
        if place == IN && self.halted || place == CONTROL && self.answer.is_none() {
            return Reply::Stall;
        }
        self.next_packet(from.endpoint).map_or(Reply::Nak, |packet| Reply::Data(self.toggles[place], packet))
    }

    fn acknowledge(&mut self, from: Address) {
        let place = [CONTROL, IN, NOTIFY][usize::from(from.endpoint)];
        self.toggles[place] = self.toggles[place].flipped();
        match from.endpoint {
            0 => {
                if let Some(answer) = &mut self.answer {
                    answer.drain(..answer.len().min(64));
                }
                if let Some(setup) = self.setup.filter(|setup| setup.request == request::SET_ADDRESS && setup.kind == 0)
                {
                    self.address = setup.value as u8;
                }
            }
            1 => drop(self.to_say.pop_front()),
            _ => drop(self.to_notify.pop_front()),
        }
    }

    fn stirred(&mut self) -> bool {
        std::mem::take(&mut self.stirred)
    }
}

/// Runs the bus for so many nanoseconds.
pub fn pass(controller: &mut Controller, device: &mut Mock, now_ns: &mut u64, nanoseconds: u64) {
    let end = *now_ns + nanoseconds;
    controller.run(*now_ns, device);
    while let Some(next) = controller.next().filter(|&next| next <= end) {
        *now_ns = next;
        controller.run(next, device);
    }
    *now_ns = end;
    controller.run(end, device);
}
