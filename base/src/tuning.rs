//! Settings of the configuration that codes change while the machine runs, and M500 saves.
//!
//! The configuration itself stays as it was read. Limits, steps and filters are in force in the motion
//! object, gains and maximum temperatures in heat control, settings of extruders in the program: here is the
//! rest.

use config::{
    FilamentChangeConfig, FilamentDetectorConfig, FilamentWidthConfig, MachineConfig, ProbeConfig, ThermistorConfig,
};
use motion::geometry::LineSettings;
use program::Words;
use units::{Amps, Axis, PerActuator, PerAxis};

use crate::laser::LaserScale;
use crate::ports::ChopperFit;
use crate::ports::{Input, InputLevels};

/// Least temperature for extrusion that M302 P0 sets where none is configured, C.
const USUAL_LEAST_WARM: f32 = 170.0;

/// Settings changed at run time, each with the code that writes it.
#[derive(Clone, Debug, Default)]
pub struct Tuning {
    /// Speeds, ways and pauses of the probe (M670).
    pub probe: ProbeConfig,
    /// Whether the probe's contact is inverted for the time being (M670 I).
    pub probe_inverted: bool,
    /// Homing positions; their changes are counted for those that depend on them.
    home: Home,
    /// Phase of each axis at its switch, 1/256 full steps; none: the phase that the first homing finds
    /// (M875.2).
    pub phases: PerAxis<Option<f64>>,
    /// Current of each motor that has a driver of ours (M906, M907).
    pub currents: PerActuator<Option<Amps>>,
    /// Threshold of each driver's load measurement (M911.3 S7), where it is another than the configuration's.
    pub stall_thresholds: PerActuator<Option<StallThreshold>>,
    /// Threshold of each driver's load measurement while its axis homes without a switch (M911.3 S9).
    pub homing_thresholds: PerActuator<Option<i16>>,
    /// Chopper of each driver, where it was computed (tune_driver).
    pub choppers: PerActuator<Option<ChopperFit>>,
    /// Greatest speed at which stealthChop drives each motor, mm/s, 0 for never (M913), where it was changed.
    pub stealth_thresholds: PerActuator<Option<f64>>,
    /// Segmentation of straight moves (M665 S and U).
    pub lines: LineSettings,
    /// Thermistors that are not as configured (M305), by temperature control.
    pub thermistors: [Option<ThermistorConfig>; units::MAX_HEATERS],
    /// Settings of the filament detector (M404).
    pub filament: FilamentDetectorConfig,
    /// Nominal filament diameter, distance of its sensor from the nozzle, and whether measurements are
    /// printed (M404 W, M406 D, M407.2).
    pub filament_width: FilamentWidthConfig,
    /// Lengths of filament moved to change it (M603).
    pub filament_change: FilamentChangeConfig,
    /// Least temperature of each tool's nozzle to extrude, and to retract, C; 0 for none (M302).
    pub least_warm: [[f32; 2]; program::MAX_TOOLS],
    /// Whether a move may be refused for the filament that it feeds: asked by each move.
    pub guards_filament: bool,
    /// Scale of a laser's power (M452, M221).
    pub laser: LaserScale,
}

/// Settings of a driver's load measurement.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StallThreshold {
    /// Register field `SGT`: the threshold.
    pub threshold: i16,
    /// Register field `SFILT`: the filter.
    pub filter: bool,
}

impl StallThreshold {
    /// Returns the setting as the words of M911.3 S7.
    pub fn words(self) -> impl Fn(char) -> Option<f64> {
        move |letter| match letter {
            'O' => Some(f64::from(self.threshold)),
            'Q' => Some(f64::from(u8::from(self.filter))),
            _ => None,
        }
    }
}

/// Homing positions of the axes.
#[derive(Clone, Debug, Default)]
struct Home {
    trim: [f64; 3],
    offset: PerAxis<f64>,
    z: f64,
    changes: u32,
}

/// Returns the configured least temperatures of nozzles, C.
fn least_warm(config: &MachineConfig) -> [[f32; 2]; program::MAX_TOOLS] {
    let mut least = [[0.0; 2]; program::MAX_TOOLS];
    for extruder in &config.extruders {
        if let Some(least) = least.get_mut(usize::from(extruder.tool.id.0)) {
            *least = [extruder.min_extrude_temp.0; 2];
        }
    }
    least
}

