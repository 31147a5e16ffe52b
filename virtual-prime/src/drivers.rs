//! Peers on the SPI buses, and on the UARTs that are no consoles. The stepper drivers: a 20-bit shift
//! register behind a chip select (TMC2590 datasheet, "SPI interface"). External drivers, and the converter
//! chips of sensors, which take and give bytes.

use std::collections::VecDeque;

use rigless::chip::spi::Peer;
use rigless::chip::{Timeline, uart};
use rigless::snapshot::Store;
use rigless::time::VirtualNanos;
use sim::models::tmc26x::FRAME_MASK;
use units::Actuator;

use crate::outputs::SharedWorld;

/// The SPI side of a driver. Bits leave at the top as bits enter at the bottom, so a longer frame keeps its
/// last 20 bits and shifts its first bits out again, as chips in a chain do.
#[derive(Debug)]
pub struct DriverPort {
    world: SharedWorld,
    index: usize,
    shift: u32,
}

impl DriverPort {
    /// Creates the port of the on-board driver with this index.
    pub const fn new(world: SharedWorld, index: usize) -> Self {
        Self { world, index, shift: 0 }
    }
}

/// The port stores no state: a run is repeated from its start, never from the middle.
impl Store for DriverPort {}

impl Peer for DriverPort {
    fn select(&mut self, context: &mut Timeline<'_, '_>) {
        let at_ns = context.now().0;
        let mut world = self.world.lock();
        world.advance(at_ns);
        self.shift = world.driver_mut(self.index).status(at_ns);
    }

    fn transfer(&mut self, mosi: u32, bits: u8, _: &mut Timeline<'_, '_>) -> u32 {
        let mut miso = 0;
        for bit in (0..bits).rev() {
            miso = miso << 1 | self.shift >> 19 & 1;
            self.shift = (self.shift << 1 | mosi >> bit & 1) & FRAME_MASK;
        }
        miso
    }

    fn deselect(&mut self, _: &mut Timeline<'_, '_>) {
        self.world.lock().driver_mut(self.index).write(self.shift);
    }
}

/// The SPI side of an external driver: datagrams of 40 bits, the first byte of which comes first.
#[derive(Debug)]
pub struct OutsidePort {
    world: SharedWorld,
    motor: Actuator,
    /// Bits that have come in, and their number.
    taken: u64,
    bits: u32,
    /// Bits that go out.
    given: u64,
}

/// Length of a datagram, bits.
const DATAGRAM: u32 = 40;

impl OutsidePort {
    /// Creates the port of the driver outside of this motor.
    pub const fn new(world: SharedWorld, motor: Actuator) -> Self {
        Self { world, motor, taken: 0, bits: 0, given: 0 }
    }
}

/// The port stores no state: a run is repeated from its start, never from the middle.
impl Store for OutsidePort {}

impl Peer for OutsidePort {
    fn select(&mut self, context: &mut Timeline<'_, '_>) {
        let mut world = self.world.lock();
        world.advance(context.now().0);
        let [a, b, c, d, e] = world.outside_shown(context.now().0, self.motor);
        (self.taken, self.bits, self.given) = (0, 0, u64::from_be_bytes([0, 0, 0, a, b, c, d, e]));
    }

    fn transfer(&mut self, mosi: u32, bits: u8, _: &mut Timeline<'_, '_>) -> u32 {
        (0..bits).rev().fold(0, |miso, bit| {
            let out = self.given >> (DATAGRAM - 1) & 1;
            self.given = self.given << 1 | self.taken >> (DATAGRAM - 1) & 1;
            self.taken = self.taken << 1 | u64::from(mosi >> bit & 1);
            self.bits += 1;
            miso << 1 | out as u32
        })
    }

    /// Hands the last 40 bits to the chip; a shorter frame is ignored.
    fn deselect(&mut self, context: &mut Timeline<'_, '_>) {
        if self.bits >= DATAGRAM {
            let [_, _, _, datagram @ ..] = self.taken.to_be_bytes();
            self.world.lock().outside_taken(context.now().0, self.motor, datagram);
        }
    }
}

/// An auxiliary UART with drivers on it, wired as their data sheet says: TX over 1 kOhm to the wire, RX
/// directly to it. So the port receives its own bytes, and then the answer of a driver.
#[derive(Debug)]
pub struct WireEnd {
    world: SharedWorld,
    channel: u8,
    /// Bytes on the wire for the port, each with the end of its last bit.
    queue: VecDeque<(u64, u8)>,
    /// Duration of a byte, as the chips have measured it.
    byte_ns: u64,
    last_ns: u64,
}

impl WireEnd {
    /// Creates the far end of the auxiliary UART with this channel.
    pub const fn new(world: SharedWorld, channel: u8) -> Self {
        Self { world, channel, queue: VecDeque::new(), byte_ns: 0, last_ns: 0 }
    }
}

/// The wire stores no state: a run is repeated from its start, never from the middle.
impl Store for WireEnd {}

impl uart::Peer for WireEnd {
    fn receive(&mut self, word: u16, context: &mut Timeline<'_, '_>) {
        let (now_ns, byte) = (context.now().0, word as u8);
        let since_ns = now_ns.saturating_sub(core::mem::replace(&mut self.last_ns, now_ns));
        if self.byte_ns > 0 && since_ns > 3 * self.byte_ns {
            // Bytes that the port has not read before a pause are lost.
            self.queue.clear();
        }
        self.byte_ns = since_ns;
        let mut world = self.world.lock();
        world.advance(now_ns);
        // The port's own byte comes back as it goes out; the port sees it a moment later than on a wire.
        self.queue.push_back((0, byte));
        self.queue.extend(world.wire_byte(now_ns, self.channel, byte).into_iter().flatten());
    }

    fn transmit(&mut self, now: VirtualNanos) -> Option<u16> {
        let (ends_ns, byte) = *self.queue.front()?;
        if ends_ns > now.0 + self.byte_ns {
            return None;
        }
        self.queue.pop_front();
        Some(u16::from(byte))
    }
}

/// The SPI side of the converter chip of a heater's sensor.
#[derive(Debug)]
pub struct ConverterPort {
    world: SharedWorld,
    heater: usize,
}

impl ConverterPort {
    /// Creates the port of the converter chip of this heater.
    pub const fn new(world: SharedWorld, heater: usize) -> Self {
        Self { world, heater }
    }
}

/// The port stores no state: a run is repeated from its start, never from the middle.
impl Store for ConverterPort {}

impl Peer for ConverterPort {
    fn select(&mut self, context: &mut Timeline<'_, '_>) {
        self.world.lock().converter_select(context.now().0, self.heater);
    }

    fn transfer(&mut self, mosi: u32, bits: u8, _: &mut Timeline<'_, '_>) -> u32 {
        let mut world = self.world.lock();
        // Words of 8, 16 or 32 bits travel with their first byte first.
        (0..bits / 8).rev().fold(0, |miso, byte| {
            miso << 8 | u32::from(world.converter_transfer(self.heater, (mosi >> (8 * byte)) as u8))
        })
    }

    fn deselect(&mut self, context: &mut Timeline<'_, '_>) {
        self.world.lock().converter_deselect(context.now().0, self.heater);
    }
}
