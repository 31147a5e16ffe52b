//! How a heater must answer to being driven: it warms, and it stays where it came to.
//!
//! What counts is not time but the output its pin was really given: ten seconds at half output are five
//! seconds of effort. So a control law that goes gently needs no longer limits, and one that asks for nothing
//! is not blamed on the heater. Warming on the way to a target and sinking away from it are judged as by
//! Klipper's `verify_heater`, with its usual figures; two things more are no heater's doing: to be given full
//! output near its target for as long as it would need to come from below, in vain; and to cool under it.
//! What is slow, as beds are, also does not stop warming from one moment to the next.

use units::{Celsius, Micros};

use super::look::{HeatCause, LOOK_PERIOD, Look};

/// Share of its most that counts as full output.
const FULL: f32 = 0.95;
/// Below its target by more than this a heater at full output must warm, also where it once was there.
const NEAR: f32 = 2.0;
/// After so many seconds at full output heat has come through to any sensor.
const COME_THROUGH_S: f32 = 6.0;
/// Then no reading falls by more than this...
const FALL: f32 = 3.0;
/// ...within so many seconds, each of which it is looked at once.
const FALL_S: usize = 3;
/// Seconds in a row that must agree: one jump makes one fall.
const AGREE: u8 = 2;
/// A heater that may take this long to warm by a little is slow: no fan blows at it, and no filament cools
/// it.
const SLOW: Micros = Micros::from_seconds(45);
/// It warmed for so many seconds...
const STEADY_S: usize = 6;
/// ...and for so many it did not: it went on by less than this share of what it had warmed in as long...
const STALLS_S: usize = 5;
const STALL: f32 = 0.2;
/// ...and so many degrees are missing.
const MISSING: f32 = 1.0;
/// Seconds whose readings are kept.
const KEPT_S: usize = STEADY_S + STALLS_S;

/// How a heater must answer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ResponseLimits {
    /// Below its target by more than this it must warm, or it is sinking.
    pub band: Celsius,
    /// It must warm by this much...
    pub gain: Celsius,
    /// ...with full output for so long; 0: not checked.
    pub within: Micros,
    /// Degrees below the band times seconds that it may sink once it was at its target; 0: not checked.
    pub sinking: f32,
}

/// How it has answered.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Response {
    target: f32,
    /// It was within the band of this target.
    was_there: bool,
    /// The reading from which it has to warm.
    from: f32,
    /// Seconds at full output since then.
    effort_s: f32,
    /// Degrees times seconds that it has been below the band.
    below: f32,
    full: FullOutput,
}

/// A heater without a pause at full output.
#[derive(Clone, Copy, Debug, Default)]
struct FullOutput {
    seconds: f32,
    /// Seconds since it warmed by what it must, and the reading then.
    in_vain_s: f32,
    from: f32,
    /// The readings of the last seconds, newest last.
    before: [f32; KEPT_S],
    falls: u8,
    stalls: u8,
}

impl FullOutput {
    /// One look at a heater that is at full output.
    fn check(&mut self, limits: &ResponseLimits, missing: f32, reading: f32) -> Result<(), HeatCause> {
        let seconds = LOOK_PERIOD.seconds() as f32;
        if self.seconds == 0.0 {
            *self = Self { from: reading, before: [reading; KEPT_S], ..Self::default() };
        }
        let whole_before = self.seconds as u32;
        self.seconds += seconds;
        self.in_vain_s += seconds;
        if reading >= self.from + limits.gain.0 || missing <= NEAR {
            (self.from, self.in_vain_s) = (reading, 0.0);
        }
        let before = self.before[KEPT_S - FALL_S];
        if self.seconds as u32 != whole_before {
            self.before.rotate_left(1);
            self.before[KEPT_S - 1] = reading;
            let falls = self.seconds > COME_THROUGH_S && before - reading > FALL;
            self.falls = if falls { self.falls + 1 } else { 0 };
            self.stalls = if limits.within >= SLOW && self.stalls() { self.stalls + 1 } else { 0 };
        }
        if self.falls >= AGREE {
            return Err(HeatCause::FallsWhileDriven(Celsius(before - reading)));
        }
        if self.stalls >= AGREE {
            return Err(HeatCause::Stalls);
        }
        if limits.within > Micros(0) && self.in_vain_s > limits.within.seconds() as f32 {
            return Err(HeatCause::NoResponse(limits.within, limits.gain));
        }
        Ok(())
    }
}

impl FullOutput {
    /// It warmed steadily, and does not any more.
    fn stalls(&self) -> bool {
        let [first, .., last] = self.before;
        let turn = self.before[STEADY_S];
        let expected = (turn - first) / STEADY_S as f32 * (STALLS_S - 1) as f32;
        let went_on = last - turn;
        // Heat that still comes through makes it warm faster and faster: that is no stall.
        let is_known = self.seconds > KEPT_S as f32;
        is_known && went_on < STALL * expected && expected - went_on > MISSING
    }
}

impl Response {
    pub(super) fn check(&mut self, limits: &ResponseLimits, full_share: f32, look: &Look) -> Result<(), HeatCause> {
        let Some(Celsius(reading)) = look.reading.filter(|_| look.is_on()) else {
            *self = Self::default();
            return Ok(());
        };
        if self.target != look.target.0 {
            *self = Self { target: look.target.0, from: reading, ..Self::default() };
        }
        let share = look.driven / full_share.max(f32::MIN_POSITIVE);
        let mut full = core::mem::take(&mut self.full);
        if share >= FULL {
            full.check(limits, look.target.0 - reading, reading)?;
            self.full = full;
        }
        let missing = look.target.0 - limits.band.0 - reading;
        if missing <= 0.0 {
            *self = Self { target: self.target, was_there: true, from: reading, full: self.full, ..Self::default() };
            return Ok(());
        }
        let seconds = LOOK_PERIOD.seconds() as f32;
        self.effort_s += share * seconds;
        if reading >= self.from + limits.gain.0 {
            (self.from, self.effort_s) = (reading, 0.0);
        }
        if self.was_there {
            self.below += missing * seconds;
        }
        if limits.sinking > 0.0 && self.below > limits.sinking {
            return Err(HeatCause::Sinking(Celsius(missing + limits.band.0)));
        }
        // Once it was there it may sink for a moment without warming: that is what the sum above judges.
        if limits.within > Micros(0) && !self.was_there && self.effort_s > limits.within.seconds() as f32 {
            return Err(HeatCause::NoResponse(limits.within, limits.gain));
        }
        Ok(())
    }
}
