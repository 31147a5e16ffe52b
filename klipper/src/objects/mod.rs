//! Objects that a host configures, each with its number.

pub mod accelerometer;
pub mod analog;
pub mod buttons;
pub mod counter;
pub mod endstop;
pub mod i2c;
pub mod lights;
pub mod output;
pub mod pwm;
pub mod soft_spi;
pub mod spi;
pub mod tmc_uart;

use crate::board::Board;

/// An object of the host's.
pub enum Object<B: Board> {
    /// The number is free.
    None,
    /// A digital output, with software PWM.
    DigitalOut(output::DigitalOut<B::Output>),
    /// A channel of hardware PWM.
    Pwm(pwm::PwmOut<B::Pwm>),
    /// An analog input with its range.
    Analog(analog::AnalogIn<B::Analog>),
    /// A motor, by its number.
    Stepper(u8),
    /// An input that ends a move.
    Endstop(endstop::Endstop<B::Input>),
    /// A trigger that stops motors.
    Trigger(endstop::Trigger),
    /// A chip on an SPI bus.
    Spi(spi::SpiDevice<B>),
    /// Bytes for a chip at a shutdown.
    SpiShutdown(spi::LastWords),
    /// A chip on an I2C bus: once its pins are set, and while no bytes are exchanged.
    I2c(Option<i2c::I2c<B>>),
    /// An accelerometer at an SPI bus.
    Accelerometer(accelerometer::Accelerometer),
    /// A serial line of TMC drivers.
    TmcUart(tmc_uart::TmcUart<B::Wire>),
    /// A strip of lights, by its number.
    Lights(u8),
    /// Buttons or an encoder.
    Buttons(buttons::Buttons<B::Input>),
    /// A tachometer of a fan.
    Counter(counter::Counter<B::Input>),
}
