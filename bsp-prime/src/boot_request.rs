//! Requests to the next start of the boot stage, by the application and by a person who presses RESET twice.
//! Stored in backup registers of the real-time clock, which a reset leaves alone and power-on clears (RM0399
//! rev 4 section 49.3.15); [`crate::last_words`] has the first twenty of them.
//!
//! A reset by the button looks like one by a debug probe, and like any other first reset. So the boot stage
//! leaves a mark, which the application takes away a second after it has begun: where a button's reset finds
//! the mark, it was the second within that second, or the application never came so far.

use stm32h7xx_hal::pac;

use crate::identity::Cause;

/// Numbers of the registers of the request, of the mark, and of the reset's causes.
const REQUEST: usize = 20;
const PRESSED: usize = 21;
const FLAGS: usize = 22;
/// Value of the lower half of the register of causes if the boot stage has written it; the flags are in the
/// upper half.
const LEFT: u32 = 0x5A5A;

/// Value of the request to wait for firmware over USB.
const DOWNLOAD: u32 = 0x4446_5521;
/// Value of the mark after the button was pressed once.
const ONCE: u32 = 0x5052_4553;

/// Has the boot stage wait for firmware over USB, instead of starting the application: at the next reset,
/// once. The request does not reset anything itself.
pub fn ask_for_download() {
    register(REQUEST).write(|w| w.bits(DOWNLOAD));
}

/// The application runs: a button's reset from now on is the first one again.
pub fn forget_button() {
    if register(PRESSED).read().bits() != 0 {
        register(PRESSED).write(|w| w.bits(0));
    }
}

/// Returns whether to wait for firmware, and clears the request. For the boot stage, which opens the backup
/// domain first.
pub(crate) fn take(cause: Cause) -> bool {
    let is_asked = register(REQUEST).read().bits() == DOWNLOAD;
    register(REQUEST).write(|w| w.bits(0));
    let is_pressed = cause == Cause::Pin;
    let was_pressed = register(PRESSED).read().bits() == ONCE;
    let is_second = is_pressed && was_pressed;
    register(PRESSED).write(|w| w.bits(if is_pressed && !is_second { ONCE } else { 0 }));
    is_asked || is_second
}

/// Leaves the flags of RCC_RSR to the application.
pub(crate) fn leave_flags(flags: u32) {
    register(FLAGS).write(|w| w.bits(flags & 0xFFFF_0000 | LEFT));
}

/// Takes the flags that the boot stage left; `None` if no boot stage came first.
pub(crate) fn take_flags() -> Option<u32> {
    let word = register(FLAGS).read().bits();
    register(FLAGS).write(|w| w.bits(0));
    (word & 0xFFFF == LEFT).then_some(word & 0xFFFF_0000)
}

fn register(number: usize) -> &'static pac::rtc::BKPR {
    // SAFETY: these three are written here alone; each access is a whole word, and the boot stage and the
    // application never run at once.
    unsafe { &(*pac::RTC::ptr()).bkpr[number] }
}
