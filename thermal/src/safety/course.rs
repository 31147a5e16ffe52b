//! Law of the course: a heater reaches its target in time, and then holds it.
//!
//! A loose thermistor reads room temperature while the heater glows; a broken heater never warms. Neither can
//! be told from one reading, both from the course of readings. The way down to a lower target has no time
//! limit; but a heater that stays hot without cooling at all is heated by something (a MOSFET that conducts).

use units::{Celsius, Micros};

use super::look::{HeatCause, Look};

/// Period at which the course is judged.
const CHECK_PERIOD: Micros = Micros::from_seconds(1);
/// Number of checks in a row outside the range that is a runaway.
const RUNAWAY_CHECKS: u8 = 6;
/// A heater that is this hot, degrees, with nothing warmer beside it, cools...
const HOT: f32 = 60.0;
/// ...by this much in any cooling timeout.
const COOLS: f32 = 0.5;
/// Greatest rise by a warmer neighbour of a heater that is off, kelvin: a heater that rises farther is heated
/// by its own output.
const WARMED_BY: f32 = 5.0;

/// Limits on the course of the temperature.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CourseLimits {
    /// Allowed deviation once the target was reached; 0 disables that check.
    pub range: Celsius,
    /// Time allowed to heat up; 0 disables.
    pub heating_timeout: Micros,
    /// Time within which a hot heater above a lower target must cool a little; 0 disables.
    pub cooling_timeout: Micros,
    /// Distance from the target that counts as reached.
    pub reached_within: Celsius,
}

#[derive(Clone, Copy, Debug, Default, PartialEq)]
enum Phase {
    #[default]
    Idle,
    HeatingUp {
        since: Micros,
    },
    /// The reading was `from` at `since`, and has not fallen by [`COOLS`] kelvin since then.
    CoolingDown {
        since: Micros,
        from: Celsius,
    },
    Reached {
        outside: u8,
    },
}

/// Course of a single heater.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Course {
    target: f32,
    phase: Phase,
    due: Micros,
}

impl Course {
    /// Judges a look, at most once a second. A new target begins a new course, with its first reading.
    pub(super) fn check(&mut self, limits: &CourseLimits, look: &Look) -> Result<(), HeatCause> {
        let Some(reading) = look.reading.filter(|_| look.is_on()) else {
            if !look.is_on() {
                *self = Self::default();
            }
            return Ok(());
        };
        let (target, now) = (look.target, look.now);
        if self.target != target.0 {
            self.target = target.0;
            self.phase = match target >= reading {
                true => Phase::HeatingUp { since: now },
                false => Phase::CoolingDown { since: now, from: reading },
            };
            self.due = now.plus(CHECK_PERIOD);
        }
        if now < self.due {
            return Ok(());
        }
        self.due = now.plus(CHECK_PERIOD);
        self.phase = match self.phase {
            Phase::HeatingUp { .. } if reading >= target - limits.reached_within => Phase::Reached { outside: 0 },
            Phase::HeatingUp { since } if ran_out(limits.heating_timeout, since, now) => {
                return Err(HeatCause::HeatingTooSlow);
            }
            Phase::CoolingDown { .. } if reading <= target + limits.reached_within => Phase::Reached { outside: 0 },
            Phase::CoolingDown { from, .. } if reading.0 < HOT || reading.0 <= from.0 - COOLS => {
                Phase::CoolingDown { since: now, from: reading }
            }
            Phase::CoolingDown { from, .. } if look.beside_warmer && reading.0 <= from.0 + WARMED_BY => {
                Phase::CoolingDown { since: now, from }
            }
            Phase::CoolingDown { since, .. } if ran_out(limits.cooling_timeout, since, now) => {
                return Err(HeatCause::DoesNotCool(reading));
            }
            Phase::Reached { outside } => Phase::Reached { outside: judge(limits, reading, target, outside)? },
            waiting => waiting,
        };
        Ok(())
    }
}

/// Returns the number of checks in a row outside the range, including the present.
fn judge(limits: &CourseLimits, reading: Celsius, target: Celsius, so_far: u8) -> Result<u8, HeatCause> {
    let deviation = reading - target;
    let range = limits.range.0;
    if range <= 0.0 || deviation.0 <= range && deviation.0 >= -range {
        return Ok(0);
    }
    if so_far + 1 >= RUNAWAY_CHECKS { Err(HeatCause::Runaway(deviation)) } else { Ok(so_far + 1) }
}

fn ran_out(timeout: Micros, since: Micros, now: Micros) -> bool {
    timeout > Micros(0) && now.since(since) > timeout
}

#[cfg(test)]
mod tests {
    use super::*;

    const LIMITS: CourseLimits = CourseLimits {
        range: Celsius(20.0),
        heating_timeout: Micros::from_seconds(60),
        cooling_timeout: Micros::from_seconds(100),
        reached_within: Celsius(1.0),
    };

    /// Checks a course of readings once a second; returns the second of the first fault.
    fn first_fault(start: f32, target: f32, course: impl Fn(u64) -> f32) -> Option<(u64, HeatCause)> {
        let mut watch = Course::default();
        (0..400).find_map(|second| {
            let reading = Some(Celsius(if second == 0 { start } else { course(second) }));
            watch.check(&LIMITS, &look_at(second, reading, target)).err().map(|cause| (second, cause))
        })
    }

