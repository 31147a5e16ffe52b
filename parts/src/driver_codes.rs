//! Codes for drivers as Marlin has them: M569 and M913 (stealthChop), M912 (reported driver troubles), M914
//! (homing without a switch).

use base::CodeContext;
use base::failure::{Answer, Failure, Outcome, Texts};
use base::motors::{named_drivers, not_set};
use base::ports::{DriverFault, DriversPort, MotorDrivers};
use base::sessions::Reply;
use base::supervisor::SupervisorPort;
use base::tuning::Tuning;
use config::MachineConfig;
use program::Words;
use units::{Actuator, Axis};

/// Speed that no motor comes to, mm/s: stealthChop always.
const ANY_SPEED: f64 = 1e6;

/// Returns the motors whose letters are written, with their values.
fn given<'a>(words: &'a Words<'_>, config: &'a MachineConfig) -> impl Iterator<Item = (Actuator, f64)> + 'a {
    let motors = Axis::ALL.into_iter().zip(Actuator::ALL).filter(|(_, motor)| config.actuators[*motor].present);
    motors.filter_map(|(axis, motor)| Some((motor, words.axis(axis)?)))
}

/// M912: forgets what was reported of these drivers, so that troubles that still hold are reported again.
///
/// # Errors
/// When P or a letter names no motor with a driver of ours.
pub fn forget_told(CodeContext { texts, ports, config, words, .. }: CodeContext<'_, impl SupervisorPort>) -> Outcome {
    let named = named_drivers(texts, words, config)?;
    ports.supervisor(|supervisor| Actuator::of_bits(named).for_each(|motor| supervisor.forget_told(motor)));
    Ok(Answer::Ok)
}

/// M913: sets the greatest speed at which stealthChop drives a motor, mm/s; 0 is never. Without words prints
/// it.
///
/// # Errors
/// When a speed is negative, or a driver refuses it. A driver without stealthChop is reported, and is no
/// error: the file may be made for other drivers.
pub fn stealth_thresholds(
    CodeContext { texts, ports, config, words, reply }: CodeContext<'_, impl DriversPort>,
    tuning: &mut Tuning,
) -> Outcome {
    if words.is_bare() {
        for (motor, settings) in config.actuators() {
            let of_file =
                config.stealth_driver(motor).map(|driver| driver.stealth_threshold.map_or(0.0, |speed| speed.0));
            if let (true, Some(speed)) =
                (settings.driver.is_spoken_with(), tuning.stealth_thresholds[motor].or(of_file))
            {
                reply.say(format_args!("{}: {speed} mm/s\n", motor.name()));
            }
        }
        return Ok(Answer::Ok);
    }
    for (motor, speed) in given(words, config) {
        set_stealth(texts, ports, config, tuning, motor, speed, reply)?;
    }
    Ok(Answer::Ok)
}

/// M569: S1 has stealthChop drive these motors at any speed, S0 never. Without a letter, all drivers with
/// stealthChop are meant.
///
/// # Errors
/// As [`stealth_thresholds`]; and when S is missing.
pub fn stealth_mode(
    CodeContext { texts, ports, config, words, reply }: CodeContext<'_, impl DriversPort>,
    tuning: &mut Tuning,
) -> Outcome {
    let Some(on) = words.get('S') else { return Err(Failure::refused(&"M569 takes S1, stealthChop, or S0")) };
    let speed = if on == 0.0 { 0.0 } else { ANY_SPEED };
    let named = words.axes();
    for (motor, _) in config.actuators() {
        let is_named = Axis::ALL.get(motor as usize).is_some_and(|axis| named.has(*axis));
        if is_named || named.is_empty() && config.stealth_driver(motor).is_some() {
            set_stealth(texts, ports, config, tuning, motor, speed, reply)?;
        }
    }
    Ok(Answer::Ok)
}

