//! The three serial ports: USART2 (debug console, PD5/PD6), USART3 (UART 0, PD8/PB11), UART4 (UART 1,
//! PB9/PH14).
//!
//! The interrupt hands received bytes to its caller's sink and moves bytes to send from a ring to the
//! hardware FIFO (16 each way); nobody waits. Only the interrupt touches the control registers after set-up:
//! a writer fills the ring and pends the interrupt, which then switches the transmitter's own interrupt on.
//! Losses of the line (overrun, framing) are counted; the protocols above have checksums for it.

use core::sync::atomic::{AtomicU32, Ordering};

use cortex_m::peripheral::NVIC;
use stm32h7xx_hal::pac;

use crate::byte_ring::ByteRing;
use crate::clocks::PCLK_HZ;
use crate::pins::{self, Mode, PinName, Pull, Speed};

/// Size of the transmit ring: a long status answer fits whole.
const TX_BYTES: usize = 4096;
/// Most bytes moved in one interrupt: one hardware FIFO (RM0399 section 51.5.4).
const FIFO_BYTES: usize = 16;

/// Data shared by the two halves of a port.
#[derive(Debug)]
struct Shared {
    tx: ByteRing<TX_BYTES>,
    /// Mask of the bits of a received word that are not data: the parity bit arrives with them.
    not_data: AtomicU32,
}

// All zeros, as the board fills this region with zeros.
#[unsafe(link_section = ".d2ram")]
static SHARED: [Shared; 3] = [const { Shared { tx: ByteRing::new(), not_data: AtomicU32::new(0) } }; 3];

/// Sends bytes by an open port without interrupts, and waits until the last is out; no interrupt of the port
/// may run. For reports of code that cannot go on. A line that takes nothing is given up.
pub(crate) fn say_at_once(port: PortName, bytes: &[u8]) {
    // SAFETY: the caller has the port to itself.
    let uart = unsafe { &*port.registers() };
    // A byte takes 87 us at 115200 baud; the bound counts cycles of the full clock.
    for byte in bytes {
        // RM0399 section 51.8.9, USART_ISR: TXFNF; 51.8.13, USART_TDR.
        if crate::wait::until(BYTE_LIMIT_US, || uart.isr.read().txe().bit_is_set()).is_err() {
            return;
        }
        uart.tdr.write(|w| w.tdr().bits(u16::from(*byte)));
    }
    // Waits for TC, the end of the transmission.
    let _sent = crate::wait::until(16 * BYTE_LIMIT_US, || uart.isr.read().tc().bit_is_set());
}

/// Limit of the wait for a byte, which takes a tenth of it.
const BYTE_LIMIT_US: u32 = 1_000;

/// Serial port of the board.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PortName {
    /// USART2 on the debug header.
    Debug,
    /// USART3 on header GD, "UART 0" of configurations.
    Uart0,
    /// UART4 on header GB, "UART 1" of configurations.
    Uart1,
}

impl PortName {
    fn interrupt(self) -> pac::Interrupt {
        match self {
            Self::Debug => pac::Interrupt::USART2,
            Self::Uart0 => pac::Interrupt::USART3,
            Self::Uart1 => pac::Interrupt::UART4,
        }
    }

    pub(crate) fn registers(self) -> *const pac::usart1::RegisterBlock {
        match self {
            Self::Debug => pac::USART2::ptr(),
            Self::Uart0 => pac::USART3::ptr(),
            Self::Uart1 => pac::UART4::ptr(),
        }
    }

    /// Transmit pin, receive pin, alternate function.
    fn pins(self) -> (PinName, PinName, u8) {
        match self {
            Self::Debug => (PinName::new('D', 5), PinName::new('D', 6), 7),
            Self::Uart0 => (PinName::new('D', 8), PinName::new('B', 11), 7),
            Self::Uart1 => (PinName::new('B', 9), PinName::new('H', 14), 8),
        }
    }

    fn shared(self) -> &'static Shared {
        &SHARED[self as usize]
    }
}

/// Parity of each word.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Parity {
    /// Frames without a parity bit.
    None,
    /// An odd number of ones, parity bit included.
    Odd,
    /// An even number of ones, parity bit included.
    Even,
}

/// Format of a word on the wire.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Frame {
    word_bits: u8,
    parity: Parity,
    two_stop_bits: bool,
}

impl Frame {
    /// 8 bits, no parity, 1 stop bit.
    pub const PLAIN: Self = Self { word_bits: 8, parity: Parity::None, two_stop_bits: false };

    /// Words of 7 to 9 bits, parity bit included, as the chip counts them; 1 or 2 stop bits. `None` when the
    /// chip cannot do that, or the words carry fewer than 7 bits of data or more than a byte.
    #[must_use]
    pub const fn new(word_bits: u8, parity: Parity, stop_bits: u8) -> Option<Self> {
        let data = if matches!(parity, Parity::None) { word_bits } else { word_bits.wrapping_sub(1) };
        let possible = matches!(word_bits, 7..=9) && matches!(data, 7 | 8) && matches!(stop_bits, 1 | 2);
        if possible { Some(Self { word_bits, parity, two_stop_bits: stop_bits == 2 }) } else { None }
    }

    /// Bits of a received word, as a byte, that carry no data.
    const fn not_data(self) -> u32 {
        let eight = match self.parity {
            Parity::None => self.word_bits >= 8,
            _ => self.word_bits == 9,
        };
        if eight { 0 } else { 0x80 }
    }
}

