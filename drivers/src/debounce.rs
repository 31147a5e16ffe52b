//! Mechanical switches bounce: a closing contact opens again several times within some milliseconds (J.
//! Ganssle, "A Guide to Debouncing", 2004: about 6 ms at most for most switches he measured). A level counts
//! when it has lasted.

use units::Micros;

/// Debounced level of a switch.
#[derive(Clone, Copy, Debug)]
pub struct Debounce {
    hold: Micros,
    stable: bool,
    /// Time at which the input left the stable level, if it is away from it.
    away_since: Option<Micros>,
}

impl Debounce {
    /// Creates a switch whose level counts after `hold` without a change; `level` counts at once.
    #[must_use]
    pub const fn new(hold: Micros, level: bool) -> Self {
        Self { hold, stable: level, away_since: None }
    }

    /// Returns the level that counts.
    #[must_use]
    pub const fn level(&self) -> bool {
        self.stable
    }

    /// Takes a sample. True when the level that counts has changed with it.
    pub fn sample(&mut self, level: bool, now: Micros) -> bool {
        if level == self.stable {
            self.away_since = None;
            return false;
        }
        let since = *self.away_since.get_or_insert(now);
        if now.since(since) < self.hold {
            return false;
        }
        self.stable = level;
        self.away_since = None;
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const HOLD: Micros = Micros(1_000);

    #[test]
    fn a_press_counts_once_it_has_lasted() {
        let mut switch = Debounce::new(HOLD, false);
        let changes: Vec<u64> = (0..40).map(|n| n * 100).filter(|t| switch.sample(*t >= 500, Micros(*t))).collect();
        assert_eq!(changes, [1_500]);
        assert!(switch.level());
    }

    #[test]
    fn without_a_hold_time_every_level_counts_at_once() {
        let mut switch = Debounce::new(Micros(0), false);
        assert!(switch.sample(true, Micros(7)) && switch.sample(false, Micros(7)));
    }

    proptest! {
        #[test]
        fn the_level_never_changes_within_the_hold_time_of_a_bounce(
            samples in prop::collection::vec((any::<bool>(), 1_u64..900), 1..200),
        ) {
            let mut switch = Debounce::new(HOLD, false);
            let (mut now, mut last_at_stable) = (0, 0);
            for (level, pause) in samples {
                now += pause;
                if level == switch.level() {
                    last_at_stable = now;
                }
                if switch.sample(level, Micros(now)) {
                    prop_assert!(now - last_at_stable >= HOLD.0);
                    prop_assert_eq!(switch.level(), level);
                    last_at_stable = now;
                }
            }
        }
    }
}
