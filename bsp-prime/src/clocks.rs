//! Supply and clock tree: SMPS, VOS1, 25 MHz crystal, 400 MHz core, 200 MHz buses, 100 MHz peripherals, and
//! the 48 MHz of USB by PLL3. The unused PLL2 and HSI48 are off.
//!
//! The HAL computes and switches, but its waits have no bound. So the crystal is started here first, with a
//! bound, and the watchdog already runs when [`freeze`] is called: should a PLL or the supply never report
//! ready, the board resets with its outputs off instead of hanging.

use stm32h7xx_hal::pac;
use stm32h7xx_hal::prelude::*;
use stm32h7xx_hal::rcc::{Ccdr, PllConfigStrategy};

use crate::wait;

/// Clock of the M7 core.
pub const CORE_HZ: u32 = 400_000_000;
/// AXI and AHB clock.
pub const HCLK_HZ: u32 = 200_000_000;
/// Clock of the APB1, APB2, APB3 and APB4 peripherals.
pub const PCLK_HZ: u32 = 100_000_000;
/// Clock of the timers on APB1 and APB2: twice the bus clock (RM0399 section 9.5, TIMPRE = 0).
pub const TIMER_HZ: u32 = 200_000_000;
/// Frequency of the crystal on PH0/PH1.
pub const CRYSTAL_HZ: u32 = 25_000_000;
/// Kernel clock of SDMMC1: PLL1 Q, the reset choice of its multiplexer.
pub const SDMMC_KERNEL_HZ: u32 = 200_000_000;

/// Limit of the crystal's start, which should take 2 ms (data sheet DS12923 table "HSE oscillator
/// characteristics"); ten times that.
const CRYSTAL_START_LIMIT_US: u32 = 20_000;

/// Two wait states more than the manual asks for at 200 MHz and VOS1, in a row that ends at 210 MHz (RM0399
/// section 4.3.8, table of recommended wait states): what boards are known to run with. Reads that miss the
/// caches take 10 ns longer; what is in a hurry runs from ITCM.
const FLASH_WAIT_STATES: u8 = 4;
/// Programming delay, WRHIGHFREQ, as long as its field allows: known good with these wait states.
const FLASH_PROGRAMMING_DELAY: u8 = 3;
/// The flash takes its new wait states within a few bus clocks.
const FLASH_LIMIT_US: u32 = 100;

/// Failure of the clock tree.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ClockError {
    /// The 25 MHz crystal did not start.
    NoCrystal,
    /// The clock tree did not come out as designed; carries the core clock in hertz.
    Wrong(u32),
    /// The flash did not take its wait states.
    FlashTiming,
}

/// Starts the crystal and waits for it, at most 20 ms.
///
/// # Errors
/// [`ClockError::NoCrystal`].
pub fn start_crystal(rcc: &pac::RCC) -> Result<(), ClockError> {
    // RM0399 section 9.7.2, RCC_CR: HSEON, then HSERDY.
    rcc.cr.modify(|_, w| w.hseon().on());
    wait::until(CRYSTAL_START_LIMIT_US, || rcc.cr.read().hserdy().is_ready()).map_err(|_| ClockError::NoCrystal)
}

/// Watches the crystal: when it stops, the core runs on from the 64 MHz oscillator and takes an NMI (RM0399
/// section 9.5.3). Without, a processor whose clock has stopped would leave every output as it is until the
/// watchdog, which has a clock of its own, resets it. A reset ends the watch.
///
/// Not by the boot stage: the application starts the crystal anew.
pub(crate) fn watch_crystal() {
    // RM0399 section 9.7.2, RCC_CR: HSECSSON; set by software, cleared by a reset alone.
    // SAFETY: `freeze` consumed the RCC token, and this runs once, before any interrupt is enabled.
    unsafe { (*pac::RCC::ptr()).cr.modify(|_, w| w.hsecsson().on()) };
}

/// Sets supply and clocks. Call once, after [`start_crystal`] and with the watchdog running.
///
/// # Errors
/// [`ClockError::Wrong`] when the tree differs from the constants of this module, on which every timer and
/// baud rate is built; [`ClockError::FlashTiming`].
pub fn freeze(pwr: pac::PWR, rcc: pac::RCC, syscfg: &pac::SYSCFG) -> Result<Ccdr, ClockError> {
    // The board feeds the core from the SMPS alone; LDO mode would be electrically wrong (RM0399 section
    // 7.4.1).
    let power = pwr.constrain().smps().vos1().freeze();
    let ccdr = rcc
        .constrain()
        .use_hse(CRYSTAL_HZ.Hz())
        .sys_ck(CORE_HZ.Hz())
        .hclk(HCLK_HZ.Hz())
        .pclk1(PCLK_HZ.Hz())
        .pclk2(PCLK_HZ.Hz())
        .pclk3(PCLK_HZ.Hz())
        .pclk4(PCLK_HZ.Hz())
        // Iterative: the input divider that gives exactly 800 MHz from the crystal.
        .pll1_strategy(PllConfigStrategy::Iterative)
        .pll1_q_ck(SDMMC_KERNEL_HZ.Hz())
        .freeze(power, syscfg);
    let core = ccdr.clocks.sys_ck().raw();
    let as_designed = core == CORE_HZ
        && ccdr.clocks.hclk().raw() == HCLK_HZ
        && ccdr.clocks.pclk1().raw() == PCLK_HZ
        && ccdr.clocks.pclk2().raw() == PCLK_HZ
        && ccdr.clocks.pll1_q_ck().is_some_and(|q| q.raw() == SDMMC_KERNEL_HZ);
    if !as_designed {
        return Err(ClockError::Wrong(core));
    }
    stop_hsi48();
    slow_flash()?;
    Ok(ccdr)
}

