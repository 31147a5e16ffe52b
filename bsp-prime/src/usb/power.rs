//! Preparation of the USB core: supply, clocks and pins.

use stm32h7xx_hal::pac;

use crate::pins::{self, Mode, PinName, Pull, Speed};
use crate::{clocks, wait};

/// The supply detector settles within a few microseconds (RM0399 section 7.4.5).
const SUPPLY_LIMIT_US: u32 = 1_000;
/// Alternate function of PA11 and PA12 (DS12923, alternate functions: OTG2_FS).
const OTG2_FS: u8 = 10;

/// Failure of the USB core.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum UsbError {
    /// The core's 3.3 V supply is missing.
    NoSupply,
    /// PLL3 does not make its 48 MHz.
    NoClock,
    /// The core does not come out of its reset.
    NotReady,
}

/// Prepares the core's supply, clocks and pins.
pub(super) fn prepare() -> Result<(), UsbError> {
    // RM0399 section 7.8.4, PWR_CR3: USB33DEN, the detector of the USB supply; both supplies are on 3.3 V, so
    // the chip's own regulator stays off.
    // SAFETY: nothing else writes this register behind `clocks::freeze`; the other bits are kept.
    let supply = unsafe { &(*pac::PWR::ptr()).cr3 };
    supply.modify(|_, w| w.usb33den().set_bit());
    wait::until(SUPPLY_LIMIT_US, || supply.read().usb33rdy().bit_is_set()).map_err(|_| UsbError::NoSupply)?;
    clocks::start_usb_clock().map_err(|_| UsbError::NoClock)?;
    // SAFETY: these bits belong to this core, and the registers are shared with nobody behind start-up:
    // SDMMC1 is reset by its own register.
    let rcc = unsafe { &*pac::RCC::ptr() };
    // RM0399 section 9.7.41, RCC_AHB1ENR; 9.7.29, RCC_AHB1RSTR; 9.7.54, RCC_AHB1LPENR. There is no ULPI
    // transceiver: with its clock asked for in sleep, the core would stand still there.
    rcc.ahb1enr.modify(|_, w| w.usb2otgen().set_bit());
    rcc.ahb1lpenr.modify(|_, w| w.usb2otglpen().set_bit().usb2ulpilpen().clear_bit());
    rcc.ahb1rstr.modify(|_, w| w.usb2otgrst().set_bit());
    let _settled = rcc.ahb1rstr.read().bits();
    rcc.ahb1rstr.modify(|_, w| w.usb2otgrst().clear_bit());
    let _settled = rcc.ahb1rstr.read().bits();
    for number in [11, 12] {
        pins::configure(PinName::new('A', number), Mode::Alternate(OTG2_FS, Speed::VeryHigh), Pull::Floating, false);
    }
    Ok(())
}
