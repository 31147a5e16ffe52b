//! Homing without a switch: the axis runs against its end, and its driver says that the motor stalls.
//!
//! A driver measures load once a full step, and rightly only at a constant speed at which the motor induces
//! something. So nothing is looked at until the axis has been at its speed for some full steps; then the
//! driver's output stops the motors at once, within the two full steps that a rotor gives way before it falls
//! out of its field. The axis backs off and comes again. The second stall counts, and must be where the first
//! was: a false stall lies on the way to the end.

use base::failure::{Failure, Texts};
use base::ports::{DriverFault, MotorDrivers, StallSearch, Wake};
use base::reason::Alarm;
use config::{EndstopConfig, EndstopStallConfig, MachineConfig};
use motion::Mode;
use units::{Actuator, Axis, AxisSet, Micros, MmPerSecond};

use super::hits::{Hits, alarm, wait_trigger};
use super::switches::{switch_of, towards};
use crate::endstop_phase::PhaseHands;

/// Greatest distance between two stalls at the same end, full steps: a rotor that fell out of its field in
/// the first has lost four, and each is seen up to two late.
const SAME_END: f64 = 6.0;
/// Least mean reading of the driver on the way: "without load and with maximum load they should show a
/// difference of at least 100" (TMC2130 datasheet rev. 1.09, 14.3). With less, noise may look like a stall.
const LEAST_FREE: u32 = 100;
/// Time between two readings over SPI.
const READING_PERIOD: Micros = Micros::from_millis(2);
/// Least number of readings for a mean.
const LEAST_READINGS: u32 = 4;
/// Greatest relative change of a speed that counts as constant.
const STEADY: f64 = 1e-3;

const STALLS_BEFORE: &str =
    "the motor stalls before its end, or nearly: raise stall_threshold, stall_current or the speed";

/// Returns the axis of this set that homes without a switch; such an axis homes alone.
pub(super) fn axis_of(config: &MachineConfig, set: AxisSet) -> Option<Axis> {
    set.axes().find(|axis| switch_of(config, *axis).is_some_and(|(_, stop)| stop.stall.homing))
}

/// Returns whether an axis of the set homes without a switch.
pub(super) fn is_used(config: &MachineConfig, set: AxisSet) -> bool {
    axis_of(config, set).is_some()
}

/// Returns the motor of an axis, and those that copy its steps.
fn motors(config: &MachineConfig, axis: Axis) -> impl Iterator<Item = Actuator> + use<'_> {
    let master = Actuator::from_index(axis as usize);
    let moves = move |motor: &Actuator| Some(*motor) == master || config.actuators[*motor].slaved_to == master;
    config.actuators().map(|(motor, _)| motor).filter(move |motor| master.is_some() && moves(motor))
}

fn full_step(config: &MachineConfig, axis: Axis) -> f64 {
    let motor = config.actuators.0.get(axis as usize);
    motor.map_or(0.0, |motor| f64::from(motor.microsteps.max(1)) / motor.steps_per_mm)
}

/// Sets the drivers of the axis for the search.
///
/// # Errors
/// When a driver does not answer, or cannot be set for it.
pub(super) fn begin<'c>(hands: &mut impl PhaseHands<'c>, axis: Axis) -> Result<(), Failure> {
    let config = hands.config();
    let Some((_, stop)) = switch_of(config, axis) else { return Ok(()) };
    for motor in motors(config, axis) {
        let threshold = hands.tuning().homing_thresholds[motor].unwrap_or(stop.stall.threshold);
        let search = StallSearch { current: stop.stall.current, threshold };
        said(hands.texts(), motor, hands.drivers(|drivers| drivers.begin_stall_search(motor, search)))?;
    }
    Ok(())
}

/// Sets the drivers back as they were.
///
/// # Errors
/// When a driver does not answer.
pub(super) fn end<'c>(hands: &mut impl PhaseHands<'c>, axis: Axis) -> Result<(), Failure> {
    let ended = motors(hands.config(), axis).map(|motor| {
        let set = hands.drivers(|drivers| drivers.end_stall_search(motor));
        said(hands.texts(), motor, set)
    });
    // All drivers are set back, also behind a silent one.
    ended.fold(Ok(()), Result::and)
}