/// The interrupt's half of a port.
#[derive(Debug)]
pub struct UartInterrupt {
    registers: *const pac::usart1::RegisterBlock,
    shared: &'static Shared,
}

// SAFETY: the pointer is to registers of a port whose only user after set-up is this value.
unsafe impl Send for UartInterrupt {}

/// The task's half of a port.
#[derive(Debug)]
pub struct UartPort {
    name: PortName,
    shared: &'static Shared,
}

/// Both halves of a port, closed. Once for each port, by the board.
pub(crate) fn port(name: PortName) -> (UartInterrupt, UartPort) {
    let interrupt = UartInterrupt { registers: name.registers(), shared: name.shared() };
    (interrupt, UartPort { name, shared: name.shared() })
}

impl UartInterrupt {
    fn registers(&self) -> &'static pac::usart1::RegisterBlock {
        // SAFETY: the pointer came from the PAC; the registers exist for the whole run and this value is
        // their only user.
        unsafe { &*self.registers }
    }

    /// Moves what the FIFOs hold and can take, received bytes to `receive`. At most 16 bytes each way, so
    /// about 3 us.
    pub fn on_interrupt(&mut self, mut receive: impl FnMut(u8)) {
        let uart = self.registers();
        let status = uart.isr.read();
        if status.ore().bit_is_set() || status.fe().bit_is_set() || status.nf().bit_is_set() || status.pe().bit_is_set()
        {
            uart.icr.write(|w| w.orecf().set_bit().fecf().set_bit().ncf().set_bit().pecf().set_bit());
        }
        for _ in 0..FIFO_BYTES {
            if uart.isr.read().rxne().bit_is_clear() {
                break;
            }
            receive(uart.rdr.read().rdr().bits() as u8 & !(self.shared.not_data.load(Ordering::Relaxed) as u8));
        }
        self.fill(uart);
    }

    fn fill(&mut self, uart: &pac::usart1::RegisterBlock) {
        for _ in 0..FIFO_BYTES {
            if self.shared.tx.is_empty() || uart.isr.read().txe().bit_is_clear() {
                break;
            }
            if let Some(byte) = self.shared.tx.pop() {
                uart.tdr.write(|w| w.tdr().bits(u16::from(byte)));
            }
        }
        // Enables the interrupt of an empty FIFO as long as there is more to send.
        let more = !self.shared.tx.is_empty();
        if uart.cr1.read().txfeie().bit() != more {
            uart.cr1.modify(|_, w| w.txfeie().bit(more));
        }
    }
}

impl UartPort {
    pub(crate) const fn name(&self) -> PortName {
        self.name
    }

    /// Returns the port's pins, transmit first; to be claimed before [`Self::open`].
    #[must_use]
    pub fn pins(&self) -> [PinName; 2] {
        let (tx, rx, _) = self.name.pins();
        [tx, rx]
    }

    /// Opens the port at `baud`. Once: its interrupt owns the registers from then on.
    pub fn open(&mut self, baud: u32, frame: Frame) {
        let (tx, rx, function) = self.name.pins();
        pins::configure(tx, Mode::Alternate(function, Speed::Low), Pull::Floating, false);
        // An open receive pin must read as an idle line.
        pins::configure(rx, Mode::Alternate(function, Speed::Low), Pull::Up, false);
        // SAFETY: while the port is disabled it does not interrupt, so nobody else touches its registers.
        let uart = unsafe { &*self.name.registers() };
        // RM0399 section 51.8: configuration is only accepted while UE is clear.
        uart.cr1.reset();
        let divider = (PCLK_HZ + baud / 2).checked_div(baud).unwrap_or(0).clamp(16, 0xFFFF);
        // SAFETY: with 16-fold oversampling the whole 16-bit divider is the field; values from 16 on are
        // valid.
        uart.brr.write(|w| unsafe { w.bits(divider) });
        self.shared.not_data.store(frame.not_data(), Ordering::Relaxed);
        // RM0399 section 51.8.4, USART_CR2: STOP = 00 is one stop bit, 10 two.
        let stop_bits = if frame.two_stop_bits { 0b10 << 12 } else { 0 };
        // SAFETY: STOP alone; every other field at its reset value.
        uart.cr2.write(|w| unsafe { w.bits(stop_bits) });
        // RM0399 section 51.8.1, USART_CR1: M1 M0 = 00 is eight bits, 01 nine, 10 seven; the parity bit
        // counts.
        uart.cr1.write(|w| {
            w.m1().bit(frame.word_bits == 7).m0().bit(frame.word_bits == 9);
            w.pce().bit(frame.parity != Parity::None).ps().bit(frame.parity == Parity::Odd)
        });
        uart.cr1.modify(|_, w| w.fifoen().set_bit().re().set_bit().te().set_bit().rxneie().set_bit().ue().set_bit());
    }

    /// Queues as much of `bytes` as fits and returns the number of bytes taken.
    pub fn write(&mut self, bytes: &[u8]) -> usize {
        let count = self.shared.tx.push_some(bytes);
        if count > 0 {
            NVIC::pend(self.name.interrupt());
        }
        count
    }

    /// Returns the number of bytes that a write would take now.
    #[must_use]
    pub fn room(&self) -> usize {
        self.shared.tx.room()
    }

    /// Whether everything written has left the ring.
    #[must_use]
    pub fn is_drained(&self) -> bool {
        self.shared.tx.is_empty()
    }
}
