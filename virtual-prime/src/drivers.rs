//! What is on the SPI buses. The stepper drivers: a 20-bit shift register behind a chip select (TMC2590
//! datasheet, "SPI interface"). And the converter chips of sensors, which take and give bytes.

use rigless::chip::Timeline;
use rigless::chip::spi::Peer;
use rigless::snapshot::Store;
use sim::models::tmc26x::FRAME_MASK;

use crate::outputs::SharedWorld;

/// The SPI side of one driver. Bits leave at the top as bits enter at the bottom, so a longer frame keeps its
/// last 20 bits and shifts its first ones out again, as chips in a chain do.
#[derive(Debug)]
pub struct DriverPort {
    world: SharedWorld,
    index: usize,
    shift: u32,
}

impl DriverPort {
    pub const fn new(world: SharedWorld, index: usize) -> Self {
        Self { world, index, shift: 0 }
    }
}

/// A run is repeated from its start, never from the middle.
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

/// The SPI side of the converter chip of a heater's sensor.
#[derive(Debug)]
pub struct ConverterPort {
    world: SharedWorld,
    heater: usize,
}

impl ConverterPort {
    pub const fn new(world: SharedWorld, heater: usize) -> Self {
        Self { world, heater }
    }
}

/// A run is repeated from its start, never from the middle.
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
