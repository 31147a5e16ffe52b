//! Simulated host: control and bulk transfers as a host controller makes them, including data toggles.

use std::collections::BTreeMap;

use super::bus::{Bus, Event, Handshake};
use super::device::Device;

/// Number of NAKs before a transfer is given up.
const PATIENCE: usize = 300;

/// Failure of a transfer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Failure {
    /// The endpoint is halted.
    Stall,
    /// The device answered NAK all the time.
    Timeout,
}

/// Request on endpoint 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Request {
    pub kind: u8,
    pub request: u8,
    pub value: u16,
    pub index: u16,
    pub length: u16,
}

impl Request {
    pub const fn new(kind: u8, request: u8, value: u16, index: u16, length: u16) -> Self {
        Self { kind, request, value, index, length }
    }

    pub fn bytes(self) -> [u8; 8] {
        let Self { kind, request, value, index, length } = self;
        let [v0, v1] = value.to_le_bytes();
        let [i0, i1] = index.to_le_bytes();
        let [l0, l1] = length.to_le_bytes();
        [kind, request, v0, v1, i0, i1, l0, l1]
    }

    pub const fn is_in(self) -> bool {
        self.kind & 0x80 != 0
    }
}

/// Host with a single device at its port.
pub struct Host<D> {
    pub bus: Bus,
    pub device: D,
    /// Data toggles that the host keeps, by endpoint address.
    toggles: BTreeMap<u8, bool>,
}

impl<D: Device> Host<D> {
    pub fn new(bus: Bus, device: D) -> Self {
        assert!(bus.wire().is_enabled, "the device has not connected");
        Self { bus, device, toggles: BTreeMap::new() }
    }

    fn run(&mut self) {
        self.device.run();
    }

    /// Lets the device run for a while.
    pub fn device_runs(&mut self) {
        for _ in 0..20 {
            self.device.run();
        }
    }

    fn toggle(&mut self, address: u8) -> &mut bool {
        self.toggles.entry(address).or_default()
    }

    // --- the bus ---

    pub fn event(&mut self, event: Event) {
        if event == Event::Reset {
            self.toggles.clear();
        }
        self.bus.wire().event(event);
        self.run();
    }

    pub fn reset(&mut self) {
        self.event(Event::Reset);
    }

    /// Enumerates the device as a host does: reset, address, configuration.
    pub fn enumerate(&mut self) {
        self.reset();
        self.out(Request::new(0x00, 5, 9, 0, 0), &[]).unwrap();
        assert_eq!(self.bus.wire().address, 9);
        self.out(Request::new(0x00, 9, 1, 0, 0), &[]).unwrap();
    }

    // --- control transfers ---

    /// Sends a request without data, or with data for the device.
    pub fn out(&mut self, request: Request, data: &[u8]) -> Result<(), Failure> {
        assert!(!request.is_in());
        self.bus.wire().setup(request.bytes());
        self.run();
        let chunks = data.chunks(64);
        for chunk in chunks {
            self.out_packet(0, chunk)?;
            self.run();
        }
        let status = self.in_packet(0)?;
        assert!(status.is_empty(), "a status stage with data");
        self.run();
        self.follow(request);
        Ok(())
    }

    /// Sends a request for data, and returns the data.
    pub fn ask(&mut self, request: Request) -> Result<Vec<u8>, Failure> {
        assert!(request.is_in());
        self.bus.wire().setup(request.bytes());
        self.run();
        let mut data = Vec::new();
        while data.len() < usize::from(request.length) {
            let packet = self.in_packet(0)?;
            self.run();
            data.extend_from_slice(&packet);
            if packet.len() < 64 {
                break;
            }
        }
        assert!(data.len() <= usize::from(request.length), "more than asked for");
        self.out_packet(0, &[])?;
        self.run();
        Ok(data)
    }