fn set_stealth(
    texts: &Texts,
    ports: &mut impl DriversPort,
    config: &MachineConfig,
    tuning: &mut Tuning,
    motor: Actuator,
    speed: f64,
    reply: &mut Reply<'_>,
) -> Result<(), Failure> {
    if speed < 0.0 || !speed.is_finite() {
        return Err(texts.refused(format_args!("{}: a speed must not be negative", motor.name())));
    }
    let settings = &config.actuators[motor];
    let full_steps_per_s = speed * settings.steps_per_mm / f64::from(settings.microsteps.max(1));
    let threshold = (speed > 0.0).then_some(full_steps_per_s as f32);
    match ports.drivers(|drivers| drivers.set_stealth_threshold(motor, threshold)) {
        Ok(()) => tuning.stealth_thresholds[motor] = Some(speed),
        Err(DriverFault::External) => reply.say(format_args!("{}: its driver has no stealthChop\n", motor.name())),
        Err(fault) => return Err(not_set(texts, motor, fault)),
    }
    Ok(())
}

/// M914: sets the load threshold of a stall for homing without a switch. Without words prints it.
///
/// # Errors
/// When a driver has no such threshold.
pub fn homing_thresholds(
    texts: &Texts,
    config: &MachineConfig,
    tuning: &mut Tuning,
    words: &Words<'_>,
    reply: &mut Reply<'_>,
) -> Outcome {
    if words.is_bare() {
        for stop in config.endstops.iter().filter(|stop| stop.stall.homing) {
            let Some(motor) = stop.axis.and_then(|axis| Actuator::from_index(axis as usize)) else { continue };
            let threshold = tuning.homing_thresholds[motor].unwrap_or(stop.stall.threshold);
            reply.say(format_args!("{}: {threshold}\n", motor.name()));
        }
        return Ok(Answer::Ok);
    }
    for (motor, threshold) in given(words, config) {
        let [least, most] = config
            .stall_thresholds(motor)
            .ok_or_else(|| texts.refused(format_args!("{}: its driver measures no load", motor.name())))?;
        if !(f64::from(least)..=f64::from(most)).contains(&threshold) {
            let name = motor.name();
            return Err(texts.refused(format_args!("{name}: {least} to {most}, lower or higher is none")));
        }
        tuning.homing_thresholds[motor] = Some(threshold as i16);
    }
    Ok(Answer::Ok)
}

#[cfg(test)]
mod tests {
    use super::*;
    use base::bench::{BenchHands, Desk, words};
    use base::hands::Hands;

    /// Settings of three motors whose drivers nobody here knows.
    const MOTORS: &str = "\
[actuator]
alpha.steps_per_mm = 80
alpha.step_pin = PD3
alpha.dir_pin = PD4
alpha.driver = external
beta.steps_per_mm = 80
beta.step_pin = PK2
beta.dir_pin = PG2
beta.driver = external
gamma.steps_per_mm = 80
gamma.step_pin = PG3
gamma.dir_pin = PG4
gamma.driver = external
";

    #[test]
    fn a_motor_is_driven_quietly_at_any_speed_or_never() {
        let mut bench = BenchHands::<()>::new(MOTORS);
        let mut desk = Desk::new();
        let mut set = |bench: &mut BenchHands<()>, line: &str| {
            let (texts, config) = (bench.texts(), bench.config());
            let reply = &mut Reply::new(&mut desk.sessions, base::sessions::Recipient::All);
            let code = CodeContext { texts, ports: &mut bench.world, config, words: &words(line), reply };
            stealth_mode(code, &mut bench.settings)
        };
        assert_eq!(set(&mut bench, "M569 S1 Y"), Ok(Answer::Ok));
        assert_eq!(bench.settings.stealth_thresholds[Actuator::Beta], Some(ANY_SPEED));
        assert_eq!(bench.settings.stealth_thresholds[Actuator::Alpha], None, "it was not named");
        assert_eq!(set(&mut bench, "M569 S0 Y"), Ok(Answer::Ok));
        assert_eq!(bench.settings.stealth_thresholds[Actuator::Beta], Some(0.0));
        assert!(set(&mut bench, "M569 Y").is_err(), "S is missing");
        assert_eq!(set(&mut bench, "M569 S1"), Ok(Answer::Ok));
        assert_eq!(bench.settings.stealth_thresholds[Actuator::Alpha], None, "no driver here has stealthChop");
    }
}
