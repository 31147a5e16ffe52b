//! Watches a heater against its promise: the target is reached in time, and then held.
//!
//! A loose thermistor reads room temperature while the heater glows; a broken heater never warms. Neither can
//! be told from one reading, both from the course of readings.

use units::{Celsius, Micros};

use super::look::{HeatCause, Look};

/// How often the course is judged.
const CHECK_PERIOD: Micros = Micros::from_seconds(1);
/// Checks in a row outside the range before it counts as a runaway.
const RUNAWAY_CHECKS: u8 = 6;

/// What the course may be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CourseLimits {
    /// Allowed deviation once the target was reached; 0 disables that check.
    pub range: Celsius,
    /// Time allowed to heat up; 0 disables.
    pub heating_timeout: Micros,
    /// Time allowed to cool down to a lower target; 0 skips the cooling phase.
    pub cooling_timeout: Micros,
    /// How close to the target counts as reached.
    pub reached_within: Celsius,
}

#[derive(Clone, Copy, Debug, Default, PartialEq)]
enum Phase {
    #[default]
    Idle,
    HeatingUp {
        since: Micros,
    },
    CoolingDown {
        since: Micros,
    },
    Reached {
        outside: u8,
    },
}

/// The course of one heater.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Course {
    target: f32,
    phase: Phase,
    due: Micros,
}

impl Course {
    /// Judges one look, at most once a second. A new target begins a new course.
    pub(super) fn check(&mut self, limits: &CourseLimits, look: &Look) -> Result<(), HeatCause> {
        if self.target != look.target.0 {
            self.begin(limits, look);
        }
        let Some(reading) = look.reading.filter(|_| look.now >= self.due) else { return Ok(()) };
        self.due = look.now.plus(CHECK_PERIOD);
        let (target, now) = (look.target, look.now);
        self.phase = match self.phase {
            Phase::Idle => Phase::Idle,
            Phase::HeatingUp { .. } if reading >= target - limits.reached_within => Phase::Reached { outside: 0 },
            Phase::HeatingUp { since } if ran_out(limits.heating_timeout, since, now) => {
                return Err(HeatCause::HeatingTooSlow);
            }
            Phase::CoolingDown { .. } if reading <= target + limits.reached_within => Phase::Reached { outside: 0 },
            Phase::CoolingDown { since } if ran_out(limits.cooling_timeout, since, now) => {
                return Err(HeatCause::CoolingTooSlow);
            }
            Phase::Reached { outside } => Phase::Reached { outside: judge(limits, reading, target, outside)? },
            waiting => waiting,
        };
        Ok(())
    }

    fn begin(&mut self, limits: &CourseLimits, look: &Look) {
        let heats = limits.cooling_timeout == Micros(0) || look.reading.is_none_or(|reading| look.target >= reading);
        self.target = look.target.0;
        self.phase = match (look.is_on(), heats) {
            (false, _) => Phase::Idle,
            (true, true) => Phase::HeatingUp { since: look.now },
            (true, false) => Phase::CoolingDown { since: look.now },
        };
        self.due = look.now.plus(CHECK_PERIOD);
    }
}

/// How many checks in a row, this one included, were outside the range.
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

    /// Runs one check a second over a course of readings; the second of the first fault.
    fn first_fault(start: f32, target: f32, course: impl Fn(u64) -> f32) -> Option<(u64, HeatCause)> {
        let mut watch = Course::default();
        (0..400).find_map(|second| {
            let reading = Some(Celsius(if second == 0 { start } else { course(second) }));
            let (now, target) = (Micros::from_seconds(second), Celsius(target));
            let look = Look { now, reading, fault: None, target, driven: 0.0, another_on: false };
            watch.check(&LIMITS, &look).err().map(|cause| (second, cause))
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
