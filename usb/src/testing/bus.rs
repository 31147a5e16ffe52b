//! Bus in memory, by transactions: the behaviour of the board's controller, without registers.
//!
//! The guarantees that all buses give to classes hold here too: a request drops the data of endpoint 0;
//! halting an endpoint drops its packets, and it takes nothing until the halt ends; ending a halt, even of an
//! endpoint that is not halted, resets its data toggle and drops packets to be sent; a packet that is too
//! long for its reader is dropped; a reset keeps packets that bulk endpoints have acknowledged; packets that
//! wait to be fetched do not wake a device on a silent bus.

use std::collections::{BTreeMap, VecDeque};
use std::sync::{Arc, Mutex, MutexGuard};

use usb_device::bus::{PollResult, UsbBus};
use usb_device::endpoint::{EndpointAddress, EndpointType};
use usb_device::{Result, UsbDirection, UsbError};

/// Packets of the host that an endpoint holds before it answers NAK.
const BUFFERS: usize = 2;

/// State of an endpoint.
#[derive(Debug, Default)]
pub struct Endpoint {
    /// Packets in the endpoint, oldest first.
    pub packets: VecDeque<Vec<u8>>,
    /// Whether the endpoint is halted.
    pub is_halted: bool,
    /// Data toggle of the next packet.
    pub toggle: bool,
}

/// State that both ends of the bus share.
#[derive(Debug, Default)]
pub struct Wire {
    /// Endpoints by their address.
    pub endpoints: BTreeMap<u8, Endpoint>,
    /// Request that the device has not fetched.
    pub setup: Option<[u8; 8]>,
    /// Address of the device.
    pub address: u8,
    /// Endpoints whose packet the host has taken, one bit each.
    complete: u16,
    events: VecDeque<Event>,
    is_silent: bool,
    /// Whether the device has connected.
    pub is_enabled: bool,
}

/// Events of the bus beside packets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Event {
    Reset,
    Suspend,
    Resume,
}

/// Device's end of the bus.
#[derive(Clone, Default)]
pub struct Bus(Arc<Mutex<Wire>>);

/// Answer of a device to a token.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Handshake {
    Data(Vec<u8>),
    Ack,
    Nak,
    Stall,
}

impl Bus {
    pub fn wire(&self) -> MutexGuard<'_, Wire> {
        self.0.lock().unwrap()
    }

    /// Returns the number of packets that an endpoint holds.
    pub fn held(&self, endpoint: EndpointAddress) -> usize {
        self.wire().endpoint(endpoint.into()).map_or(0, |endpoint| endpoint.packets.len())
    }
}

impl Wire {
    fn endpoint(&mut self, address: u8) -> Option<&mut Endpoint> {
        self.endpoints.get_mut(&address)
    }

    // --- the host's end ---

    pub fn event(&mut self, event: Event) {
        if event == Event::Reset {
            self.drop_everything();
        }
        self.events.push_back(event);
    }

    fn drop_everything(&mut self) {
        for (address, endpoint) in &mut self.endpoints {
            let packets =
                if matches!(address, 0 | 0x80..) { VecDeque::new() } else { core::mem::take(&mut endpoint.packets) };
            *endpoint = Endpoint { packets, ..Endpoint::default() };
        }
        self.setup = None;
        self.complete = 0;
        self.address = 0;
    }

    /// Sends a request, which a device always takes.
    pub fn setup(&mut self, request: [u8; 8]) {
        self.is_silent = false;
        for address in [0x00, 0x80] {
            *self.endpoint(address).unwrap() = Endpoint::default();
        }
        self.complete &= !1;
        self.setup = Some(request);
    }

    /// Asks for a packet; `toggle` is the expected data toggle.
    pub fn token_in(&mut self, number: u8, toggle: bool) -> Handshake {
        self.is_silent = false;
        let is_control = number == 0;
        let Some(endpoint) = self.endpoints.get_mut(&(0x80 | number)) else { panic!("no endpoint {number} in") };
        if endpoint.is_halted {
            return Handshake::Stall;
        }
        let Some(packet) = endpoint.packets.pop_front() else { return Handshake::Nak };
        assert!(
            is_control || endpoint.toggle == toggle,
            "endpoint {number} in: the host drops this packet as one seen"
        );
        endpoint.toggle ^= true;
        self.complete |= 1 << number;
        Handshake::Data(packet)
    }

