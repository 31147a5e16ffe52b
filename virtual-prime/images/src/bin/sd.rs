//! Identifies the SD card and moves blocks through the FIFO and through the internal DMA, as RM0399 chapter 58 and the
//! SD specification describe it.
#![no_std]
#![no_main]

use cortex_m_rt::entry;
use images::{pac, pass, start_clocks, wait_for};

/// RESP formats of SDMMC_CMDR.
const NONE: u32 = 0;
const SHORT: u32 = 1 << 8;
const SHORT_UNCHECKED: u32 = 2 << 8;
const LONG: u32 = 3 << 8;
const CMDTRANS: u32 = 1 << 6;
const CMDSTOP: u32 = 1 << 7;
const CPSMEN: u32 = 1 << 12;
const DTDIR: u32 = 1 << 1;
/// Blocks of 512 bytes.
const BLOCK: u32 = 9 << 4;
const ALL_FLAGS: u32 = 0x1FE0_0FFF;
const WORDS: usize = 128;

struct Host<'a>(&'a pac::SDMMC1);

impl Host<'_> {
    fn status(&self) -> u32 {
        self.0.star.read().bits()
    }

    /// A command; its first response word. Panics when it times out.
    fn command(&self, index: u32, argument: u32, kind: u32) -> u32 {
        // SAFETY: every bit of these registers is writable.
        unsafe {
            self.0.icr.write(|w| w.bits(ALL_FLAGS));
            self.0.argr.write(|w| w.bits(argument));
            self.0.cmdr.write(|w| w.bits(index | kind | CPSMEN));
        }
        wait_for("the end of a command", || self.status() & 0xC5 != 0);
        assert!(self.status() & 0x05 == 0, "CMD{index}: status {:#x}", self.status());
        self.0.resp1r.read().bits()
    }

    /// Prepares the data path for this many bytes.
    fn expect(&self, bytes: u32, direction: u32, block: u32) {
        // SAFETY: every bit of these registers is writable.
        unsafe {
            self.0.dtimer.write(|w| w.bits(u32::MAX));
            self.0.dlenr.write(|w| w.bits(bytes));
            self.0.dctrl.write(|w| w.bits(block | direction));
        }
    }

    /// Points the internal DMA at a buffer, or switches it off.
    fn dma(&self, buffer: Option<u32>) {
        // SAFETY: the buffer outlives the transfer, which the caller waits for.
        unsafe {
            self.0.idmabase0r.write(|w| w.bits(buffer.unwrap_or(0)));
            self.0.idmactrlr.write(|w| w.bits(u32::from(buffer.is_some())));
        }
    }

    fn wait_data(&self) {
        wait_for("DATAEND", || self.status() & (1 << 8 | 0x3A) != 0);
        assert!(self.status() & 0x3A == 0, "data status {:#x}", self.status());
    }
}

/// Power-up, identification, four data lines: the card's address.
fn identify(host: &Host<'_>) -> u32 {
    // SAFETY: PWRCTRL = on; CLKDIV = 250: 400 kHz from 200 MHz.
    unsafe {
        host.0.clkcr.write(|w| w.bits(250));
        host.0.power.write(|w| w.bits(3));
    }
    host.command(0, 0, NONE);
    assert_eq!(host.command(8, 0x1AA, SHORT) & 0xFFF, 0x1AA);
    wait_for("the card's power-up", || {
        host.command(55, 0, SHORT);
        host.command(41, 0x4010_0000, SHORT_UNCHECKED) >> 31 == 1
    });
    host.command(2, 0, LONG);
    let address = host.command(3, 0, SHORT) & 0xFFFF_0000;
    host.command(9, address, LONG);
    host.command(7, address, SHORT);
    host.command(55, address, SHORT);
    host.command(6, 2, SHORT);
    // SAFETY: CLKDIV = 4: 25 MHz; four data lines; hardware flow control.
    host.0.clkcr.write(|w| unsafe { w.bits(4 | 1 << 14 | 1 << 17) });
    address
}

/// One block through the FIFO.
fn read_block(host: &Host<'_>, block: u32, into: &mut [u32; WORDS]) {
    host.dma(None);
    host.expect(512, DTDIR, BLOCK);
    host.command(17, block, SHORT | CMDTRANS);
    let mut words = into.iter_mut();
    while words.len() > 0 {
        wait_for("RXFIFOHF", || host.status() & (1 << 15) != 0);
        words.by_ref().take(8).for_each(|word| *word = host.0.fifor.read().bits());
    }
    host.wait_data();
}

#[entry]
fn main() -> ! {
    let dp = pac::Peripherals::take().unwrap();
    start_clocks(&dp);
    dp.RCC.ahb3enr.modify(|_, w| w.sdmmc1en().set_bit());
    let host = Host(&dp.SDMMC1);
    let address = identify(&host);

    let mut boot = [0; WORDS];
    read_block(&host, 0, &mut boot);
    assert_eq!(boot[127] >> 16, 0xAA55, "the volume's first block ends in its signature");

    // Three blocks out through the DMA, and back in one go.
    let mut pattern = [0_u32; 3 * WORDS];
    pattern.iter_mut().zip(0x1000_0000..).for_each(|(word, value)| *word = value);
    let last = 100_000;
    host.dma(Some(pattern.as_ptr() as u32));
    host.expect(3 * 512, 0, BLOCK);
    host.command(25, last, SHORT | CMDTRANS);
    host.wait_data();
    host.command(12, 0, SHORT | CMDSTOP);
    wait_for("the end of programming", || host.command(13, address, SHORT) >> 9 & 0xF == 4);

    let mut back = [0_u32; 3 * WORDS];
    host.dma(Some(back.as_mut_ptr() as u32));
    host.expect(3 * 512, DTDIR, BLOCK);
    host.command(18, last, SHORT | CMDTRANS);
    host.wait_data();
    host.command(12, 0, SHORT | CMDSTOP);
    cortex_m::asm::dsb();
    assert!(back == pattern, "what comes back is not what was written");

    // A block out through the FIFO, and back.
    host.dma(None);
    host.expect(512, 0, BLOCK);
    host.command(24, last + 7, SHORT | CMDTRANS);
    for burst in pattern[..WORDS].chunks(8) {
        wait_for("TXFIFOHE", || host.status() & (1 << 14) != 0);
        // SAFETY: the FIFO takes any word.
        burst.iter().for_each(|&word| host.0.fifor.write(|w| unsafe { w.bits(word) }));
    }
    host.wait_data();
    wait_for("the end of programming", || host.command(13, address, SHORT) >> 9 & 0xF == 4);
    read_block(&host, last + 7, &mut boot);
    assert!(boot == pattern[..WORDS], "what comes back is not what was written");

    // The internal DMA does not reach the TCMs.
    host.dma(Some(0x2000_0000));
    host.expect(512, DTDIR, BLOCK);
    host.command(17, 0, SHORT | CMDTRANS);
    wait_for("IDMATE", || host.status() & (1 << 27) != 0);
    pass()
}
