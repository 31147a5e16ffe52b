//! A pin as registers see it: mode, resistor, level. Everything here is one write to BSRR or a short masked
//! change of a mode register.

use stm32h7xx_hal::pac;

use super::name::{PinName, PinSpec, Pull};

/// Slew rate of a driven pin (RM0399 section 12.4.3, GPIOx_OSPEEDR), with rise and fall times at 50 pF
/// (DS12923, output timing characteristics). The gentlest that serves: steeper edges ring on the headers'
/// cables and disturb the analog inputs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Speed {
    /// 17 ns. For everything below a megahertz whose instant is not critical: heaters, chip selects, the
    /// drivers' SPI, serial ports, PWM.
    Low = 0b00,
    /// 5 ns, a tick of the step clock: STEP and DIR.
    Medium = 0b01,
    /// 4 ns: the SD card's 25 MHz, as running boards have it. The data sheet allows a card's edges 10 ns.
    High = 0b10,
    /// 3 ns. USB, as running boards have it: its transceiver shapes the edges itself. And what Ethernet sends
    /// at 50 MHz, on a few centimetres of the board.
    VeryHigh = 0b11,
}

/// Function of a pin (RM0399 section 12.4.1, GPIOx_MODER).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mode {
    /// Input for digital levels.
    Input,
    /// Digital output with this slew rate.
    Output(Speed),
    /// Belongs to the peripheral with this alternate function number.
    Alternate(u8, Speed),
    /// Analog; also the state of lowest consumption.
    Analog,
}

/// Distance of the port blocks (RM0399 section 2.3.2, table of boundary addresses).
const PORT_STRIDE: usize = 0x400;

pub(super) fn registers(pin: PinName) -> &'static pac::gpioa::RegisterBlock {
    let address = pac::GPIOA::ptr() as usize + pin.port() * PORT_STRIDE;
    // SAFETY: ports A to K lie one stride apart and share GPIOA's layout, and a `PinName` is one of them.
    // Levels change by BSRR (atomic per bit); mode registers change in a masked section.
    unsafe { &*(address as *const pac::gpioa::RegisterBlock) }
}

/// Opens the clock gates of all ports. Before any other function of this module.
pub(crate) fn enable_ports() {
    // SAFETY: runs once, first of all, with interrupts off; the RCC token is still unused.
    let rcc = unsafe { &*pac::RCC::ptr() };
    rcc.ahb4enr.modify(|_, w| {
        w.gpioaen().enabled().gpioben().enabled().gpiocen().enabled().gpioden().enabled();
        w.gpioeen().enabled().gpiofen().enabled().gpiogen().enabled().gpiohen().enabled();
        w.gpioien().enabled().gpiojen().enabled().gpioken().enabled()
    });
    let _settled = rcc.ahb4enr.read().bits();
}

fn pull_bits(pull: Pull) -> u32 {
    match pull {
        Pull::Floating => 0b00,
        Pull::Up => 0b01,
        Pull::Down => 0b10,
    }
}

/// Sets mode, resistor and output type of a pin. Level first, mode last, so that an output never glitches.
pub(crate) fn configure(pin: PinName, mode: Mode, pull: Pull, open_drain: bool) {
    let port = registers(pin);
    let (number, two) = (u32::from(pin.number()), 2 * u32::from(pin.number()));
    let (code, speed) = match mode {
        Mode::Input => (0b00, Speed::Low),
        Mode::Output(speed) => (0b01, speed),
        Mode::Alternate(_, speed) => (0b10, speed),
        Mode::Analog => (0b11, Speed::Low),
    };
    cortex_m::interrupt::free(|_| {
        // SAFETY: every two-bit (or one-bit, four-bit) pattern written is a valid field value of these
        // registers; only this pin's field changes, and interrupts are masked for the read-change-write.
        unsafe {
            port.otyper.modify(|r, w| w.bits(r.bits() & !(1 << number) | (u32::from(open_drain) << number)));
            port.ospeedr.modify(|r, w| w.bits(r.bits() & !(0b11 << two) | ((speed as u32) << two)));
            port.pupdr.modify(|r, w| w.bits(r.bits() & !(0b11 << two) | (pull_bits(pull) << two)));
            if let Mode::Alternate(function, _) = mode {
                let shift = 4 * (number & 7);
                let field = u32::from(function & 0xF) << shift;
                if number < 8 {
                    port.afrl.modify(|r, w| w.bits(r.bits() & !(0xF << shift) | field));
                } else {
                    port.afrh.modify(|r, w| w.bits(r.bits() & !(0xF << shift) | field));
                }
            }
            port.moder.modify(|r, w| w.bits(r.bits() & !(0b11 << two) | (code << two)));
        }
    });
}

/// A digital output. `on` and `off` are words for BSRR (RM0399 section 12.4.7): low half sets, high half
/// resets.
#[derive(Debug)]
pub struct Output {
    pin: PinName,
    on: u32,
}

impl Output {
    /// Makes `spec` an output that is off, without an instant of on.
    pub(crate) fn off(spec: PinSpec) -> Self {
        Self::off_with_edges(spec, Speed::Low)
    }

