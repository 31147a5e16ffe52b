//! The SD card at the controller's registers, by RM0399 chapter 58 and the SD specification.

use crate::{pac, wait_for};

/// RESP formats of SDMMC_CMDR.
pub const NONE: u32 = 0;
pub const SHORT: u32 = 1 << 8;
pub const SHORT_UNCHECKED: u32 = 2 << 8;
pub const LONG: u32 = 3 << 8;
pub const CMDTRANS: u32 = 1 << 6;
pub const CMDSTOP: u32 = 1 << 7;
const CPSMEN: u32 = 1 << 12;
/// SDMMC_DCTRL: direction from the card, and blocks of 512 bytes.
pub const DTDIR: u32 = 1 << 1;
pub const BLOCK: u32 = 9 << 4;
const ALL_FLAGS: u32 = 0x1FE0_0FFF;
/// Number of words in a block.
pub const WORDS: usize = 128;
/// SDMMC_STAR: flags that end a command, and errors of data.
const COMMAND_OVER: u32 = 0xC5;
const COMMAND_FAILED: u32 = 0x05;
pub const DATA_ERRORS: u32 = 0x3A;
pub const CTIMEOUT: u32 = 1 << 2;
pub const TXUNDERR: u32 = 1 << 4;
pub const RXOVERR: u32 = 1 << 5;
pub const DATAEND: u32 = 1 << 8;
pub const DABORT: u32 = 1 << 11;
pub const DPSMACT: u32 = 1 << 12;
pub const TXFIFOHE: u32 = 1 << 14;
pub const RXFIFOHF: u32 = 1 << 15;
pub const TXFIFOF: u32 = 1 << 16;
pub const RXFIFOE: u32 = 1 << 19;
/// SDMMC_CLKCR: dividers for 400 kHz and 25 MHz from 200 MHz, four lines, hardware flow control.
pub const IDENTIFY: u32 = 250;
pub const FAST: u32 = 4;
pub const FOUR_LINES: u32 = 1 << 14;
pub const FLOW_CONTROL: u32 = 1 << 17;

/// Registers of the SDMMC1 controller.
pub struct Host<'a>(pub &'a pac::SDMMC1);

impl Host<'_> {
    /// Reads the flags of SDMMC_STAR.
    pub fn status(&self) -> u32 {
        self.0.star.read().bits()
    }

    /// Sets the bus clock and width.
    pub fn clock(&self, bits: u32) {
        // SAFETY: every bit of the register is writable.
        self.0.clkcr.write(|w| unsafe { w.bits(bits) });
    }

    /// Carries out a command, with success or not. Returns the flags.
    pub fn attempt(&self, index: u32, argument: u32, kind: u32) -> u32 {
        // SAFETY: every bit of these registers is writable.
        unsafe {
            self.0.icr.write(|w| w.bits(ALL_FLAGS));
            self.0.argr.write(|w| w.bits(argument));
            self.0.cmdr.write(|w| w.bits(index | kind | CPSMEN));
        }
        wait_for("the end of a command", || self.status() & COMMAND_OVER != 0);
        self.status()
    }

    /// Carries out a command and returns its first response word. Panics when it times out.
    #[track_caller]
    pub fn command(&self, index: u32, argument: u32, kind: u32) -> u32 {
        let status = self.attempt(index, argument, kind);
        assert!(status & COMMAND_FAILED == 0, "CMD{index}: status {status:#x}");
        self.0.resp1r.read().bits()
    }

    /// Prepares the data path for this many bytes.
    pub fn expect(&self, bytes: u32, direction: u32, block: u32) {
        // SAFETY: every bit of these registers is writable.
        unsafe {
            self.0.dtimer.write(|w| w.bits(u32::MAX));
            self.0.dlenr.write(|w| w.bits(bytes));
            self.0.dctrl.write(|w| w.bits(block | direction));
        }
    }

    /// Points the internal DMA at a buffer, or switches it off.
    pub fn dma(&self, buffer: Option<u32>) {
        // SAFETY: the buffer outlives the transfer, which the caller waits for.
        unsafe {
            self.0.idmabase0r.write(|w| w.bits(buffer.unwrap_or(0)));
            self.0.idmactrlr.write(|w| w.bits(u32::from(buffer.is_some())));
        }
    }

    /// Waits for the end of a transfer, and panics unless it is a good one.
    #[track_caller]
    pub fn wait_data(&self) {
        wait_for("DATAEND", || self.status() & (DATAEND | DATA_ERRORS) != 0);
        assert!(self.status() & DATA_ERRORS == 0, "data status {:#x}", self.status());
    }

    /// Waits until the card has programmed the last data.
    pub fn wait_programmed(&self, address: u32) {
        wait_for("the end of programming", || self.command(13, address, SHORT) >> 9 & 0xF == 4);
    }

    /// Powers up, identifies and selects the card. Returns the card's address. The bus stays at one line and
    /// 400 kHz.
    pub fn identify(&self) -> u32 {
        self.clock(IDENTIFY);
        // SAFETY: PWRCTRL = on.
        self.0.power.write(|w| unsafe { w.bits(3) });
        // A millisecond is longer than 74 clocks.
        cortex_m::asm::delay(400_000);
        self.command(0, 0, NONE);
        assert_eq!(self.command(8, 0x1AA, SHORT) & 0xFFF, 0x1AA);
        wait_for("the card's power-up", || {
            self.command(55, 0, SHORT);
            self.command(41, 0x4010_0000, SHORT_UNCHECKED) >> 31 == 1
        });
        self.command(2, 0, LONG);
        let address = self.command(3, 0, SHORT) & 0xFFFF_0000;
        self.command(9, address, LONG);
        self.command(7, address, SHORT);
        address
    }

    /// Switches to four data lines at 25 MHz, with these bits of SDMMC_CLKCR besides.
    pub fn widen(&self, address: u32, bits: u32) {
        self.command(55, address, SHORT);
        self.command(6, 2, SHORT);
        self.clock(FAST | FOUR_LINES | bits);
    }
}
