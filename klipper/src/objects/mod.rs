//! Objects that a host configures, each with its number.

pub mod analog;
pub mod buttons;
pub mod counter;
pub mod endstop;
pub mod output;
pub mod pwm;
pub mod spi;

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
    Spi(spi::SpiDevice<B::Spi>),
    /// Bytes for a chip at a shutdown.
    SpiShutdown(spi::LastWords),
    /// Buttons or an encoder.
    Buttons(buttons::Buttons<B::Input>),
    /// A tachometer of a fan.
    Counter(counter::Counter<B::Input>),
}
