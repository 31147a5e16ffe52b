//! Starts the independent watchdog, feeds it, then lets it reset the part; after the reset finds its flag.
#![no_std]
#![no_main]

use core::fmt::Write;

use cortex_m_rt::entry;
use images::{Console, pac, pass, start_clocks, wait_for};

#[entry]
fn main() -> ! {
    let dp = pac::Peripherals::take().unwrap();
    start_clocks(&dp);
    let mut console = Console::new(&dp);
    if dp.RCC.rsr.read().iwdg1rstf().bit() {
        let _ = writeln!(console, "bitten");
        console.drain();
        pass()
    }
    // SAFETY: keys, prescaler 4 and reload 319 of the manual: (319 + 1) / 8 kHz = 40 ms.
    unsafe {
        dp.IWDG1.kr.write(|w| w.bits(0xCCCC));
        dp.IWDG1.kr.write(|w| w.bits(0x5555));
        dp.IWDG1.pr.write(|w| w.bits(0));
        dp.IWDG1.rlr.write(|w| w.bits(319));
    }
    wait_for("the watchdog's registers", || dp.IWDG1.sr.read().bits() == 0);
    for _ in 0..5 {
        // SAFETY: the reload key.
        dp.IWDG1.kr.write(|w| unsafe { w.bits(0xAAAA) });
        // A delay of 30 ms.
        cortex_m::asm::delay(12_000_000);
    }
    let _ = writeln!(console, "fed");
    loop {
        cortex_m::asm::wfi();
    }
}
