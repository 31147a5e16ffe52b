//! Driver of one motor, of whichever kind.

use tmc::Driver;
use units::Amps;

use crate::outside_bus::OutsideBus;
use crate::stealth::Outside;

/// Driver of one actuator's coils. `LINE` is a single-wire UART; `E` enables an external driver: its active
/// state is the pin's high.
#[derive(Debug, Default)]
pub enum MotorDriver<SPI, LINE, E> {
    /// No driver, or a driver without an enable pin.
    #[default]
    None,
    /// Chip on the on-board bus, with the highest current allowed for its power stage.
    Chip(Driver<SPI>, Amps),
    /// External driver, enabled by this pin.
    External(E),
    /// External driver whose chip is on a bus.
    Outside(Outside<OutsideBus<SPI, LINE>, E>),
}
