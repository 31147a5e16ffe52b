//! The two clocks: step ticks (5 ns) for motion, microseconds for everything else.

/// Rate of the step timer: the APB1 timer kernel clock at 400 MHz core (RM0399 section 9.5, "Clock
/// distribution").
pub const STEP_CLOCK_HZ: u32 = 200_000_000;
/// Length of one step tick.
pub const TICK_NANOSECONDS: u32 = 1_000_000_000 / STEP_CLOCK_HZ;

/// A point on, or a length of, the step clock. 64 bits never wrap; the 32-bit timer holds the low half.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Ticks(pub u64);

impl Ticks {
    /// Converts from whole microseconds.
    #[must_use]
    pub const fn from_micros(micros: u64) -> Self {
        Self(micros * (STEP_CLOCK_HZ / 1_000_000) as u64)
    }

    /// Converts to whole nanoseconds.
    #[must_use]
    pub const fn nanoseconds(self) -> u64 {
        self.0 * TICK_NANOSECONDS as u64
    }

    /// Converts to seconds, with fraction.
    #[must_use]
    pub fn seconds(self) -> f64 {
        self.0 as f64 / f64::from(STEP_CLOCK_HZ)
    }

    /// Returns the point this far later.
    #[must_use]
    pub const fn plus(self, other: Self) -> Self {
        Self(self.0 + other.0)
    }

    /// Returns the time since `earlier`; zero when `earlier` is later.
    #[must_use]
    pub const fn since(self, earlier: Self) -> Self {
        Self(self.0.saturating_sub(earlier.0))
    }
}

/// A point on, or a length of, the coarse clock that heat control, timeouts and reports use. Counts from
/// boot.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Micros(pub u64);

impl Micros {
    /// Converts from whole milliseconds.
    #[must_use]
    pub const fn from_millis(millis: u64) -> Self {
        Self(millis * 1_000)
    }

    /// Converts from whole seconds.
    #[must_use]
    pub const fn from_seconds(seconds: u64) -> Self {
        Self(seconds * 1_000_000)
    }

    /// Converts to whole milliseconds.
    #[must_use]
    pub const fn millis(self) -> u64 {
        self.0 / 1_000
    }

    /// Converts to seconds, with fraction.
    #[must_use]
    pub fn seconds(self) -> f64 {
        self.0 as f64 / 1e6
    }

    /// Returns the point this far later.
    #[must_use]
    pub const fn plus(self, other: Self) -> Self {
        Self(self.0 + other.0)
    }

    /// Returns the time since `earlier`; zero when `earlier` is later.
    #[must_use]
    pub const fn since(self, earlier: Self) -> Self {
        Self(self.0.saturating_sub(earlier.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_two_clocks_agree() {
        assert_eq!(TICK_NANOSECONDS * STEP_CLOCK_HZ, 1_000_000_000);
        assert_eq!(Ticks::from_micros(3).nanoseconds(), 3_000);
        assert_eq!(Ticks::from_micros(2_000_000).seconds(), Micros::from_seconds(2).seconds());
        assert_eq!(Micros(5).since(Micros(9)), Micros(0));
    }
}
