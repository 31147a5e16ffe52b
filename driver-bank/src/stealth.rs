//! External drivers with stealthChop chips: what codes set at run time, and the reports of their state.

use core::fmt::{Result as Written, Write};

use base::ports::{DriverFault, DriverStatus, ElectricalPhase, StallSearch};
use embedded_hal::digital::OutputPin;
use tmc::stealth::{self, LoadMeasurement, RegisterBus, StealthDriver, StealthSettings, register};
use tmc::{Chopper, Microsteps};
use units::{Actuator, Amps};

use crate::error::fault;
use crate::tuning;

/// External chip with the enable input and current limit of its board.
#[derive(Debug)]
pub struct Outside<BUS, E> {
    pub(crate) chip: StealthDriver<BUS>,
    /// The enable input of the driver's board, if a pin leads there.
    pub(crate) enable: Option<E>,
    /// Highest current allowed for the board.
    pub(crate) most: Amps,
}

impl<BUS: RegisterBus, E: OutputPin> Outside<BUS, E> {
    /// Writes all settings again, with the bridges off.
    pub(crate) fn initialise(&mut self) -> Result<(), DriverFault> {
        self.chip.start().map_err(fault)
    }

    /// Switches the chip's bridges, and the enable input of its board.
    pub(crate) fn set_enabled(&mut self, enabled: bool) -> Result<(), DriverFault> {
        let told = if enabled { self.chip.enable() } else { self.chip.disable() };
        let is_on = enabled && told.is_ok();
        let pin = self.enable.as_mut().map_or(Ok(()), |pin| pin.set_state(is_on.into()));
        told.map_err(fault)?;
        pin.map_err(|_| DriverFault::Silent)
    }

    /// Sets the peak current and returns the nearest possible one.
    pub(crate) fn set_current(&mut self, peak: Amps) -> Result<Amps, DriverFault> {
        self.chip.set_current(Amps(peak.0.min(self.most.0))).map(|current| current.actual).map_err(fault)
    }

    /// Returns the peak current that is set.
    pub(crate) const fn current(&self) -> Amps {
        self.chip.current().actual
    }

    /// Reads the status of the chip.
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

    /// Sets the microsteps and returns the previous ones.
    pub(crate) fn set_microsteps(&mut self, microsteps: Microsteps) -> Result<u16, DriverFault> {
        let before = self.chip.settings().microsteps.count();
        self.chip.set_microsteps(microsteps).map_err(fault)?;
        Ok(before)
    }

    /// Reads the place in the electrical cycle.
    pub(crate) fn phase(&mut self) -> Result<ElectricalPhase, DriverFault> {
        let place = self.chip.read(register::MSCNT).map_err(fault)? as u16;
        Ok(ElectricalPhase { place, microsteps: self.chip.settings().microsteps.count() })
    }

    /// Sets current and load measurement for a search.
    pub(crate) fn begin_search(&mut self, search: StallSearch) -> Result<(), DriverFault> {
        let peak = search.current.map(|peak| Amps(peak.0.min(self.most.0)));
        self.chip.begin_search(search.threshold, peak).map_err(fault)
    }

    /// Reads the load reserve: how far the motor is from a stall.
    pub(crate) fn reserve(&mut self) -> Result<u16, DriverFault> {
        self.chip.reserve().map_err(fault)
    }

    /// Restores the settings from before a search.
    pub(crate) fn end_search(&mut self) -> Result<(), DriverFault> {
        self.chip.end_search().map_err(fault)
    }

    /// Applies a group of settings by its number, as M911.3 counts them, of the groups that these chips have.
    pub(crate) fn set_option(&mut self, option: u8, word: &dyn Fn(char) -> Option<f64>) -> Result<(), DriverFault> {
        let number = |letter: char| word(letter).map(|value| value as i32);
        let switch = || number('Z').map(|value| value != 0).ok_or(DriverFault::BadSetting);
        let mut settings = *self.chip.settings();
        match option {
            1 => {
                let chip = self.chip.chip();
                // Blanking times are the chip's own; the fifth word, the decrement, these chips do not have.
                let clocks = number('V').and_then(|clocks| u8::try_from(clocks).ok());
                let blank_time = clocks.and_then(|clocks| chip.blank_time(clocks)).ok_or(DriverFault::BadSetting)?;
                let word = |letter: char| match letter {
                    'V' => Some(i32::from(blank_time.clocks())),
                    'Y' => Some(0),
                    letter => number(letter),
                };
                let Some(Chopper::SpreadCycle { off_time, hysteresis_start, hysteresis_end, .. }) =
                    tuning::chopper(false, &word)
                else {
                    return Err(DriverFault::BadSetting);
                };
                settings = StealthSettings { off_time, blank_time, hysteresis_start, hysteresis_end, ..settings };
            }
            4 => settings.interpolation = switch()?,
            // The setting S8 has switched coolStep on.
            5 if switch()? => settings.cool_step = Some(settings.cool_step.ok_or(DriverFault::BadSetting)?),
            5 => settings.cool_step = None,
            7 => {
                let threshold = number('O').and_then(|value| i16::try_from(value).ok());
                settings.stall_threshold = threshold.ok_or(DriverFault::BadSetting)?;
                settings.stall_filter = number('Q').is_some_and(|value| value != 0);
            }
            8 => settings.cool_step = Some(tuning::cool_step(&number).ok_or(DriverFault::BadSetting)?),
            _ => return Err(DriverFault::BadSetting),
        }
        self.chip.set(settings).map_err(fault)
    }

    /// Sets the speed up to which stealthChop drives, full steps a second; `None`: never.
    pub(crate) fn set_stealth_threshold(&mut self, full_steps_per_s: Option<f32>) -> Result<(), DriverFault> {
        let chip = self.chip.chip();
        let stealth_threshold = full_steps_per_s.map(|speed| stealth::step_time(chip, speed));
        self.chip.set(StealthSettings { stealth_threshold, ..*self.chip.settings() }).map_err(fault)
    }

    /// Prints the chip's status, settings and registers.
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
                if let (false, Ok(load)) = (self.chip.chip().load() == LoadMeasurement::None, self.chip.reserve()) {
                    writeln!(out, "Stall Guard value: {load}")?;
                }
                faults(&status, out)?;
            }
        }
        let (settings, peak) = (self.chip.settings(), self.chip.current().actual.0);
        let rms = peak * core::f32::consts::FRAC_1_SQRT_2;
        writeln!(out, "Current setting: {:.0}mA Peak - {rms:.6} Amps RMS", peak * 1_000.0)?;
        writeln!(out, "Microsteps: 1/{}", settings.microsteps.count())?;
        writeln!(out, "Coolstep: {}", if settings.cool_step.is_some() { "on" } else { "off" })?;
        writeln!(out, "Step interpolation is {}", if settings.interpolation { "on" } else { "off" })?;
        writeln!(out, "stealthChop is {}", if settings.stealth_threshold.is_some() { "on" } else { "off" })?;
        writeln!(out, "Register dump of {}:", motor.name())?;
        self.chip.words().try_for_each(|(register, word)| writeln!(out, " {}: {word:08X}", register.name))
    }

    /// Prints mode, off time, blanking time, then hysteresis start, end and decrement, which these chips do
    /// not have.
    pub(crate) fn describe_chopper(&self, out: &mut dyn Write) -> Written {
        let set = self.chip.settings();
        let (start, end) = (set.hysteresis_start, set.hysteresis_end);
        writeln!(out, "0,{},{},{start},{end},0", set.off_time, self.chip.chip().blank_clocks(set.blank_time))
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
