//! Heaters with a model: whether one takes much more heat, or much less, than its model explains, for long. A
//! sensor that slides out slowly, or drifts, is no fault that readings tell of: control follows it. But a
//! heater that is hotter than it reads loses more heat, and one that is colder, less.

use units::{HeaterId, MAX_HEATERS, Micros};

/// How often heaters are looked at.
const PERIOD: Micros = Micros::from_seconds(1);
/// This share more or less than the model explains is told: a quarter may be drafts, a sagging supply and a
/// sock that has come off together.
const MUCH: f32 = 0.4;
/// Below this all is well again.
const LITTLE: f32 = 0.25;
/// For so long.
const LONG: Micros = Micros::from_seconds(60);

/// What was seen of all heaters.
#[derive(Debug, Default)]
pub struct SurplusWatch {
    due: Micros,
    /// Since when there was much.
    since: [Option<Micros>; MAX_HEATERS],
    /// Which were told, one bit each.
    told: u8,
}

impl SurplusWatch {
    /// Looks at the share of each heater that holds its target by a model: what it takes beyond what is
    /// explained, of what is. The first that is to be told.
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
            // A minute and more of it, an end, and again.
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
