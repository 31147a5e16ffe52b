//! The independent watchdog: once started it resets the board, outputs off, unless it is fed. Nothing stops
//! it.

use stm32h7xx_hal::pac;

/// Running watchdog, to be fed. Exists once.
#[derive(Debug)]
pub struct Watchdog {
    registers: pac::IWDG1,
}

/// The LSI runs at 32 kHz; divided by 32, one count is a millisecond, divided by 256, eight (RM0399 section
/// 49.3.1).
const MAX_COUNTS: u32 = 0xFFF;

impl Watchdog {
    /// Starts the watchdog with a limit of up to 32 s (the LSI's tolerance is a few percent), or changes the
    /// limit when it runs. The watchdog stands still while a debugger halts the core.
    ///
    /// The prescaler and reload values travel to the LSI's clock domain over the next milliseconds; nobody
    /// needs to wait for that.
    #[must_use]
    pub(crate) fn start(registers: pac::IWDG1, limit_ms: u32) -> Self {
        // SAFETY: DBGMCU is used here alone; RM0399 section 63.5.8, APB4FZ1: freeze the watchdog in debug.
        let debug = unsafe { &*pac::DBGMCU::ptr() };
        debug.apb4fz1.modify(|_, w| w.dbg_wdglsd1().set_bit());
        // RM0399 section 49.4: start (which starts the LSI), unlock, divide by 32, reload value, reload.
        registers.kr.write(|w| w.key().start());
        registers.kr.write(|w| w.key().enable());
        let is_short = limit_ms <= MAX_COUNTS;
        registers.pr.write(|w| if is_short { w.pr().divide_by32() } else { w.pr().divide_by256() });
        let counts = if is_short { limit_ms } else { limit_ms / 8 };
        registers.rlr.write(|w| w.rl().bits(counts.clamp(1, MAX_COUNTS) as u16));
        registers.kr.write(|w| w.key().reset());
        Self { registers }
    }

    /// Grants another full period.
    pub fn feed(&mut self) {
        self.registers.kr.write(|w| w.key().reset());
    }
}
