//! Law of response: a driven heater must warm, and must stay at its target.
//!
//! Effort is counted, not time: the output that the pin was really given, so ten seconds at half output are
//! five seconds of effort. So a control law that goes gently needs no longer limits, and a law that asks for
//! nothing is not blamed on the heater. Warming on the way to a target and sinking away from it are judged as
//! by Klipper's `verify_heater`, with its usual figures. No sound heater does two things more: take full
//! output near its target in vain for as long as it would need to come from below, or cool under full output.
//! Slow heaters, such as beds, also do not stop warming from a moment to the next.

use units::{Celsius, Micros};

use super::look::{HeatCause, LOOK_PERIOD, Look};

/// Share of the heater's greatest output that counts as full output.
const FULL: f32 = 0.95;
/// Distance below the target, C, from which a heater at full output must warm, also after it was at the
/// target.
const NEAR: f32 = 2.0;
/// Time at full output, s, after which heat has come through to any sensor.
const COME_THROUGH_S: f32 = 6.0;
/// After that time no reading falls by more than this, C...
const FALL: f32 = 3.0;
/// ...within so many seconds, with a comparison each second.
const FALL_S: usize = 3;
/// Number of comparisons in a row that must agree: a single jump makes a single fall.
const AGREE: u8 = 2;
/// Least `verify_gain_time` of a slow heater: no fan blows at it, and no filament cools it.
const SLOW: Micros = Micros::from_seconds(45);
/// Stall of a slow heater: after warming steadily for this many seconds...
const STEADY_S: usize = 6;
/// ...the heater warms for `STALLS_S` seconds by less than the share `STALL` of the former rate...
const STALLS_S: usize = 5;
const STALL: f32 = 0.2;
/// ...and this many degrees are missing.
const MISSING: f32 = 1.0;
/// Number of seconds whose readings are kept.
const KEPT_S: usize = STEADY_S + STALLS_S;

/// Limits on a heater's response.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ResponseLimits {
    /// Distance below the target beyond which the heater must warm, or is sinking.
    pub band: Celsius,
    /// Least rise, with the effort of `within`.
    pub gain: Celsius,
    /// Time at full output for that rise; 0: not checked.
    pub within: Micros,
    /// Degrees below the band times seconds that the heater may sink once it was at its target; 0: not
    /// checked.
    pub sinking: f32,
}

/// Response of a heater so far.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Response {
    target: f32,
    /// Whether the heater was within the band of this target.
    was_there: bool,
    /// The reading from which the heater must warm.
    from: f32,
    /// Effort since then, seconds at full output.
    effort_s: f32,
    /// Degrees below the band, times seconds.
    below: f32,
    full: FullOutput,
}

/// A heater that has been at full output without a pause.
#[derive(Clone, Copy, Debug, Default)]
struct FullOutput {
    seconds: f32,
    /// Seconds since the heater warmed by `gain`, and the reading then.
    in_vain_s: f32,
    from: f32,
    /// Readings of the last seconds, newest last.
    before: [f32; KEPT_S],
    falls: u8,
    stalls: u8,
}

impl FullOutput {
    /// Takes a look at a heater that is at full output.
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
    /// Returns whether the heater warmed steadily, and does not any more.
    fn stalls(&self) -> bool {
        let [first, .., last] = self.before;
        let turn = self.before[STEADY_S];
        let expected = (turn - first) / STEADY_S as f32 * (STALLS_S - 1) as f32;
        let went_on = last - turn;
        // Heat that still comes through makes the heater warm faster and faster, which is no stall.
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
        // A heater that was at its target may sink for a moment without warming; the sum above judges that.
        if limits.within > Micros(0) && !self.was_there && self.effort_s > limits.within.seconds() as f32 {
            return Err(HeatCause::NoResponse(limits.within, limits.gain));
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LIMITS: ResponseLimits =
        ResponseLimits { band: Celsius(5.0), gain: Celsius(2.0), within: Micros::from_seconds(60), sinking: 120.0 };

    /// Runs a heater at full output towards 100 C, with its reading after so many seconds; returns the first
    /// fault and its second.
    fn driven(limits: ResponseLimits, reads: impl Fn(f32) -> f32) -> Option<(f32, HeatCause)> {
        let mut response = Response::default();
        (0..400 * 20).find_map(|look| {
            let second = look as f32 * 0.05;
            let reading = Some(Celsius(reads(second)));
            let look = Look { reading, target: Celsius(100.0), driven: 1.0, ..Look::default() };
            Some((second, response.check(&limits, 1.0, &look).err()?))
        })
    }

    #[test]
    fn a_slow_heater_that_suddenly_does_not_warm_any_more_stalls() {
        let (at, cause) = driven(LIMITS, |second| 20.0 + second.min(30.0)).expect("a fault");
        assert!(cause == HeatCause::Stalls && (33.0..39.0).contains(&at), "{cause:?} after {at} s");
        // A quick heater has fans and filament that hold it up.
        let quick = ResponseLimits { within: Micros::from_seconds(20), ..LIMITS };
        let (at, cause) = driven(quick, |second| 20.0 + second.min(30.0)).expect("a fault");
        assert!(matches!(cause, HeatCause::NoResponse(..)) && at > 45.0, "{cause:?} after {at} s");
    }

    #[test]
    fn a_heater_that_warms_by_its_gain_in_time_is_sound_until_it_is_there() {
        for gain_in_s in [20.0, 55.0] {
            let reads = move |second: f32| (20.0 + 2.0 * second / gain_in_s).min(99.0);
            assert_eq!(driven(LIMITS, reads), None, "2 C in {gain_in_s} s");
        }
        let (at, cause) = driven(LIMITS, |second| 20.0 + 2.0 * second / 75.0).expect("a fault");
        assert!(matches!(cause, HeatCause::NoResponse(..)) && (59.0..62.0).contains(&at), "{cause:?} after {at} s");
    }

    #[test]
    fn near_its_target_a_heater_at_full_output_must_still_warm() {
        // 3 C are missing, within the band: only the look at full output sees it.
        let (at, cause) = driven(LIMITS, |second| (20.0 + 2.0 * second).min(97.0)).expect("a fault");
        assert!(matches!(cause, HeatCause::NoResponse(..) | HeatCause::Stalls), "{cause:?} after {at} s");
        assert_eq!(driven(ResponseLimits { within: Micros(0), ..LIMITS }, |_| 97.0), None, "0 disables it");
    }
}
