//! The only way this crate waits: for a condition, and never longer than stated.

use cortex_m::peripheral::DWT;

/// Core cycles in a microsecond once the clocks are up. Before that the core is slower and the bound is
/// longer, never shorter.
const CYCLES_PER_MICROSECOND: u32 = crate::clocks::CORE_HZ / 1_000_000;

/// The condition did not come true in time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TimedOut;

/// Polls `condition` until it holds or `limit_us` microseconds have passed (at most ten seconds: the counter
/// wraps).
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
        if DWT::cycle_count().wrapping_sub(start) > limit {
            // Looked at once more: an interrupt may have taken the whole allowance between the two tests.
            return if condition() { Ok(()) } else { Err(TimedOut) };
        }
    }
}

/// Spends at least `time_us` microseconds, for hardware that asks for a pause and offers no flag.
pub fn pause(time_us: u32) {
    // The condition never holds, so the result carries nothing.
    let _always_times_out = until(time_us, || false);
}