/// The HAL starts the 48 MHz oscillator whether or not something uses it.
fn stop_hsi48() {
    // RM0399 section 9.7.2, RCC_CR: HSI48ON.
    // SAFETY: `freeze` consumed the RCC token, and this runs once, before any interrupt is enabled.
    unsafe { (*pac::RCC::ptr()).cr.modify(|_, w| w.hsi48on().off()) };
}

/// Sets more wait states for the flash than this clock needs.
fn slow_flash() -> Result<(), ClockError> {
    // SAFETY: nothing else writes this register; more wait states are safe at any clock.
    let access = unsafe { &(*pac::FLASH::ptr()).acr };
    // RM0399 section 4.9.1, FLASH_ACR; section 4.3.8: the new value counts once it reads back.
    // SAFETY: 4 and 3 fit their fields.
    access.write(|w| unsafe { w.latency().bits(FLASH_WAIT_STATES).wrhighfreq().bits(FLASH_PROGRAMMING_DELAY) });
    let taken = || access.read().latency().bits() == FLASH_WAIT_STATES;
    wait::until(FLASH_LIMIT_US, taken).map_err(|_| ClockError::FlashTiming)
}

/// The switch of the system clock takes effect within a few of its periods.
const SWITCH_LIMIT_US: u32 = 1_000;

/// Restores the clocks to their state after a reset: the core on the 64 MHz oscillator, the PLL and the
/// crystal off, every divider one, no peripheral clocked. For the boot stage, so that the application finds
/// the chip as it expects it; supply and voltage scale stay, which a reset leaves alone or the application
/// sets again.
pub(crate) fn release() {
    // SAFETY: the boot stage's last act with the clocks, interrupts off; nobody else holds the registers.
    let rcc = unsafe { &*pac::RCC::ptr() };
    // RM0399 section 9.7.6, RCC_CFGR: SW = 000 is HSI, which was never switched off; SWS follows.
    rcc.cfgr.reset();
    // Without the switch the PLL cannot be stopped, and nothing that follows would run: the watchdog does.
    let _switched = wait::until(SWITCH_LIMIT_US, || rcc.cfgr.read().sws().is_hsi());
    // RM0399 section 9.7.2, RCC_CR: HSION alone; the PLLs before the crystal that feeds them.
    rcc.cr.modify(|_, w| w.pll1on().off().pll2on().off().pll3on().off());
    let _stopped = wait::until(SWITCH_LIMIT_US, || rcc.cr.read().pll1rdy().is_not_ready());
    // SAFETY: HSION alone, the register's value after a reset.
    rcc.cr.write(|w| unsafe { w.bits(1) });
    rcc.d1cfgr.reset();
    rcc.d2cfgr.reset();
    rcc.d3cfgr.reset();
    rcc.pllckselr.reset();
    rcc.pllcfgr.reset();
    rcc.pll1divr.reset();
    rcc.d1ccipr.reset();
    rcc.d3ccipr.reset();
    reset_peripherals(rcc);
}

/// Resets the peripherals that the boot stage has used and closes all gates. Not the pins: those that guard
/// the outputs stay as they are, clock or no clock.
fn reset_peripherals(rcc: &pac::rcc::RegisterBlock) {
    // RM0399 section 9.7.27 ff., "peripheral reset register".
    rcc.ahb3rstr.modify(|_, w| w.sdmmc1rst().set_bit());
    rcc.apb1lrstr.modify(|_, w| {
        w.tim2rst().set_bit().tim5rst().set_bit().tim6rst().set_bit().tim7rst().set_bit().usart2rst().set_bit()
    });
    // The read back makes sure that the pulses have reached the blocks before they end.
    let _settled = rcc.apb1lrstr.read().bits();
    rcc.ahb3rstr.reset();
    rcc.apb1lrstr.reset();
    let _settled = rcc.apb1lrstr.read().bits();
    rcc.ahb1enr.reset();
    rcc.ahb2enr.reset();
    rcc.ahb3enr.reset();
    rcc.ahb4enr.reset();
    rcc.apb1lenr.reset();
    rcc.apb2enr.reset();
    rcc.apb4enr.reset();
    let _settled = rcc.apb4enr.read().bits();
}

