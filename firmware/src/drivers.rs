//! The motor drivers: up to four chips on the motor SPI bus, enable pins for external drivers. And the chips
//! of temperature sensors, which may be on the same bus.

use bsp_prime::pins::Output;
use bsp_prime::spi::SpiChip;

/// The drivers of all actuators.
pub type DriverBank = driver_bank::DriverBank<SpiChip, Output>;
/// What moves one actuator's coils.
pub type MotorDriver = driver_bank::MotorDriver<SpiChip, Output>;
/// The converter chips of temperature sensors.
pub type SensorBank = sensor_bank::SensorBank<SpiChip>;