/// Returns whether any extruder's moves have a greatest length.
fn has_longest(config: &MachineConfig) -> bool {
    config.extruders.iter().any(|extruder| extruder.max_extrude_only_distance > 0.0)
}

impl Tuning {
    /// Returns whether the probe's contact is closed.
    #[must_use]
    pub const fn probe_touches(&self, inputs: InputLevels) -> bool {
        inputs.is_active(Input::Probe) != self.probe_inverted
    }

    /// Takes the settings from the configuration.
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
            lines: config.motion.lines,
            thermistors: [None; units::MAX_HEATERS],
            filament: config.filament_detector,
            filament_width: config.filament_width,
            filament_change: config.filament_change,
            least_warm: least_warm(config),
            laser: LaserScale::new(config),
            guards_filament: config.extruders.iter().any(|extruder| extruder.min_extrude_temp.0 > 0.0)
                || has_longest(config),
        }
    }

    /// M302: sets the least temperatures of nozzles.
    pub fn set_least_warm(&mut self, config: &MachineConfig, words: &Words<'_>) {
        match words.get('P') {
            Some(allowed) if allowed != 0.0 => self.least_warm = Default::default(),
            Some(_) => {
                let usual = |[least, _]: [f32; 2]| [if least > 0.0 { least } else { USUAL_LEAST_WARM }; 2];
                self.least_warm = least_warm(config).map(usual);
            }
            None => {}
        }
        for least in &mut self.least_warm {
            // Marlin has no temperature of its own for retracting.
            *least = words.get('S').map_or(*least, |celsius| [celsius as f32; 2]);
            least[1] = words.get('R').map_or(least[1], |celsius| celsius as f32);
        }
        self.guards_filament = self.least_warm.iter().flatten().any(|celsius| *celsius > 0.0) || has_longest(config);
    }

    /// Returns the position at which an axis homes, mm, without its correction.
    #[must_use]
    pub fn homing_position(&self, config: &MachineConfig, axis: Axis) -> f64 {
        match axis {
            Axis::Z => self.home.z,
            axis => config.homing_endstop(axis).map_or(0.0, |stop| stop.homing_position.0),
        }
    }

    /// Returns the trims of towers or arms, mm (M666).
    #[must_use]
    pub const fn trim(&self) -> [f64; 3] {
        self.home.trim
    }

    /// Sets the trims of towers or arms, mm (M666).
    pub const fn set_trim(&mut self, trim: [f64; 3]) {
        self.home.trim = trim;
        self.home_changed();
    }

    /// Returns the corrections of homing positions, mm (M206).
    #[must_use]
    pub const fn home_offset(&self) -> &PerAxis<f64> {
        &self.home.offset
    }

    /// Sets the correction of one axis's homing position, mm (M206).
    pub fn set_home_offset(&mut self, axis: Axis, mm: f64) {
        self.home.offset[axis] = mm;
        self.home_changed();
    }

    /// Returns the Z at which the tool homes, mm (M665 Z).
    #[must_use]
    pub const fn home_z(&self) -> f64 {
        self.home.z
    }

    /// Sets the Z at which the tool homes, mm (M665 Z).
    pub const fn set_home_z(&mut self, mm: f64) {
        self.home.z = mm;
        self.home_changed();
    }

    /// Returns how often trims, corrections and Z have been changed.
    #[must_use]
    pub const fn home_changes(&self) -> u32 {
        self.home.changes
    }

    const fn home_changed(&mut self) {
        self.home.changes = self.home.changes.wrapping_add(1);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bench::words;

    #[test]
    fn nozzles_may_be_cold_when_that_is_allowed_and_have_their_limits_back() {
        let config = MachineConfig::default();
        let mut tuning = Tuning::new(&config);
        assert!(!tuning.guards_filament);
        tuning.set_least_warm(&config, &words("M302 S180 R150"));
        assert!(tuning.guards_filament && tuning.least_warm.iter().all(|least| *least == [180.0, 150.0]));
        tuning.set_least_warm(&config, &words("M302 P1"));
        assert!(!tuning.guards_filament && tuning.least_warm.iter().flatten().all(|celsius| *celsius == 0.0));
        tuning.set_least_warm(&config, &words("M302 P0"));
        assert!(
            tuning.guards_filament && tuning.least_warm.iter().flatten().all(|celsius| *celsius == USUAL_LEAST_WARM)
        );
        tuning.set_least_warm(&config, &words("M302 S170"));
        assert!(tuning.least_warm.iter().all(|least| *least == [170.0; 2]));
    }
}
