//! Reading of the phase: the place in the electrical cycle of an axis' motors when its switch closed.

use base::failure::Failure;
use base::ports::{DriverFault, ElectricalPhase, MotorDrivers};
use motion::MotionConfig;
use units::{Axis, Micros, PerActuator, StepCount};

use super::axes::checked;
use super::cycle::{CYCLE, Gearing, within};
use super::readings::{Reading, Unread, Way};
use crate::endstop_phase::PhaseHands;

/// Time after which the chips have come to rest. A chip that interpolates moves on to its step's place for as
/// long as the step before took. The chip takes a motor for standing 2^20 of its clocks after the last step
/// (TMC2590 data sheet, `STST`), 70 ms at 15 MHz: no interpolated step takes longer.
const AT_REST: Micros = Micros(80_000);
/// Places of a full step.
const PLACES: i64 = 256;

/// The approach in which a switch has closed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pass {
    /// The first approach.
    Fast {
        /// Whether the motors had been stopped at once before.
        was_cut: bool,
    },
    /// The slow approach, which measures.
    Slow,
}

/// Notes the phase, if the configuration asks for it. The switch of an axis has closed with the motors at
/// these steps and the axis at `hit`, mm, and they stand since.
///
/// # Errors
/// [`Failure::HALTED`].
pub fn switch_closed<'c>(
    hands: &mut impl PhaseHands<'c>,
    axis: Axis,
    then: &PerActuator<StepCount>,
    hit: f64,
    pass: Pass,
) -> Result<(), Failure> {
    if !checked(hands.config()).has(axis) {
        return Ok(());
    }
    match pass {
        Pass::Fast { was_cut } => {
            // Only the steps count here, and a silent driver is reported at the slow approach.
            let made = read(hands, axis, then, hit).ok().map(|reading| reading.made);
            hands.phases().of(axis).fast_made = made.filter(|_| !was_cut);
        }
        Pass::Slow => {
            hands.wait_for(AT_REST)?;
            let reading = read(hands, axis, then, hit);
            hands.phases().of(axis).reading = Some(reading);
        }
    }
    Ok(())
}

fn read<'c>(
    hands: &mut impl PhaseHands<'c>,
    axis: Axis,
    then: &PerActuator<StepCount>,
    hit: f64,
) -> Result<Reading, Unread> {
    let motion = hands.motion_config().map_err(|_| Unread::Uneven)?;
    let (now, made) = hands.motion(|motion| (motion.steps(), motion.steps_made(then)));
    let gearing = Gearing::of(&motion.kinematics, axis).ok_or(Unread::Uneven)?;
    let mut reading = Reading { phase: 0.0, hit, made: Way::default(), mm: 0.0, is_absolute: true };
    for (motor, sign) in gearing.motors() {
        let settings = &hands.config().actuators[motor];
        let at = match hands.drivers(|drivers| drivers.phase(motor)) {
            Ok(chip) => place_then(chip, settings.direction_inverted(), now[motor], then[motor]),
            Err(DriverFault::External) => {
                reading.is_absolute = false;
                At::after(made[motor], settings.microsteps)
            }
            Err(_) => return Err(Unread::Silent(motor)),
        };
        let mm = gearing.share * mm_per_place(&motion, motor, at.size).ok_or(Unread::Uneven)?;
        if reading.mm != 0.0 && libm::fabs(mm - reading.mm) > 1e-9 * mm {
            return Err(Unread::Uneven);
        }
        reading.mm = mm;
        reading.phase += sign * at.place as f64;
        reading.made = reading.made.with(sign * (i64::from(made[motor]) * at.size) as f64, at.size);
    }
    reading.phase = within(reading.phase, CYCLE);
    Ok(reading)
}

/// A motor's place in the cycle, not wrapped, and the size of a step in places.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct At {
    place: i64,
    size: i64,
}

impl At {
    /// Returns the place this many steps after zero.
    fn after(steps: StepCount, microsteps: u16) -> Self {
        let size = PLACES / i64::from(microsteps.clamp(1, 256));
        Self { place: i64::from(steps) * size, size }
    }
}

/// Returns a motor's place at the step count `then`, from its chip's place at the count `now`: the chip
/// counts up with DIR low, which is forward unless DIR is inverted.
fn place_then(chip: ElectricalPhase, inverted: bool, now: StepCount, then: StepCount) -> At {
    let back = At::after(then.wrapping_sub(now), chip.microsteps);
    let here = if inverted { -i64::from(chip.place) } else { i64::from(chip.place) };
    At { place: here + back.place, ..back }
}

fn mm_per_place(motion: &MotionConfig, motor: units::Actuator, size: i64) -> Option<f64> {
    let steps_per_mm = motion.actuators[motor]?.steps_per_mm;
    Some(1.0 / (steps_per_mm * size as f64))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::endstop_phase::cycle::nearest;
    use proptest::prelude::*;

    /// A chip as its data sheet describes it: each step moves its place by 256 over the microsteps, up with
    /// DIR low.
    fn stepped(place: u16, steps: i32, microsteps: u16, dir_high: bool) -> u16 {
        let way = i64::from(steps) * PLACES / i64::from(microsteps);
        (i64::from(place) + if dir_high { -way } else { way }).rem_euclid(1_024) as u16
    }

    proptest! {
        /// The reading is the motor's place at the switch, however far the motor ran on behind it, in either
        /// direction and at any microstepping.
        #[test]
        fn the_phase_is_that_of_the_switch_and_not_of_the_stop(
            start in 0_u16..1_024, to_switch in -90_000..90_000_i32, behind in -5_000..5_000_i32,
            exponent in 0_u32..9, inverted in any::<bool>(), count in -1_000_000..1_000_000_i32,
        ) {
            let microsteps = 1 << exponent;
            let at_switch = stepped(start, to_switch, microsteps, inverted);
            let at_rest = stepped(at_switch, behind, microsteps, inverted);
            let chip = ElectricalPhase { place: at_rest, microsteps };
            let found = place_then(chip, inverted, count + behind, count);
            let forward = if inverted { -i64::from(at_switch) } else { i64::from(at_switch) };
            prop_assert_eq!((found.place - forward).rem_euclid(1_024), 0);
            // The place rises as the motor counts up.
            let further = place_then(chip, inverted, count + behind, count + 1);
            prop_assert_eq!(further.place - found.place, PLACES / i64::from(microsteps));
        }

        /// An external driver's phase repeats with its cycle of 4 full steps.
        #[test]
        fn steps_made_repeat_with_the_cycle(steps in -1_000_000..1_000_000_i32, exponent in 0_u32..9, turns in -99..99_i32) {
            let microsteps = 1_u16 << exponent;
            let one = At::after(steps, microsteps);
            let other = At::after(steps + turns * 4 * i32::from(microsteps), microsteps);
            prop_assert_eq!(nearest((one.place - other.place) as f64, CYCLE), 0.0);
        }
    }
}