    fn look_at(second: u64, reading: Option<Celsius>, target: f32) -> Look {
        let (now, target) = (Micros::from_seconds(second), Celsius(target));
        Look { now, reading, target, ..Look::default() }
    }

    #[test]
    fn a_heater_that_never_warms_is_stopped_when_its_time_is_up() {
        assert_eq!(first_fault(20.0, 200.0, |_| 25.0), Some((61, HeatCause::HeatingTooSlow)));
    }

    #[test]
    fn a_heater_that_arrives_in_time_and_holds_is_left_alone() {
        assert_eq!(first_fault(20.0, 200.0, |second| (20.0 + 5.0 * second as f32).min(201.0)), None);
    }

    #[test]
    fn a_fallen_sensor_is_a_runaway_after_six_checks() {
        let fault = first_fault(20.0, 200.0, |second| if second < 50 { 200.0 } else { 60.0 });
        assert_eq!(fault, Some((55, HeatCause::Runaway(Celsius(-140.0)))));
    }

    #[test]
    fn a_short_draught_is_no_runaway() {
        assert_eq!(first_fault(20.0, 200.0, |second| if second % 10 < 5 { 170.0 } else { 200.0 }), None);
    }

    #[test]
    fn cooling_takes_as_long_as_it_takes() {
        // A degree in fifty seconds, from 90 C: four hundred seconds do not suffice by far.
        assert_eq!(first_fault(90.0, 30.0, |second| 90.0 - 0.02 * second as f32), None);
        // The heater is as cold as the room, and is to become colder.
        assert_eq!(first_fault(24.0, 10.0, |_| 24.0), None);
    }

    #[test]
    fn what_stays_hot_above_a_lower_target_is_heated() {
        assert_eq!(first_fault(200.0, 100.0, |_| 199.8), Some((101, HeatCause::DoesNotCool(Celsius(199.8)))));
        let turns = |second: u64| if second < 200 { 200.0 - 0.3 * second as f32 } else { 140.0 };
        assert!(matches!(first_fault(200.0, 100.0, turns), Some((300.., HeatCause::DoesNotCool(_)))));
    }

    #[test]
    fn without_a_cooling_timeout_a_lower_target_is_no_runaway() {
        let limits = CourseLimits { cooling_timeout: Micros(0), ..LIMITS };
        let mut watch = Course::default();
        for second in 0..400 {
            let reading = Some(Celsius((200.0 - 0.5 * second as f32).max(100.0)));
            assert_eq!(watch.check(&limits, &look_at(second, reading, 100.0)), Ok(()), "{second}");
        }
    }

    #[test]
    fn a_target_given_before_the_first_reading_is_judged_from_that_on() {
        let mut watch = Course::default();
        for second in 0..60 {
            let reading = (second > 0).then_some(Celsius(200.0 - second as f32));
            assert_eq!(watch.check(&LIMITS, &look_at(second, reading, 100.0)), Ok(()), "{second}");
        }
    }

    #[test]
    fn what_stands_beside_something_warmer_may_stay_warm() {
        let mut watch = Course::default();
        for second in 0..400 {
            let look = look_at(second, Some(Celsius(70.0)), 50.0);
            assert_eq!(watch.check(&LIMITS, &Look { beside_warmer: true, ..look }), Ok(()));
        }
    }

    #[test]
    fn what_grows_warmer_above_a_lower_target_is_heated_whatever_stands_beside_it() {
        let mut watch = Course::default();
        let fault = (0..400).find_map(|second| {
            let look = look_at(second, Some(Celsius(70.0 + 0.1 * second as f32)), 50.0);
            watch.check(&LIMITS, &Look { beside_warmer: true, ..look }).err()
        });
        assert!(matches!(fault, Some(HeatCause::DoesNotCool(_))), "{fault:?}");
    }

    /// Returns the first fault of a heater that is asked for 40 C and reads the same all the time.
    fn stays_at(celsius: f32, beside_warmer: bool) -> Option<HeatCause> {
        let mut course = Course::default();
        (0..400).find_map(|second| {
            let look = Look {
                now: Micros::from_seconds(second),
                reading: Some(Celsius(celsius)),
                target: Celsius(40.0),
                beside_warmer,
                ..Look::default()
            };
            course.check(&LIMITS, &look).err()
        })
    }

    #[test]
    fn from_sixty_degrees_on_a_heater_must_cool() {
        assert_eq!(stays_at(60.0, false), Some(HeatCause::DoesNotCool(Celsius(60.0))));
        assert_eq!(stays_at(59.9, false), None, "so warm a room keeps it");
        assert_eq!(stays_at(60.0, true), None, "a neighbour does");
    }

    #[test]
    fn the_limits_of_the_range_are_within_it() {
        for (reading, after) in [(60.0, 6), (60.1, 0), (20.0, 6), (19.9, 0)] {
            let judged =
                (0..RUNAWAY_CHECKS).try_fold(0, |so_far, _| judge(&LIMITS, Celsius(reading), Celsius(40.0), so_far));
            assert_eq!(judged.is_ok(), after == 6, "{reading}");
        }
        let off = CourseLimits { range: Celsius(0.0), ..LIMITS };
        assert_eq!(judge(&off, Celsius(400.0), Celsius(40.0), RUNAWAY_CHECKS), Ok(0), "0 disables it");
    }
}
