//! Transfer of a chip's settings from the configuration to the driver's copy of the registers.

use core::fmt;

use config::{ActuatorConfig, CoolStepConfig, DriverKind, MachineConfig, TmcConfig};
use embedded_hal::spi::{Mode, SpiDevice};
use tmc::stealth::{self, SingleWire, StealthChip, StealthDriver, StealthSettings};
use tmc::{Chip, CoolStep, Driver, Error, Microsteps, StallGuard, StepInput};
use units::{Actuator, Amps, Ohms};

use crate::motor_driver::MotorDriver;
use crate::outside_bus::{BusFailed, OutsideBus};
use crate::stealth::Outside;

/// SPI mode of the chips, and a clock in Hz for the slowest oscillator and wires to a header; the chips allow
/// 4 MHz ("SPI timing").
pub const OUTSIDE_CLOCK: (Mode, u32) = (tmc::SPI_MODE, 1_000_000);

/// SPI mode and clock of TMC2590 and TMC2660 on external boards.
pub const CHIP_CLOCK: (Mode, u32) = (tmc::SPI_MODE, tmc::SPI_CLOCK_HZ);

/// A setting that the chip cannot take; the motor stays without its driver.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NotSetUp<E> {
    /// Error of the driver.
    Driver(Error<E>),
    /// Not a power of two up to 256.
    Microsteps(u16),
}

impl<E: fmt::Debug> fmt::Display for NotSetUp<E> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Driver(error) => error.fmt(f),
            Self::Microsteps(count) => write!(f, "microsteps must be a power of two up to 256, not {count}"),
        }
    }
}

/// Keeps only errors about settings that no chip can take; a chip may be silent, since the motor supply may
/// be off. All of its registers are written, and silence is reported, by
/// [`base::ports::MotorDrivers::initialise`].
fn stored<T, E>(result: Result<T, Error<E>>) -> Result<(), NotSetUp<E>> {
    match result {
        Err(error @ Error::Setting(_)) => Err(NotSetUp::Driver(error)),
        _ => Ok(()),
    }
}

/// Creates the driver of this motor, with its settings: raw registers first, then the named ones.
///
/// # Errors
/// The setting that the chip cannot take.
pub fn set_up<SPI: SpiDevice, LINE, E>(
    spi: SPI,
    motor: &ActuatorConfig,
    settings: &TmcConfig,
) -> Result<MotorDriver<SPI, LINE, E>, NotSetUp<SPI::Error>> {
    let kind = if motor.driver == DriverKind::Tmc2660 { Chip::Tmc2660 } else { Chip::Tmc2590 };
    let mut driver = Driver::new(spi, kind, settings.sense_resistor).map_err(NotSetUp::Driver)?;
    if let Some(words) = settings.registers {
        stored(driver.load_registers(words))?;
    }
    let microsteps = Microsteps::from_count(motor.microsteps).ok_or(NotSetUp::Microsteps(motor.microsteps))?;
    // The step engine relies on double edges, whatever raw registers say.
    let input = StepInput { microsteps, double_edge: true, interpolation: settings.step_interpolation };
    stored(driver.set_step_input(input))?;
    let most = settings.max_current;
    // Without a current of its own the motor keeps that of the raw registers, but for the ceiling.
    let wanted = motor.current.or(settings.registers.map(|_| driver.current()));
    if let Some(current) = wanted {
        stored(driver.set_current(Amps(current.0.min(most.0))))?;
    }
    stored(driver.set_standstill_current(settings.standstill_current.map(|current| Amps(current.0.min(most.0)))))?;
    let load = driver.registers().sgcsconf;
    stored(driver.set_stall_guard(StallGuard {
        threshold: settings.stall_threshold.unwrap_or(load.threshold()),
        filter: settings.stall_filter.unwrap_or(load.sfilt() == 1),
    }))?;
    if let Some(cool_step) = cool_step(&settings.cool_step) {
        stored(driver.set_cool_step(Some(cool_step)))?;
    }
    // Without a setting, the gate drive follows the raw registers, or the chip's default.
    if let Some(strength) = settings.gate_drive {
        stored(driver.set_gate_drive(strength))?;
    }
    if let Some(on) = settings.short_to_supply_detection {
        stored(driver.set_short_to_supply_detection(on))?;
    }
    // The setting is on unless told otherwise, and a TMC2660 has no passive fast decay.
    stored(driver.set_passive_fast_decay(settings.passive_fast_decay && kind == Chip::Tmc2590))?;
    Ok(MotorDriver::Chip(driver, most))
}

