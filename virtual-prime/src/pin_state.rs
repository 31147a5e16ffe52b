//! State of a pin as its port's registers set it (RM0399 section 12.4).

use rigless::device::RegisterFile;
use rigless::soc::stm32h743::generated::gpioa::Register;

/// Source of a pin's level.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Drive {
    /// No source: analog, or an input without a resistor, or an open-drain output that is let go.
    Released,
    /// An input with its pull-up.
    PulledUp,
    /// An input with its pull-down.
    PulledDown,
    /// An output that drives low.
    Low,
    /// An output that drives high.
    High,
    /// The peripheral with this alternate function number.
    Function(u8),
}

/// State of a pin's port registers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PinState {
    /// Source of the pin's level.
    pub drive: Drive,
    /// Output speed (OSPEEDR): 0 low, 1 medium, 2 high, 3 very high.
    pub speed: u8,
    /// Pull resistor (PUPDR): 0 none, 1 up, 2 down.
    pub pull: u8,
    /// Whether the output is open-drain (OTYPER).
    pub open_drain: bool,
}

impl PinState {
    pub(crate) fn of(port: &RegisterFile, number: u8) -> Self {
        let field = |register: Register, width: u32| {
            (port.get(register) >> (u32::from(number) * width) & ((1 << width) - 1)) as u8
        };
        let (mode, pull) = (field(Register::Moder, 2), field(Register::Pupdr, 2));
        let (open_drain, high) = (field(Register::Otyper, 1) == 1, field(Register::Odr, 1) == 1);
        let alternate = if number < 8 { Register::Afrl } else { Register::Afrh };
        let function = (port.get(alternate) >> (4 * (number & 7)) & 0xF) as u8;
        let drive = match (mode, pull, high) {
            (0, 1, _) => Drive::PulledUp,
            (0, 2, _) => Drive::PulledDown,
            (1, _, true) if open_drain => Drive::Released,
            (1, _, true) => Drive::High,
            (1, _, false) => Drive::Low,
            (2, ..) => Drive::Function(function),
            _ => Drive::Released,
        };
        Self { drive, speed: field(Register::Ospeedr, 2), pull, open_drain }
    }
}