/// Divider of the crystal for the input of PLL3: 1 MHz. The oscillator of PLL3 runs at 336 MHz, and its Q
/// output is a seventh: the 48 MHz of USB, exactly. The values are those of Smoothieware v2.
const USB_INPUT_DIVIDER: u8 = 25;
const USB_MULTIPLIER: u16 = 336;
const USB_OUTPUT_DIVIDER: u8 = 7;
const _: () =
    assert!(CRYSTAL_HZ / USB_INPUT_DIVIDER as u32 * USB_MULTIPLIER as u32 / USB_OUTPUT_DIVIDER as u32 == 48_000_000);
/// Limit of the wait for PLL3, which locks within 150 us (DS12923, PLL characteristics for inputs of 1 to 2
/// MHz).
const PLL_LOCK_LIMIT_US: u32 = 1_000;

/// Starts PLL3 and gives its Q output to the USB cores. The HAL would have it run at 960 MHz, and only with
/// its P output on as well.
///
/// # Errors
/// It does not lock.
pub(crate) fn start_usb_clock() -> Result<(), wait::TimedOut> {
    // SAFETY: `freeze` consumed the RCC token; PLL3 and the USB multiplexer belong to USB alone, and other
    // fields of these registers are changed by nobody behind start-up.
    let rcc = unsafe { &*pac::RCC::ptr() };
    // RM0399 section 9.7.12, RCC_PLLCKSELR: DIVM3.
    rcc.pllckselr.modify(|_, w| w.divm3().bits(USB_INPUT_DIVIDER));
    // Section 9.7.13, RCC_PLLCFGR: inputs of 1 to 2 MHz (PLL3RGE 00), the medium oscillator (PLL3VCOSEL), no
    // fraction, only the Q output.
    rcc.pllcfgr.modify(|_, w| {
        w.pll3rge().range1().pll3vcosel().medium_vco().pll3fracen().reset();
        w.divp3en().disabled().divq3en().enabled().divr3en().disabled()
    });
    // Section 9.7.18, RCC_PLL3DIVR: both fields count from 0.
    // SAFETY: 336 and 7 are within 4 to 512 and 1 to 128.
    rcc.pll3divr.modify(|_, w| unsafe { w.divn3().bits(USB_MULTIPLIER - 1).divq3().bits(USB_OUTPUT_DIVIDER - 1) });
    rcc.cr.modify(|_, w| w.pll3on().on());
    wait::until(PLL_LOCK_LIMIT_US, || rcc.cr.read().pll3rdy().is_ready())?;
    // Section 9.7.21, RCC_D2CCIP2R: USBSEL.
    rcc.d2ccip2r.modify(|_, w| w.usbsel().pll3_q());
    Ok(())
}

/// Opens the clock gates of everything this board package uses. A peripheral without one here does not exist
/// for us.
pub fn enable_peripherals() {
    // SAFETY: `freeze` consumed the RCC token; the HAL keeps it without touching the enable registers again,
    // and this runs once, before any interrupt is enabled.
    let rcc = unsafe { &*pac::RCC::ptr() };
    // RM0399 section 9.7.40 ff., "clock register". AHB: DMA, ADCs, SDMMC, RAMs of domain D2.
    rcc.ahb1enr.modify(|_, w| w.dma1en().enabled().adc12en().enabled());
    rcc.ahb2enr.modify(|_, w| w.sram1en().enabled().sram2en().enabled().sram3en().enabled());
    rcc.ahb3enr.modify(|_, w| w.sdmmc1en().enabled());
    rcc.ahb4enr.modify(|_, w| w.adc3en().enabled());
    // APB: timers, serial ports, SPI, system configuration.
    rcc.apb1lenr.modify(|_, w| {
        w.tim2en().enabled().tim5en().enabled().tim6en().enabled().tim7en().enabled();
        w.usart2en().enabled().usart3en().enabled().uart4en().enabled()
    });
    rcc.apb2enr.modify(|_, w| w.spi1en().enabled().spi4en().enabled().tim1en().enabled().tim8en().enabled());
    rcc.apb4enr.modify(|_, w| w.syscfgen().enabled().rtcapben().enabled());
    // RM0399 section 9.7.19, RCC_D3CCIPR: the ADCs run from per_ck (HSI, 64 MHz).
    rcc.d3ccipr.modify(|_, w| w.adcsel().per());
    // RM0399 section 3.2: two cycles after the write before the first access; this read back is longer than
    // that.
    let _settled = rcc.apb4enr.read().bits();
    cortex_m::asm::dsb();
}
