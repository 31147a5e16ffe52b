//! The board as the controller asks for it: pins by number, converters, buses, the step clock.
//!
//! Pins have the numbers of the dictionary: sixteen to a port, PA0 is 0, PK15 is 175, and above them what has
//! no digital side ([`PAD_PA0_C`], [`CHIP_TEMPERATURE`]).

pub use crate::numbers::{ADC_MAX, CHIP_TEMPERATURE, PAD_PA0_C, PWM_MAX};

/// Resistor of an input.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pull {
    /// A resistor to 3.3 V.
    Up,
    /// A resistor to ground.
    Down,
    /// No resistor at all.
    None,
}

/// A digital output that has been claimed.
pub trait Output {
    /// Drives the pin to a level.
    fn set(&mut self, high: bool);
}

/// A digital input that has been claimed.
pub trait Input {
    /// Returns the level of the pin.
    fn is_high(&self) -> bool;
}

/// An open-drain line that has been claimed: low, or left to its resistor.
pub trait Wire {
    /// Pulls the line low, or lets go of it.
    fn set(&mut self, high: bool);

    /// Returns the level of the line.
    fn is_high(&self) -> bool;
}

/// A chip on an SPI bus, with its select line.
pub trait Spi {
    /// Selects the chip, exchanges the bytes in place, and deselects it. A bus that does not answer leaves
    /// zeros.
    fn exchange(&mut self, bytes: &mut [u8]);
}

/// Settings of a chip on an SPI bus.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SpiSettings {
    /// Number of the select pin; `None` for a chip that is always selected.
    pub select: Option<u32>,
    /// The chip is selected by a high level.
    pub active_high: bool,
    /// Number of the bus in the dictionary's enumeration `spi_bus`.
    pub bus: u32,
    /// SPI mode, 0 to 3.
    pub mode: u8,
    /// Greatest rate of the clock, Hz.
    pub rate_hz: u32,
}

/// Pins and timing of a motor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MotorSettings {
    /// Number of the step pin.
    pub step_pin: u32,
    /// Number of the direction pin; it is low for direction 0.
    pub dir_pin: u32,
    /// Edges at which the driver makes a step.
    pub edge: StepEdge,
    /// Least length of a pulse, and least time between a step and a turn, ticks.
    pub pulse_ticks: u32,
}

/// Edges of the step pin at which a driver makes a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StepEdge {
    /// At a rising edge: pulses are high.
    Rising,
    /// At a falling edge: pulses are low.
    Falling,
    /// At each edge of the pin.
    Both,
}

/// The board, as far as the controller needs it. A pin can be claimed once; whoever is refused gets `None`,
/// and the host is told that the pin is not valid.
pub trait Board {
    /// Handle of an output pin.
    type Output: Output;
    /// Handle of an input pin.
    type Input: Input;
    /// A claimed analog input.
    type Analog: Copy;
    /// A claimed channel of hardware PWM.
    type Pwm: Copy;
    /// A chip on an SPI bus.
    type Spi: Spi;
    /// A claimed open-drain line.
    type Wire: Wire;
    /// A strip of lights.
    type Strip: Copy;

    /// Returns the low half of the step clock, in ticks of 5 ns.
    fn clock(&self) -> u32;

    /// Returns how often the low half has turned over.
    fn clock_turns(&self) -> u32;

    /// Makes a pin an output of this level.
    fn output(&mut self, pin: u32, high: bool) -> Option<Self::Output>;

    /// Makes a pin an input.
    fn input(&mut self, pin: u32, pull: Pull) -> Option<Self::Input>;

    /// Makes a pin an open-drain line with this resistor, let go of.
    fn wire(&mut self, pin: u32, pull: Pull) -> Option<Self::Wire>;

    /// Waits so many ticks of the step clock. Only jobs call it, without the lock.
    fn pause(ticks: u32);

    /// Claims a pin for a strip of lights, which have 500 bytes at most.
    ///
    /// # Errors
    /// The reason why it cannot.
    fn strip(&mut self, pin: u32) -> Result<Self::Strip, crate::Reason>;

    /// Begins to send bytes to a strip. False, and nothing happens, while another one is on its way.
    fn send_to_strip(&mut self, strip: Self::Strip, bytes: &[u8]) -> bool;

    /// Makes a pin an analog input. Conversions begin with [`Board::begin`].
    fn analog(&mut self, pin: u32) -> Option<Self::Analog>;

    /// Returns the latest conversion of an analog input, 0 to [`ADC_MAX`]; `None` before there is one, or
    /// when the converter has stopped.
    fn read_analog(&mut self, input: Self::Analog) -> Option<u16>;

    /// Claims a pin of hardware PWM with this period. All pins of one timer have one period.
    ///
    /// # Errors
    /// The reason why it cannot.
    fn pwm(&mut self, pin: u32, cycle_ticks: u32, value: u16) -> Result<Self::Pwm, crate::Reason>;

    /// Sets a channel of hardware PWM, 0 to [`PWM_MAX`].
    fn set_pwm(&mut self, channel: Self::Pwm, value: u16);

    /// Claims step and direction pin of motor `index`, both at rest.
    fn motor(&mut self, index: usize, settings: MotorSettings) -> Option<()>;

    /// Makes a chip on an SPI bus.
    ///
    /// # Errors
    /// The reason why it cannot.
    fn spi(&mut self, settings: SpiSettings) -> Result<Self::Spi, crate::Reason>;

    /// The configuration is whole: starts the conversions of all analog inputs, gives the step interrupt its
    /// motors, and the MOSFET outputs their supply.
    fn begin(&mut self);

    /// Cuts or gives the supply of the MOSFET outputs.
    fn power_outputs(&mut self, on: bool);

    /// Reads a word of the chip's read-only memory, of 1, 2 or 4 bytes; `None` for any other address.
    fn read_factory(&self, bytes: u8, address: u32) -> Option<u32>;

    /// Has the step interrupt look at the step queue.
    fn wake_steps(&self);
}
