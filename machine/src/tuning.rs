//! What codes change of the configuration while the machine runs, and M500 saves.
//!
//! The configuration itself stays as it was read. Limits, steps and filters are in force in the motion
//! object, gains and maximum temperatures in heat control, settings of extruders in the program: here is the
//! rest.

use config::{
    FilamentChangeConfig, FilamentDetectorConfig, FilamentWidthConfig, MachineConfig, ProbeConfig, ThermistorConfig,
};
use motion::geometry::LineSettings;
use units::{Amps, Axis, PerActuator, PerAxis};

use crate::motion_config::line_settings;
use crate::ports::ChopperFit;

/// Settings changed at run time. Each has the code that writes it.
#[derive(Clone, Debug, Default)]
pub struct Tuning {
    /// Speeds, ways and pauses of the probe (M670).
    pub probe: ProbeConfig,
    /// The probe's contact is the other way round for the time being (M670 I).
    pub probe_inverted: bool,
    /// Where axes home; what follows from it must hear of changes.
    home: Home,
    /// The phase of each axis at its switch, 1/256 full steps; none: what the first homing finds (M875.2).
    pub phases: PerAxis<Option<f64>>,
    /// Current of each motor that has a driver of ours (M906, M907).
    pub currents: PerActuator<Option<Amps>>,
    /// Threshold of each driver's load measurement (M911.3 S7), where it is another than the configuration's.
    pub stall_thresholds: PerActuator<Option<StallThreshold>>,
    /// The same while the motor's axis homes without a switch (M911.3 S9).
    pub homing_thresholds: PerActuator<Option<i16>>,
    /// The chopper of each driver, where it was computed (tune_driver).
    pub choppers: PerActuator<Option<ChopperFit>>,
    /// Up to which speed stealthChop drives each motor, mm/s, 0 for never (M913), where it was changed.
    pub stealth_thresholds: PerActuator<Option<f64>>,
    /// How straight moves are cut (M665 S and U).
    pub lines: LineSettings,
    /// Thermistors that are not as configured (M305), by temperature control.
    pub thermistors: [Option<ThermistorConfig>; units::MAX_HEATERS],
    /// How the filament detector looks (M404).
    pub filament: FilamentDetectorConfig,
    /// What filament is nominally, how far its sensor is from the nozzle, and whether it says what it
    /// measures (M404 W, M406 D, M407.2).
    pub filament_width: FilamentWidthConfig,
    /// How far filament is moved to change it (M603).
    pub filament_change: FilamentChangeConfig,
}

/// How a driver measures load.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StallThreshold {
    /// `SGT`
    pub threshold: i16,
    /// `SFILT`
    pub filter: bool,
}

impl StallThreshold {
    /// As the words of M911.3 S7.
    pub fn words(self) -> impl Fn(char) -> Option<f64> {
        move |letter| match letter {
            'O' => Some(f64::from(self.threshold)),
            'Q' => Some(f64::from(u8::from(self.filter))),
            _ => None,
        }
    }
}

/// Where axes home.
#[derive(Clone, Debug, Default)]
struct Home {
    trim: [f64; 3],
    offset: PerAxis<f64>,
    z: f64,
    changes: u32,
}

impl Tuning {
    /// As configured.
    #[must_use]
    pub fn new(config: &MachineConfig) -> Self {
        let mut currents = PerActuator([None; units::MAX_ACTUATORS]);
        config.actuators().for_each(|(motor, settings)| currents[motor] = settings.current);
        Self {
            probe: config.probe,
            probe_inverted: false,
            home: Home {
                trim: config.homing.trim.map(|trim| trim.0),
                z: config.homing_endstop(Axis::Z).map_or(0.0, |stop| stop.homing_position.0),
                ..Home::default()
            },
            phases: PerAxis(Axis::ALL.map(|axis| config.homing_endstop(axis).and_then(|stop| stop.phase.calibrated))),
            currents,
            stall_thresholds: PerActuator::default(),
            choppers: PerActuator::default(),
            stealth_thresholds: PerActuator::default(),
            homing_thresholds: PerActuator::default(),
            lines: line_settings(config),
            thermistors: [None; units::MAX_HEATERS],
            filament: config.filament_detector,
            filament_width: config.filament_width,
            filament_change: config.filament_change,
        }
    }

    /// Where an axis homes, mm, without its correction.
    #[must_use]
    pub fn homing_position(&self, config: &MachineConfig, axis: Axis) -> f64 {
        match axis {
            Axis::Z => self.home.z,
            axis => config.homing_endstop(axis).map_or(0.0, |stop| stop.homing_position.0),
        }
    }

    /// Trims of towers or arms, mm (M666).
    #[must_use]
    pub const fn trim(&self) -> [f64; 3] {
        self.home.trim
    }

    /// Changes them.
    pub const fn set_trim(&mut self, trim: [f64; 3]) {
        self.home.trim = trim;
        self.home_changed();
    }

    /// Corrections of homing positions, mm (M206).
    #[must_use]
    pub const fn home_offset(&self) -> &PerAxis<f64> {
        &self.home.offset
    }

    /// Changes that of one axis.
    pub fn set_home_offset(&mut self, axis: Axis, mm: f64) {
        self.home.offset[axis] = mm;
        self.home_changed();
    }

    /// Z where it homes, mm (M665 Z).
    #[must_use]
    pub const fn home_z(&self) -> f64 {
        self.home.z
    }

    /// Changes it.
    pub const fn set_home_z(&mut self, mm: f64) {
        self.home.z = mm;
        self.home_changed();
    }

    /// How often any of these was changed.
    #[must_use]
    pub const fn home_changes(&self) -> u32 {
        self.home.changes
    }

    const fn home_changed(&mut self) {
        self.home.changes = self.home.changes.wrapping_add(1);
    }
}
