//! Reads block 5 of every card that comes into the slot and prints its first word. A card that is gone
//! answers no status; for the next card the controller is reset by RCC, since POWER can be switched on only
//! once (RM0399, 58.10.1).
#![no_std]
#![no_main]

use core::fmt::Write;

use cortex_m_rt::entry;
use images::sd::{BLOCK, CMDTRANS, CTIMEOUT, DTDIR, FLOW_CONTROL, Host, IDENTIFY, NONE, RXFIFOE, SHORT, WORDS};
use images::{Console, pac, pass, start_clocks, wait_for};

const CARDS: u32 = 3;

fn reset(rcc: &pac::RCC) {
    rcc.ahb3rstr.modify(|_, w| w.sdmmc1rst().set_bit());
    rcc.ahb3rstr.modify(|_, w| w.sdmmc1rst().clear_bit());
}

/// Whether a card answers to CMD8 after CMD0.
fn present(host: &Host<'_>) -> bool {
    host.clock(IDENTIFY);
    // SAFETY: PWRCTRL = on.
    host.0.power.write(|w| unsafe { w.bits(3) });
    cortex_m::asm::delay(400_000);
    host.attempt(0, 0, NONE);
    host.attempt(8, 0x1AA, SHORT) & CTIMEOUT == 0
}

#[entry]
fn main() -> ! {
    let dp = pac::Peripherals::take().unwrap();
    start_clocks(&dp);
    let mut console = Console::new(&dp);
    dp.RCC.ahb3enr.modify(|_, w| w.sdmmc1en().set_bit());
    let host = Host(&dp.SDMMC1);
    for _ in 0..CARDS {
        reset(&dp.RCC);
        while !present(&host) {
            reset(&dp.RCC);
            cortex_m::asm::delay(400_000);
        }
        let address = host.identify();
        host.widen(address, FLOW_CONTROL);
        host.expect(512, DTDIR, BLOCK);
        host.command(17, 5, SHORT | CMDTRANS);
        for index in 0..WORDS {
            wait_for("a word", || host.status() & RXFIFOE == 0);
            let word = host.0.fifor.read().bits();
            if index == 0 {
                let _ = writeln!(console, "{word:#010x}");
            }
        }
        host.wait_data();
        while host.attempt(13, address, SHORT) & CTIMEOUT == 0 {
            cortex_m::asm::delay(40_000);
        }
        let _ = writeln!(console, "gone");
    }
    console.drain();
    pass()
}
