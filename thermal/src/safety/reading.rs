//! Law of readings: their range and their rate of change.

use units::{Celsius, Micros};

use super::look::{HeatCause, Look};
use crate::sensor::SensorFault;

/// Number of unbelievable readings in a row that is a fault. Control has its heater off from the first.
const BAD_READINGS: u8 = 4;
/// Number of such readings before a sensor has been read for the first time: a converter chip of many samples
/// takes 0.8 s from power-on.
const FIRST_READINGS: u8 = 20;
/// Time between two comparisons of the reading with earlier ones.
const COMPARE_PERIOD: Micros = Micros::from_millis(250);
/// Number of comparisons in a second.
const A_SECOND: usize = 4;
/// Comparisons in a row that must agree on a rate: a spike of one reading makes one at each end.
const AGREE: u8 = 2;
/// Least change between comparisons that is a jump, C, if the change before went the other way.
const JUMP: f32 = 6.0;
/// Number of jumps that is a fault; a jump is forgiven every 2.5 s.
const JUMPS: u8 = 8;
/// Number of comparisons after which a jump is forgiven.
const FORGIVEN_AFTER: u8 = 10;

/// Limits on the readings of a heater.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReadingLimits {
    /// Lowest believable reading while heating.
    pub min: Celsius,
    /// Highest believable reading while heating.
    pub max: Celsius,
    /// Largest rise in a second while heating; 0: any.
    pub rise_per_s: f32,
    /// Largest fall in a second while heating; 0: any.
    pub fall_per_s: f32,
}

/// Memory of earlier readings.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct ReadingLaw {
    bad: u8,
    /// Whether the sensor has given a temperature, or said why not.
    seen: bool,
    due: Micros,
    /// Readings of the last second, newest last, as many as `known` says.
    before: [f32; A_SECOND],
    known: usize,
    agree: u8,
    /// The last change, if it was a jump.
    jump: f32,
    jumps: u8,
    since_forgiven: u8,
}

impl ReadingLaw {
    pub(super) fn check(&mut self, limits: &ReadingLimits, look: &Look) -> Result<(), HeatCause> {
        let believable = match look.reading {
            None => Err(HeatCause::NoReading(look.fault.unwrap_or(SensorFault::SILENT))),
            Some(reading) if reading < limits.min => Err(HeatCause::BelowMinimum(reading)),
            Some(reading) if reading > limits.max => Err(HeatCause::AboveMaximum(reading)),
            Some(_) => Ok(()),
        };
        let bad = if believable.is_err() && look.is_on() { self.bad.saturating_add(1) } else { 0 };
        self.bad = bad;
        let changes = self.compare(limits, look);
        self.seen |= look.reading.is_some() || look.fault != Some(SensorFault::SILENT);
        let most = if self.seen { BAD_READINGS } else { FIRST_READINGS };
        if bad >= most { believable } else { changes }
    }

    /// Compares the reading with earlier ones, while the heater is on.
    fn compare(&mut self, limits: &ReadingLimits, look: &Look) -> Result<(), HeatCause> {
        let Some(Celsius(reading)) = look.reading else {
            // A reading after a gap has nothing to be compared with.
            self.known = 0;
            return Ok(());
        };
        if look.now < self.due {
            return Ok(());
        }
        self.due = look.now.plus(COMPARE_PERIOD);
        let (oldest, newest, known) = (self.before[0], self.before[A_SECOND - 1], self.known);
        self.before.rotate_left(1);
        self.before[A_SECOND - 1] = reading;
        self.known = (known + 1).min(A_SECOND);
        if !look.is_on() {
            (self.agree, self.jump, self.jumps) = (0, 0.0, 0);
            return Ok(());
        }
        if known > 0 && self.jumps(reading - newest) {
            return Err(HeatCause::Erratic);
        }
        let change = if known == A_SECOND { reading - oldest } else { 0.0 };
        let rises = limits.rise_per_s > 0.0 && change > limits.rise_per_s;
        let falls = limits.fall_per_s > 0.0 && -change > limits.fall_per_s;
        self.agree = if rises || falls { self.agree + 1 } else { 0 };
        match self.agree >= AGREE {
            true if rises => Err(HeatCause::RisesTooFast(Celsius(change))),
            true => Err(HeatCause::FallsTooFast(Celsius(-change))),
            false => Ok(()),
        }
    }

    /// Counts changes that reverse the change before; returns true when there were too many.
    fn jumps(&mut self, change: f32) -> bool {
        self.since_forgiven += 1;
        if self.since_forgiven >= FORGIVEN_AFTER {
            (self.since_forgiven, self.jumps) = (0, self.jumps.saturating_sub(1));
        }
        let is_jump = !(-JUMP..=JUMP).contains(&change);
        if is_jump && change * self.jump < 0.0 {
            self.jumps = self.jumps.saturating_add(1);
        }
        if is_jump {
            self.jump = change;
        }
        self.jumps >= JUMPS
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LIMITS: ReadingLimits =
        ReadingLimits { min: Celsius(5.0), max: Celsius(280.0), rise_per_s: 30.0, fall_per_s: 15.0 };

    /// Looks at these readings, one each quarter of a second, with the heater on; returns the first fault.
    fn fault(readings: impl Iterator<Item = f32>) -> Option<HeatCause> {
        let mut law = ReadingLaw::default();
        readings.enumerate().find_map(|(place, reading)| {
            let now = Micros::from_millis(250 * (place as u64 + 1));
            let look = Look { now, reading: Some(Celsius(reading)), target: Celsius(200.0), ..Look::default() };
            law.check(&LIMITS, &look).err()
        })
    }

    #[test]
    fn the_limits_themselves_are_believed_and_nothing_beyond() {
        for (reading, cause) in [
            (5.0, None),
            (4.99, Some(HeatCause::BelowMinimum(Celsius(4.99)))),
            (280.0, None),
            (280.01, Some(HeatCause::AboveMaximum(Celsius(280.01)))),
        ] {
            assert_eq!(fault((0..30).map(|_| reading)), cause);
        }
    }

    #[test]
    fn a_heater_may_change_at_its_greatest_rate_and_no_faster() {
        let at = |per_s: f32| fault((0..20).map(move |quarter| 100.0 + per_s * quarter as f32 / 4.0));
        assert_eq!((at(30.0), at(-15.0)), (None, None));
        assert_eq!(at(32.0), Some(HeatCause::RisesTooFast(Celsius(32.0))));
        assert_eq!(at(-16.0), Some(HeatCause::FallsTooFast(Celsius(16.0))));
    }

    #[test]
    fn a_sensor_has_longer_before_its_first_reading_than_after() {
        let silent_from = |first: usize| {
            let mut law = ReadingLaw::default();
            (0..60).find(|look| {
                let now = Micros::from_millis(50 * (*look as u64 + 1));
                let reading = (*look < first).then_some(Celsius(100.0));
                let fault = reading.is_none().then_some(SensorFault::SILENT);
                law.check(&LIMITS, &Look { now, reading, fault, target: Celsius(200.0), ..Look::default() }).is_err()
            })
        };
        assert_eq!(silent_from(0), Some(19));
        assert_eq!(silent_from(10), Some(13));
    }
}