    /// Sends a packet with this data toggle.
    pub fn token_out(&mut self, number: u8, packet: &[u8], toggle: bool) -> Handshake {
        self.is_silent = false;
        let is_control = number == 0;
        let Some(endpoint) = self.endpoint(number) else { panic!("no endpoint {number} out") };
        if endpoint.is_halted {
            return Handshake::Stall;
        }
        if endpoint.packets.len() >= BUFFERS {
            return Handshake::Nak;
        }
        assert!(
            is_control || endpoint.toggle == toggle,
            "endpoint {number} out: the device drops this packet as one seen"
        );
        endpoint.toggle ^= true;
        endpoint.packets.push_back(packet.to_vec());
        Handshake::Ack
    }
}

impl UsbBus for Bus {
    const QUIRK_SET_ADDRESS_BEFORE_STATUS: bool = true;

    fn alloc_ep(
        &mut self,
        direction: UsbDirection,
        address: Option<EndpointAddress>,
        _: EndpointType,
        packet: u16,
        _: u8,
    ) -> Result<EndpointAddress> {
        let address = address.expect("every endpoint of ours has its number");
        assert_eq!(address.direction(), direction);
        assert!(packet <= 64, "full speed");
        let taken = self.wire().endpoints.insert(address.into(), Endpoint::default());
        if taken.is_some() { Err(UsbError::InvalidEndpoint) } else { Ok(address) }
    }

    fn enable(&mut self) {
        self.wire().is_enabled = true;
    }

    fn reset(&self) {
        self.wire().drop_everything();
    }

    fn set_device_address(&self, address: u8) {
        self.wire().address = address;
    }

    fn write(&self, address: EndpointAddress, packet: &[u8]) -> Result<usize> {
        let mut wire = self.wire();
        let endpoint = wire.endpoint(address.into()).ok_or(UsbError::InvalidEndpoint)?;
        assert!(packet.len() <= 64, "a packet of {} bytes", packet.len());
        if endpoint.is_halted || !endpoint.packets.is_empty() {
            return Err(UsbError::WouldBlock);
        }
        endpoint.packets.push_back(packet.to_vec());
        Ok(packet.len())
    }

    fn read(&self, address: EndpointAddress, into: &mut [u8]) -> Result<usize> {
        let mut wire = self.wire();
        let setup = if u8::from(address) == 0 { wire.setup.take() } else { None };
        let packet = match setup {
            Some(setup) => setup.to_vec(),
            None => {
                let endpoint = wire.endpoint(address.into()).ok_or(UsbError::InvalidEndpoint)?;
                endpoint.packets.pop_front().ok_or(UsbError::WouldBlock)?
            }
        };
        let place = into.get_mut(..packet.len()).ok_or(UsbError::BufferOverflow)?;
        place.copy_from_slice(&packet);
        Ok(packet.len())
    }

    fn set_stalled(&self, address: EndpointAddress, stalled: bool) {
        if let Some(endpoint) = self.wire().endpoint(address.into()) {
            if address.index() != 0 {
                if stalled || address.is_in() {
                    endpoint.packets.clear();
                }
                endpoint.toggle &= stalled;
            }
            endpoint.is_halted = stalled;
        }
    }

    fn is_stalled(&self, address: EndpointAddress) -> bool {
        self.wire().endpoint(address.into()).is_none_or(|endpoint| endpoint.is_halted)
    }

    fn suspend(&self) {}

    fn resume(&self) {}

    fn poll(&self) -> PollResult {
        let mut wire = self.wire();
        if let Some(event) = wire.events.pop_front() {
            wire.is_silent = event == Event::Suspend;
            return match event {
                Event::Reset => PollResult::Reset,
                Event::Suspend => PollResult::Suspend,
                Event::Resume => PollResult::Resume,
            };
        }
        if wire.is_silent {
            return PollResult::None;
        }
        let has_packets = |(address, endpoint): (&u8, &Endpoint)| {
            (address & 0x80 == 0 && !endpoint.packets.is_empty()).then(|| 1_u16 << address)
        };
        let ep_out = wire.endpoints.iter().filter_map(has_packets).fold(0, |mask, bit| mask | bit);
        let ep_setup = u16::from(wire.setup.is_some());
        let ep_in_complete = core::mem::take(&mut wire.complete);
        if ep_out | ep_setup | ep_in_complete == 0 {
            return PollResult::None;
        }
        PollResult::Data { ep_out, ep_in_complete, ep_setup }
    }
}
