//! Supervision of the chip's own supply, VDD: its detector signals that the 3.3 V fall, long before the chip
//! itself stops at 1.6 V.

use stm32h7xx_hal::pac;

use crate::trigger;

/// PLS: 2.85 V, 2.75 V on the way down at least (DS12923, "Reset and power control block characteristics",
/// VPVD6). Of the seven it is the highest that a supply of 3.3 V +-10 % never reaches by itself.
const LEVEL: u8 = 0b110;
/// Event input of the detector (RM0399 section 21.4, table of event inputs).
const EVENT: u32 = 16;

/// Enables the interrupt `PVD_PVM`, which comes when VDD falls below [`LEVEL`], or is below it already
/// (RM0399 section 7.5.3).
pub(crate) fn watch() {
    // SAFETY: `freeze` consumed the token of PWR; only these two fields of the register are changed, once,
    // before any interrupt is enabled.
    unsafe { (*pac::PWR::ptr()).cr1.modify(|_, w| w.pls().bits(LEVEL).pvde().set_bit()) };
    trigger::listen_for_rise(EVENT);
}
