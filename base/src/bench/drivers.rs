//! Motor drivers that keep what they are told, and answer as a test says.

use core::fmt;

use units::{Actuator, Amps, PerActuator, Volts};

use crate::ports::{
    ChopperFit, Coil, Description, DriverFault, DriverStatus, ElectricalPhase, MotorDrivers, StallSearch,
};

/// Drivers of all motors.
#[derive(Clone, Copy, Debug, Default)]
pub struct BenchDrivers {
    /// Motors with current, one bit each.
    pub enabled: u8,
    /// Peak coil currents.
    pub currents: PerActuator<Option<Amps>>,
    /// Settings of the motors that search for their stall.
    pub searching: PerActuator<Option<StallSearch>>,
    /// Load reserve that every motor measures.
    pub reserve: u16,
    /// Fault of every driver; none: they answer.
    pub fault: Option<DriverFault>,
    /// Place in the electrical cycle of every motor.
    pub phase: Option<ElectricalPhase>,
}

impl BenchDrivers {
    fn answer<T>(&self, value: T) -> Result<T, DriverFault> {
        self.fault.map_or(Ok(value), Err)
    }
}

impl MotorDrivers for BenchDrivers {
    fn initialise(&mut self, motor: Actuator) -> Result<(), DriverFault> {
        self.enabled &= !motor.bit();
        self.answer(())
    }

    fn set_enabled(&mut self, motor: Actuator, enabled: bool) -> Result<(), DriverFault> {
        self.answer(())?;
        self.enabled = if enabled { self.enabled | motor.bit() } else { self.enabled & !motor.bit() };
        Ok(())
    }

    fn set_current(&mut self, motor: Actuator, peak: Amps) -> Result<Amps, DriverFault> {
        self.answer(())?;
        self.currents[motor] = Some(peak);
        Ok(peak)
    }

    fn current(&self, motor: Actuator) -> Option<Amps> {
        self.currents[motor]
    }

    fn status(&mut self, _: Actuator) -> Result<DriverStatus, DriverFault> {
        self.answer(DriverStatus::default())
    }

    fn phase(&mut self, _: Actuator) -> Result<ElectricalPhase, DriverFault> {
        self.answer(())?;
        self.phase.ok_or(DriverFault::External)
    }

    fn begin_stall_search(&mut self, motor: Actuator, search: StallSearch) -> Result<(), DriverFault> {
        self.answer(())?;
        self.searching[motor] = Some(search);
        Ok(())
    }

    fn reserve(&mut self, _: Actuator) -> Result<u16, DriverFault> {
        self.answer(self.reserve)
    }

    fn end_stall_search(&mut self, motor: Actuator) -> Result<(), DriverFault> {
        self.searching[motor] = None;
        self.answer(())
    }

    fn fit_chopper(&mut self, _: Actuator, _: Coil, _: Volts) -> Result<Option<ChopperFit>, DriverFault> {
        self.answer(None)
    }

    fn describe(&mut self, motor: Actuator, _: Description, out: &mut dyn fmt::Write) -> fmt::Result {
        writeln!(out, "{}", motor.name())
    }

    fn set_microsteps(&mut self, _: Actuator, count: u16) -> Result<u16, DriverFault> {
        self.answer(count)
    }

    fn set_stealth_threshold(&mut self, _: Actuator, _: Option<f32>) -> Result<(), DriverFault> {
        self.answer(())
    }

    fn write_register(&mut self, _: Actuator, _: u8, _: u32) -> Result<(), DriverFault> {
        self.answer(())
    }

    fn set_option(&mut self, _: Actuator, _: u8, _: &dyn Fn(char) -> Option<f64>) -> Result<(), DriverFault> {
        self.answer(())
    }
}
