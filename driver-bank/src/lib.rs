//! The machine's port to its motor drivers ([`base::ports::MotorDrivers`]) over TMC chips and enable pins.
//!
//! A crate of its own because `machine` never sees a chip and `tmc` never sees a machine; the board and the
//! native runner bring their own bus and pins.
#![no_std]

mod chopper_fit;
mod error;
mod motor_driver;
mod outside_bus;
mod set_up;
mod stealth;
mod tuning;

#[cfg(test)]
mod tests;

use core::fmt::Write;

use base::ports::{
    ChopperFit, Coil, Description, DriverFault, DriverStatus, ElectricalPhase, MotorDrivers, StallSearch,
};
use embedded_hal::digital::OutputPin;
use embedded_hal::spi::SpiDevice;
use tmc::{Driver, Microsteps, ReadSelect, Reading, StallGuard, StepInput};
use units::{Actuator, Amps, PerActuator, Volts};

use crate::error::fault;

pub use motor_driver::MotorDriver;
pub use outside_bus::OutsideBus;
pub use set_up::{CHIP_CLOCK, NotSetUp, OUTSIDE_CLOCK, set_up, set_up_outside, switch_off};
pub use stealth::Outside;
pub use tmc::stealth::{SingleWire, SpiRegisters, WireFault, WireRegisters};

/// The drivers of all actuators.
#[derive(Debug)]
pub struct DriverBank<SPI, LINE, E>(pub PerActuator<MotorDriver<SPI, LINE, E>>);

impl<SPI, LINE, E> Default for DriverBank<SPI, LINE, E> {
    fn default() -> Self {
        Self(PerActuator([const { MotorDriver::None }; units::MAX_ACTUATORS]))
    }
}

impl<SPI: SpiDevice, LINE, E> DriverBank<SPI, LINE, E> {
    fn chip(&mut self, motor: Actuator) -> Result<&mut Driver<SPI>, DriverFault> {
        match &mut self.0[motor] {
            MotorDriver::Chip(chip, _) => Ok(chip),
            MotorDriver::None | MotorDriver::External(_) | MotorDriver::Outside(_) => Err(DriverFault::External),
        }
    }
}

impl<SPI: SpiDevice, LINE: SingleWire, E: OutputPin> MotorDrivers for DriverBank<SPI, LINE, E> {
    fn initialise(&mut self, motor: Actuator) -> Result<(), DriverFault> {
        if let MotorDriver::Outside(driver) = &mut self.0[motor] {
            return driver.initialise();
        }
        let chip = self.chip(motor)?;
        // A silent chip is found by `start`, which writes every register; switching off first only changes
        // the copy it writes.
        let _silent_or_off = chip.disable();
        chip.start().map(drop).map_err(fault)
    }

    fn set_enabled(&mut self, motor: Actuator, enabled: bool) -> Result<(), DriverFault> {
        if let MotorDriver::External(enable) = &mut self.0[motor] {
            return enable.set_state(enabled.into()).map_err(|_| DriverFault::Silent);
        }
        if let MotorDriver::Outside(driver) = &mut self.0[motor] {
            return driver.set_enabled(enabled);
        }
        let chip = self.chip(motor)?;
        let answer = if enabled { chip.enable() } else { chip.disable() };
        match answer.map(drop).map_err(fault) {
            // The bridges of a chip are off after a reset.
            Err(DriverFault::Reset) if !enabled => Ok(()),
            done => done,
        }
    }

    fn set_current(&mut self, motor: Actuator, peak: Amps) -> Result<Amps, DriverFault> {
        if let MotorDriver::Outside(driver) = &mut self.0[motor] {
            return driver.set_current(peak);
        }
        let MotorDriver::Chip(chip, most) = &mut self.0[motor] else { return Err(DriverFault::External) };
        let peak = Amps(peak.0.min(most.0));
        chip.set_current(peak).map(|setting| setting.actual).map_err(fault)
    }

    fn current(&self, motor: Actuator) -> Option<Amps> {
        match &self.0[motor] {
            MotorDriver::Chip(chip, _) => Some(chip.current()),
            MotorDriver::Outside(driver) => Some(driver.current()),
            MotorDriver::None | MotorDriver::External(_) => None,
        }
    }

    fn status(&mut self, motor: Actuator) -> Result<DriverStatus, DriverFault> {
        if let MotorDriver::Outside(driver) = &mut self.0[motor] {
            return driver.status();
        }
        let status = self.chip(motor)?.status().map_err(fault)?;
        let (supply_short_a, supply_short_b) = match status.reading {
            Reading::Diagnostics(all) => (all.short_to_supply_a, all.short_to_supply_b),
            _ => (false, false),
        };
        Ok(DriverStatus {
            standstill: status.standstill,
            over_temperature_warning: status.over_temperature_warning,
            over_temperature: status.over_temperature,
            short_a: status.short_a && !supply_short_a,
            short_b: status.short_b && !supply_short_b,
            supply_short_a,
            supply_short_b,
            open_a: status.open_load_a,
            open_b: status.open_load_b,
            // A reset of these chips is reported as [`DriverFault::Reset`].
            reset: false,
        })
    }

