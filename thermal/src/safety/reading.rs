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
