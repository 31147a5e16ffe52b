//! The motor drivers: up to four chips on the motor SPI bus, drivers outside on either SPI bus or an
//! auxiliary UART, enable pins for external drivers. And the chips of temperature sensors, which may be on
//! the same buses.

use bsp_prime::pins::Output;
use bsp_prime::single_wire::{SingleWireLine, WireError};
use bsp_prime::spi::SpiChip;
use driver_bank::{SingleWire, WireFault};

/// The drivers of all actuators.
pub type DriverBank = driver_bank::DriverBank<SpiChip, Line, Output>;
/// Driver of one actuator's coils.
pub type MotorDriver = driver_bank::MotorDriver<SpiChip, Line, Output>;
/// Bus of an external driver.
pub type OutsideBus = driver_bank::OutsideBus<SpiChip, Line>;
/// The converter chips of temperature sensors.
pub type SensorBank = sensor_bank::SensorBank<SpiChip>;

/// An auxiliary UART with drivers on it.
#[derive(Debug)]
pub struct Line(pub SingleWireLine);

impl SingleWire for Line {
    type Error = WireError;

    fn exchange(&mut self, datagram: &[u8], answer: &mut [u8]) -> Result<(), WireFault<WireError>> {
        self.0.exchange(datagram, answer).map_err(|error| match error {
            WireError::NoEcho => WireFault::NoEcho,
            WireError::Disturbed => WireFault::Disturbed,
            WireError::NoAnswer => WireFault::NoAnswer,
            WireError::Misused => WireFault::Port(error),
        })
    }
}
