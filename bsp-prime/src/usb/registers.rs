//! Registers of the OTG core, by their offsets (RM0399 chapter 60, register map): the PAC has a type for each
//! endpoint's registers, though they repeat at a fixed stride.

use stm32h7xx_hal::pac;

/// Control and status of the core.
pub const GOTGCTL: usize = 0x000;
/// Configuration of the AHB interface.
pub const GAHBCFG: usize = 0x008;
/// Configuration of the USB core.
pub const GUSBCFG: usize = 0x00C;
/// Resets and FIFO flushes.
pub const GRSTCTL: usize = 0x010;
/// Pending events of the core.
pub const GINTSTS: usize = 0x014;
/// Mask of the core's interrupts.
pub const GINTMSK: usize = 0x018;
/// Reading it takes the head of the receive FIFO.
pub const GRXSTSP: usize = 0x020;
/// Size of the receive FIFO.
pub const GRXFSIZ: usize = 0x024;
/// Place and size of endpoint 0's transmit FIFO.
pub const DIEPTXF0: usize = 0x028;
/// Transceiver and voltage sensing.
pub const GCCFG: usize = 0x038;
/// Configuration of the device.
pub const DCFG: usize = 0x800;
/// Control of the device.
pub const DCTL: usize = 0x804;
/// Interrupt mask of all IN endpoints.
pub const DIEPMSK: usize = 0x810;
/// Interrupt mask of all OUT endpoints.
pub const DOEPMSK: usize = 0x814;
/// Endpoints with pending interrupts.
pub const DAINT: usize = 0x818;
/// Mask of endpoint interrupts.
pub const DAINTMSK: usize = 0x81C;
/// Power and clock gating.
pub const PCGCCTL: usize = 0xE00;

/// Place and size of the transmit FIFO of an endpoint from 1 on.
pub const fn dieptxf(number: usize) -> usize {
    0x100 + 4 * number
}

/// Control of an endpoint to the host.
pub const fn diepctl(number: usize) -> usize {
    0x900 + 0x20 * number
}

/// Pending events of an IN endpoint.
pub const fn diepint(number: usize) -> usize {
    0x908 + 0x20 * number
}

/// Packets and bytes to send at an IN endpoint.
pub const fn dieptsiz(number: usize) -> usize {
    0x910 + 0x20 * number
}

/// Number of free words in an IN endpoint's FIFO.
pub const fn dtxfsts(number: usize) -> usize {
    0x918 + 0x20 * number
}

/// Control of an endpoint from the host.
pub const fn doepctl(number: usize) -> usize {
    0xB00 + 0x20 * number
}

/// Pending events of an OUT endpoint.
pub const fn doepint(number: usize) -> usize {
    0xB08 + 0x20 * number
}

/// Packets and bytes to receive at an OUT endpoint.
pub const fn doeptsiz(number: usize) -> usize {
    0xB10 + 0x20 * number
}

/// Address of an endpoint's FIFO: written for the host; any of them read gives the received words.
const fn fifo(number: usize) -> usize {
    0x1000 * (number + 1)
}

/// Bits of GINTSTS and GINTMSK.
pub mod event {
    /// The core is a host.
    pub const CMOD: u32 = 1 << 0;
    /// The receive FIFO is not empty.
    pub const RXFLVL: u32 = 1 << 4;
    /// The bus is silent.
    pub const USBSUSP: u32 = 1 << 11;
    /// The bus is reset.
    pub const USBRST: u32 = 1 << 12;
    /// The reset is over, the speed known.
    pub const ENUMDNE: u32 = 1 << 13;
    /// An endpoint to the host.
    pub const IEPINT: u32 = 1 << 18;
    /// An endpoint from the host.
    pub const OEPINT: u32 = 1 << 19;
    /// The bus is not silent any more.
    pub const WKUPINT: u32 = 1 << 31;
}

/// Bits of DIEPCTLx and DOEPCTLx.
pub mod endpoint {
    pub const USBAEP: u32 = 1 << 15;
    pub const STALL: u32 = 1 << 21;
    pub const CNAK: u32 = 1 << 26;
    pub const SNAK: u32 = 1 << 27;
    pub const SD0PID: u32 = 1 << 28;
    pub const SODDFRM: u32 = 1 << 29;
    pub const EPDIS: u32 = 1 << 30;
    pub const EPENA: u32 = 1 << 31;
    /// Bits that act when written as 1, and must not be written back.
    pub const ACTIONS: u32 = CNAK | SNAK | SD0PID | SODDFRM | EPDIS | EPENA;
    /// Bits of DIEPINTx and DOEPINTx: the transfer is complete.
    pub const XFRC: u32 = 1 << 0;
    /// The endpoint is disabled.
    pub const EPDISD: u32 = 1 << 1;
    /// DOEPINTx: what came before is a request.
    pub const STUP: u32 = 1 << 3;
}

fn address(offset: usize) -> usize {
    pac::OTG2_HS_GLOBAL::ptr() as usize + offset
}

/// Reads a register of the core.
pub fn read(offset: usize) -> u32 {
    // SAFETY: offsets are those of this module, words within OTG2's 256 KiB (RM0399 section 2.3.2), which
    // exist whenever its clock runs; `UsbSocket::start` sees to that first. The bus alone uses them.
    unsafe { (address(offset) as *const u32).read_volatile() }
}

/// Writes a register of the core.
pub fn write(offset: usize, value: u32) {
    // SAFETY: as for `read`; no value of these registers has the core reach memory, as its DMA stays off.
    unsafe { (address(offset) as *mut u32).write_volatile(value) }
}

/// Changes bits of a register that has no bits that act by being written back.
pub fn modify(offset: usize, clear: u32, set: u32) {
    write(offset, read(offset) & !clear | set);
}

/// Changes bits of an endpoint's control register and sets its action bits.
pub fn control(offset: usize, clear: u32, set: u32) {
    modify(offset, endpoint::ACTIONS | clear, set);
}

/// Returns the next word received.
pub fn receive() -> u32 {
    read(fifo(0))
}

/// Writes a word for the host.
pub fn transmit(number: usize, word: u32) {
    write(fifo(number), word);
}
