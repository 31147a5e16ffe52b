//! Checks of external drivers with a register interface, of which only the file's settings are known.

use super::findings::Checks;
use crate::machine::{ActuatorConfig, DriverKind, StealthConfig};
use crate::suggest::{at_least, at_most, at_most_amps};
use units::{Actuator, Amps};

/// Reports entries of drivers that no motor has.
pub(super) fn unused(checks: &mut Checks<'_, '_>) {
    for kind in DriverKind::OUTSIDE {
        let Some(family) = checks.config.stealth_family(kind) else { continue };
        for actuator in Actuator::ALL {
            let motor = &checks.config.actuators[actuator];
            if !family.axes[actuator].present || !motor.present || motor.driver == kind {
                continue;
            }
            let (name, has) = (actuator.name(), motor.driver.name());
            let reason = format_args!("a motor has one driver, and there is an entry for it in [{}]", kind.name());
            let fix = format_args!("write {name}.driver = {}, or delete that entry if {has} is right", kind.name());
            checks.error(("actuator", actuator as usize, "driver"), reason, fix);
        }
    }
}

/// Checks the external driver of a motor.
pub(super) fn check(checks: &mut Checks<'_, '_>, actuator: Actuator, motor: &ActuatorConfig) {
    let config = checks.config;
    let Some(chip) = config.stealth_driver(actuator) else { return };
    let (section, place, name) = (motor.driver.name(), actuator as usize, actuator.name());
    let resistor_key = if motor.driver == DriverKind::Tmc2240 { "reference_resistor" } else { "sense_resistor" };
    if !chip.present {
        let reason = format_args!("the motor's driver has no entry in [{section}]");
        let select = if motor.driver.is_on_uart() { "" } else { "spi_cs_pin and " };
        let fix = format_args!("write [{section}] {name}.{select}{resistor_key}");
        return checks.error(("actuator", place, "driver"), reason, fix);
    }
    if motor.driver.is_on_uart() {
        line(checks, section, actuator, chip.uart_address);
    }
    match chip.spi_cs_pin {
        None if motor.driver.is_on_uart() => {}
        None => {
            let reason = format_args!("the driver needs a chip select");
            checks.error((section, place, "spi_cs_pin"), reason, format_args!("write the pin it is wired to"));
        }
        Some(pin) if pin.inverted => {
            let reason = format_args!("a chip select is active low by itself");
            checks.error((section, place, "spi_cs_pin"), reason, format_args!("delete the !"));
        }
        Some(_) => {}
    }
    if i16::from(chip.hysteresis_start) + i16::from(chip.hysteresis_end) > 15 {
        let reason =
            format_args!("{} and hysteresis_start {} make more than 15", chip.hysteresis_end, chip.hysteresis_start);
        checks.error((section, place, "hysteresis_end"), reason, format_args!("write less"));
    }
    super::motors::cool_step(checks, section, place, chip.cool_step);
    if motor.driver.is_on_uart() && chip.cool_step.lower > 0 && chip.stealth_threshold.is_none() {
        let reason = format_args!("a {section} measures load while stealthChop drives, which it never does");
        let fix = format_args!("write stealthchop_threshold, or delete it");
        checks.warn((section, place, "coolstep_lower"), reason, fix);
    }
    stall_watch(checks, section, actuator, motor, chip);
    let Some(resistor) = chip.resistor else {
        if !checks.is_unreadable((section, place, resistor_key)) {
            let reason = format_args!("the resistor is that of the driver's own board, and the current depends on it");
            let fix = format_args!("look it up, mostly it is printed on the board, and write it");
            checks.error((section, place, resistor_key), reason, fix);
        }
        return;
    };
    let Some(Amps(most)) = motor.driver.measurable(resistor) else { return };
    current(checks, section, actuator, motor, most);
    if let Some(Amps(standing)) = chip.standstill_current
        && standing > chip.max_current.get()
    {
        let reason = format_args!("{:.0} mA is above max_current", standing * 1_000.0);
        checks.error((section, place, "standstill_current"), reason, format_args!("write less than max_current"));
    }
}

