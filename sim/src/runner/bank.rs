//! The on-board driver chips behind the machine's port: the real driver crate over the simulated SPI bus.

use std::convert::Infallible;
use std::rc::Rc;

use config::MachineConfig;
use driver_bank::{DriverBank, MotorDriver, OutsideBus, SingleWire, SpiRegisters, WireFault, WireRegisters};
use embedded_hal::digital::OutputPin;
use embedded_hal::spi::{ErrorType, Operation, SpiDevice};
use units::Actuator;

use super::simulation::Simulation;
use crate::world::DriverConfig;

/// Select of a chip on the simulated bus.
#[derive(Clone, Copy)]
enum Select {
    /// Select of a chip on the board, by its number.
    OnBoard(usize),
    /// Select of the driver outside the board of a motor.
    Outside(Actuator),
}

/// Place of a chip on the simulated bus.
#[derive(Clone)]
pub struct Bus {
    simulation: Rc<Simulation>,
    select: Select,
}

impl ErrorType for Bus {
    type Error = Infallible;
}

impl Bus {
    fn frame(&self, bytes: &mut [u8]) {
        let now_ns = self.simulation.now_ns.get();
        let mut world = self.simulation.world.borrow_mut();
        match self.select {
            // A frame has 24 clocks: the chip takes the last 20 bits and answers with the first 20 (TMC2590
            // datasheet, "SPI interface").
            Select::OnBoard(index) => {
                let word = bytes.iter().fold(0_u32, |word, byte| word << 8 | u32::from(*byte)) & 0xF_FFFF;
                let answer = world.driver_spi(now_ns, index, word) << 4;
                for (byte, value) in bytes.iter_mut().zip(answer.to_be_bytes().into_iter().skip(1)) {
                    *byte = value;
                }
            }
            Select::Outside(motor) => {
                let datagram = <[u8; 5]>::try_from(&*bytes).expect("a datagram of 40 bits");
                bytes.copy_from_slice(&world.outside_spi(now_ns, motor, datagram));
            }
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

/// Enable pin of an external driver.
pub struct Enable {
    simulation: Rc<Simulation>,
    motor: Actuator,
}

impl embedded_hal::digital::ErrorType for Enable {
    type Error = Infallible;
}

impl OutputPin for Enable {
    fn set_low(&mut self) -> Result<(), Infallible> {
        self.set(false);
        Ok(())
    }

    fn set_high(&mut self) -> Result<(), Infallible> {
        self.set(true);
        Ok(())
    }
}

impl Enable {
    fn set(&self, enabled: bool) {
        let now_ns = self.simulation.now_ns.get();
        let mut world = self.simulation.world.borrow_mut();
        let entry = world.config().actuators.iter().find(|entry| entry.actuator == self.motor);
        if let Some(
            DriverConfig::External { enable_high: Some(high), .. }
            | DriverConfig::Outside { enable_high: Some(high), .. },
        ) = entry.map(|entry| entry.driver)
        {
            world.enable_pin(now_ns, self.motor, enabled == high);
        }
    }
}

/// Auxiliary UART with the drivers on it, TX over a resistor.
pub struct Line {
    simulation: Rc<Simulation>,
    channel: u8,
}

impl std::fmt::Debug for Line {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "line {}", self.channel)
    }
}

/// Bit time at 250,000 baud, and the wire's idle time before a datagram.
const BIT_NS: u64 = 4_000;
const IDLE_NS: u64 = 16 * BIT_NS;

impl SingleWire for Line {
    type Error = Infallible;

    /// Exchanges a datagram at once, as far as the machine is concerned, though to the chips in its time.
    fn exchange(&mut self, datagram: &[u8], answer: &mut [u8]) -> Result<(), WireFault<Infallible>> {
        let clock = &self.simulation.wires_ns[usize::from(self.channel)];
        let mut at_ns = clock.get().max(self.simulation.now_ns.get()) + IDLE_NS;
        let mut world = self.simulation.world.borrow_mut();
        let mut said = None;
        for byte in datagram {
            at_ns += 10 * BIT_NS;
            said = world.wire_byte(at_ns, self.channel, *byte);
        }
        clock.set(said.map_or(at_ns, |answer| answer[7].0));
        if answer.is_empty() {
            return Ok(());
        }
        let said = said.ok_or(WireFault::NoAnswer)?;
        answer.iter_mut().zip(said).for_each(|(to, (_, byte))| *to = byte);
        Ok(())
    }
}

/// Drivers of all actuators.
pub type Bank = DriverBank<Bus, Line, Enable>;

/// Gives every configured motor its driver. Reports settings a chip cannot take.
pub fn configure(simulation: &Rc<Simulation>, config: &MachineConfig, report: &mut dyn FnMut(&str)) -> (Bank, bool) {
    let (mut bank, mut clean) = (Bank::default(), true);
    for (motor, settings) in config.actuators() {
        let enable = Enable { simulation: Rc::clone(simulation), motor };
        let bus = |select| Bus { simulation: Rc::clone(simulation), select };
        let set_up = if let Some(chip) = config.stealth_driver(motor) {
            let enable = settings.en_pin.map(|_| enable);
            let bus = match config.driver_uart(motor) {
                Some(channel) => {
                    let line = Line { simulation: Rc::clone(simulation), channel };
                    OutsideBus::Wire(WireRegisters::new(line, chip.uart_address))
                }
                None => OutsideBus::Spi(SpiRegisters(bus(Select::Outside(motor)))),
            };
            driver_bank::set_up_outside(bus, enable, config, motor).map_err(|error| error.to_string())
        } else if let Some(chip) = config.driver(motor) {
            let set_up = driver_bank::set_up(bus(Select::OnBoard(motor as usize)), settings, chip);
            set_up.map_err(|error| error.to_string())
        } else {
            Ok(MotorDriver::External(enable))
        };
        match set_up {
            Ok(driver) => bank.0[motor] = driver,
            Err(error) => {
                report(&format!("driver {}: {error}", motor.name()));
                clean = false;
            }
        }
    }
    (bank, clean)
}
