//! Watches the stallGuard outputs of drivers while their motors move: a carriage that has hit something
//! stands, and its motor goes on stepping.
//!
//! A driver measures load once a full step, and the value means something only at a constant speed at which
//! the motor induces enough voltage. So an output counts only while the motor has been at such a speed for
//! some full steps, and one reading alone, which lasts a full step, is not believed.

use config::EndstopStallConfig;
use units::{Actuator, Micros, PerActuator};

/// Time between two looks.
const PERIOD: Micros = Micros(1_000);
/// Full steps of stall readings that are believed.
const BELIEVED: f32 = 1.5;
/// Full steps of stall that each full step of other readings takes off again: a rotor that fell out of its
/// field turns freely for two of four full steps.
const FORGIVEN: f32 = 0.25;
/// Greatest share by which a constant speed changes between two looks.
const STEADY: f32 = 0.01;

/// Watched state of one motor.
#[derive(Clone, Copy, Debug, Default)]
pub struct Sight {
    /// Speed, full steps per second either way.
    pub speed: f32,
    /// Least speed at which load can be measured, full steps per second.
    pub least: f32,
    /// Whether the driver reports a stall.
    pub stalls: bool,
}

#[derive(Clone, Copy, Debug, Default)]
struct Track {
    speed: f32,
    since: Micros,
    /// Full steps of readings that said stall, lately.
    stalled: f32,
}

/// Readings of the motors so far.
#[derive(Clone, Copy, Debug, Default)]
pub struct StallWatch {
    due: Micros,
    looked: Micros,
    tracks: PerActuator<Track>,
}

impl StallWatch {
    /// Returns whether a look is due.
    pub fn is_due(&self, now: Micros) -> bool {
        now >= self.due
    }

    /// Stops watching for this time.
    pub fn rest(&mut self, now: Micros, time: Micros) {
        *self = Self { due: now.plus(time), looked: now, ..Self::default() };
    }

    /// Looks at the motors and returns one that stalls. `None` in `sights` is not watched.
    pub fn look(&mut self, now: Micros, sights: &PerActuator<Option<Sight>>) -> Option<Actuator> {
        let seconds = now.since(self.looked).0 as f32 * 1e-6;
        (self.due, self.looked) = (now.plus(PERIOD), now);
        let mut found = None;
        for motor in Actuator::ALL {
            let (Some(sight), track) = (sights[motor], &mut self.tracks[motor]) else { continue };
            let changes = libm::fabsf(sight.speed - track.speed) > STEADY * sight.speed;
            if sight.speed < sight.least || changes {
                *track = Track { speed: sight.speed, since: now, stalled: 0.0 };
                continue;
            }
            let settling = EndstopStallConfig::SETTLING_S as f32
                + EndstopStallConfig::SETTLING_FULL_STEPS as f32 / sight.speed.max(1.0);
            if now.since(track.since) < Micros((settling * 1e6) as u64) {
                continue;
            }
            let full_steps = seconds * sight.speed;
            track.stalled = if sight.stalls {
                track.stalled + full_steps
            } else {
                (track.stalled - FORGIVEN * full_steps).max(0.0)
            };
            if track.stalled >= BELIEVED {
                track.stalled = 0.0;
                found = found.or(Some(motor));
            }
        }
        found
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the time, ms, after which a stall of alpha is believed within a second of these readings.
    fn seen(speed: impl Fn(u64) -> f32, stalls: impl Fn(u64) -> bool) -> Option<u64> {
        let mut watch = StallWatch::default();
        (0..1_000).find(|ms| {
            let mut sights = PerActuator::<Option<Sight>>::default();
            sights[Actuator::Alpha] = Some(Sight { speed: speed(*ms), least: 200.0, stalls: stalls(*ms) });
            watch.look(Micros::from_millis(*ms), &sights).is_some()
        })
    }

    #[test]
    fn a_stall_at_constant_speed_is_believed_within_three_full_steps() {
        // At 500 full steps a second each takes two milliseconds.
        let at = seen(|_| 500.0, |ms| ms >= 100).expect("a stall");
        assert!((100..=104).contains(&at), "{at}");
        // A rotor that falls out stands for two full steps of four.
        assert!(seen(|_| 500.0, |ms| ms >= 100 && ms % 8 < 4).is_some_and(|at| at < 110));
    }

    #[test]
    fn one_reading_alone_and_readings_of_slow_or_changing_motion_are_not() {
        assert_eq!(seen(|_| 500.0, |ms| ms % 40 < 2), None, "a full step of twenty");
        assert_eq!(seen(|_| 150.0, |_| true), None, "slow");
        assert_eq!(seen(|ms| 200.0 + 10.0 * (ms % 150) as f32, |_| true), None, "it speeds up");
        assert_eq!(seen(|ms| if ms % 16 == 0 { 300.0 } else { 500.0 }, |_| true), None, "short moves");
    }

    #[test]
    fn a_look_is_due_each_millisecond_and_not_while_it_rests() {
        let mut watch = StallWatch::default();
        let at = Micros::from_millis(7);
        assert!(watch.is_due(at));
        watch.look(at, &PerActuator::default());
        assert!(!watch.is_due(at.plus(Micros(999))) && watch.is_due(at.plus(Micros(1_000))));
        watch.rest(at, Micros::from_millis(50));
        assert!(!watch.is_due(at.plus(Micros::from_millis(49))) && watch.is_due(at.plus(Micros::from_millis(50))));
    }
}
