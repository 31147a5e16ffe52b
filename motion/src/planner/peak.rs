//! Greatest size of what is known at a number of places only.

use crate::greatest;

/// Greatest size of a smooth function known at equal distances: between two places a parabola rises above
/// both by an eighth of the second difference at most.
#[derive(Clone, Copy, Default)]
pub(super) struct Peak {
    /// Greatest size at a place.
    pub most: f64,
    hidden: f64,
    before: [f64; 2],
    seen: u32,
}

impl Peak {
    /// Takes the next value.
    pub fn take(&mut self, value: f64) {
        let [older, old] = self.before;
        if self.seen >= 2 {
            self.hidden = greatest(self.hidden, libm::fabs(value - 2.0 * old + older));
        }
        self.most = greatest(self.most, libm::fabs(value));
        self.before = [old, value];
        self.seen += 1;
    }

    /// Returns a bound of the size, between the places too.
    pub fn bound(&self) -> f64 {
        // A parabola hides an eighth of the second difference; a fifth more covers what a parabola does not
        // tell.
        self.most + 0.15 * self.hidden
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn a_parabola_stays_within_the_bound(middle in 2.0..6.0_f64, bend in -3.0..3.0_f64, top in -5.0..5.0_f64) {
            let at = |x: f64| top - bend * (x - middle) * (x - middle);
            let mut peak = Peak::default();
            (0..=8).for_each(|x| peak.take(at(f64::from(x))));
            let most = (0..=800).map(|x| at(f64::from(x) / 100.0).abs()).fold(0.0, f64::max);
            prop_assert!(peak.bound() >= most, "{} is less than {most}", peak.bound());
            prop_assert!(peak.bound() <= peak.most + 0.4 * bend.abs(), "{} is far more than {most}", peak.bound());
        }
    }
}
