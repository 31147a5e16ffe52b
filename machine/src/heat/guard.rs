//! Watches a heater against its promise: the target is reached in time, and then held.
//!
//! A loose thermistor reads room temperature while the heater glows; a broken heater never warms. Neither can
//! be told from one reading, both from the course of readings.

use units::{Celsius, Micros};

use super::HeatCause;

/// How often the course is judged.
const CHECK_PERIOD: Micros = Micros::from_seconds(1);
/// Checks in a row outside the range before it counts as a runaway.
const RUNAWAY_CHECKS: u8 = 6;

/// What the guard allows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GuardSettings {
    /// Allowed deviation once the target was reached; 0 disables that check.
    pub range: Celsius,
    /// Time allowed to heat up; 0 disables.
    pub heating_timeout: Micros,
    /// Time allowed to cool down to a lower target; 0 skips the cooling phase.
    pub cooling_timeout: Micros,
    /// How close to the target counts as reached.
    pub reached_within: Celsius,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Phase {
    Idle,
    HeatingUp { since: Micros },
    CoolingDown { since: Micros },
    Reached { outside: u8 },
}

/// The guard of one heater.
#[derive(Clone, Copy, Debug)]
pub struct Guard {
    settings: GuardSettings,
    phase: Phase,
    due: Micros,
}

impl Guard {
    /// A guard at rest.
    #[must_use]
    pub const fn new(settings: GuardSettings) -> Self {
        Self { settings, phase: Phase::Idle, due: Micros(0) }
    }

    /// The target changed; watching starts anew.
    pub fn new_target(&mut self, reading: Option<Celsius>, target: Celsius, now: Micros) {
        let heats = self.settings.cooling_timeout == Micros(0) || reading.is_none_or(|reading| target >= reading);
        self.phase = match (target > super::OFF_BELOW, heats) {
            (false, _) => Phase::Idle,
            (true, true) => Phase::HeatingUp { since: now },
            (true, false) => Phase::CoolingDown { since: now },
        };
        self.due = now.plus(CHECK_PERIOD);
    }

    /// Judges one reading, at most once a second.
    pub fn check(&mut self, reading: Celsius, target: Celsius, now: Micros) -> Result<(), HeatCause> {
        if now < self.due {
            return Ok(());
        }
        self.due = now.plus(CHECK_PERIOD);
        let settings = &self.settings;
        self.phase = match self.phase {
            Phase::Idle => Phase::Idle,
            Phase::HeatingUp { .. } if reading >= target - settings.reached_within => Phase::Reached { outside: 0 },
            Phase::HeatingUp { since } if ran_out(settings.heating_timeout, since, now) => {
                return Err(HeatCause::HeatingTooSlow);
            }
            Phase::CoolingDown { .. } if reading <= target + settings.reached_within => Phase::Reached { outside: 0 },
            Phase::CoolingDown { since } if ran_out(settings.cooling_timeout, since, now) => {
                return Err(HeatCause::CoolingTooSlow);
            }
            Phase::Reached { outside } => Phase::Reached { outside: self.outside(reading, target, outside)? },
            waiting => waiting,
        };
        Ok(())
    }

    fn outside(&self, reading: Celsius, target: Celsius, so_far: u8) -> Result<u8, HeatCause> {
        let deviation = reading - target;
        let range = self.settings.range.0;
        if range <= 0.0 || deviation.0 <= range && deviation.0 >= -range {
            return Ok(0);
        }
        if so_far + 1 >= RUNAWAY_CHECKS { Err(HeatCause::Runaway(deviation)) } else { Ok(so_far + 1) }
    }
}

fn ran_out(timeout: Micros, since: Micros, now: Micros) -> bool {
    timeout > Micros(0) && now.since(since) > timeout
}

#[cfg(test)]
mod tests {
    use super::*;

    const SETTINGS: GuardSettings = GuardSettings {
        range: Celsius(20.0),
        heating_timeout: Micros::from_seconds(60),
        cooling_timeout: Micros::from_seconds(100),
        reached_within: Celsius(1.0),
    };

    /// Runs one check a second over a course of readings; the second of the first fault.
    fn first_fault(start: f32, target: f32, course: impl Fn(u64) -> f32) -> Option<(u64, HeatCause)> {
        let mut guard = Guard::new(SETTINGS);
        guard.new_target(Some(Celsius(start)), Celsius(target), Micros(0));
        (1..400).find_map(|second| {
            let checked = guard.check(Celsius(course(second)), Celsius(target), Micros::from_seconds(second));
            checked.err().map(|cause| (second, cause))
        })
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
    fn cooling_to_a_lower_target_has_its_own_time() {
        assert_eq!(first_fault(200.0, 100.0, |second| (200.0 - 1.1 * second as f32).max(100.0)), None);
        assert_eq!(first_fault(200.0, 100.0, |_| 199.0), Some((101, HeatCause::CoolingTooSlow)));
    }
}
