//! Drivers outside the board with stealthChop chips: from the configuration to the chip, and what a person is
//! told of it.

use core::fmt::{Result as Written, Write};

use config::{ActuatorConfig, DriverKind, StealthConfig};
use embedded_hal::digital::OutputPin;
use embedded_hal::spi::{Mode, SpiDevice};
use machine::ports::{DriverFault, DriverStatus};
use tmc::stealth::{self, RegisterBus, SpiRegisters, StealthChip, StealthDriver, StealthSettings, register};
use tmc::{BlankTime, Microsteps};
use units::{Actuator, Amps, Ohms};

use crate::set_up::NotSetUp;
use crate::{MotorDriver, fault};

/// SPI mode of the chips, and a clock in Hz that they take however slow their oscillator is, and wires to a
/// header too: they allow 4 MHz ("SPI timing").
pub const OUTSIDE_CLOCK: (Mode, u32) = (tmc::SPI_MODE, 1_000_000);

/// A chip outside with what its board has beside it.
#[derive(Debug)]
pub struct Outside<BUS, E> {
    chip: StealthDriver<BUS>,
    /// The enable input of the driver's board, if a pin leads there.
    enable: Option<E>,
    /// The most it may be asked for.
    most: Amps,
}

/// The driver of this motor outside the board, with its settings. Sends nothing.
///
/// # Errors
/// The setting that the chip cannot take.
pub fn set_up<SPI: SpiDevice, E>(
    spi: SPI,
    enable: Option<E>,
    motor: &ActuatorConfig,
    settings: &StealthConfig,
) -> Result<MotorDriver<SPI, E>, NotSetUp<SPI::Error>> {
    let kind = match motor.driver {
        DriverKind::Tmc2130 => StealthChip::Tmc2130,
        DriverKind::Tmc5160 => StealthChip::Tmc5160,
        DriverKind::Tmc2240 => StealthChip::Tmc2240,
        DriverKind::Tmc2590 | DriverKind::Tmc2660 | DriverKind::External => return Ok(MotorDriver::None),
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
        blank_time: BlankTime::from_clocks(settings.blank_time).unwrap_or(plain.blank_time),
        hysteresis_start: settings.hysteresis_start,
        hysteresis_end: settings.hysteresis_end,
        ..plain
    };
    let mut chip = StealthDriver::new(SpiRegisters(spi), kind, settings_of_chip).map_err(NotSetUp::Driver)?;
    if let Some(current) = motor.current {
        chip.store_current(lesser(current, settings.max_current));
    }
    Ok(MotorDriver::Outside(Outside { chip, enable, most: settings.max_current }))
}

fn lesser(a: Amps, b: Amps) -> Amps {
    if a.0 < b.0 { a } else { b }
}

impl<BUS: RegisterBus, E: OutputPin> Outside<BUS, E> {
    /// Writes everything again, with the bridges off.
    pub(crate) fn initialise(&mut self) -> Result<(), DriverFault> {
        self.chip.start().map_err(fault)
    }

    /// The chip's bridges, and the enable input of its board.
    pub(crate) fn set_enabled(&mut self, enabled: bool) -> Result<(), DriverFault> {
        let told = if enabled { self.chip.enable() } else { self.chip.disable() };
        let is_on = enabled && told.is_ok();
        let pin = self.enable.as_mut().map_or(Ok(()), |pin| pin.set_state(is_on.into()));
        told.map_err(fault)?;
        pin.map_err(|_| DriverFault::Silent)
    }

    /// Peak current; gives what it becomes.
    pub(crate) fn set_current(&mut self, peak: Amps) -> Result<Amps, DriverFault> {
        self.chip.set_current(lesser(peak, self.most)).map(|current| current.actual).map_err(fault)
    }

    /// Peak current that is set.
    pub(crate) const fn current(&self) -> Amps {
        self.chip.current().actual
    }

    /// What the chip says of itself.
    pub(crate) fn status(&mut self) -> Result<DriverStatus, DriverFault> {
        let status = self.chip.status().map_err(fault)?;
        let ([short_a, short_b], [supply_short_a, supply_short_b]) = (status.short, status.supply_short);
        let [open_a, open_b] = status.open_load;
        Ok(DriverStatus {
            standstill: status.standstill,
            over_temperature_warning: status.over_temperature_warning,
            over_temperature: status.over_temperature,
            short_a,
            short_b,
            supply_short_a,
            supply_short_b,
            open_a,
            open_b,
            reset: status.reset,
        })
    }

    /// Microsteps; gives what they were.
    pub(crate) fn set_microsteps(&mut self, microsteps: Microsteps) -> Result<u16, DriverFault> {
        let before = self.chip.settings().microsteps.count();
        self.chip.set_microsteps(microsteps).map_err(fault)?;
        Ok(before)
    }

    /// What the chip says, what it is told, and its registers.
    pub(crate) fn describe(&mut self, motor: Actuator, out: &mut dyn Write) -> Written {
        writeln!(out, "Chip type {}, outside the board", self.chip.chip().name())?;
        match self.chip.status() {
            Err(error) => writeln!(out, "WARNING: {error}")?,
            Ok(status) => {
                writeln!(out, "Motor is {}", if status.standstill { "standing still" } else { "moving" })?;
                writeln!(out, "Enabled: {}", u8::from(self.chip.is_enabled()))?;
                if let Ok(place) = self.chip.read(register::MSCNT) {
                    writeln!(out, "Microstep position phase A: {place}")?;
                }
                writeln!(out, "Stall Guard value: {}", status.stall_guard)?;
                faults(&status, out)?;
            }
        }
        let (settings, peak) = (self.chip.settings(), self.chip.current().actual.0);
        let rms = peak * core::f32::consts::FRAC_1_SQRT_2;
        writeln!(out, "Current setting: {:.0}mA Peak - {rms:.6} Amps RMS", peak * 1_000.0)?;
        writeln!(out, "Microsteps: 1/{}", settings.microsteps.count())?;
        writeln!(out, "Step interpolation is {}", if settings.interpolation { "on" } else { "off" })?;
        writeln!(out, "stealthChop is {}", if settings.stealth_threshold.is_some() { "on" } else { "off" })?;
        writeln!(out, "Register dump of {}:", motor.name())?;
        self.chip.words().try_for_each(|(register, word)| writeln!(out, " {}: {word:08X}", register.name))
    }

    /// Mode, off time, blanking time, then hysteresis start, end and decrement, which these chips do not
    /// have.
    pub(crate) fn describe_chopper(&self, out: &mut dyn Write) -> Written {
        let set = self.chip.settings();
        let (start, end) = (set.hysteresis_start, set.hysteresis_end);
        writeln!(out, "0,{},{},{start},{end},0", set.off_time, set.blank_time.clocks())
    }
}

fn faults(status: &stealth::StealthStatus, out: &mut dyn Write) -> Written {
    for (there, text) in [
        (status.reset, "the driver was without power and has lost its settings"),
        (status.charge_pump_low, "Undervoltage"),
        (status.over_temperature_warning, "Overtemperature Prewarning"),
        (status.over_temperature, "Overtemperature Shutdown"),
        (status.short[0], "SHORT to ground on channel A"),
        (status.short[1], "SHORT to ground on channel B"),
        (status.supply_short[0], "SHORT to supply on channel A"),
        (status.supply_short[1], "SHORT to supply on channel B"),
        (status.open_load[0], "Channel A seems to be unconnected"),
        (status.open_load[1], "Channel B seems to be unconnected"),
    ] {
        if there {
            writeln!(out, "WARNING: {text}")?;
        }
    }
    Ok(())
}
