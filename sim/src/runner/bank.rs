//! The on-board driver chips behind the machine's port: the real driver crate over the simulated SPI bus.

use std::convert::Infallible;
use std::fmt::Write;
use std::rc::Rc;

use config::{DriverKind, MachineConfig};
use embedded_hal::spi::{ErrorType, Operation, SpiDevice};
use machine::ports::{DriverFault, DriverStatus, MotorDrivers};
use tmc::{Chip, Driver, Error, Microsteps, StepInput};
use units::{Actuator, Amps, MAX_ACTUATORS};

use super::ports::Shared;

/// One chip's place on the simulated bus.
#[derive(Clone)]
pub struct Bus {
    shared: Rc<Shared>,
    index: usize,
}

impl ErrorType for Bus {
    type Error = Infallible;
}

impl Bus {
    /// One frame of 24 clocks: the chip takes the last 20 bits and answers with the first 20 (TMC2590 datasheet, "SPI
    /// interface").
    fn frame(&self, bytes: &mut [u8]) {
        let word = bytes.iter().fold(0_u32, |word, byte| word << 8 | u32::from(*byte)) & 0xF_FFFF;
        let now_ns = self.shared.now_ns.get();
        let answer = self.shared.world.borrow_mut().driver_spi(now_ns, self.index, word) << 4;
        for (byte, value) in bytes.iter_mut().zip(answer.to_be_bytes().into_iter().skip(1)) {
            *byte = value;
        }
    }
}

impl SpiDevice for Bus {
    fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), Infallible> {
        for operation in operations {
            match operation {
                Operation::TransferInPlace(bytes) => self.frame(bytes),
                Operation::Transfer(read, write) => {
                    let mut bytes = write.to_vec();
                    self.frame(&mut bytes);
                    for (to, from) in read.iter_mut().zip(bytes) {
                        *to = from;
                    }
                }
                Operation::Write(bytes) => self.frame(&mut bytes.to_vec()),
                Operation::Read(bytes) => self.frame(bytes),
                Operation::DelayNs(_) => {}
            }
        }
        Ok(())
    }
}

/// What moves one actuator's coils.
#[derive(Default)]
pub enum Motor {
    #[default]
    None,
    Chip(Box<Driver<Bus>>, Amps),
    External,
}

/// The drivers of all actuators.
pub struct Bank {
    shared: Rc<Shared>,
    motors: [Motor; MAX_ACTUATORS],
}

impl Bank {
    /// Nothing configured yet.
    pub fn new(shared: Rc<Shared>) -> Self {
        Self { shared, motors: Default::default() }
    }

    /// Gives every configured motor its driver. Reports settings a chip cannot take.
    pub fn configure(&mut self, config: &MachineConfig, report: &mut dyn FnMut(&str)) -> bool {
        let mut clean = true;
        for (actuator, motor) in config.actuators() {
            self.motors[actuator as usize] = match config.driver(actuator) {
                None => Motor::External,
                Some(settings) => {
                    let chip = if motor.driver == DriverKind::Tmc2660 { Chip::Tmc2660 } else { Chip::Tmc2590 };
                    let bus = Bus { shared: Rc::clone(&self.shared), index: actuator as usize };
                    let made = Driver::new(bus, chip, settings.sense_resistor).map_err(|error| error.to_string());
                    let microsteps = Microsteps::from_count(motor.microsteps).ok_or("bad microsteps".to_string());
                    match made.and_then(|driver| Ok((driver, microsteps?))) {
                        Ok((mut driver, microsteps)) => {
                            let input =
                                StepInput { microsteps, double_edge: true, interpolation: settings.step_interpolation };
                            // The bus cannot fail, and a silent chip is found by `initialise`.
                            let _silent = driver.set_step_input(input);
                            if let Some(current) = motor.current {
                                let peak =
                                    if current.0 > settings.max_current.0 { settings.max_current } else { current };
                                let _silent = driver.set_current(peak);
                            }
                            let _silent = driver.set_standstill_current(settings.standstill_current);
                            Motor::Chip(Box::new(driver), settings.max_current)
                        }
                        Err(error) => {
                            report(&format!("{}: {error}", actuator.name()));
                            clean = false;
                            Motor::None
                        }
                    }
                }
            };
        }
        clean
    }

    fn chip(&mut self, motor: Actuator) -> Result<&mut Driver<Bus>, DriverFault> {
        match &mut self.motors[motor as usize] {
            Motor::Chip(chip, _) => Ok(chip),
            Motor::None | Motor::External => Err(DriverFault::External),
        }
    }
}

fn fault<E>(error: Error<E>) -> DriverFault {
    match error {
        Error::Bus(_) | Error::Absent => DriverFault::Silent,
        Error::WrongAnswer(_) | Error::Setting(_) => DriverFault::BadAnswer,
    }
}

impl MotorDrivers for Bank {
    fn initialise(&mut self, motor: Actuator) -> Result<(), DriverFault> {
        let chip = self.chip(motor)?;
        let _silent_or_off = chip.disable();
        chip.start().map(drop).map_err(fault)
    }

    fn set_enabled(&mut self, motor: Actuator, enabled: bool) -> Result<(), DriverFault> {
        if let Motor::External = self.motors[motor as usize] {
            let shared = Rc::clone(&self.shared);
            let now_ns = shared.now_ns.get();
            let mut world = shared.world.borrow_mut();
            let active =
                world.config().actuators.iter().find(|entry| entry.actuator == motor).map(|entry| entry.driver);
            if let Some(crate::world::DriverConfig::External { enable_high: Some(high), .. }) = active {
                world.enable_pin(now_ns, motor, enabled == high);
            }
            return Ok(());
        }
        let chip = self.chip(motor)?;
        let answer = if enabled { chip.enable() } else { chip.disable() };
        answer.map(drop).map_err(fault)
    }

    fn set_current(&mut self, motor: Actuator, peak: Amps) -> Result<Amps, DriverFault> {
        let Motor::Chip(chip, most) = &mut self.motors[motor as usize] else { return Err(DriverFault::External) };
        let peak = if peak.0 > most.0 { *most } else { peak };
        chip.set_current(peak).map(|setting| setting.actual).map_err(fault)
    }

    fn current(&self, motor: Actuator) -> Option<Amps> {
        match &self.motors[motor as usize] {
            Motor::Chip(chip, _) => Some(chip.current()),
            Motor::None | Motor::External => None,
        }
    }

    fn status(&mut self, motor: Actuator) -> Result<DriverStatus, DriverFault> {
        let status = self.chip(motor)?.status().map_err(fault)?;
        Ok(DriverStatus {
            standstill: status.standstill,
            over_temperature_warning: status.over_temperature_warning,
            over_temperature: status.over_temperature,
            short_a: status.short_a,
            short_b: status.short_b,
            open_a: status.open_load_a,
            open_b: status.open_load_b,
        })
    }

    fn describe(&mut self, motor: Actuator, out: &mut dyn Write) -> std::fmt::Result {
        let Ok(chip) = self.chip(motor) else { return writeln!(out, "{}: external driver", motor.name()) };
        let (name, state) = (chip.chip().name(), if chip.is_enabled() { "enabled" } else { "disabled" });
        writeln!(out, "{}: {name}, {state}, {:.3} A", motor.name(), chip.current().0)?;
        match chip.status() {
            Ok(status) => writeln!(out, "  answer {:05x}: {:?}", status.raw, status.reading),
            Err(error) => writeln!(out, "  {error}"),
        }
    }
}