/// Creates the driver of this motor outside the board, with its settings. Sends nothing.
///
/// # Errors
/// The setting that the chip cannot take.
pub fn set_up_outside<SPI: SpiDevice, LINE: SingleWire, E>(
    bus: OutsideBus<SPI, LINE>,
    enable: Option<E>,
    config: &MachineConfig,
    actuator: Actuator,
) -> Result<MotorDriver<SPI, LINE, E>, NotSetUp<BusFailed>> {
    let motor: &ActuatorConfig = &config.actuators[actuator];
    let (Some(settings), Some(kind)) = (config.stealth_driver(actuator), chip_of(motor.driver)) else {
        return Ok(MotorDriver::None);
    };
    let microsteps = Microsteps::from_count(motor.microsteps).ok_or(NotSetUp::Microsteps(motor.microsteps))?;
    let full_steps_per_mm = motor.steps_per_mm / f64::from(motor.microsteps.max(1));
    let plain = StealthSettings::new(settings.resistor.unwrap_or(Ohms(0.0)));
    let settings_of_chip = StealthSettings {
        microsteps,
        interpolation: settings.step_interpolation,
        stealth_threshold: settings
            .stealth_threshold
            .map(|speed| stealth::step_time(kind, (speed.get() * full_steps_per_mm) as f32)),
        off_time: settings.off_time,
        blank_time: kind.blank_time(settings.blank_time).unwrap_or(plain.blank_time),
        hysteresis_start: settings.hysteresis_start,
        hysteresis_end: settings.hysteresis_end,
        stall_threshold: settings.stall_threshold,
        stall_filter: settings.stall_filter,
        stall_output: settings.stall_watch,
        load_from: Some(stealth::step_time(kind, (config.load_speed(actuator).get() * full_steps_per_mm) as f32)),
        cool_step: cool_step(&settings.cool_step),
        ..plain
    };
    let mut chip = StealthDriver::new(bus, kind, settings_of_chip).map_err(NotSetUp::Driver)?;
    if let Some(current) = motor.current {
        chip.store_current(Amps(current.0.min(settings.max_current.0)));
    }
    Ok(MotorDriver::Outside(Outside { chip, enable, most: settings.max_current }))
}

/// Returns the chip of a driver of this kind; a TMC2226 is a TMC2209 in another case.
const fn chip_of(kind: DriverKind) -> Option<StealthChip> {
    match kind {
        DriverKind::Tmc2130 => Some(StealthChip::Tmc2130),
        DriverKind::Tmc5160 => Some(StealthChip::Tmc5160),
        DriverKind::Tmc2240 => Some(StealthChip::Tmc2240),
        DriverKind::Tmc2208 => Some(StealthChip::Tmc2208),
        DriverKind::Tmc2209 | DriverKind::Tmc2226 => Some(StealthChip::Tmc2209),
        DriverKind::Tmc2590 | DriverKind::Tmc2660 | DriverKind::External => None,
    }
}

/// Converts the coolStep settings; their thresholds are in readings, of which the chip takes 32 at a time.
/// `None` keeps the registers.
fn cool_step(settings: &CoolStepConfig) -> Option<CoolStep> {
    let steps = |reading: u16| (reading / CoolStepConfig::STEP) as u8;
    let (lower, upper) = (steps(settings.lower), steps(settings.falls_from()));
    (lower > 0).then(|| CoolStep {
        lower_threshold: lower,
        threshold_width: upper.saturating_sub(lower + 1),
        increment: settings.up,
        decrement: settings.down,
        quarter_current: settings.quarter,
    })
}

/// Switches off the bridges of a chip that no motor of the configuration uses. The chip keeps its settings
/// for as long as the motor supply stays, through a reset of the board too, and the enable line is common to
/// all: the chip would hold its motor with an earlier configuration's current.
///
/// # Errors
/// As [`Driver::disable`]; without motor supply nobody answers, and the chip is off anyway.
pub fn switch_off<SPI: SpiDevice>(spi: SPI) -> Result<(), Error<SPI::Error>> {
    /// No current flows, so that any value does.
    const SENSE_RESISTOR: Ohms = Ohms(0.05);
    // Both kinds of chips have the same CHOPCONF.
    Driver::new(spi, Chip::Tmc2590, SENSE_RESISTOR)?.disable().map(drop)
}
