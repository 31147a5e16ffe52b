//! Bounded waits, the only ones of this crate: for a condition, and never longer than stated.

use cortex_m::asm::delay;
use cortex_m::peripheral::DWT;

/// Core cycles in a microsecond once the clocks are up. Before that the core is slower and the bound is
/// longer, never shorter.
const CYCLES_PER_MICROSECOND: u32 = crate::clocks::CORE_HZ / 1_000_000;

/// The condition did not come true in time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TimedOut;

/// Divisor of the time waited already that gives the pause between two checks: a sixteenth.
const SPACING: u32 = 16;

/// Longest pause between two checks: 4 us, in core cycles.
const LONGEST_PAUSE: u32 = 4 * CYCLES_PER_MICROSECOND;

/// Polls `condition` until it holds or `limit_us` microseconds have passed (at most ten seconds: the counter
/// wraps).
///
/// The condition is checked ever more rarely, since every check is an access to a bus that others use: a wait
/// of milliseconds takes fewer than thousands of checks. The wait ends late by at most a fifth of its length,
/// and never by more than 12 us. (A turn of the loop in `asm::delay` takes one to three cycles.)
///
/// The counter is the DWT's, started by [`crate::Board::take`].
///
/// # Errors
/// [`TimedOut`] when the condition still did not hold at the limit.
pub fn until(limit_us: u32, mut condition: impl FnMut() -> bool) -> Result<(), TimedOut> {
    let limit = limit_us.saturating_mul(CYCLES_PER_MICROSECOND);
    let start = DWT::cycle_count();
    loop {
        if condition() {
            return Ok(());
        }
        let waited = DWT::cycle_count().wrapping_sub(start);
        if waited > limit {
            // A last check: an interrupt may have taken the whole allowance between the two tests.
            return if condition() { Ok(()) } else { Err(TimedOut) };
        }
        delay((waited / SPACING).min(LONGEST_PAUSE));
    }
}

/// Spends at least `time_us` microseconds, for hardware that asks for a pause and offers no flag.
pub fn pause(time_us: u32) {
    let cycles = time_us.saturating_mul(CYCLES_PER_MICROSECOND);
    let start = DWT::cycle_count();
    loop {
        let left = cycles.saturating_sub(DWT::cycle_count().wrapping_sub(start));
        if left == 0 {
            return;
        }
        // A quarter of what is left: three times as long would still not be too long.
        delay(left / 4);
    }
}
