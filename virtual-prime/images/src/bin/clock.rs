//! Sets the real-time clock, lets a second pass and reads it back.
#![no_std]
#![no_main]

use cortex_m_rt::entry;
use images::{pac, pass, start_clocks, wait_for};

#[entry]
fn main() -> ! {
    let dp = pac::Peripherals::take().unwrap();
    start_clocks(&dp);
    dp.PWR.cr1.modify(|_, w| w.dbp().set_bit());
    dp.RCC.bdcr.modify(|_, w| w.lseon().set_bit());
    while !dp.RCC.bdcr.read().lserdy().bit() {
        cortex_m::asm::delay(400_000);
    }
    dp.RCC.bdcr.modify(|_, w| w.rtcsel().lse().rtcen().set_bit());

    // SAFETY: the keys, INIT, and a date and time in the registers' own format.
    unsafe {
        dp.RTC.wpr.write(|w| w.bits(0xCA));
        dp.RTC.wpr.write(|w| w.bits(0x53));
        dp.RTC.isr.modify(|r, w| w.bits(r.bits() | 1 << 7));
    }
    wait_for("INITF", || dp.RTC.isr.read().initf().bit());
    // SAFETY: Tuesday, 31 December 2024, 23:59:59.
    unsafe {
        dp.RTC.tr.write(|w| w.bits(0x23_5959));
        dp.RTC.dr.write(|w| w.bits(0x24_5231));
        dp.RTC.isr.modify(|r, w| w.bits(r.bits() & !(1 << 7 | 1 << 5)));
        dp.RTC.wpr.write(|w| w.bits(0xFF));
    }
    wait_for("RSF", || dp.RTC.isr.read().rsf().bit());
    assert_eq!(dp.RTC.tr.read().bits(), 0x23_5959);
    assert_eq!(dp.RTC.dr.read().bits(), 0x24_5231);
    // A delay of 1.1 s.
    cortex_m::asm::delay(440_000_000);
    assert_eq!(dp.RTC.tr.read().bits(), 0);
    assert_eq!(dp.RTC.dr.read().bits(), 0x25_6101);
    assert!(dp.RTC.isr.read().inits().bit());
    pass()
}
