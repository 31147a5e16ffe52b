//! The stepper drivers' SPI: a 20-bit shift register behind a chip select (TMC2590 datasheet, "SPI
//! interface").

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
