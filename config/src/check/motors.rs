//! Motors, their drivers, currents and slaves.

use super::findings::{Checks, report};
use crate::board::{TMC2590_SENSE_VOLTS, TMC2660_SENSE_VOLTS};
use crate::diagnostic::Severity;
use crate::ledger::{Ledger, Path};
use crate::machine::{ActuatorConfig, CoolStepConfig, DriverKind, MachineConfig, TmcConfig};
use crate::report::Reporter;
use crate::suggest::{at_most, at_most_amps};
use core::fmt;
use units::{Actuator, Amps, MmPerSecond};

const ACTUATOR: &str = "actuator";

/// Lowers speeds beyond the step frequency and currents beyond the driver's ceiling, with a warning each.
pub(super) fn limit(config: &mut MachineConfig, ledger: &Ledger, reporter: &mut Reporter<'_>) {
    for actuator in Actuator::ALL {
        let place = actuator as usize;
        let ceiling = config.max_current(actuator);
        let motor = config.actuators[actuator];
        let (possible, bound) = step_rate_possible(config, motor.driver);
        let rate = motor.max_rate.get() * motor.steps_per_mm;
        // A rate higher by rounding alone needs no warning.
        if motor.present && rate > possible * 1.000_001 {
            let lowered = MmPerSecond(possible / motor.steps_per_mm);
            let reason = format_args!("needs {rate:.0} steps/s, but {bound} allows {possible:.0}; lowered");
            let fix = format_args!("write {} or less, or change {bound}", at_most(lowered.per_minute()));
            let setting = (ACTUATOR, place, "max_rate");
            report(config, ledger, reporter, Severity::Warning, setting, reason, fix);
            config.actuators[actuator].max_rate = lowered;
        }
        if let (true, Some(Amps(most)), Some(Amps(wanted))) = (motor.present, ceiling, motor.current)
            && wanted > most
        {
            let reason = format_args!("{wanted} A is above the driver's max_current of {most} A; lowered");
            let fix = format_args!("write {most} or less");
            let setting = ("current control", place, "current");
            report(config, ledger, reporter, Severity::Warning, setting, reason, fix);
            config.actuators[actuator].current = Some(Amps(most));
        }
    }
}

/// Steps in a second that a motor can make, and the setting that bounds them. A driver outside takes
/// pulses: high for `step_pulse_us`, low for as long and half a microsecond, which the end of a pulse may
/// come late.
fn step_rate_possible(config: &MachineConfig, driver: DriverKind) -> (f64, &'static str) {
    let most = f64::from(config.system.step_frequency_hz);
    let pulses = 1e6 / (2.0 * f64::from(config.system.step_pulse_us.max(1)) + 0.5);
    if !driver.is_on_board() && pulses < most { (pulses, "step_pulse_us") } else { (most, "step_frequency") }
}

pub(super) fn check(checks: &mut Checks<'_, '_>) {
    let config = checks.config;
    // Motors must have no gap from alpha on, and be X, Y and Z at least.
    let count = config.actuators().count();
    for actuator in Actuator::ALL.into_iter().take(count.max(3)) {
        if !config.actuators[actuator].present {
            let reason = format_args!("there is no motor {}", actuator.name());
            let fix = format_args!("describe it: motors are alpha, beta, gamma and up, without a gap");
            checks.error((ACTUATOR, actuator as usize, "steps_per_mm"), reason, fix);
        }
    }
    super::stealth_drivers::unused(checks);
    for (actuator, motor) in config.actuators() {
        step_and_direction(checks, actuator, motor);
        driver(checks, actuator, motor);
        slow_table(checks, actuator, motor);
        if let Some(master) = motor.slaved_to {
            slave(checks, actuator, master);
        }
    }
    super::arms::check(checks);
}

fn step_and_direction(checks: &mut Checks<'_, '_>, actuator: Actuator, motor: &ActuatorConfig) {
    for (key, pin) in [("step_pin", motor.step_pin), ("dir_pin", motor.dir_pin)] {
        if pin.is_none() {
            checks.error(
                (ACTUATOR, actuator as usize, key),
                format_args!("the motor needs a {key}"),
                format_args!("write one"),
            );
        }
    }
    if motor.reversed && motor.dir_pin.is_some_and(|pin| pin.inverted) {
        let reason = format_args!("the motor is reversed here and by ! on dir_pin; together they count once");
        checks.warn((ACTUATOR, actuator as usize, "reversed"), reason, format_args!("keep one of them"));
    }
}

