//! Moves blocks through the FIFO and through the internal DMA, by RM0399 chapter 58 and the SD specification.
#![no_std]
#![no_main]

use cortex_m_rt::entry;
use images::sd::{BLOCK, CMDSTOP, CMDTRANS, DTDIR, FLOW_CONTROL, Host, SHORT, WORDS};
use images::{pac, pass, start_clocks, wait_for};

/// Reads a block through the FIFO.
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
    let address = host.identify();
    host.widen(address, FLOW_CONTROL);

    let mut boot = [0; WORDS];
    read_block(&host, 0, &mut boot);
    assert_eq!(boot[127] >> 16, 0xAA55, "the volume's first block ends in its signature");

    // Three blocks go out through the DMA, and back at once.
    let mut pattern = [0_u32; 3 * WORDS];
    pattern.iter_mut().zip(0x1000_0000..).for_each(|(word, value)| *word = value);
    let last = 100_000;
    host.dma(Some(pattern.as_ptr() as u32));
    host.expect(3 * 512, 0, BLOCK);
    host.command(25, last, SHORT | CMDTRANS);
    host.wait_data();
    host.command(12, 0, SHORT | CMDSTOP);
    host.wait_programmed(address);

    let mut back = [0_u32; 3 * WORDS];
    host.dma(Some(back.as_mut_ptr() as u32));
    host.expect(3 * 512, DTDIR, BLOCK);
    host.command(18, last, SHORT | CMDTRANS);
    host.wait_data();
    host.command(12, 0, SHORT | CMDSTOP);
    cortex_m::asm::dsb();
    assert!(back == pattern, "what comes back is not what was written");

    // A block goes out through the FIFO, and back.
    host.dma(None);
    host.expect(512, 0, BLOCK);
    host.command(24, last + 7, SHORT | CMDTRANS);
    for burst in pattern[..WORDS].chunks(8) {
        wait_for("TXFIFOHE", || host.status() & (1 << 14) != 0);
        // SAFETY: the FIFO takes any word.
        burst.iter().for_each(|&word| host.0.fifor.write(|w| unsafe { w.bits(word) }));
    }
    host.wait_data();
    host.wait_programmed(address);
    read_block(&host, last + 7, &mut boot);
    assert!(boot == pattern[..WORDS], "what comes back is not what was written");

    // The internal DMA does not reach the TCMs.
    host.dma(Some(0x2000_0000));
    host.expect(512, DTDIR, BLOCK);
    host.command(17, 0, SHORT | CMDTRANS);
    wait_for("IDMATE", || host.status() & (1 << 27) != 0);
    pass()
}
