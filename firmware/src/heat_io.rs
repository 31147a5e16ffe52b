//! What the heat task touches: heater and switch outputs, the two enables of the output stage, the thermistor scan.

use bsp_prime::adc::Thermistors;
use bsp_prime::pins::Output;
use machine::heat::HeatControl;
use machine::ports::{MAX_HEATERS, MAX_SWITCHES, OutputLevels, SensorReading, SensorReadings, heater_bit, switch_bit};

/// Modulation ticks between two control ticks: 100 Hz.
const TICKS_PER_CONTROL: u32 = machine::heat::MODULATION_HZ / 100;

/// Heat control with its inputs and outputs: one resource, since one is never used without the other.
pub struct Heat {
    pub control: HeatControl,
    pub io: HeatIo,
    ticks: u32,
}

pub struct HeatIo {
    pub heaters: [Option<Output>; MAX_HEATERS],
    pub switches: [Option<Output>; MAX_SWITCHES],
    pub thermistors: Thermistors,
    /// For each temperature controller, the place of its input in the scan.
    pub sensors: [Option<usize>; MAX_HEATERS],
    fets: Output,
    fets_power: Output,
    /// Levels that the pins have now.
    present: OutputLevels,
}

impl Heat {
    pub fn new(thermistors: Thermistors, fets: Output, fets_power: Output) -> Self {
        let io = HeatIo {
            heaters: [const { None }; MAX_HEATERS],
            switches: [const { None }; MAX_SWITCHES],
            thermistors,
            sensors: [None; MAX_HEATERS],
            fets,
            fets_power,
            present: OutputLevels::default(),
        };
        Self { control: HeatControl::new(), io, ticks: 0 }
    }

    /// One tick of the modulators, and every so many one of the controllers. True after a control tick.
    pub fn tick(&mut self) -> bool {
        self.ticks += 1;
        let control_is_due = self.ticks >= TICKS_PER_CONTROL;
        if control_is_due {
            self.ticks = 0;
            let readings = self.io.readings();
            self.control.tick(bsp_prime::time::now(), &readings);
        }
        let levels = self.control.modulation_tick();
        self.io.apply(levels);
        control_is_due
    }
}

impl HeatIo {
    fn readings(&self) -> SensorReadings {
        self.sensors.map(|input| match input.map(|input| self.thermistors.average(input)) {
            Some(Ok(counts)) => SensorReading::Counts(counts),
            // Not scanned yet, or a scan that stopped: a missing sensor, which keeps the heater off.
            Some(Err(_)) | None => SensorReading::Missing,
        })
    }

    /// Writes the pins whose level changes.
    fn apply(&mut self, levels: OutputLevels) {
        if levels == self.present {
            return;
        }
        let changed = levels.on ^ self.present.on;
        let outputs = self.heaters.iter_mut().enumerate().map(|(index, output)| (heater_bit(index), output));
        let switches = self.switches.iter_mut().enumerate().map(|(index, output)| (switch_bit(index), output));
        for (bit, output) in outputs.chain(switches) {
            if changed & bit != 0
                && let Some(output) = output
            {
                output.set(levels.on & bit != 0);
            }
        }
        if levels.fets_enabled != self.present.fets_enabled {
            self.fets_power.set(levels.fets_enabled);
            self.fets.set(levels.fets_enabled);
        }
        self.present = levels;
    }
}