/// X and Y as slow as a lead screw: the speed was probably meant in mm/s, as in other firmwares.
const SLOWEST_TABLE: MmPerSecond = MmPerSecond(10.0);

fn slow_table(checks: &mut Checks<'_, '_>, actuator: Actuator, motor: &ActuatorConfig) {
    let setting = (ACTUATOR, actuator as usize, "max_rate");
    if matches!(actuator, Actuator::Alpha | Actuator::Beta) && motor.max_rate < SLOWEST_TABLE {
        let written = motor.max_rate.per_minute();
        let reason =
            format_args!("{written:.0} mm/min is only {:.1} mm/s for a motor of X and Y", motor.max_rate.get());
        let fix = format_args!("this one is in mm/min: for {written:.0} mm/s write {:.0}", written * 60.0);
        checks.warn(setting, reason, fix);
    }
}

fn driver(checks: &mut Checks<'_, '_>, actuator: Actuator, motor: &ActuatorConfig) {
    let place = actuator as usize;
    if motor.driver.is_spoken_with() && !motor.microsteps.is_power_of_two() {
        let reason = format_args!("{} microsteps do not exist", motor.microsteps);
        let fix = format_args!("write 1, 2, 4, 8, 16, 32, 64, 128 or 256, and fit steps_per_mm to it");
        checks.error((ACTUATOR, place, "microsteps"), reason, fix);
    }
    let (section, sense_volts) = match motor.driver {
        DriverKind::Tmc2590 => ("tmc2590", TMC2590_SENSE_VOLTS),
        DriverKind::Tmc2660 => ("tmc2660", TMC2660_SENSE_VOLTS),
        DriverKind::External => {
            if motor.current.is_some() {
                let reason = format_args!("an external driver's current cannot be set from here");
                checks.warn(("current control", place, "current"), reason, format_args!("delete the line"));
            }
            return;
        }
        _ => {
            return super::stealth_drivers::check(checks, actuator, motor);
        }
    };
    let Some(chip) = checks.config.driver(actuator) else { return };
    if !chip.present {
        return missing_chip(checks, section, actuator, motor.driver);
    }
    if chip.is_assumed {
        let (milliohms, most) = (chip.sense_resistor.get() * 1e3, chip.max_current.get());
        let reason = format_args!(
            "[{section}] does not describe the motor's driver; taken for the board's own: sense resistor {milliohms:.0} mOhm, \
             at most {most} A"
        );
        let fix = format_args!("write [{section}] {}.sense_resistor if that is right, or what is", actuator.name());
        checks.warn((ACTUATOR, place, "driver"), reason, fix);
    }
    if chip.spi_cs_pin.is_none() {
        let reason = format_args!("the driver needs a chip select");
        checks.error((section, place, "spi_cs_pin"), reason, format_args!("write one"));
    }
    if chip.spi_cs_pin.is_some_and(|pin| pin.inverted) {
        let reason = format_args!("a chip select is active low by itself");
        checks.error((section, place, "spi_cs_pin"), reason, format_args!("delete the !"));
    }
    current(checks, section, actuator, motor, chip, sense_volts);
}

/// Reports that the file does not describe the chip that drives a motor.
fn missing_chip(checks: &mut Checks<'_, '_>, section: &str, actuator: Actuator, driver: DriverKind) {
    let at = (ACTUATOR, actuator as usize, "driver");
    let reason = format_args!("the motor's driver has no entry in [{section}]");
    let (other, family) = match driver {
        DriverKind::Tmc2590 => ("tmc2660", &checks.config.tmc2660),
        _ => ("tmc2590", &checks.config.tmc2590),
    };
    if !family.axes[actuator].present {
        let fix = format_args!("write [{section}] {}.sense_resistor, or driver = external", actuator.name());
        return checks.error(at, reason, fix);
    }
    if Path::named(ACTUATOR, at.1, at.2).is_some_and(|path| checks.ledger.span(path).is_some()) {
        let fix = format_args!("there is one in [{other}]: write driver = {other} if the board has those");
        return checks.error(at, reason, fix);
    }
    let fix = format_args!(
        "there is one in [{other}]: for a board with those check with --board {other}, for this one write \
         [{section}] {}.sense_resistor",
        actuator.name()
    );
    checks.error(at, reason, fix);
}

