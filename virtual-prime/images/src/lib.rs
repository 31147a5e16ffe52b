//! Shared code of the images: the board's start-up sequence, a console, and a way to end a run.
#![no_std]

pub mod sd;

use core::fmt::{self, Write};
use core::panic::PanicInfo;

use cortex_m_semihosting::debug::{self, EXIT_FAILURE, EXIT_SUCCESS};
pub use stm32h7::stm32h747cm7 as pac;

/// Number of polls allowed for anything that must come.
const PATIENCE: u32 = 2_000_000;

/// Waits for a condition; a run that waits in vain fails with the place in its message.
#[track_caller]
pub fn wait_for(what: &str, condition: impl Fn() -> bool) {
    for _ in 0..PATIENCE {
        if condition() {
            return;
        }
    }
    panic!("waited in vain for {what}");
}

/// Starts direct SMPS supply, voltage scale 1, 400 MHz from the 25 MHz crystal, 200 MHz AHB, 100 MHz APB, as
/// RM0399 chapters 7 and 9 order it.
pub fn start_clocks(dp: &pac::Peripherals) {
    // SAFETY: the value is one of RM0399 table 32's configurations: SDEN alone.
    dp.PWR.cr3.write(|w| unsafe { w.bits(0x0000_0004) });
    wait_for("ACTVOSRDY", || dp.PWR.csr1.read().actvosrdy().bit());
    // SAFETY: VOS = 0b11 is scale 1.
    dp.PWR.d3cr.write(|w| unsafe { w.vos().bits(0b11) });
    wait_for("VOSRDY", || dp.PWR.d3cr.read().vosrdy().bit());

    let rcc = &dp.RCC;
    rcc.cr.modify(|_, w| w.hseon().set_bit());
    wait_for("HSERDY", || rcc.cr.read().hserdy().bit());
    // SAFETY: PLL1 from HSE (2), DIVM1 = 5; N = 160, P = 2, Q = 4, R = 2 in the minus-one encoding of 9.7.14.
    unsafe {
        rcc.pllckselr.write(|w| w.bits(2 | 5 << 4));
        // PLL1 has 4 to 8 MHz in, wide VCO, outputs P and Q.
        rcc.pllcfgr.write(|w| w.bits(0b10 << 2 | 1 << 16 | 1 << 17));
        rcc.pll1divr.write(|w| w.bits(159 | 1 << 9 | 3 << 16 | 1 << 24));
    }
    rcc.cr.modify(|_, w| w.pll1on().set_bit());
    wait_for("PLL1RDY", || rcc.cr.read().pll1rdy().bit());
    // SAFETY: HPRE = /2; D1PPRE, D2PPRE1, D2PPRE2, D3PPRE = /2; flash with four wait states, WRHIGHFREQ 2.
    unsafe {
        rcc.d1cfgr.write(|w| w.bits(0b1000 | 0b100 << 4));
        rcc.d2cfgr.write(|w| w.bits(0b100 << 4 | 0b100 << 8));
        rcc.d3cfgr.write(|w| w.bits(0b100 << 4));
    }
    dp.FLASH.acr.modify(|_, w| unsafe { w.bits(0x24) });
    rcc.cfgr.modify(|_, w| w.sw().pll1());
    wait_for("SWS", || rcc.cfgr.read().sws().is_pll1());
}

/// The debug console, USART2 on PD5 and PD6, 115200 baud from PCLK1 = 100 MHz.
pub struct Console<'a>(&'a pac::USART2);

impl<'a> Console<'a> {
    /// Switches the USART on.
    pub fn new(dp: &'a pac::Peripherals) -> Self {
        dp.RCC.ahb4enr.modify(|_, w| w.gpioden().set_bit());
        dp.RCC.apb1lenr.modify(|_, w| w.usart2en().set_bit());
        // SAFETY: alternate function 7 for PD5 and PD6.
        dp.GPIOD.afrl.modify(|r, w| unsafe { w.bits(r.bits() & !0x0FF0_0000 | 0x0770_0000) });
        dp.GPIOD.moder.modify(|_, w| w.moder5().alternate().moder6().alternate());
        dp.USART2.brr.write(|w| unsafe { w.bits(868) });
        dp.USART2.cr1.write(|w| w.ue().set_bit().te().set_bit().re().set_bit());
        Self(&dp.USART2)
    }

    /// Sends a byte once the transmit register is empty.
    pub fn put(&self, byte: u8) {
        wait_for("TXE", || self.0.isr.read().txe().bit());
        self.0.tdr.write(|w| w.tdr().bits(u16::from(byte)));
    }

    /// Returns a received byte, if there is one.
    pub fn get(&self) -> Option<u8> {
        self.0.isr.read().rxne().bit().then(|| self.0.rdr.read().rdr().bits() as u8)
    }

    /// Waits until the last byte is on the wire.
    pub fn drain(&self) {
        wait_for("TC", || self.0.isr.read().tc().bit());
    }
}

impl Write for Console<'_> {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        text.bytes().for_each(|byte| self.put(byte));
        Ok(())
    }
}

/// Ends the run, as every check held.
pub fn pass() -> ! {
    loop {
        debug::exit(EXIT_SUCCESS);
    }
}

#[panic_handler]
fn panic(info: &PanicInfo<'_>) -> ! {
    if let Ok(mut out) = cortex_m_semihosting::hio::hstdout() {
        let _ = writeln!(out, "{info}");
    }
    loop {
        debug::exit(EXIT_FAILURE);
    }
}
