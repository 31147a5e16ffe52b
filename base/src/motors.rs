//! Motor currents and diagnostics of the drivers: M906, M907, M911.

use core::fmt::{self, Write};

use config::MachineConfig;
use program::Words;
use units::{Actuator, Amps, Axis};

use crate::CodeContext;
use crate::axes::{Axes, internal_motors};
use crate::failure::{Answer, Failure, FailureKind, Outcome, Texts, short};
use crate::ports::{Description, DriverFault, DriversPort, MotionPort, MotorDrivers};
use crate::sessions::Reply;
use crate::tuning::{StallThreshold, Tuning};

/// Letters of the motors.
const LETTERS: &str = "XYZABC";

/// M906 in mA, M907 in A: sets the currents that are given; without words prints those that are set. A slaved
/// motor that is not named takes its master's.
///
/// # Errors
/// When a letter names no motor, a current is negative, or a motor has no driver that takes it.
pub fn motor_currents(
    CodeContext { texts, ports, config, words, reply }: CodeContext<'_, impl DriversPort>,
    axes: &mut Axes,
    tuning: &mut Tuning,
) -> Outcome {
    if let Some(letter) = words.other_than(LETTERS) {
        let number = words.code().number;
        return Err(texts.refused(format_args!("M{number}: {letter} is the letter of no motor")));
    }
    if words.is_bare() {
        report_currents(tuning, reply);
    }
    for (axis, motor) in Axis::ALL.into_iter().zip(Actuator::ALL) {
        let takes_current = config.max_current(motor).is_some();
        let master = config.actuators[motor].slaved_to.filter(|_| takes_current);
        let of_master = || words.axis(*Axis::ALL.get(master? as usize)?);
        let Some(amps) = words.axis(axis).or_else(of_master) else { continue };
        let set = set_current(texts, ports, config, motor, Amps(amps as f32), reply)?;
        tuning.currents[motor] = Some(set);
        axes.has_new_current(motor);
    }
    Ok(Answer::Ok)
}

/// Gives a motor a current, at most what its driver may give. Returns the current given.
fn set_current(
    texts: &Texts,
    ports: &mut impl DriversPort,
    config: &MachineConfig,
    motor: Actuator,
    wanted: Amps,
    reply: &mut Reply<'_>,
) -> Result<Amps, Failure> {
    let name = motor.name();
    let refuse = |reason: &str| texts.refused(format_args!("{name}: {reason}"));
    if wanted.0 < 0.0 || !wanted.0.is_finite() {
        return Err(refuse("the current must not be negative"));
    }
    let Some(ceiling) = config.max_current(motor).filter(|_| config.actuators[motor].present) else {
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
        Err(DriverFault::Reset) => Err(refuse("the driver was without power")),
    }
}

fn report_currents(tuning: &Tuning, reply: &mut Reply<'_>) {
    let mut by_name = Actuator::ALL;
    units::sort_short(&mut by_name, |one, other| one.name().cmp(other.name()));
    for motor in by_name {
        if let Some(amps) = tuning.currents[motor] {
            reply.say(format_args!("{}: {:.5} Amps\n", motor.name(), amps.0));
        }
    }
}

