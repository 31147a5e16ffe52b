//! `[filament detector]`, `[filament width sensor]` and `[filament change]`.

use units::{Micros, Mm, MmPerSecond, ToolId};

use crate::pin::{Pin, ThermistorInput};

/// Section `[filament detector]`: run-out and jams.
#[derive(Clone, Copy, Debug, Default)]
pub struct FilamentDetectorConfig {
    /// Whether there is a detector.
    pub enable: bool,
    /// Pulse input of a wheel that filament turns.
    pub encoder_pin: Option<Pin>,
    /// Input that is active while filament is too thick.
    pub bulge_pin: Option<Pin>,
    /// Input that is active while there is no filament.
    pub detector_pin: Option<Pin>,
    /// Time between two checks of the pulses.
    pub check_every: Micros,
    /// Pulses per millimetre of filament.
    pub pulses_per_mm: f64,
    /// Whether heaters stay on when the detector suspends the job.
    pub leave_heaters_on: bool,
}

impl FilamentDetectorConfig {
    /// Returns the input for missing or too thick filament: `bulge_pin` where both are given.
    #[must_use]
    pub fn level_pin(&self) -> Option<Pin> {
        self.bulge_pin.or(self.detector_pin).filter(|_| self.enable)
    }

    /// Returns the pulse input of the wheel.
    #[must_use]
    pub fn wheel_pin(&self) -> Option<Pin> {
        self.encoder_pin.filter(|_| self.enable)
    }
}

/// Calibration gauge of known thickness, and the reading of the sensor with it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Gauge {
    /// Reading of all inputs together, ten-thousandths of full scale.
    pub raw: f64,
    /// Diameter of the gauge.
    pub diameter: Mm,
}

/// Section `[filament width sensor]`.
#[derive(Clone, Copy, Debug, Default)]
pub struct FilamentWidthConfig {
    /// Whether there is a width sensor.
    pub enable: bool,
    /// Inputs of the sensor: one, or those of two Hall sensors, whose readings are added up.
    pub inputs: [Option<ThermistorInput>; 2],
    /// Gauges used for the calibration.
    pub gauges: [Gauge; 2],
    /// Diameter per volt, mm; 0: by the gauges.
    pub mm_per_volt: f64,
    /// Nominal diameter, for which E in mm is meant.
    pub nominal: Mm,
    /// Greatest deviation from nominal that is believed.
    pub max_difference: Mm,
    /// Filament length from the sensor to the nozzle.
    pub delay: Mm,
    /// Diameter below which filament has run out; 0: never.
    pub min_diameter: Mm,
    /// Diameter above which filament would jam; 0: never.
    pub max_diameter: Mm,
    /// Whether the flow is corrected by the measured diameter.
    pub correct_flow: bool,
    /// Whether the filament before the first measured piece is taken to be as thick; otherwise nominal.
    pub measured_at_once: bool,
    /// Extruder whose filament is measured.
    pub tool: ToolId,
    /// Whether measurements are reported on every console.
    pub log: bool,
}

impl FilamentWidthConfig {
    /// Returns the inputs in use, each with its place in the list.
    pub fn live_inputs(&self) -> impl Iterator<Item = (usize, ThermistorInput)> + use<> {
        let inputs = if self.enable { self.inputs } else { [None; 2] };
        inputs.into_iter().enumerate().filter_map(|(place, input)| Some((place, input?)))
    }
}

/// Section `[filament change]`: M600, M701 and M702.
#[derive(Clone, Copy, Debug, Default)]
pub struct FilamentChangeConfig {
    /// Length retracted as soon as the job is suspended, so that nothing oozes.
    pub retract: Mm,
    /// Height by which the tool rises.
    pub lift: Mm,
    /// Parking position, machine X and Y; `None`: where the job stopped.
    pub park: [Option<Mm>; 2],
    /// Speed of the move to the parking position.
    pub park_rate: MmPerSecond,
    /// Length pulled out of the machine; 0: the operator pulls.
    pub unload: Mm,
    /// Speed of the unloading.
    pub unload_rate: MmPerSecond,
    /// Length pushed in up to the nozzle; 0: the operator pushes.
    pub load: Mm,
    /// Speed of the loading.
    pub load_rate: MmPerSecond,
    /// Length pressed through the nozzle after loading.
    pub purge: Mm,
    /// Speed of the purging.
    pub purge_rate: MmPerSecond,
}
