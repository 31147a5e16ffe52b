//! Numbers that board and host agree on; the build script includes them in the dictionary.

/// Rate of the step clock, which is the clock of the protocol, Hz.
pub const CLOCK_HZ: u32 = 200_000_000;
/// Divisor of the squared durations in `stats`.
pub const STATS_SUMSQ_BASE: u32 = 256;
/// Bytes that a host may have on the way: half of what the line's ring holds.
pub const RECEIVE_WINDOW: u32 = 1024;
/// Number of the pad PA0_C, an analog input that is no digital pin: the thermistor on the board.
pub const PAD_PA0_C: u32 = 253;
/// Number of the chip's temperature sensor, as Klipper's firmware has it.
pub const CHIP_TEMPERATURE: u32 = 254;
/// Greatest value of one conversion.
pub const ADC_MAX: u16 = 4095;
/// Value of hardware PWM that is always on.
pub const PWM_MAX: u16 = 32_768;
/// Names of outcomes on an I2C bus, by their numbers.
pub const I2C_STATUS: [&str; 5] = ["SUCCESS", "NACK", "BUS_TIMEOUT", "START_NACK", "START_READ_NACK"];
