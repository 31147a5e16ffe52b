//! What codes change of the configuration while the machine runs, and M500 saves.
//!
//! The configuration itself stays as it was read. Limits, steps and filters are in force in the motion object, gains and maximum
//! temperatures in heat control, settings of extruders in the program: here is the rest.

use config::{MachineConfig, ProbeConfig};
use motion::geometry::LineSettings;
use units::{Amps, Axis, PerActuator, PerAxis};

use crate::motion_config::line_settings;

/// Settings changed at run time. Each has the code that writes it.
#[derive(Clone, Debug, Default)]
pub struct Tuning {
    /// Speeds, ways and pauses of the probe (M670).
    pub probe: ProbeConfig,
    /// The probe's contact is the other way round for the time being (M670 I).
    pub probe_inverted: bool,
    /// Trims of towers or arms, mm (M666).
    pub trim: [f64; 3],
    /// Corrections of homing positions, mm (M206).
    pub home_offset: PerAxis<f64>,
    /// Z where it homes, mm (M665 Z).
    pub home_z: f64,
    /// Current of each motor that has a driver of ours (M906, M907).
    pub currents: PerActuator<Option<Amps>>,
    /// How straight moves are cut (M665 S and U).
    pub lines: LineSettings,
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
            trim: config.homing.trim.map(|trim| trim.0),
            home_offset: PerAxis([0.0; units::MAX_AXES]),
            home_z: config.homing_endstop(Axis::Z).map_or(0.0, |stop| stop.homing_position.0),
            currents,
            lines: line_settings(config),
        }
    }

    /// Where an axis homes, mm, without its correction.
    #[must_use]
    pub fn homing_position(&self, config: &MachineConfig, axis: Axis) -> f64 {
        match axis {
            Axis::Z => self.home_z,
            axis => config.homing_endstop(axis).map_or(0.0, |stop| stop.homing_position.0),
        }
    }
}
