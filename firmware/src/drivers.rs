//! The motor drivers: up to four chips on the motor SPI bus, enable pins for external drivers.

use bsp_prime::pins::Output;
use bsp_prime::spi::MotorDevice;

/// The drivers of all actuators.
pub type DriverBank = driver_bank::DriverBank<MotorDevice, Output>;
/// What moves one actuator's coils.
pub type MotorDriver = driver_bank::MotorDriver<MotorDevice, Output>;
