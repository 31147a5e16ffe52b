//! Detects a falling supply (brown-out). A supply's usual voltage is learnt while it is there, for machines
//! have 12 V or 24 V and nobody tells them.

use units::Volts;

/// Share of the usual voltage below which a supply falls. Long cables and the bed's current take a tenth.
const SHARE: f32 = 0.75;
/// Voltage below which a supply is off, and its usual voltage is learnt anew.
pub const OFF: Volts = Volts(6.0);
/// Share of the way that the usual voltage comes to a reading: up at once when a supply comes up, down within
/// some ten seconds of looks 3 ms apart.
const RISES: f32 = 0.1;
const SINKS: f32 = 0.000_3;
/// Looks in a row that must find the supply low: a single one may be of a motor's switching.
const LOOKS: u8 = 2;

/// State of one supply.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FallingSupply {
    /// Usual voltage, V; zero until known.
    usual: f32,
    low: u8,
}

impl FallingSupply {
    /// Looks at the supply. True when the voltage has been low twice in a row: below `least`, or below three
    /// quarters of the usual voltage without `least`.
    pub fn look(&mut self, volts: Volts, least: Option<Volts>) -> bool {
        let Volts(now) = volts;
        let Volts(least) = least.unwrap_or(Volts(self.usual * SHARE));
        if now < least {
            self.low = self.low.saturating_add(1);
            return self.low >= LOOKS;
        }
        self.low = 0;
        if self.usual == 0.0 && now >= OFF.0 {
            self.usual = now;
        }
        self.usual += (now - self.usual) * if now > self.usual { RISES } else { SINKS };
        if now < OFF.0 {
            self.usual = 0.0;
        }
        false
    }

    /// Returns the supply's usual voltage.
    #[must_use]
    pub const fn usual(&self) -> Volts {
        Volts(self.usual)
    }

    /// Returns whether the voltage was low at the last look.
    #[must_use]
    pub const fn is_low(&self) -> bool {
        self.low > 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn steady(volts: f32) -> FallingSupply {
        let mut supply = FallingSupply::default();
        assert!((0..1_000).all(|_| !supply.look(Volts(volts), None)));
        supply
    }

    #[test]
    fn three_quarters_of_what_it_usually_has_twice_in_a_row() {
        for usual in [12.0, 24.0, 48.0] {
            let mut supply = steady(usual);
            assert!(!supply.look(Volts(usual * 0.76), None) && !supply.look(Volts(usual * 0.76), None));
            assert!(!supply.look(Volts(usual * 0.74), None) && supply.look(Volts(usual * 0.74), None));
        }
        let mut supply = steady(24.0);
        assert!(
            (0..100).all(|look| !supply.look(Volts(if look % 2 == 0 { 10.0 } else { 24.0 }), None)),
            "not in a row"
        );
    }

    #[test]
    fn one_that_comes_up_slowly_or_is_set_lower_is_usual_after_a_while() {
        let mut supply = FallingSupply::default();
        for look in 0..2_000 {
            assert!(!supply.look(Volts((look as f32 * 0.1).min(24.0)), None), "on its way up");
        }
        assert!((supply.usual().0 - 24.0).abs() < 0.1);
        for _ in 0..20_000 {
            assert!(!supply.look(Volts(19.0), None));
        }
        assert!((supply.usual().0 - 19.0).abs() < 0.1, "within a minute: {:?}", supply.usual());
    }

    #[test]
    fn what_the_configuration_says_counts_instead() {
        let mut supply = steady(24.0);
        assert!((0..10).all(|_| !supply.look(Volts(10.0), Some(Volts(9.0)))));
        assert!(!supply.look(Volts(8.9), Some(Volts(9.0))) && supply.look(Volts(8.9), Some(Volts(9.0))));
        let mut supply = steady(24.0);
        assert!((0..10).all(|_| !supply.look(Volts(1.0), Some(Volts(0.0)))), "0: never");
    }

    #[test]
    fn one_that_was_never_there_does_not_fall() {
        let mut supply = FallingSupply::default();
        assert!((0..10).all(|_| !supply.look(Volts(0.3), None)));
    }
}
