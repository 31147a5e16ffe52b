//! The strength of motor currents, and what the drivers say: M906, M907, M911.

use core::fmt::{self, Write};

use config::MachineConfig;
use program::Words;
use units::{Actuator, Amps, Axis};

use crate::axes::{Axes, internal_motors, motors};
use crate::failure::{Answer, Failure, Outcome, message};
use crate::ports::{Description, DriverFault, DriversPort, MotorDrivers};
use crate::sessions::Reply;
use crate::tuning::Tuning;

/// Letters of motors.
const LETTERS: &str = "XYZABC";

/// M906 in mA, M907 in A: sets the currents that are given; without words says those that are set.
///
/// # Errors
/// When a letter is that of no motor, a current is negative, or a motor has no driver that takes it.
pub(crate) fn motor_currents(
    ports: &mut impl DriversPort,
    config: &MachineConfig,
    axes: &mut Axes,
    tuning: &mut Tuning,
    words: &Words<'_>,
    reply: &mut Reply<'_>,
) -> Outcome {
    if let Some(letter) = words.other_than(LETTERS) {
        let number = words.code().number;
        return Err(Failure::Refused(message(format_args!("M{number}: {letter} is the letter of no motor"))));
    }
    if words.is_bare() {
        report_currents(tuning, reply);
    }
    for (axis, motor) in Axis::ALL.into_iter().zip(Actuator::ALL) {
        let Some(amps) = words.axis(axis) else { continue };
        let set = set_current(ports, config, motor, Amps(amps as f32), reply)?;
        tuning.currents[motor] = Some(set);
        axes.has_new_current(motor);
    }
    Ok(Answer::Ok)
}

/// Gives a motor a current, at most what its driver may give. Returns that.
fn set_current(
    ports: &mut impl DriversPort,
    config: &MachineConfig,
    motor: Actuator,
    wanted: Amps,
    reply: &mut Reply<'_>,
) -> Result<Amps, Failure> {
    let name = motor.name();
    let refuse = |reason: &str| Failure::Refused(message(format_args!("{name}: {reason}")));
    if wanted.0 < 0.0 || !wanted.0.is_finite() {
        return Err(refuse("the current must not be negative"));
    }
    let ceiling = config.driver(motor).map(|driver| driver.max_current);
    let Some(ceiling) = ceiling.filter(|_| config.actuators[motor].present) else {
        return Err(refuse("has no driver whose current can be set"));
    };
    let allowed = if wanted > ceiling { ceiling } else { wanted };
    if allowed < wanted {
        reply.say(format_args!("WARNING: {name}: current cut to max_current {:.3} A\n", allowed.0));
    }
    match ports.drivers(|drivers| drivers.set_current(motor, allowed)) {
        Ok(_) => Ok(allowed),
        Err(DriverFault::External) => Err(refuse("has no driver whose current can be set")),
        Err(DriverFault::BadSetting) => Err(refuse("the driver cannot be set so")),
        Err(DriverFault::Silent | DriverFault::BadAnswer) => Err(refuse("the driver does not answer")),
    }
}

fn report_currents(tuning: &Tuning, reply: &mut Reply<'_>) {
    for motor in Actuator::ALL {
        if let Some(amps) = tuning.currents[motor] {
            reply.say(format_args!("{}: {:.5} Amps\n", motor.name(), amps.0));
        }
    }
}

/// The currents as M500 saves them.
pub(crate) fn write_currents(text: &mut impl Write, tuning: &Tuning, config: &MachineConfig) -> fmt::Result {
    let mut any = false;
    for (axis, motor) in Axis::ALL.into_iter().zip(Actuator::ALL) {
        if let Some(amps) = tuning.currents[motor].filter(|_| config.actuators[motor].present) {
            let head = if any { "" } else { ";Motor currents:\nM907" };
            write!(text, "{head} {}{:.5}", axis.letter(), amps.0)?;
            any = true;
        }
    }
    if any { writeln!(text) } else { Ok(()) }
}

/// M911: the motors whose drivers are asked about, one bit each: all, that with P's number, or those whose
/// letters are written.
///
/// # Errors
/// When P or a letter is that of no driver of ours: those there are.
pub(crate) fn named_drivers(words: &Words<'_>, config: &MachineConfig) -> Result<u8, Failure> {
    let internal = internal_motors(config);
    if let Some(p) = words.get('P') {
        let named = motors(internal).find(|motor| f64::from(*motor as u8) == p);
        return named
            .map(Actuator::bit)
            .ok_or_else(|| no_driver(config, format_args!("M911: P{p} is the number of no driver; there are")));
    }
    let mut named = 0;
    for axis in words.axes().axes() {
        let motor = motors(internal).find(|motor| *motor as usize == axis as usize);
        let motor = motor.ok_or_else(|| {
            no_driver(config, format_args!("M911: {} is the letter of no driver; there are", axis.letter()))
        })?;
        named |= motor.bit();
    }
    Ok(if named == 0 { internal } else { named })
}

fn no_driver(config: &MachineConfig, why: fmt::Arguments<'_>) -> Failure {
    let mut text = message(why);
    for (place, motor) in motors(internal_motors(config)).enumerate() {
        let comma = if place == 0 { "" } else { "," };
        let letter = Axis::ALL.get(motor as usize).map_or('?', |axis| axis.letter());
        // What does not fit any more is left out.
        let _ = write!(text, "{comma} P{} {letter}", motor as u8);
    }
    Failure::Refused(text)
}

/// What one driver says of itself.
pub(crate) fn describe_driver(ports: &mut impl DriversPort, motor: Actuator, all: bool, reply: &mut Reply<'_>) {
    let mut text = heapless::String::<1_024>::new();
    // A description that does not fit is cut.
    let _ = ports.drivers(|drivers| drivers.describe(motor, Description::Everything, &mut text));
    let (number, letter) = (motor as u8, letter_of(motor));
    if all {
        reply.say(format_args!("Motor {number} ({letter})...\n"));
    }
    reply.say(format_args!("designator {letter}, actuator {}, {text}", motor.name()));
    if all {
        reply.say(format_args!("\n"));
    }
}

fn letter_of(motor: Actuator) -> char {
    Axis::ALL.get(motor as usize).map_or('?', |axis| axis.letter())
}