    /// Resets data toggles as a host does behind certain requests.
    fn follow(&mut self, request: Request) {
        match request {
            Request { kind: 0x02, request: 1, value: 0, index, .. } => *self.toggle(index as u8) = false,
            Request { kind: 0x00, request: 9, .. } => self.toggles.clear(),
            // Bulk endpoints of the interfaces of both ports and the disk.
            Request { kind: 0x01, request: 11, index, .. } => {
                let endpoints: &[u8] = match index {
                    1 => &[0x81, 0x01],
                    3 => &[0x83, 0x02],
                    4 => &[0x85, 0x03],
                    _ => &[],
                };
                endpoints.iter().for_each(|address| *self.toggle(*address) = false);
            }
            _ => {}
        }
    }

    pub fn descriptor(&mut self, kind: u8, index: u8, length: u16) -> Result<Vec<u8>, Failure> {
        let language = if kind == 3 && index > 0 { 0x0409 } else { 0 };
        self.ask(Request::new(0x80, 6, u16::from_be_bytes([kind, index]), language, length))
    }

    pub fn clear_halt(&mut self, address: u8) {
        self.out(Request::new(0x02, 1, 0, address.into(), 0), &[]).unwrap();
    }

    pub fn is_halted(&mut self, address: u8) -> bool {
        self.ask(Request::new(0x82, 0, 0, address.into(), 2)).unwrap() == [1, 0]
    }

    // --- packets ---

    /// Fetches a packet from the device.
    pub fn in_packet(&mut self, number: u8) -> Result<Vec<u8>, Failure> {
        for _ in 0..PATIENCE {
            if let Some(packet) = self.try_in(number)? {
                return Ok(packet);
            }
        }
        Err(Failure::Timeout)
    }

    /// Tries to fetch a packet; `None` for NAK.
    pub fn try_in(&mut self, number: u8) -> Result<Option<Vec<u8>>, Failure> {
        let toggle = *self.toggle(0x80 | number);
        let handshake = self.bus.wire().token_in(number, toggle);
        self.run();
        match handshake {
            Handshake::Data(packet) => {
                *self.toggle(0x80 | number) ^= true;
                Ok(Some(packet))
            }
            Handshake::Stall => Err(Failure::Stall),
            _ => Ok(None),
        }
    }

    /// Sends a packet to the device.
    pub fn out_packet(&mut self, number: u8, packet: &[u8]) -> Result<(), Failure> {
        for _ in 0..PATIENCE {
            if self.try_out(number, packet)? {
                return Ok(());
            }
        }
        Err(Failure::Timeout)
    }

    /// Tries to send a packet; false for NAK.
    pub fn try_out(&mut self, number: u8, packet: &[u8]) -> Result<bool, Failure> {
        let toggle = *self.toggle(number);
        let handshake = self.bus.wire().token_out(number, packet, toggle);
        self.run();
        match handshake {
            Handshake::Ack => {
                *self.toggle(number) ^= true;
                Ok(true)
            }
            Handshake::Stall => Err(Failure::Stall),
            _ => Ok(false),
        }
    }

    // --- bulk transfers ---

    /// Sends all data; a failure includes the number of bytes sent before.
    pub fn bulk_out(&mut self, number: u8, data: &[u8]) -> Result<(), (usize, Failure)> {
        for (index, packet) in data.chunks(64).enumerate() {
            self.out_packet(number, packet).map_err(|failure| (index * 64, failure))?;
        }
        Ok(())
    }

    /// Fetches this number of bytes, or up to a short packet; a failure includes the bytes received before.
    pub fn bulk_in(&mut self, number: u8, length: usize) -> Result<Vec<u8>, (Vec<u8>, Failure)> {
        let mut data = Vec::new();
        while data.len() < length {
            match self.in_packet(number) {
                Ok(packet) => {
                    data.extend_from_slice(&packet);
                    if packet.len() < 64 {
                        break;
                    }
                }
                Err(failure) => return Err((data, failure)),
            }
        }
        assert!(data.len() <= length, "babble: {} bytes for {length}", data.len());
        Ok(data)
    }
}
