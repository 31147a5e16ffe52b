//! The debug console's port in the three ways firmware uses one, each echoing a line in upper case: polled,
//! after an overrun; by interrupts; by DMA in both directions, where the idle line ends a message of unknown
//! length.
#![no_std]
#![no_main]

use core::fmt::Write;
use core::sync::atomic::{AtomicBool, AtomicU8, AtomicUsize, Ordering, fence};

use cortex_m::asm::{delay, wfi};
use cortex_m::peripheral::NVIC;
use cortex_m_rt::entry;
use images::{Console, pac, pass, start_clocks, wait_for};
use pac::interrupt;

const ROOM: usize = 64;
const UE_RE_TE: u32 = 1 | 1 << 2 | 1 << 3;
const IDLEIE: u32 = 1 << 4;
const RXNEIE: u32 = 1 << 5;
const TXEIE: u32 = 1 << 7;
const DMAR_DMAT: u32 = 1 << 6 | 1 << 7;
/// Requests of USART2 at the first multiplexer, RM0399 table 120.
const USART2_RX: u32 = 43;
const USART2_TX: u32 = 44;
/// Stream control: enable, memory to peripheral, memory increment.
const EN: u32 = 1;
const TO_PERIPHERAL: u32 = 1 << 6;
const MINC: u32 = 1 << 10;
/// Transfer complete of stream 1, in LISR and LIFCR.
const TCIF1: u32 = 1 << 11;

/// Bytes that the interrupt has taken from the line, and the number of bytes sent back.
static TAKEN: [AtomicU8; ROOM] = [const { AtomicU8::new(0) }; ROOM];
static COUNT: AtomicUsize = AtomicUsize::new(0);
static SENT: AtomicUsize = AtomicUsize::new(0);
static IDLE: AtomicBool = AtomicBool::new(false);

#[interrupt]
fn USART2() {
    // SAFETY: main leaves the registers of the port alone while interrupts are on.
    let port = unsafe { &*pac::USART2::ptr() };
    let (status, control) = (port.isr.read(), port.cr1.read().bits());
    if status.idle().bit() {
        // SAFETY: IDLECF.
        port.icr.write(|w| unsafe { w.bits(1 << 4) });
        IDLE.store(true, Ordering::Release);
    }
    if status.rxne().bit() && control & RXNEIE != 0 {
        let count = COUNT.load(Ordering::Relaxed);
        TAKEN[count].store(port.rdr.read().bits() as u8, Ordering::Relaxed);
        COUNT.store(count + 1, Ordering::Release);
        // SAFETY: there is something to send.
        port.cr1.modify(|r, w| unsafe { w.bits(r.bits() | TXEIE) });
    }
    if status.txe().bit() && control & TXEIE != 0 {
        let sent = SENT.load(Ordering::Relaxed);
        if sent < COUNT.load(Ordering::Relaxed) {
            port.tdr.write(|w| w.tdr().bits(u16::from(TAKEN[sent].load(Ordering::Relaxed).to_ascii_uppercase())));
            SENT.store(sent + 1, Ordering::Release);
        } else {
            // SAFETY: nothing left.
            port.cr1.modify(|r, w| unsafe { w.bits(r.bits() & !TXEIE) });
        }
    }
}

/// Receives two characters without reading the first: the second is lost, the first is kept (RM0399, "Overrun
/// error").
fn overrun(console: &Console<'_>, port: &pac::USART2) {
    wait_for("an overrun", || port.isr.read().ore().bit());
    assert_eq!(console.get(), Some(b'1'));
    assert_eq!(console.get(), None);
    // SAFETY: ORECF.
    port.icr.write(|w| unsafe { w.bits(1 << 3) });
    assert!(!port.isr.read().ore().bit());
}

fn polled(console: &Console<'_>) {
    loop {
        let Some(byte) = console.get() else { continue };
        console.put(byte.to_ascii_uppercase());
        if byte == b'\n' {
            return console.drain();
        }
    }
}

