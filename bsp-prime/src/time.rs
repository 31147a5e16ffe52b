//! The two clocks, each a free-running 32-bit timer with its 64-bit extension: TIM2 at 200 MHz for steps,
//! TIM5 at 1 MHz for the rest. And the interrupts after a time: TIM6 for the step feed, TIM7 for heat and
//! slow outputs, TIM5 for the watch over the laser.
//!
//! The extension counts half turns of the timer. A single task calls [`Clock::keep`] more often than a half
//! turn lasts (10.7 s for TIM2); the 64-bit time may then be read from any priority, without a lock: in
//! either order of reading, a half turn that is not yet counted shows as a top bit that disagrees with the
//! count's parity.

use core::sync::atomic::{AtomicU32, Ordering};

use cortex_m::peripheral::NVIC;
use stm32h7xx_hal::pac;
use units::{Micros, Ticks};

use crate::clocks::TIMER_HZ;

const TOP_BIT: u32 = 1 << 31;

/// A free-running 32-bit counter and how many half turns it has made.
#[derive(Debug)]
pub struct Clock {
    half_turns: AtomicU32,
}

static STEP_CLOCK: Clock = Clock { half_turns: AtomicU32::new(0) };
static MICRO_CLOCK: Clock = Clock { half_turns: AtomicU32::new(0) };

impl Clock {
    /// Counts a half turn that has happened since the last call. Only a single caller is allowed.
    fn keep(&self, count: u32) {
        let half_turns = self.half_turns.load(Ordering::Relaxed);
        if (count & TOP_BIT != 0) != (half_turns & 1 != 0) {
            self.half_turns.store(half_turns.wrapping_add(1), Ordering::Relaxed);
        }
    }

    /// Returns the 64-bit time; `read` gives the counter.
    fn extend(&self, read: impl Fn() -> u32) -> u64 {
        let half_turns = self.half_turns.load(Ordering::Relaxed);
        // The counter must be read after the half turns (see the module's text).
        core::sync::atomic::compiler_fence(Ordering::SeqCst);
        let count = read();
        (u64::from(half_turns) << 31) + u64::from(count ^ ((half_turns & 1) << 31))
    }
}

fn tim2() -> &'static pac::tim2::RegisterBlock {
    // SAFETY: TIM2's registers exist for the whole run. Only this module (its counter, read-only after
    // `start`) and the step engine (compare and status registers) touch them.
    unsafe { &*pac::TIM2::ptr() }
}

fn tim5() -> &'static pac::tim2::RegisterBlock {
    // SAFETY: TIM5 is this module's alone; after `start` its counter is only read, and [`alarm`] has its
    // first compare channel.
    unsafe { &*pac::TIM5::ptr() }
}

/// Interrupt of TIM5 at a time that is put off again and again: what happens when something else is late.
pub(crate) mod alarm {
    use super::tim5;

    /// Has the interrupt come in so many microseconds, rather than when it was to come.
    #[inline]
    pub fn put_off(microseconds: u32) {
        let timer = tim5();
        timer.ccr1().write(|w| w.ccr().bits(timer.cnt.read().bits().wrapping_add(microseconds)));
    }

    /// Lets the interrupt come, or not.
    pub fn enable(is_enabled: bool) {
        // RM0399 section 43.4.5, SR: a flag goes by writing 0. Section 43.4.4, DIER.
        tim5().sr.reset();
        tim5().dier.write(|w| w.cc1ie().bit(is_enabled));
    }

    /// Clears the interrupt. True when its time has come, and was not put off meanwhile.
    pub fn acknowledge() -> bool {
        let timer = tim5();
        timer.sr.reset();
        timer.cnt.read().bits().wrapping_sub(timer.ccr1().read().bits()) < 1 << 31
    }
}

/// Returns the low half of the step clock, in ticks of 5 ns.
#[inline(always)]
#[must_use]
pub fn step_ticks() -> u32 {
    tim2().cnt.read().bits()
}

/// Returns the step clock. Correct as long as [`keep_clocks`] is called more than once in ten seconds.
#[must_use]
pub fn now_ticks() -> Ticks {
    Ticks(STEP_CLOCK.extend(step_ticks))
}

