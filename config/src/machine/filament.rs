//! `[filament detector]`, `[filament width sensor]` and `[filament change]`.

use units::{Micros, Mm, MmPerSecond, ToolId};

use crate::pin::{Pin, ThermistorInput};

/// `[filament detector]`
#[derive(Clone, Copy, Debug, Default)]
pub struct FilamentDetectorConfig {
    /// There is a detector.
    pub enable: bool,
    /// A wheel that filament turns: its pulses.
    pub encoder_pin: Option<Pin>,
    /// Active while filament is too thick.
    pub bulge_pin: Option<Pin>,
    /// Active while there is no filament.
    pub detector_pin: Option<Pin>,
    /// Between two looks at the pulses.
    pub check_every: Micros,
    /// Pulses of a millimetre.
    pub pulses_per_mm: f64,
    /// Heaters stay on when it suspends the job.
    pub leave_heaters_on: bool,
}

impl FilamentDetectorConfig {
    /// The input that says that there is no filament, or that it is too thick: where both are given, the
    /// latter.
    #[must_use]
    pub fn level_pin(&self) -> Option<Pin> {
        self.bulge_pin.or(self.detector_pin).filter(|_| self.enable)
    }

    /// The input of the wheel.
    #[must_use]
    pub fn wheel_pin(&self) -> Option<Pin> {
        self.encoder_pin.filter(|_| self.enable)
    }
}

/// Something of known thickness, and what the sensor read with it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Gauge {
    /// Ten-thousandths of full scale, of all inputs together.
    pub raw: f64,
    /// Its diameter.
    pub diameter: Mm,
}

/// `[filament width sensor]`
#[derive(Clone, Copy, Debug, Default)]
pub struct FilamentWidthConfig {
    /// There is one.
    pub enable: bool,
    /// Its inputs: one, or those of two Hall sensors, whose readings are added up.
    pub inputs: [Option<ThermistorInput>; 2],
    /// What it was calibrated with.
    pub gauges: [Gauge; 2],
    /// Diameter of a volt, mm; 0: by the gauges.
    pub mm_per_volt: f64,
    /// What E in mm is meant for.
    pub nominal: Mm,
    /// What differs more is not believed.
    pub max_difference: Mm,
    /// Filament from the sensor to the nozzle.
    pub delay: Mm,
    /// Thinner: it has run out; 0: never.
    pub min_diameter: Mm,
    /// Thicker: it would jam; 0: never.
    pub max_diameter: Mm,
    /// The flow follows what was measured.
    pub correct_flow: bool,
    /// What is before the first piece measured is as thick; else nominal.
    pub measured_at_once: bool,
    /// The extruder whose filament it measures.
    pub tool: ToolId,
    /// What is measured is said.
    pub log: bool,
}

impl FilamentWidthConfig {
    /// The inputs that are read, each with its place in the list.
    pub fn live_inputs(&self) -> impl Iterator<Item = (usize, ThermistorInput)> + use<> {
        let inputs = if self.enable { self.inputs } else { [None; 2] };
        inputs.into_iter().enumerate().filter_map(|(place, input)| Some((place, input?)))
    }
}

/// `[filament change]`
#[derive(Clone, Copy, Debug, Default)]
pub struct FilamentChangeConfig {
    /// Pulled back as soon as the job is suspended, so that nothing oozes.
    pub retract: Mm,
    /// How far the tool rises.
    pub lift: Mm,
    /// Where it waits, machine X and Y; `None`: where it is.
    pub park: [Option<Mm>; 2],
    /// How fast it goes there.
    pub park_rate: MmPerSecond,
    /// Pulled out of the machine; 0: a person does it.
    pub unload: Mm,
    /// How fast.
    pub unload_rate: MmPerSecond,
    /// Pushed in up to the nozzle; 0: a person does it.
    pub load: Mm,
    /// How fast.
    pub load_rate: MmPerSecond,
    /// Pressed through the nozzle after that.
    pub purge: Mm,
    /// How fast.
    pub purge_rate: MmPerSecond,
}