fn by_interrupts(port: &pac::USART2) {
    // SAFETY: the handler's state is its own.
    unsafe { NVIC::unmask(pac::Interrupt::USART2) };
    // SAFETY: enabled, both directions, an interrupt for each character.
    port.cr1.write(|w| unsafe { w.bits(UE_RE_TE | RXNEIE) });
    loop {
        // Interrupts are masked between the check and the sleep; a pending interrupt ends the sleep all the
        // same.
        let over = cortex_m::interrupt::free(|_| {
            let count = COUNT.load(Ordering::Acquire);
            let over =
                count > 0 && TAKEN[count - 1].load(Ordering::Relaxed) == b'\n' && SENT.load(Ordering::Acquire) == count;
            if !over {
                wfi();
            }
            over
        });
        if over {
            break;
        }
    }
    wait_for("TC", || port.isr.read().tc().bit());
    NVIC::mask(pac::Interrupt::USART2);
}

/// Receives a message by DMA and sends it back. Returns its length.
fn by_dma(dp: &pac::Peripherals, buffer: &mut [u8; ROOM]) -> usize {
    let (port, receive, send) = (&dp.USART2, &dp.DMA1.st[0], &dp.DMA1.st[1]);
    // SAFETY: the buffer lives until both streams are off; addresses are those of its memory and of the port.
    unsafe {
        receive.par.write(|w| w.bits(port.rdr.as_ptr() as u32));
        receive.m0ar.write(|w| w.bits(buffer.as_mut_ptr() as u32));
        receive.ndtr.write(|w| w.bits(ROOM as u32));
        receive.cr.write(|w| w.bits(MINC | EN));
    }
    while cortex_m::interrupt::free(|_| {
        let waiting = !IDLE.load(Ordering::Acquire);
        if waiting {
            wfi();
        }
        waiting
    }) {}
    IDLE.store(false, Ordering::Relaxed);
    // SAFETY: off, and then the rest is known.
    receive.cr.modify(|r, w| unsafe { w.bits(r.bits() & !EN) });
    wait_for("the stream to stop", || receive.cr.read().bits() & EN == 0);
    let length = ROOM - receive.ndtr.read().bits() as usize;
    fence(Ordering::SeqCst);
    buffer[..length].make_ascii_uppercase();
    fence(Ordering::SeqCst);
    // SAFETY: as above.
    unsafe {
        dp.DMA1.lifcr.write(|w| w.bits(0xF7D));
        send.par.write(|w| w.bits(port.tdr.as_ptr() as u32));
        send.m0ar.write(|w| w.bits(buffer.as_ptr() as u32));
        send.ndtr.write(|w| w.bits(length as u32));
        send.cr.write(|w| w.bits(MINC | TO_PERIPHERAL | EN));
    }
    wait_for("the transfer", || dp.DMA1.lisr.read().bits() & TCIF1 != 0);
    wait_for("TC", || port.isr.read().tc().bit());
    length
}

#[entry]
fn main() -> ! {
    let dp = pac::Peripherals::take().unwrap();
    start_clocks(&dp);
    let mut console = Console::new(&dp);
    overrun(&console, &dp.USART2);
    polled(&console);
    by_interrupts(&dp.USART2);

    dp.RCC.ahb1enr.modify(|_, w| w.dma1en().set_bit());
    // The line fell idle after the lines before as well, so the mark is cleared.
    IDLE.store(false, Ordering::Relaxed);
    // SAFETY: the requests of USART2 to the first two streams; an interrupt for the idle line alone.
    unsafe {
        dp.DMAMUX1.ccr[0].write(|w| w.bits(USART2_RX));
        dp.DMAMUX1.ccr[1].write(|w| w.bits(USART2_TX));
        dp.USART2.icr.write(|w| w.bits(1 << 4));
        dp.USART2.cr3.write(|w| w.bits(DMAR_DMAT));
        dp.USART2.cr1.write(|w| w.bits(UE_RE_TE | IDLEIE));
        NVIC::unmask(pac::Interrupt::USART2);
    }
    let mut buffer = [0; ROOM];
    let lengths = [by_dma(&dp, &mut buffer), by_dma(&dp, &mut buffer)];
    NVIC::mask(pac::Interrupt::USART2);
    delay(1_000);
    // SAFETY: polled again.
    dp.USART2.cr3.write(|w| unsafe { w.bits(0) });
    let _ = writeln!(console, "{} {}", lengths[0], lengths[1]);
    console.drain();
    pass()
}
