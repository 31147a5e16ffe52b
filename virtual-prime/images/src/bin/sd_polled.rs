//! Reads and writes the SD card through the FIFO alone, by polling: a word at a time by RXFIFOE and TXFIFOF,
//! and by halves of the FIFO by RXFIFOHF and TXFIFOHE; with hardware flow control and without; with one data
//! line and with four; single blocks and several. Then tests the two errors of a FIFO that is not served, and
//! the stopping of a transfer.
#![no_std]
#![no_main]

use cortex_m_rt::entry;
use images::sd::{
    BLOCK, CMDSTOP, CMDTRANS, CTIMEOUT, DABORT, DATA_ERRORS, DATAEND, DPSMACT, DTDIR, FAST, FLOW_CONTROL, Host,
    IDENTIFY, RXFIFOE, RXFIFOHF, RXOVERR, SHORT, TXFIFOF, TXFIFOHE, TXUNDERR, WORDS,
};
use images::{pac, pass, start_clocks, wait_for};

const BLOCKS: usize = 3;
const HALF: usize = 8;
const FIRST: u32 = 90_000;

/// Flags that pace the words.
#[derive(Clone, Copy)]
enum By {
    Word,
    Half,
}

fn fetch(host: &Host<'_>, by: By, into: &mut [u32]) {
    let (flag, set, count) = match by {
        By::Word => (RXFIFOE, false, 1),
        By::Half => (RXFIFOHF, true, HALF),
    };
    for part in into.chunks_mut(count) {
        wait_for("words from the card", || (host.status() & flag != 0) == set || host.status() & DATA_ERRORS != 0);
        part.iter_mut().for_each(|word| *word = host.0.fifor.read().bits());
    }
}

fn feed(host: &Host<'_>, by: By, words: &[u32]) {
    let (flag, set, count) = match by {
        By::Word => (TXFIFOF, false, 1),
        By::Half => (TXFIFOHE, true, HALF),
    };
    for part in words.chunks(count) {
        wait_for("room for words", || (host.status() & flag != 0) == set || host.status() & DATA_ERRORS != 0);
        // SAFETY: the FIFO takes any word.
        part.iter().for_each(|&word| host.0.fifor.write(|w| unsafe { w.bits(word) }));
    }
}

fn read(host: &Host<'_>, block: u32, by: By, into: &mut [u32]) {
    let many = into.len() > WORDS;
    host.expect(into.len() as u32 * 4, DTDIR, BLOCK);
    host.command(if many { 18 } else { 17 }, block, SHORT | CMDTRANS);
    fetch(host, by, into);
    host.wait_data();
    if many {
        host.command(12, 0, SHORT | CMDSTOP);
    }
}

fn write(host: &Host<'_>, address: u32, block: u32, by: By, words: &[u32]) {
    let many = words.len() > WORDS;
    host.expect(words.len() as u32 * 4, 0, BLOCK);
    host.command(if many { 25 } else { 24 }, block, SHORT | CMDTRANS);
    feed(host, by, words);
    host.wait_data();
    if many {
        host.command(12, 0, SHORT | CMDSTOP);
    }
    host.wait_programmed(address);
}

/// Writes blocks and reads them back, one and then several, by words and by halves.
fn round(host: &Host<'_>, address: u32, seed: u32) {
    let mut words = [0_u32; BLOCKS * WORDS];
    let mut back = [0_u32; BLOCKS * WORDS];
    for (by, other) in [(By::Word, By::Half), (By::Half, By::Word)] {
        for count in [1, BLOCKS] {
            let salt = seed << 16 | (count as u32) << 8 | by as u32;
            words.iter_mut().zip(0_u32..).for_each(|(word, index)| *word = salt.rotate_left(index & 31) ^ index);
            let (words, back) = (&words[..count * WORDS], &mut back[..count * WORDS]);
            write(host, address, FIRST + salt % 1_000, by, words);
            back.fill(0);
            read(host, FIRST + salt % 1_000, other, back);
            assert!(back == words, "what comes back is not what was written, round {seed}");
        }
    }
}

/// Tests an overrun: a block that nobody takes overruns the FIFO; the transfer stays open until it is
/// stopped.
fn overrun(host: &Host<'_>) {
    host.expect(512, DTDIR, BLOCK);
    host.command(17, FIRST, SHORT | CMDTRANS);
    wait_for("RXOVERR", || host.status() & (DATA_ERRORS | DATAEND) != 0);
    assert_eq!(host.status() & (DATA_ERRORS | DATAEND | DPSMACT), RXOVERR | DPSMACT);
    host.attempt(12, 0, SHORT | CMDSTOP);
    assert_eq!(host.status() & (DABORT | DPSMACT), DABORT);
}

/// Tests an underrun: only a part of a block is given.
fn underrun(host: &Host<'_>, address: u32) {
    host.expect(512, 0, BLOCK);
    host.command(24, FIRST, SHORT | CMDTRANS);
    feed(host, By::Word, &[0x5555_AAAA; 20]);
    wait_for("TXUNDERR", || host.status() & (DATA_ERRORS | DATAEND) != 0);
    assert_eq!(host.status() & (DATA_ERRORS | DATAEND | DPSMACT), TXUNDERR | DPSMACT);
    host.attempt(12, 0, SHORT | CMDSTOP);
    assert_eq!(host.status() & (DABORT | DPSMACT), DABORT);
    host.wait_programmed(address);
}

#[entry]
fn main() -> ! {
    let dp = pac::Peripherals::take().unwrap();
    start_clocks(&dp);
    dp.RCC.ahb3enr.modify(|_, w| w.sdmmc1en().set_bit());
    let host = Host(&dp.SDMMC1);
    let address = host.identify();

    // The answer to ACMD51 is the eight bytes of the SCR, at 400 kHz over one line: the second word comes 80
    // us after the first.
    host.command(16, 8, SHORT);
    host.command(55, address, SHORT);
    host.expect(8, DTDIR, 3 << 4);
    host.command(51, 0, SHORT | CMDTRANS);
    let mut scr = [0; 2];
    fetch(&host, By::Word, &mut scr);
    host.wait_data();
    assert_eq!(u32::from_be(scr[0]) >> 16 & 0xF, 5, "one and four data lines");
    host.command(16, 512, SHORT);

    for (seed, clock) in [(1, IDENTIFY), (2, FAST), (3, FAST | FLOW_CONTROL)] {
        host.clock(clock);
        round(&host, address, seed);
    }
    host.widen(address, 0);
    round(&host, address, 4);
    host.widen(address, FLOW_CONTROL);
    round(&host, address, 5);
    host.widen(address, 0);
    overrun(&host);
    underrun(&host, address);
    round(&host, address, 6);

    // POWER cannot be switched off again, short of a reset by RCC.
    dp.SDMMC1.power.write(|w| unsafe { w.bits(0) });
    assert_eq!(dp.SDMMC1.power.read().bits() & 3, 3);
    assert_eq!(host.attempt(13, address, SHORT) & CTIMEOUT, 0);
    dp.RCC.ahb3rstr.modify(|_, w| w.sdmmc1rst().set_bit());
    dp.RCC.ahb3rstr.modify(|_, w| w.sdmmc1rst().clear_bit());
    assert_eq!((dp.SDMMC1.power.read().bits(), dp.SDMMC1.clkcr.read().bits(), host.status()), (0, 0, 0));
    pass()
}
