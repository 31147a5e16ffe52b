//! Watches heaters with a model: a heater that takes much more heat, or much less, than its model explains,
//! for long, is reported. Readings do not show a sensor that slides out slowly, or drifts: control follows
//! it. But a heater that is hotter than its reading loses more heat, and one that is colder, less.

use units::{HeaterId, MAX_HEATERS, Micros};

/// Time between two looks at the heaters.
const PERIOD: Micros = Micros::from_seconds(1);
/// Share above or below the model's heat that is reported: a quarter may be drafts, a sagging supply and a
/// sock that has come off together.
const MUCH: f32 = 0.4;
/// Share below which the heater counts as well again.
const LITTLE: f32 = 0.25;
/// Time for which the surplus must last.
const LONG: Micros = Micros::from_seconds(60);

/// State of the watch over all heaters.
#[derive(Debug, Default)]
pub struct SurplusWatch {
    due: Micros,
    /// Time since which the surplus has been large.
    since: [Option<Micros>; MAX_HEATERS],
    /// Heaters that were reported, one bit each.
    told: u8,
}

impl SurplusWatch {
    /// Looks at the share of each heater that holds its target by a model: the unexplained part of its heat
    /// over the explained part. Returns the first heater that is to be reported.
    pub fn look(&mut self, now: Micros, mut share: impl FnMut(HeaterId) -> Option<f32>) -> Option<(HeaterId, f32)> {
        if now < self.due {
            return None;
        }
        self.due = now.plus(PERIOD);
        let mut found = None;
        for (id, since) in HeaterId::all().zip(&mut self.since) {
            let bit = 1_u8 << id.index();
            let share = share(id).unwrap_or(0.0);
            if share.abs() < LITTLE {
                self.told &= !bit;
            }
            if share.abs() < MUCH {
                *since = None;
                continue;
            }
            let long = now.since(*since.get_or_insert(now)) >= LONG;
            if long && self.told & bit == 0 && found.is_none() {
                self.told |= bit;
                found = Some((id, share));
            }
        }
        found
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_lasts_is_told_once() {
        let mut watch = SurplusWatch::default();
        let mut told = std::vec::Vec::new();
        for second in 1..600 {
            // A minute and more of surplus, its end, and surplus again.
            let share = match second {
                100..200 | 400..500 => 0.45,
                200..250 => 0.3,
                550..580 => -0.9,
                _ => 0.1,
            };
            let first = HeaterId::all().next();
            let found = watch.look(Micros::from_seconds(second), |id| (Some(id) == first).then_some(share));
            told.extend(found.map(|(_, share)| (second, share)));
        }
        assert_eq!(told, [(160, 0.45), (460, 0.45)]);
    }
}
