//! Flags between the tasks: whether there is work for idle, and who has run since the watchdog was fed.

use core::sync::atomic::{AtomicBool, Ordering};

use stm32h7xx_hal::pac::Interrupt;

/// Interrupt of the timer of `timers`, which idle pends as well.
const TIMERS: Interrupt = Interrupt::TIM6_DAC;

/// Whether there may be work for idle.
static AWAKE: AtomicBool = AtomicBool::new(true);
/// Whether idle has made a turn, and the timers have run, since the watchdog was fed.
static TURNED: AtomicBool = AtomicBool::new(false);
static RAN: AtomicBool = AtomicBool::new(false);

/// Ends the rest of idle, or the next one. Called by whoever leaves work or bytes.
pub fn wake() {
    AWAKE.store(true, Ordering::Release);
}

/// Has the timers run: commands may have set some, or brought steps.
pub fn run_timers() {
    rtic::pend(TIMERS);
}

/// Notes that the timers have run. `has_news`: there are answers, or there is work.
pub fn note_run(has_news: bool) {
    RAN.store(true, Ordering::Relaxed);
    if has_news {
        wake();
    }
}

/// Notes that idle makes a turn.
pub fn note_turn() {
    TURNED.store(true, Ordering::Relaxed);
}

/// Returns whether idle and the timers have run since the last time that this was so. `is_excused`: idle need
/// not.
pub fn all_have_run(is_excused: bool) -> bool {
    let all = (TURNED.load(Ordering::Relaxed) || is_excused) && RAN.load(Ordering::Relaxed);
    if all {
        TURNED.store(false, Ordering::Relaxed);
        RAN.store(false, Ordering::Relaxed);
    }
    all
}

/// Lets the core sleep until there may be work.
///
/// Interrupts are masked from the look to the sleep, so that none that brings work comes between. One that
/// comes is pending then: it ends the sleep at once, and is taken some cycles later, within what a step may
/// be late.
pub fn rest() {
    while !AWAKE.swap(false, Ordering::Acquire) {
        cortex_m::interrupt::free(|_| {
            if !AWAKE.load(Ordering::Relaxed) {
                cortex_m::asm::wfi();
            }
        });
    }
}