    fn phase(&mut self, motor: Actuator) -> Result<ElectricalPhase, DriverFault> {
        if let MotorDriver::Outside(driver) = &mut self.0[motor] {
            return driver.phase();
        }
        let chip = self.chip(motor)?;
        let microsteps = 256 >> chip.registers().drvctrl.mres().min(8);
        match chip.read(ReadSelect::Microstep).map_err(fault)?.reading {
            Reading::Microstep(place) => Ok(ElectricalPhase { place, microsteps }),
            _ => Err(DriverFault::BadAnswer),
        }
    }

    fn begin_stall_search(&mut self, motor: Actuator, search: StallSearch) -> Result<(), DriverFault> {
        if let MotorDriver::Outside(driver) = &mut self.0[motor] {
            return driver.begin_search(search);
        }
        let MotorDriver::Chip(chip, most) = &mut self.0[motor] else { return Err(DriverFault::External) };
        // No filter, as the rotor would fall out of step before the four full steps of an average.
        let threshold = i8::try_from(search.threshold).map_err(|_| DriverFault::BadSetting)?;
        let stall_guard = StallGuard { threshold, filter: false };
        let peak = search.current.map(|peak| Amps(peak.0.min(most.0)));
        chip.begin_search(stall_guard, peak).map_err(fault)
    }

    fn reserve(&mut self, motor: Actuator) -> Result<u16, DriverFault> {
        if let MotorDriver::Outside(driver) = &mut self.0[motor] {
            return driver.reserve();
        }
        match self.chip(motor)?.read(ReadSelect::StallGuard).map_err(fault)?.reading {
            Reading::StallGuard(value) => Ok(value),
            _ => Err(DriverFault::BadAnswer),
        }
    }

    fn end_stall_search(&mut self, motor: Actuator) -> Result<(), DriverFault> {
        if let MotorDriver::Outside(driver) = &mut self.0[motor] {
            return driver.end_search();
        }
        self.chip(motor)?.end_search().map_err(fault)
    }

    fn fit_chopper(&mut self, motor: Actuator, coil: Coil, supply: Volts) -> Result<Option<ChopperFit>, DriverFault> {
        if let MotorDriver::Outside(driver) = &mut self.0[motor] {
            return driver.fit_chopper(coil, supply);
        }
        chopper_fit::on_board(self.chip(motor)?, coil, supply)
    }

    fn describe(&mut self, motor: Actuator, what: Description, out: &mut dyn Write) -> core::fmt::Result {
        if let MotorDriver::Outside(driver) = &mut self.0[motor] {
            return match what {
                Description::Everything => driver.describe(motor, out),
                Description::Chopper => driver.describe_chopper(out),
            };
        }
        let Ok(chip) = self.chip(motor) else { return writeln!(out, "external driver") };
        match what {
            Description::Everything => tuning::describe(chip, motor, out),
            Description::Chopper => tuning::describe_chopper(chip, out),
        }
    }

    fn set_microsteps(&mut self, motor: Actuator, count: u16) -> Result<u16, DriverFault> {
        let microsteps = Microsteps::from_count(count).ok_or(DriverFault::BadSetting)?;
        if let MotorDriver::Outside(driver) = &mut self.0[motor] {
            return driver.set_microsteps(microsteps);
        }
        let chip = self.chip(motor)?;
        let now = chip.registers().drvctrl;
        let input = StepInput { microsteps, double_edge: now.dedge() == 1, interpolation: now.intpol() == 1 };
        chip.set_step_input(input).map_err(fault)?;
        Ok(256 >> now.mres())
    }

    fn set_stealth_threshold(&mut self, motor: Actuator, full_steps_per_s: Option<f32>) -> Result<(), DriverFault> {
        let MotorDriver::Outside(driver) = &mut self.0[motor] else { return Err(DriverFault::External) };
        driver.set_stealth_threshold(full_steps_per_s)
    }

    fn write_register(&mut self, motor: Actuator, number: u8, value: u32) -> Result<(), DriverFault> {
        if let MotorDriver::Outside(_) = &self.0[motor] {
            return Err(DriverFault::BadSetting);
        }
        let chip = self.chip(motor)?;
        let word = tuning::addressed(number, value).ok_or(DriverFault::BadSetting)?;
        chip.write_raw(word).map_err(fault)
    }

    fn set_option(
        &mut self,
        motor: Actuator,
        option: u8,
        word: &dyn Fn(char) -> Option<f64>,
    ) -> Result<(), DriverFault> {
        if let MotorDriver::Outside(driver) = &mut self.0[motor] {
            return driver.set_option(option, word);
        }
        tuning::set_option(self.chip(motor)?, option, word)
    }
}