/// Writes the currents as M500 saves them.
pub fn write_currents(text: &mut impl Write, tuning: &Tuning, config: &MachineConfig) -> fmt::Result {
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

/// Writes the load thresholds of drivers as M500 saves them.
pub fn write_stall_thresholds(text: &mut impl Write, tuning: &Tuning) -> fmt::Result {
    for motor in Actuator::ALL {
        if let Some(StallThreshold { threshold, filter }) = tuning.stall_thresholds[motor] {
            let filter = u8::from(filter);
            writeln!(text, ";Load measurement:\nM911.3 P{} S7 O{threshold} Q{filter}", motor as u8)?;
        }
        if let Some(threshold) = tuning.homing_thresholds[motor] {
            writeln!(text, ";The same while it homes:\nM911.3 P{} S9 O{threshold}", motor as u8)?;
        }
    }
    Ok(())
}

/// Writes the greatest speeds of stealthChop as M500 saves them.
pub fn write_stealth_thresholds(text: &mut impl Write, tuning: &Tuning) -> fmt::Result {
    for (axis, motor) in Axis::ALL.into_iter().zip(Actuator::ALL) {
        if let Some(speed) = tuning.stealth_thresholds[motor] {
            writeln!(text, ";stealthChop up to this speed:\nM913 {}{speed}", axis.letter())?;
        }
    }
    Ok(())
}

/// Writes the choppers as M500 saves them.
pub fn write_choppers(text: &mut impl Write, tuning: &Tuning) -> fmt::Result {
    for motor in Actuator::ALL {
        if let Some(fit) = &tuning.choppers[motor] {
            let (off, blank) = (fit.off_time, fit.blank_clocks);
            let (start, end) = (fit.hysteresis_start, fit.hysteresis_end);
            writeln!(text, ";Chopper:\nM911.3 P{} S1 U{off} V{blank} W{start} X{end} Y0", motor as u8)?;
        }
    }
    Ok(())
}

/// M911: returns the motors whose drivers are asked about, one bit each: all, that with P's number, or those
/// whose letters are written.
///
/// # Errors
/// When P or a letter names no driver of ours; the text lists those there are.
pub fn named_drivers(texts: &Texts, words: &Words<'_>, config: &MachineConfig) -> Result<u8, Failure> {
    let internal = internal_motors(config);
    if let Some(p) = words.get('P') {
        let named = Actuator::of_bits(internal).find(|motor| f64::from(*motor as u8) == p);
        return named
            .map(Actuator::bit)
            .ok_or_else(|| no_driver(texts, config, format_args!("M911: P{p} is the number of no driver; there are")));
    }
    let mut named = 0;
    for axis in words.axes().axes() {
        let motor = Actuator::of_bits(internal).find(|motor| *motor as usize == axis as usize);
        let motor = motor.ok_or_else(|| {
            no_driver(texts, config, format_args!("M911: {} is the letter of no driver; there are", axis.letter()))
        })?;
        named |= motor.bit();
    }
    Ok(if named == 0 { internal } else { named })
}

fn no_driver(texts: &Texts, config: &MachineConfig, why: fmt::Arguments<'_>) -> Failure {
    let mut text = short(why);
    for (place, motor) in Actuator::of_bits(internal_motors(config)).enumerate() {
        let comma = if place == 0 { "" } else { "," };
        let letter = Axis::ALL.get(motor as usize).map_or('?', |axis| axis.letter());
        // Drivers that do not fit into the text are left out.
        let _ = write!(text, "{comma} P{} {letter}", motor as u8);
    }
    texts.keep(FailureKind::Refused, &text)
}

/// Prints everything that one driver reports.
pub fn describe_driver(ports: &mut impl DriversPort, motor: Actuator, all: bool, reply: &mut Reply<'_>) {
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

/// M911.1: prints how drivers regulate their current, one line each.
///
/// # Errors
/// As [`named_drivers`].
pub fn describe_choppers(
    CodeContext { texts, ports, config, words, reply }: CodeContext<'_, impl DriversPort>,
) -> Outcome {
    for motor in Actuator::of_bits(named_drivers(texts, words, config)?) {
        let mut text = heapless::String::<64>::new();
        // The line fits, so errors are ignored.
        let _ = ports.drivers(|drivers| drivers.describe(motor, Description::Chopper, &mut text));
        reply.say(format_args!("{},{text}", letter_of(motor)));
    }
    Ok(Answer::Ok)
}

/// M911.2: writes one register of one driver; R255 writes all of them again. Without R lists the registers.
///
/// # Errors
/// When a word is missing, or the chip does not take it.
pub fn write_register(
    CodeContext { texts, ports, config, words, reply }: CodeContext<'_, impl DriversPort>,
) -> Outcome {
    let Some(number) = words.get('R') else {
        reply.say(format_args!(
            "P motor, else all, R register V value: R1 driver control, R2 chopper, R3 coolStep, R4 stallGuard2 and current, \
             R5 configuration, R255 writes all again\n"
        ));
        return Ok(Answer::Ok);
    };
    let value = words.get('V').filter(|value| (0.0..1_048_576.0).contains(value));
    for motor in Actuator::of_bits(named_drivers(texts, words, config)?) {
        let done = match (number, value) {
            (255.0, _) => ports.drivers(|drivers| drivers.initialise(motor)),
            (1.0..=5.0, Some(value)) => {
                ports.drivers(|drivers| drivers.write_register(motor, number as u8, value as u32))
            }
            _ => Err(DriverFault::BadSetting),
        };
        done.map_err(|fault| not_set(texts, motor, fault))?;
    }
    Ok(Answer::Ok)
}

/// M911.3: writes a group of settings, by its number S.
///
/// # Errors
/// When the chip does not take them.
pub fn driver_option(
    CodeContext { texts, ports, config, words, reply }: CodeContext<'_, impl DriversPort>,
    tuning: &mut Tuning,
) -> Outcome {
    let named = named_drivers(texts, words, config)?;
    let Some(option) = words.get('S').filter(|option| (0.0..=9.0).contains(option)) else {
        Actuator::of_bits(named).for_each(|_| reply.say(format_args!("No options were recognised\n")));
        return Ok(Answer::Ok);
    };
    let threshold = words.get('O').map(|threshold| threshold as i16);
    for motor in Actuator::of_bits(named) {
        if option == 9.0 {
            let [least, most] = config.stall_thresholds(motor).unwrap_or([0, -1]);
            let threshold = threshold.filter(|threshold| (least..=most).contains(threshold));
            tuning.homing_thresholds[motor] =
                Some(threshold.ok_or_else(|| not_set(texts, motor, DriverFault::BadSetting))?);
            continue;
        }
        let set = ports.drivers(|drivers| drivers.set_option(motor, option as u8, &|letter| words.get(letter)));
        set.map_err(|fault| not_set(texts, motor, fault))?;
        if option < 2.0 {
            // Settings by hand take the place of the computed chopper.
            tuning.choppers[motor] = None;
        }
        if let Some(threshold) = threshold.filter(|_| option == 7.0) {
            let filter = words.get('Q').is_some_and(|filter| filter != 0.0);
            tuning.stall_thresholds[motor] = Some(StallThreshold { threshold, filter });
        }
    }
    Ok(Answer::Ok)
}

/// M909: sets microsteps until the next reset.
///
/// # Errors
/// When a motor has no driver of ours, or the driver has no such microsteps.
pub fn microsteps(
    CodeContext { texts, ports, config, words, reply }: CodeContext<'_, impl DriversPort + MotionPort>,
) -> Outcome {
    for (axis, motor) in Axis::ALL.into_iter().zip(Actuator::ALL) {
        let Some(count) = words.axis(axis) else { continue };
        if !Actuator::of_bits(internal_motors(config)).any(|internal| internal == motor) {
            return Err(not_set(texts, motor, DriverFault::External));
        }
        let set = if (1.0..=256.0).contains(&count) {
            ports.drivers(|drivers| drivers.set_microsteps(motor, count as u16))
        } else {
            Err(DriverFault::BadSetting)
        };
        let before = set.map_err(|fault| not_set(texts, motor, fault))?;
        let letter = axis.letter();
        reply.say(format_args!("microsteps for {letter} temporarily changed to: 1/{count}\n"));
        if words.code().subcode == 1 {
            let steps = scale_steps(texts, ports, motor, count / f64::from(before))?;
            reply.say(format_args!("steps/mm for {letter} temporarily changed to: {steps:.6}\n"));
        }
    }
    Ok(Answer::Ok)
}

/// Multiplies a motor's steps per mm by a factor; returns the new steps per mm.
fn scale_steps(texts: &Texts, ports: &mut impl MotionPort, motor: Actuator, factor: f64) -> Result<f64, Failure> {
    let missing = || Failure::refused(&"motion is not configured");
    let mut settings = ports.motion(|motion| motion.config().copied()).ok_or_else(missing)?;
    let actuator = settings.actuators[motor].as_mut().ok_or_else(missing)?;
    actuator.steps_per_mm *= factor;
    let steps = actuator.steps_per_mm;
    ports.motion(|motion| motion.configure(settings)).map_err(|error| texts.refusal(error))?;
    Ok(steps)
}

/// `setregs <motor> r1,r2,r3,r4,r5`: writes all registers of a driver, in hexadecimal.
///
/// # Errors
/// When the chip does not take them.
pub fn set_registers(
    texts: &Texts,
    ports: &mut impl DriversPort,
    config: &MachineConfig,
    arguments: &str,
    reply: &mut Reply<'_>,
) -> Outcome {
    let (name, words) = arguments.split_once(' ').unwrap_or((arguments, ""));
    let mut values = [0; 5];
    let mut given = words.split(',').map(|word| u32::from_str_radix(word.trim(), 16));
    let whole = values.iter_mut().all(|value| given.next().and_then(Result::ok).map(|word| *value = word).is_some());
    if words.is_empty() || !whole || given.next().is_some() {
        reply.say(format_args!("invalid - 5 registers required\n"));
        return Ok(Answer::Ok);
    }
    let named = |motor: &Actuator| motor.name() == name || name.len() == 1 && name.starts_with(letter_of(*motor));
    let motor = Actuator::of_bits(internal_motors(config)).find(named);
    let motor =
        motor.ok_or_else(|| no_driver(texts, config, format_args!("{name} is the name of no driver; there are")))?;
    for (number, value) in (1..).zip(values) {
        let written = ports.drivers(|drivers| drivers.write_register(motor, number, value));
        written.map_err(|fault| not_set(texts, motor, fault))?;
    }
    reply.say(format_args!("registers temporarily set for motor {}\n", motor as u8));
    Ok(Answer::Ok)
}

/// Returns the failure of a driver that did not take its settings.
pub fn not_set(texts: &Texts, motor: Actuator, fault: DriverFault) -> Failure {
    let why = match fault {
        DriverFault::External => "has no driver of this board",
        DriverFault::Silent | DriverFault::BadAnswer => "the driver does not answer",
        DriverFault::Reset => "the driver was without power",
        DriverFault::BadSetting => "the driver cannot be set so",
    };
    texts.refused(format_args!("{}: {why}", motor.name()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bench::{BenchHands, Desk, THREE_MOTORS, words};
    use crate::hands::Hands;

    /// A machine with a driver of ours for X.
    fn machine() -> BenchHands<()> {
        BenchHands::new(THREE_MOTORS)
    }

    fn option(bench: &mut BenchHands<()>, line: &str) -> Outcome {
        let mut desk = Desk::new();
        let reply = &mut Reply::new(&mut desk.sessions, crate::sessions::Recipient::All);
        let (texts, config) = (bench.texts(), bench.config());
        let code = CodeContext { texts, ports: &mut bench.world, config, words: &words(line), reply };
        driver_option(code, &mut bench.settings)
    }

    #[test]
    fn a_threshold_is_kept_for_what_it_was_set_for() {
        let mut bench = machine();
        assert_eq!(option(&mut bench, "M911.3 P0 S7 O5 Q1"), Ok(Answer::Ok));
        let kept = bench.settings.stall_thresholds[Actuator::Alpha].expect("a threshold");
        assert_eq!((kept.threshold, kept.filter), (5, true));
        assert_eq!(bench.settings.homing_thresholds[Actuator::Alpha], None);
        assert_eq!(option(&mut bench, "M911.3 P0 S9 O-3"), Ok(Answer::Ok));
        assert_eq!(bench.settings.homing_thresholds[Actuator::Alpha], Some(-3));
        assert_eq!(bench.settings.stall_thresholds[Actuator::Alpha].map(|kept| kept.threshold), Some(5));
        assert!(option(&mut bench, "M911.3 P0 S9 O100").is_err(), "out of the chip's range");
        assert_eq!(option(&mut bench, "M911.3 P0 S6 O9"), Ok(Answer::Ok));
        assert_eq!(bench.settings.stall_thresholds[Actuator::Alpha].map(|kept| kept.threshold), Some(5));
    }

    #[test]
    fn microsteps_scale_the_steps_where_asked() {
        let mut bench = machine();
        let mut desk = Desk::new();
        let mut set = |line: &str| {
            let (texts, config) = (bench.texts(), bench.config());
            let reply = &mut Reply::new(&mut desk.sessions, crate::sessions::Recipient::All);
            let code = CodeContext { texts, ports: &mut bench.world, config, words: &words(line), reply };
            let done = microsteps(code);
            let own = bench.motion(|motion| motion.config().copied()).expect("a configuration");
            done.map(|_| own.actuators[Actuator::Alpha].expect("a motor").steps_per_mm)
        };
        assert_eq!(set("M909 X16"), Ok(80.0));
        assert!(set("M909 X0").is_err() && set("M909 X512").is_err() && set("M909 Y16").is_err());
    }
}
