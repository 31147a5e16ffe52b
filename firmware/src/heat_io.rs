//! Hardware of the heat task: heater and switch outputs, the two enables of the output stage, the thermistor
//! scan.

use base::ports::{
    DatedReading, MAX_HEATERS, MAX_SWITCHES, OutputLevels, SensorReading, SensorReadings, heater_bit, switch_bit,
};
use base::tasks::{self, Due, HeatTask};
use bsp_prime::adc::Thermistors;
use bsp_prime::pins::{Input, Output};
use bsp_prime::pwm::Pwm;
use config::MAX_FANS;
use thermal::HeatControl;
use units::{Celsius, Micros};

use crate::lock_free::REACHED;

/// Age at which a chip temperature is stale: four runs of the slow task.
const CHIP_STALE: Micros = Micros::from_millis(400);

/// Heat control with its inputs and outputs: one resource, since one is never used without the other.
pub struct Heat {
    /// Built in place: moving it would take main stack that start-up does not have.
    pub control: &'static mut HeatControl,
    pub io: HeatIo,
    task: HeatTask,
}

/// Inputs and outputs of heat control.
pub struct HeatIo {
    pub heaters: [Option<Output>; MAX_HEATERS],
    pub switches: [Option<Output>; MAX_SWITCHES],
    pub thermistors: Thermistors,
    /// Places in the scan of the temperature controllers' inputs.
    pub sensors: [Option<usize>; MAX_HEATERS],
    /// Controllers that get the chip's temperature.
    pub of_chip: [bool; MAX_HEATERS],
    /// Whether the chips of some sensors are to be read.
    pub reads_chips: bool,
    /// Readings of other tasks, for each controller.
    told: [Option<DatedReading>; MAX_HEATERS],
    /// Places in the scan of the filament width sensor's inputs.
    pub filament_width: [Option<usize>; 2],
    /// Inputs of tachometers, by the place of the fan in the configuration's list.
    pub tachometers: [Option<Input>; MAX_FANS],
    /// Timers of hardware PWM switches.
    pub pwm: Pwm,
    /// Timer and channel of each hardware PWM switch.
    pub pwm_switches: [Option<(usize, usize)>; MAX_SWITCHES],
    fets: Output,
    fets_power: Output,
    /// Levels that the pins have now.
    present: OutputLevels,
}

impl Heat {
    /// Creates heat control with nothing wired.
    pub fn new(
        control: &'static mut HeatControl,
        thermistors: Thermistors,
        fets: Output,
        fets_power: Output,
        pwm: Pwm,
    ) -> Self {
        let io = HeatIo {
            heaters: [const { None }; MAX_HEATERS],
            switches: [const { None }; MAX_SWITCHES],
            thermistors,
            sensors: [None; MAX_HEATERS],
            of_chip: [false; MAX_HEATERS],
            reads_chips: false,
            told: [None; MAX_HEATERS],
            filament_width: [None; 2],
            tachometers: [const { None }; MAX_FANS],
            pwm,
            pwm_switches: [None; MAX_SWITCHES],
            fets,
            fets_power,
            present: OutputLevels::default(),
        };
        Self { control, io, task: HeatTask::new() }
    }

    /// Runs the heat task once.
    pub fn run(&mut self) -> Due {
        let Self { control, io, task } = self;
        task.run(bsp_prime::time::now(), &REACHED, control, io)
    }

    /// Runs the heat task between two periods: see [`bsp_prime::time::pend_heat_tick`].
    pub fn run_early(&mut self) {
        let Self { control, io, task } = self;
        task.run_early(&REACHED, control, io);
    }
}

impl HeatIo {
    /// Takes the microcontroller's temperature, which the slow task reads.
    pub fn set_chip(&mut self, celsius: Option<Celsius>) {
        let taken = bsp_prime::time::now();
        let reading = celsius.map(|celsius| SensorReading::MilliDegrees((celsius.0 * 1e3) as i32));
        let told = reading.map(|reading| DatedReading { reading, taken, lasts: CHIP_STALE });
        for (place, _) in self.told.iter_mut().zip(self.of_chip).filter(|(_, of_chip)| *of_chip) {
            *place = told;
        }
    }

    /// Takes the reading of a controller's sensor chip.
    pub fn set_reading(&mut self, controller: usize, reading: DatedReading) {
        if let Some(place) = self.told.get_mut(controller) {
            *place = Some(reading);
        }
    }
}

/// Returns the average reading of an input of the scan.
fn reading(thermistors: &Thermistors, input: Option<usize>) -> SensorReading {
    match input.map(|input| thermistors.average(input)) {
        Some(Ok(counts)) => SensorReading::Counts(counts),
        // An input not scanned yet, or a scan that stopped, counts as a missing sensor, which keeps the
        // heater off.
        Some(Err(_)) | None => SensorReading::Missing,
    }
}

impl tasks::HeatIo for HeatIo {
    fn readings(&mut self) -> SensorReadings {
        let mut readings = self.sensors.map(|input| reading(&self.thermistors, input));
        let now = bsp_prime::time::now();
        for (reading, told) in readings.iter_mut().zip(&self.told) {
            if let Some(told) = told {
                *reading = told.at(now);
            }
        }
        readings
    }

    fn scan_position(&mut self) -> u32 {
        self.thermistors.samples_to_wrap()
    }

    fn filament_width(&mut self) -> [SensorReading; 2] {
        self.filament_width.map(|input| reading(&self.thermistors, input))
    }

    fn tachometers(&mut self) -> u8 {
        let on = |input: &Option<Input>| input.as_ref().is_some_and(Input::is_on);
        self.tachometers.iter().rev().fold(0, |levels, input| levels << 1 | u8::from(on(input)))
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

    fn set_pwm(&mut self, switch: usize, duty: f32) {
        if let Some(Some((timer, channel))) = self.pwm_switches.get(switch) {
            self.pwm.set(*timer, *channel, duty);
        }
    }
}
