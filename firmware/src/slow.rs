//! Hardware of the slow task: driver chips, supply voltages, the supervisor that judges both, and sensor
//! chips, whose bus may be that of the drivers: the owner of this structure owns both buses.

use base::ports::SupplyVoltages;
use base::supervisor::Supervisor;
use bsp_prime::adc::{AdcError, Supplies, chip_celsius, pin_volts};
use bsp_prime::pins::table;
use config::{MachineConfig, Name};
use heapless::Vec;
use units::{Celsius, Volts};

use crate::drivers::{DriverBank, SensorBank};

/// Monitored voltage and its divider.
struct Monitor {
    name: Name,
    input: usize,
    scale: f32,
}

/// Resource of the slow task.
pub struct Slow {
    pub drivers: DriverBank,
    pub sensors: SensorBank,
    pub supervisor: Supervisor,
    supplies: Supplies,
    monitors: Vec<Monitor, { config::MAX_VOLTAGES }>,
}

impl Slow {
    /// Creates the slow watch with nothing wired.
    pub fn new(supplies: Supplies) -> Self {
        let (drivers, sensors) = (DriverBank::default(), SensorBank::default());
        Self { drivers, sensors, supervisor: Supervisor::new(), supplies, monitors: Vec::new() }
    }

    /// Starts reading the configured voltages.
    pub fn monitor(&mut self, config: &MachineConfig) -> Result<(), AdcError> {
        let mut inputs = Vec::<usize, { config::MAX_VOLTAGES + 3 }>::new();
        // The chip's own inputs are always there.
        let _fit = inputs.extend_from_slice(&[table::CHIP_TEMPERATURE, table::VREF, table::VBAT]);
        for voltage in &config.voltages {
            let input = usize::from(voltage.input.0);
            let monitor = Monitor { name: voltage.name.clone(), input, scale: voltage.scale };
            // Both lists hold as many as the configuration can.
            let _fits = self.monitors.push(monitor).is_ok() && inputs.push(input).is_ok();
        }
        self.supplies.start(&inputs)
    }

    /// A monitored voltage by its name, the chip's own reference as `vref`, or a coin cell as `vbat`.
    pub fn voltage(&self, name: &str) -> Option<Volts> {
        match name {
            "vref" => return Some(source_volts(self.supplies.reading(table::VREF)?, 1.0)),
            "vbat" => return Some(source_volts(self.supplies.reading(table::VBAT)?, table::VBAT_DIVIDER)),
            _ => {}
        }
        let monitor = self.monitors.iter().find(|monitor| monitor.name == name)?;
        Some(source_volts(self.supplies.reading(monitor.input)?, monitor.scale))
    }

    /// Returns the voltage of this name and requests a new reading.
    pub fn voltage_now(&mut self, name: &str) -> Option<Volts> {
        let monitor = self.monitors.iter().find(|monitor| monitor.name == name)?;
        Some(source_volts(self.supplies.follow(monitor.input)?, monitor.scale))
    }

    /// Returns the temperature of the chip.
    pub fn chip_celsius(&self) -> Option<Celsius> {
        chip_celsius(self.supplies.reading(table::CHIP_TEMPERATURE)?).map(Celsius)
    }

    /// Runs the slow task, ten times a second.
    pub fn tick(&mut self) {
        self.supplies.poll();
        let supply = SupplyVoltages { motor: self.voltage("vmotor"), fets: self.voltage("vfet") };
        self.supervisor.tick(bsp_prime::time::now(), &mut self.drivers, supply, bsp_prime::kept::events());
    }
}

/// Converts a reading of a monitored input to volts at its source.
fn source_volts(reading: u16, scale: f32) -> Volts {
    Volts(pin_volts(reading) * scale)
}
