//! Finds the motors that turn slowly and steadily: only then does a driver's open load indicator mean
//! anything.
//!
//! TMC2590 datasheet section 7.10 and TMC2660 datasheet section 6.10: the bits say that no chopper event came
//! during the last period of constant coil polarity, two full steps, and may be false in fast motion and at
//! standstill.

use units::{Actuator, Micros, PerActuator, StepCount};

/// Time between two looks.
const PERIOD: Micros = Micros::from_millis(100);
/// Least full steps between two looks in which both coils have surely changed polarity.
const FEWEST: f32 = 4.0;
/// Greatest full steps between two looks in slow motion: two turns a second of a motor of 200.
const MOST: f32 = 40.0;

/// Watch over the motors' steps.
#[derive(Clone, Copy, Debug, Default)]
pub struct SlowTurning {
    due: Micros,
    before: PerActuator<StepCount>,
    slow: u8,
}

impl SlowTurning {
    /// Looks at how many steps each motor has made. Returns the motors, one bit each, that turned slowly the
    /// same way since the look before last; nothing when no look is due.
    pub fn look(
        &mut self,
        now: Micros,
        made: &PerActuator<StepCount>,
        microsteps: impl Fn(Actuator) -> u16,
    ) -> Option<u8> {
        if now < self.due {
            return None;
        }
        // A late look has seen more steps than it should, which only makes motion look faster.
        self.due = now.plus(PERIOD);
        let slow = Actuator::ALL.into_iter().filter(|motor| {
            let steps = made[*motor].wrapping_sub(self.before[*motor]).unsigned_abs();
            let full_steps = steps as f32 / f32::from(microsteps(*motor).max(1));
            (FEWEST..=MOST).contains(&full_steps)
        });
        let slow = slow.fold(0, |mask, motor| mask | motor.bit());
        self.before = *made;
        Some(slow & core::mem::replace(&mut self.slow, slow))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the result of the fifth look at a motor with so many full steps a second.
    fn seen(full_steps_per_s: f32) -> u8 {
        let mut turning = SlowTurning::default();
        let mut made = PerActuator::<StepCount>::default();
        let looks = (1..=5).map(|look| {
            made[Actuator::Beta] += (full_steps_per_s * 16.0 / 10.0) as StepCount;
            turning.look(Micros::from_millis(look * 100), &made, |_| 16)
        });
        looks.last().flatten().unwrap_or_default()
    }

    #[test]
    fn only_slow_motion_counts() {
        assert_eq!(seen(0.0), 0);
        assert_eq!(seen(30.0), 0);
        assert_eq!(seen(50.0), Actuator::Beta.bit());
        assert_eq!(seen(350.0), Actuator::Beta.bit());
        assert_eq!(seen(-350.0), Actuator::Beta.bit());
        assert_eq!(seen(500.0), 0);
    }

    #[test]
    fn it_takes_two_looks() {
        let mut turning = SlowTurning::default();
        let made = |steps| {
            let mut made = PerActuator::<StepCount>::default();
            made[Actuator::Alpha] = steps;
            made
        };
        assert_eq!(turning.look(Micros::from_millis(0), &made(0), |_| 16), Some(0));
        assert_eq!(turning.look(Micros::from_millis(50), &made(160), |_| 16), None);
        assert_eq!(turning.look(Micros::from_millis(100), &made(160), |_| 16), Some(0));
        assert_eq!(turning.look(Micros::from_millis(200), &made(320), |_| 16), Some(Actuator::Alpha.bit()));
        assert_eq!(turning.look(Micros::from_millis(300), &made(320), |_| 16), Some(0));
    }
}