/// Returns the coarse clock, microseconds.
#[must_use]
pub fn now() -> Micros {
    Micros(MICRO_CLOCK.extend(|| tim5().cnt.read().bits()))
}

/// Notices that a clock has turned over. Called by one periodic task, and by nobody else.
pub fn keep_clocks() {
    STEP_CLOCK.keep(step_ticks());
    MICRO_CLOCK.keep(tim5().cnt.read().bits());
}

/// Starts both clocks. Called once by the board.
pub(crate) fn start() {
    for (timer, divider) in [(tim2(), 1), (tim5(), TIMER_HZ / 1_000_000)] {
        // RM0399 section 43.4: prescaler and period are buffered; the update event loads them and its flag is
        // then cleared.
        timer.psc.write(|w| w.psc().bits((divider - 1) as u16));
        timer.arr.write(|w| w.arr().bits(u32::MAX));
        timer.egr.write(|w| w.ug().set_bit());
        timer.sr.reset();
        timer.cr1.write(|w| w.cen().set_bit());
    }
}

/// Ticks of the step clock in a microsecond.
const TICKS_PER_US: u32 = TIMER_HZ / 1_000_000;

/// A periodic interrupt from a basic timer.
#[derive(Debug)]
pub struct Ticker {
    registers: *const pac::tim6::RegisterBlock,
    period_us: u32,
}

// SAFETY: the pointer is to registers, which are the same from every context; each ticker is the only user of
// its timer.
unsafe impl Send for Ticker {}

/// Pends the heat tick's interrupt, besides its periods.
pub fn pend_heat_tick() {
    NVIC::pend(pac::Interrupt::TIM7);
}

impl Ticker {
    /// Returns TIM6, the timer of the step feed.
    #[must_use]
    pub fn feed(_timer: pac::TIM6) -> Self {
        Self { registers: pac::TIM6::ptr(), period_us: 0 }
    }

    /// Returns TIM7, the timer of heat control and the slow outputs.
    #[must_use]
    pub fn heat(_timer: pac::TIM7) -> Self {
        Self { registers: pac::TIM7::ptr(), period_us: 0 }
    }

    fn registers(&self) -> &pac::tim6::RegisterBlock {
        // SAFETY: the pointer came from the PAC for a timer whose token was consumed by the constructor.
        unsafe { &*self.registers }
    }

    /// RM0399 section 46.4: without preload the period holds at once.
    #[inline(always)]
    fn set_period(&self) {
        self.registers().arr.write(|w| w.arr().bits(self.period_us.clamp(2, 65_536) as u16 - 1));
    }

    /// Interrupts every `period_us` microseconds, 2 to 65 536.
    pub fn start(&mut self, period_us: u32) {
        self.period_us = period_us;
        let timer = self.registers();
        timer.psc.write(|w| w.psc().bits((TIMER_HZ / 1_000_000 - 1) as u16));
        self.set_period();
        // RM0399 section 46.4: the update event loads the prescaler; its own flag must not count as a period.
        timer.egr.write(|w| w.ug().set_bit());
        timer.sr.reset();
        timer.dier.write(|w| w.uie().set_bit());
        timer.cr1.write(|w| w.cen().set_bit());
    }

    /// Sets the next interrupt to so long from now, rounded down to whole microseconds, with the same period
    /// after it. A whole period is not counted from now but from the last interrupt, so that periods have no
    /// drift.
    #[inline]
    pub fn next_in(&mut self, wait: Ticks) {
        let wait_us = wait.0 as u32 / TICKS_PER_US;
        if wait_us >= self.period_us {
            return;
        }
        let timer = self.registers();
        // RM0399 section 46.4: without preload the period holds at once. The counter is set to zero by hand,
        // and before: an update event would interrupt, and a counter beyond the period runs on to its end.
        timer.cnt.write(|w| w.cnt().bits(0));
        timer.arr.write(|w| w.arr().bits(wait_us.max(2) as u16 - 1));
    }

    /// Clears the interrupt. True when a period had indeed ended.
    #[inline]
    pub fn acknowledge(&mut self) -> bool {
        let timer = self.registers();
        let ended = timer.sr.read().uif().bit_is_set();
        timer.sr.reset();
        // The new period takes effect after a wait.
        self.set_period();
        ended
    }
}