    fn off_with_edges(spec: PinSpec, speed: Speed) -> Self {
        let on = if spec.inverted { spec.pin.bit() << 16 } else { spec.pin.bit() };
        let output = Self { pin: spec.pin, on };
        output.write(false);
        configure(spec.pin, Mode::Output(speed), Pull::Floating, spec.open_drain);
        output
    }

    fn write(&self, on: bool) {
        let word = if on { self.on } else { self.on.rotate_left(16) };
        // SAFETY: a BSRR write changes only the pin this output owns.
        registers(self.pin).bsrr.write(|w| unsafe { w.bits(word) });
    }

    /// Switches on or off, in the sense of the configuration.
    #[inline]
    pub fn set(&mut self, on: bool) {
        self.write(on);
    }

    /// Returns whether the output is on (the driven level, not that of the wire).
    #[must_use]
    pub fn is_on(&self) -> bool {
        let high = registers(self.pin).odr.read().bits() & self.pin.bit() != 0;
        high == (self.on <= u32::from(u16::MAX))
    }

    /// Returns the name of the pin.
    #[must_use]
    pub fn pin(&self) -> PinName {
        self.pin
    }
}

impl embedded_hal::digital::ErrorType for Output {
    type Error = core::convert::Infallible;
}

/// High is on, in the sense of the configuration.
impl embedded_hal::digital::OutputPin for Output {
    fn set_low(&mut self) -> Result<(), Self::Error> {
        self.set(false);
        Ok(())
    }

    fn set_high(&mut self) -> Result<(), Self::Error> {
        self.set(true);
        Ok(())
    }
}

/// Open-drain line with more than one party: pulled low, or left to its resistor.
#[derive(Debug)]
pub struct Line {
    pin: PinName,
}

impl Line {
    /// Makes a pin a line that is let go of.
    pub(crate) fn new(spec: PinSpec) -> Self {
        let mut line = Self { pin: spec.pin };
        line.set(true);
        configure(spec.pin, Mode::Output(Speed::Low), spec.pull, true);
        line
    }

    /// Pulls the line low, or lets go of it.
    pub fn set(&mut self, high: bool) {
        let word = if high { self.pin.bit() } else { self.pin.bit() << 16 };
        // SAFETY: a BSRR write changes only the pin this line owns.
        registers(self.pin).bsrr.write(|w| unsafe { w.bits(word) });
    }

    /// Returns the level of the line, whoever makes it: an output's input stays on (RM0399 section 12.3.10).
    #[must_use]
    pub fn is_high(&self) -> bool {
        registers(self.pin).idr.read().bits() & self.pin.bit() != 0
    }
}

/// Digital input pin with polarity.
#[derive(Clone, Debug)]
pub struct Input {
    pin: PinName,
    inverted: bool,
}

impl Input {
    pub(crate) fn new(spec: PinSpec) -> Self {
        configure(spec.pin, Mode::Input, spec.pull, false);
        Self { pin: spec.pin, inverted: spec.inverted }
    }

    /// Returns the same input with opposite polarity.
    #[must_use]
    pub const fn opposite(&self) -> Self {
        Self { pin: self.pin, inverted: !self.inverted }
    }

    /// Returns whether the input is active, in the sense of the configuration.
    #[inline]
    #[must_use]
    pub fn is_on(&self) -> bool {
        (registers(self.pin).idr.read().bits() & self.pin.bit() != 0) != self.inverted
    }

    /// Returns the name of the pin.
    #[must_use]
    pub fn pin(&self) -> PinName {
        self.pin
    }
}

/// Pin for the step interrupt: the register to write, and the word that switches the pin on. See [`Output`].
#[derive(Clone, Copy, Debug)]
pub struct FastPin {
    bsrr: *mut u32,
    on: u32,
}

// SAFETY: the pointer is to a write-only register that is atomic per bit; it is the same from every context.
unsafe impl Send for FastPin {}
// SAFETY: as for Send; writing is all one can do.
unsafe impl Sync for FastPin {}

impl FastPin {
    /// Unconnected pin: writes no bit of a real port.
    pub const NONE: Self = Self { bsrr: (0x5802_0000 + 0x18) as *mut u32, on: 0 };

    /// Makes `spec` an output that is off, and gives the fast handle to it.
    pub(crate) fn off(spec: PinSpec) -> Self {
        let output = Output::off_with_edges(spec, Speed::Medium);
        Self { bsrr: registers(spec.pin).bsrr.as_ptr(), on: output.on }
    }

    /// The BSRR word for on.
    #[inline(always)]
    #[must_use]
    pub const fn on_word(self) -> u32 {
        self.on
    }

    /// The BSRR word for off: the other half of the register.
    #[inline(always)]
    #[must_use]
    pub const fn off_word(self) -> u32 {
        self.on.rotate_left(16)
    }

    /// Whether the pin is driven high now: its bit in the output register beside BSRR (RM0399 section
    /// 12.4.6).
    #[must_use]
    pub fn is_high(self) -> bool {
        let bit = (self.on | self.on >> 16) & 0xFFFF;
        // SAFETY: ODR is the word below BSRR in every port's block; reading it changes nothing.
        unsafe { self.bsrr.sub(1).read_volatile() & bit != 0 }
    }

    /// The BSRR register to write it to.
    #[must_use]
    pub const fn register(self) -> *mut u32 {
        self.bsrr
    }
}