fn current(
    checks: &mut Checks<'_, '_>,
    section: &str,
    actuator: Actuator,
    motor: &ActuatorConfig,
    chip: &TmcConfig,
    sense_volts: f32,
) {
    let place = actuator as usize;
    let most = sense_volts / chip.sense_resistor.get();
    match motor.current {
        None if motor.slaved_to.is_none() && !checks.is_unreadable(("current control", place, "current")) => {
            let reason = format_args!("the motor has no current, so it gets the least its driver can give");
            let fix = format_args!("write [current control] {}.current = ...", actuator.name());
            checks.warn((ACTUATOR, place, "driver"), reason, fix);
        }
        Some(Amps(wanted)) if wanted > most => {
            let milliohms = chip.sense_resistor.get() * 1_000.0;
            let reason = format_args!("{wanted} A is more than a {milliohms:.0} mOhm sense resistor can measure");
            checks.error(
                ("current control", place, "current"),
                reason,
                format_args!("write {} or less", at_most_amps(most)),
            );
        }
        _ => {}
    }
    cool_step(checks, section, place, chip.cool_step);
    if let Some(Amps(standing)) = chip.standstill_current
        && standing > chip.max_current.get()
    {
        let reason = format_args!("{:.0} mA is above max_current", standing * 1_000.0);
        checks.error((section, place, "standstill_current"), reason, format_args!("write less than max_current"));
    }
}

/// The chip has 32 readings in one step of its thresholds, and sixteen steps between them.
pub(super) fn cool_step(checks: &mut Checks<'_, '_>, section: &str, place: usize, settings: CoolStepConfig) {
    const STEP: u16 = CoolStepConfig::STEP;
    let (lower, upper) = (settings.lower, settings.falls_from());
    if lower == 0 {
        if settings.upper.is_some() {
            let reason = format_args!("coolStep is off");
            checks.warn((section, place, "coolstep_upper"), reason, format_args!("write coolstep_lower, or delete it"));
        }
        return;
    }
    if lower % STEP != 0 {
        let reason = format_args!("{lower} is no multiple of {STEP}");
        let fix = format_args!("write {}", (lower / STEP).max(1) * STEP);
        checks.error((section, place, "coolstep_lower"), reason, fix);
    }
    if upper % STEP != 0 || upper <= lower || upper > lower + 16 * STEP {
        let reason = format_args!("{upper} is no multiple of {STEP} above coolstep_lower = {lower}");
        let fix = format_args!("write {} to {}", lower + STEP, lower + 16 * STEP);
        checks.error((section, place, "coolstep_upper"), reason, fix);
    }
}

fn slave(checks: &mut Checks<'_, '_>, actuator: Actuator, master: Actuator) {
    let config = checks.config;
    let setting = (ACTUATOR, actuator as usize, "slaved_to");
    let (slave, leader) = (&config.actuators[actuator], &config.actuators[master]);
    let mut error = |reason: fmt::Arguments<'_>, fix: &str| checks.error(setting, reason, format_args!("{fix}"));
    if (actuator as usize) < 3 {
        error(format_args!("only delta, epsilon and zeta can follow another motor"), "delete the line");
    }
    if !leader.present {
        error(format_args!("there is no motor {}", master.name()), "name a motor that exists");
    }
    if slave.microsteps != leader.microsteps {
        error(
            format_args!("it has {} microsteps, {} has {}", slave.microsteps, master.name(), leader.microsteps),
            "write the same microsteps for both",
        );
    }
    if slave.steps_per_mm != leader.steps_per_mm {
        error(
            format_args!("it has {} steps/mm, {} has {}", slave.steps_per_mm, master.name(), leader.steps_per_mm),
            "write the same steps_per_mm for both",
        );
    }
}
