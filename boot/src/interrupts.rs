//! The interrupts of the boot stage: a tick for waits to end by, the debug console's bytes, the card, USB.

use core::cell::RefCell;

use bsp_prime::board::enable_interrupt;
use bsp_prime::pac::{Interrupt, interrupt};
use bsp_prime::sd;
use bsp_prime::time::{self, Ticker};
use bsp_prime::uart::UartInterrupt;
use critical_section::Mutex;

const TICK_US: u32 = 1_000;

static OWNED: Mutex<RefCell<Option<(Ticker, UartInterrupt)>>> = Mutex::new(RefCell::new(None));

/// Starts the tick, and enables all interrupts.
pub fn start(mut tick: Ticker, debug: UartInterrupt) {
    tick.start(TICK_US);
    critical_section::with(|cs| OWNED.borrow(cs).replace(Some((tick, debug))));
    for interrupt in [Interrupt::TIM7, Interrupt::USART2, Interrupt::SDMMC1] {
        enable_interrupt(interrupt);
    }
}

/// Waits for an interrupt, a millisecond at most, with that of the USB core enabled meanwhile.
pub fn wait() {
    // With interrupts masked, an interrupt that comes before the wait still ends it.
    cortex_m::interrupt::free(|_| {
        enable_interrupt(Interrupt::OTG_FS);
        cortex_m::asm::wfi();
    });
}

fn with(action: impl FnOnce(&mut Ticker, &mut UartInterrupt)) {
    critical_section::with(|cs| {
        if let Some((tick, debug)) = OWNED.borrow(cs).borrow_mut().as_mut() {
            action(tick, debug);
        }
    });
}

#[interrupt]
fn TIM7() {
    time::keep_clocks();
    with(|tick, _| {
        tick.acknowledge();
    });
}

#[interrupt]
fn USART2() {
    // Received bytes are dropped.
    with(|_, debug| debug.on_interrupt(|_| {}));
}

#[interrupt]
fn SDMMC1() {
    sd::on_interrupt();
}

#[interrupt]
fn OTG_FS() {
    // The USB device is run by the loop that waits here.
    cortex_m::peripheral::NVIC::mask(Interrupt::OTG_FS);
}