/// Whether stalls that are watched for can be seen: by an input, and by the chopper whose load is measured,
/// stealthChop's in a chip on a UART, spreadCycle's in the others.
fn stall_watch(
    checks: &mut Checks<'_, '_>,
    section: &str,
    actuator: Actuator,
    motor: &ActuatorConfig,
    chip: &StealthConfig,
) {
    let setting = |key| (section, actuator as usize, key);
    if !chip.stall_watch {
        if chip.stall_pin.is_some() {
            let reason = format_args!("nobody looks at it while the motor moves");
            checks.warn(setting("stall_pin"), reason, format_args!("write stall_watch = true, or delete it"));
        }
        return;
    }
    let has_input = checks.config.watched_for_stalls().any(|(watched, _)| watched == actuator);
    if !has_input && !checks.is_unreadable(setting("stall_pin")) {
        let reason = format_args!("the driver is outside the board, and its output DIAG leads nowhere");
        checks.error(setting("stall_watch"), reason, format_args!("write stall_pin, the input it is wired to"));
    }
    let silent_up_to = chip.stealth_threshold.map_or(0.0, units::MmPerSecond::get);
    let (least, most) = (checks.config.load_speed(actuator).get(), motor.max_rate.get());
    let reason = if motor.driver.is_on_uart() && silent_up_to < most {
        format_args!("a {section} measures load while stealthChop drives")
    } else if !motor.driver.is_on_uart() && silent_up_to > least {
        format_args!("a {section} measures no load while stealthChop drives")
    } else {
        return;
    };
    if motor.driver.is_on_uart() {
        let fix = format_args!("write {}, the motor's max_rate, or more; above it no stall is seen", at_least(most));
        checks.warn(setting("stealthchop_threshold"), reason, fix);
    } else {
        let fix = format_args!("write {} or less, from where on stalls are looked for", at_most(least));
        checks.warn(setting("stealthchop_threshold"), reason, fix);
    }
}

/// A line belongs to drivers or to a console, and each driver on it has an address of its own. A TMC2208
/// takes what is for address 0, and has none to choose.
fn line(checks: &mut Checks<'_, '_>, section: &str, actuator: Actuator, address: u8) {
    let config = checks.config;
    let Some(channel) = config.driver_uart(actuator) else { return };
    if config.uart.enable && config.uart.channel == channel {
        let reason =
            format_args!("UART {channel} is that of [uart console]: a line cannot serve drivers and a console");
        let fix = format_args!("write the other one here or there, and wire it so");
        checks.error((section, 0, "uart_channel"), reason, fix);
    }
    let of = |motor: Actuator| config.stealth_driver(motor).map_or(0, |driver| driver.uart_address);
    let mut others = config.actuators().map(|(motor, _)| motor).take_while(|motor| *motor != actuator);
    let same = others.find(|motor| config.driver_uart(*motor) == Some(channel) && of(*motor) == address);
    if let Some(other) = same {
        let reason = format_args!("{} has address {address} on UART {channel} too", other.name());
        if config.actuators[actuator].driver == DriverKind::Tmc2208 {
            let fix =
                format_args!("a tmc2208 needs a UART of its own, or one whose other drivers are not at address 0");
            checks.error(("actuator", actuator as usize, "driver"), reason, fix);
        } else {
            let fix = format_args!("write another, as MS1 and MS2 of the driver are wired");
            checks.error((section, actuator as usize, "uart_address"), reason, fix);
        }
    }
}

fn current(checks: &mut Checks<'_, '_>, section: &str, actuator: Actuator, motor: &ActuatorConfig, most: f32) {
    let setting = ("current control", actuator as usize, "current");
    match motor.current {
        None if !checks.is_unreadable(setting) => {
            let reason = format_args!("the motor has no current, so it gets the least its driver can give");
            let fix = format_args!("write [current control] {}.current = ...", actuator.name());
            checks.warn(("actuator", actuator as usize, "driver"), reason, fix);
        }
        Some(Amps(wanted)) if wanted > most => {
            let reason = format_args!("{wanted} A is more than the driver's resistor in [{section}] allows");
            checks.error(setting, reason, format_args!("write {} or less", at_most_amps(most)));
        }
        _ => {}
    }
}
