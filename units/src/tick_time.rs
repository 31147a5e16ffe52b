//! Time on the step clock, finer than a tick: exact to add, never wrapping, equal on every machine.

use fixed::types::U96F32;

use crate::convert::{fixed_32, float_of_u64};
use crate::{STEP_CLOCK_HZ, Ticks};

/// A point on, or a length of, the step clock, finer than a tick: 96 bits of ticks, 32 of fraction.
pub type TickTime = U96F32;

/// Fixed-point units of [`TickTime`] in a second.
const UNITS_PER_SECOND: f64 = STEP_CLOCK_HZ as f64 * 4_294_967_296.0;

/// A length of time in seconds, zero when negative or not a number.
#[must_use]
pub fn tick_time(seconds: f64) -> TickTime {
    TickTime::from_bits(fixed_32(seconds * STEP_CLOCK_HZ as f64))
}

/// Returns the time from one moment to a later one, seconds; zero when it is not later.
#[must_use]
pub fn seconds_between(from: TickTime, to: TickTime) -> f64 {
    let units = to.saturating_sub(from).to_bits();
    // A slow move may take longer than the 21 s of 64 bits.
    let (high, low) = (float_of_u64((units >> 64) as u64), float_of_u64(units as u64));
    (high * 18_446_744_073_709_551_616.0 + low) / UNITS_PER_SECOND
}

/// Seconds in the low half of a length of [`TickTime`].
#[must_use]
pub fn seconds_of(units: u64) -> f64 {
    float_of_u64(units) / UNITS_PER_SECOND
}

/// The whole tick at a point in time.
#[must_use]
pub const fn whole_ticks(time: TickTime) -> Ticks {
    Ticks((time.to_bits() >> 32) as u64)
}

/// A point in time at a whole tick.
#[must_use]
pub const fn at_tick(ticks: Ticks) -> TickTime {
    TickTime::from_bits((ticks.0 as u128) << 32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_times_are_told_as_well_as_short_ones() {
        for seconds in [1e-6, 20.0, 22.0, 3_600.0] {
            let from = at_tick(Ticks(12_345));
            assert!((seconds_between(from, from + tick_time(seconds)) / seconds - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn seconds_become_ticks_and_nonsense_becomes_nothing() {
        assert_eq!(whole_ticks(tick_time(0.001)), Ticks(200_000));
        assert_eq!(tick_time(-1.0), TickTime::ZERO);
        assert_eq!(tick_time(f64::NAN), TickTime::ZERO);
        assert_eq!(whole_ticks(at_tick(Ticks(7)) + tick_time(2.6e-9 + 2.6e-9)), Ticks(8));
    }
}
