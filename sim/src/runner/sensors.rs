//! The converter chips of sensors behind the machine's heat task: their real driver over the simulated SPI
//! buses.

use std::convert::Infallible;
use std::rc::Rc;

use base::ports::{DatedReading, MAX_HEATERS, SensorReading};
use config::MachineConfig;
use embedded_hal::spi::{ErrorType, Operation, SpiDevice};
use units::Micros;

use super::simulation::Simulation;

/// Lines of a chip.
pub struct Line {
    simulation: Rc<Simulation>,
    heater: usize,
}

impl ErrorType for Line {
    type Error = Infallible;
}

impl SpiDevice for Line {
    fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), Infallible> {
        let (now_ns, heater) = (self.simulation.now_ns.get(), self.heater);
        let mut world = self.simulation.world.borrow_mut();
        world.converter_select(now_ns, heater);
        for operation in operations {
            match operation {
                Operation::Read(bytes) => {
                    bytes.iter_mut().for_each(|byte| *byte = world.converter_transfer(heater, 0));
                }
                Operation::Write(bytes) => {
                    for byte in bytes.iter() {
                        world.converter_transfer(heater, *byte);
                    }
                }
                Operation::TransferInPlace(bytes) => {
                    bytes.iter_mut().for_each(|byte| *byte = world.converter_transfer(heater, *byte));
                }
                Operation::Transfer(read, write) => {
                    for (index, byte) in read.iter_mut().enumerate() {
                        *byte = world.converter_transfer(heater, write.get(index).copied().unwrap_or(0));
                    }
                }
                Operation::DelayNs(_) => {}
            }
        }
        world.converter_deselect(now_ns, heater);
        Ok(())
    }
}

/// Bank of the chips, and its readings.
#[derive(Default)]
pub struct Sensors {
    bank: sensor_bank::SensorBank<Line>,
    read: [Option<DatedReading>; MAX_HEATERS],
    /// Whether the task that reads is kept from running.
    pub stand: bool,
}

impl Sensors {
    /// Makes the chips of a configuration.
    pub fn of(simulation: &Rc<Simulation>, config: &MachineConfig) -> Self {
        let mut sensors = Self::default();
        for (heater, controller) in config.temperatures.iter().enumerate() {
            let spi = &controller.sensor.spi;
            if spi.channel.is_some() && spi.select_pin.is_some() {
                sensors.bank.add(heater, &controller.sensor, Line { simulation: Rc::clone(simulation), heater });
            }
        }
        sensors
    }

    /// Runs the task once.
    pub fn run(&mut self, now: Micros) {
        if self.stand {
            return;
        }
        if let Some((heater, reading)) = self.bank.poll(now)
            && let Some(place) = self.read.get_mut(heater)
        {
            *place = Some(reading);
        }
    }

    /// Returns the last reading of a sensor.
    pub fn reading(&self, heater: usize, now: Micros) -> SensorReading {
        self.read.get(heater).copied().flatten().map_or(SensorReading::Missing, |read| read.at(now))
    }
}
