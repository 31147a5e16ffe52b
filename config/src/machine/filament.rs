//! `[filament detector]` and `[filament change]`.

use units::{Micros, Mm, MmPerSecond};

use crate::pin::Pin;

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