fn said(texts: &Texts, motor: Actuator, done: Result<(), DriverFault>) -> Result<(), Failure> {
    let why = match done {
        // An external driver with its own stall output has its own settings.
        Ok(()) | Err(DriverFault::External) => return Ok(()),
        Err(DriverFault::BadSetting) => "cannot be set for homing without a switch",
        Err(DriverFault::Silent | DriverFault::BadAnswer) => "does not answer, check its supply and wiring",
        Err(DriverFault::Reset) => "was without power, check its supply",
    };
    Err(texts.alarm(format_args!("motor driver {} {why}", motor.name())))
}

/// Moves towards the end of the axis until its motor stalls.
pub(super) fn approach<'c>(
    hands: &mut impl PhaseHands<'c>,
    axis: Axis,
    rate: MmPerSecond,
    travel: fn(&EndstopConfig) -> f64,
) -> Result<Hits, Failure> {
    let config = hands.config();
    let mut at = hands.position();
    let Some((input, stop)) = switch_of(config, axis) else {
        return Err(Failure::refused(&"the axis has no end to home to"));
    };
    let mut target = at;
    target[axis] += towards(stop) * travel(stop);
    // The position of a motor that has been pushed against an end is unknown until it has been measured.
    hands.axes().forget_homed(AxisSet::of(axis));
    hands.latch().disarm();
    hands.go(target, rate, Mode::Feed)?;
    steady(hands, full_step(config, axis))?;
    hands.latch().arm_hard(input.bit());
    let free = mean_reading(hands, axis)?;
    let Some(trigger) = wait_trigger(hands)? else {
        let what = "the motor did not stall within its travel: stall_threshold may be too high for it";
        return Err(alarm(hands.texts(), config, axis, Alarm::HomingSearch, what));
    };
    if free.is_some_and(|mean| mean < LEAST_FREE) {
        return Err(alarm(hands.texts(), config, axis, Alarm::HomingSearch, STALLS_BEFORE));
    }
    at[axis] = hands.motion(|motion| motion.position_of_steps(&trigger.steps))[axis];
    Ok(Hits { at, unsure: AxisSet::NONE, was_cut: true })
}

/// Returns the mean reading of the driver until the axis stops; `None` if the readings are too few.
fn mean_reading<'c>(hands: &mut impl PhaseHands<'c>, axis: Axis) -> Result<Option<u32>, Failure> {
    let Some(motor) = Actuator::from_index(axis as usize) else { return Ok(None) };
    let (mut sum, mut count, mut due) = (0, 0, hands.now());
    while hands.latch().armed() != 0 && !hands.motion(|motion| motion.is_idle()) {
        if hands.now() >= due {
            due = hands.now().plus(READING_PERIOD);
            // If the driver cannot be asked, its output alone decides.
            if let Ok(reading) = hands.drivers(|drivers| drivers.reserve(motor)) {
                sum += u32::from(reading);
                count += 1;
            }
        }
        hands.wait(Wake::Time).unless_halted()?;
    }
    Ok((count >= LEAST_READINGS).then(|| sum / count))
}

/// Waits until motion has been at a constant speed for as long as the load takes to be measured, or has
/// ended.
pub fn steady<'c>(hands: &mut impl PhaseHands<'c>, full_step: f64) -> Result<(), Failure> {
    hands.motion(motion::Motion::flush);
    let (mut speed, mut since) = (0.0, hands.now());
    loop {
        hands.wait(Wake::Time).unless_halted()?;
        let (now, is_idle) = hands.motion(|motion| (motion.speed().0, motion.is_idle()));
        if is_idle {
            return Ok(());
        }
        if now <= 0.0 || libm::fabs(now - speed) > STEADY * now {
            (speed, since) = (now, hands.now());
            continue;
        }
        let seconds = EndstopStallConfig::SETTLING_S + EndstopStallConfig::SETTLING_FULL_STEPS * full_step / speed;
        if hands.now().since(since) >= Micros((seconds * 1e6) as u64) {
            return Ok(());
        }
    }
}

/// Checks that the second stall was at the end that the first has found.
///
/// # Errors
/// An alarm when the second stall was on the way there, or when there was nothing at the place of the first.
pub(super) fn is_at_the_end(
    texts: &Texts,
    config: &MachineConfig,
    axis: Axis,
    first: f64,
    second: f64,
) -> Result<(), Failure> {
    let further = switch_of(config, axis).map_or(0.0, |(_, stop)| (second - first) * towards(stop));
    let allowed = SAME_END * full_step(config, axis);
    let what = if further < -allowed {
        STALLS_BEFORE
    } else if further > allowed {
        "the motor does not stall where it did at first: something gave way, or it never met its end"
    } else {
        return Ok(());
    };
    Err(alarm(texts, config, axis, Alarm::HomingSearch, what))
}
