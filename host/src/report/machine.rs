//! The few facts of a configuration that a report needs.

use super::program::Beginning;
use anyhow::{Context, Result, bail};
use base::motion_config::motion_config;
use config::{BoardId, MachineConfig};
use motion::Kinematics;
use std::path::Path;
use units::{Actuator, Axis, MAX_ACTUATORS, PerActuator, PerAxis};

/// Scale, geometry and home of a machine.
#[derive(Clone, Debug)]
pub struct Machine {
    /// Steps per mm of each motor; none if there is no such motor.
    pub steps_per_mm: [Option<f64>; MAX_ACTUATORS],
    /// Relation of motors to axes; none if no machine can have the configured geometry.
    pub kinematics: Option<Kinematics>,
    /// State in which a program begins; X, Y and Z after homing, if an axis has a homing switch.
    pub beginning: Beginning,
    /// Greatest speed of X, Y and Z, mm/s.
    pub max_speed: [f64; 3],
    /// Longest time between a change of direction and the motor's next step, nanoseconds.
    pub direction_setup_ns: u32,
    /// Whether input shapers round corners on purpose.
    pub shaped: bool,
    /// Motor that moves the filament of each tool.
    pub extruders: Vec<(u8, Actuator)>,
}

impl Machine {
    /// Reads a configuration file; findings are [`crate::check`]'s business, an unusable file is an error.
    pub fn read(path: &Path) -> Result<Self> {
        let text = std::fs::read(path).with_context(|| format!("cannot read {}", path.display()))?;
        let (config, summary) = config::parse(&text, BoardId::default(), &mut ());
        if !summary.is_usable() {
            bail!("{} has errors; see: velvet check {0}", path.display());
        }
        Ok(Self::new(&config))
    }

    fn new(config: &MachineConfig) -> Self {
        let mut steps_per_mm = [None; MAX_ACTUATORS];
        for (actuator, settings) in config.actuators() {
            steps_per_mm[actuator as usize] = Some(settings.steps_per_mm);
        }
        let motion = motion_config(config).ok();
        let setup = motion.iter().flat_map(|motion| motion.actuators.0).flatten().map(|motor| motor.direction_setup);
        let direction_setup_ns = setup.max().unwrap_or(0) * units::TICK_NANOSECONDS;
        let kinematics = motion.map(|motion| motion.kinematics);
        let beginning = Beginning {
            home: home(config),
            feed: config.motion.default_feed_rate.0,
            seek: config.motion.default_seek_rate.0,
            keeps_seek: config.motion.compliant_seek_rate,
        };
        let max_speed = config.motion.axis_max_speed.map(|limit| limit.map_or(f64::INFINITY, |limit| limit.0));
        let extruders = config.extruders.iter().filter_map(|tool| Some((tool.tool.id.0, tool.actuator()?))).collect();
        let shaped = motion.is_some_and(|motion| motion.filters.shapers.iter().any(Option::is_some));
        Self { steps_per_mm, kinematics, beginning, max_speed, direction_setup_ns, shaped, extruders }
    }

    /// Returns the filament motor of a tool.
    pub fn extruder(&self, tool: u8) -> Option<Actuator> {
        self.extruders.iter().find(|(id, _)| *id == tool).map(|(_, actuator)| *actuator)
    }

    /// Returns every motor that moves filament.
    pub fn filament(&self) -> Vec<Actuator> {
        let mut motors: Vec<Actuator> = self.extruders.iter().map(|(_, motor)| *motor).collect();
        motors.sort_by_key(|motor| *motor as usize);
        motors.dedup();
        motors
    }

    /// Returns the machine position in mm for motor positions in steps.
    pub fn point(&self, steps: [f64; MAX_ACTUATORS]) -> [f64; MAX_ACTUATORS] {
        let mut mm = [0.0; MAX_ACTUATORS];
        for (mm, (steps, scale)) in mm.iter_mut().zip(steps.into_iter().zip(self.steps_per_mm)) {
            *mm = scale.map_or(0.0, |scale| steps / scale);
        }
        self.kinematics.unwrap_or_default().point(&PerActuator(mm)).0
    }

    /// Returns motor positions in steps for a machine position.
    pub fn steps(&self, point: [f64; 3]) -> [f64; MAX_ACTUATORS] {
        let [x, y, z] = point;
        let mut steps = self.kinematics.unwrap_or_default().actuators(&PerAxis([x, y, z, 0.0, 0.0, 0.0])).0;
        for (steps, scale) in steps.iter_mut().zip(self.steps_per_mm) {
            *steps = scale.map_or(0.0, |scale| *steps * scale);
        }
        steps
    }

    /// Returns a difference of motor positions in steps, taken within a turn for a motor that turns
    /// endlessly and may differ by whole turns.
    pub fn within_a_turn(&self, motor: Actuator, steps: f64) -> f64 {
        let turn = self.kinematics.and_then(|kinematics| kinematics.turn_of(motor));
        match (turn, self.steps_per_mm[motor as usize]) {
            (Some(degrees), Some(scale)) => steps - (steps / (degrees * scale)).round() * degrees * scale,
            _ => steps,
        }
    }

    /// Returns a Cartesian printer with one extruder, for tests.
    #[cfg(test)]
    pub fn printer() -> Self {
        Self {
            steps_per_mm: [Some(80.0), Some(80.0), Some(400.0), Some(415.0), None, None],
            kinematics: Some(Kinematics::Cartesian),
            beginning: [Some(0.0); 3].into(),
            max_speed: [f64::INFINITY; 3],
            direction_setup_ns: 500,
            shaped: false,
            extruders: vec![(0, Actuator::Delta)],
        }
    }
}

/// Returns the position of X, Y and Z after homing (`procedures/src/homing/mod.rs`).
fn home(config: &MachineConfig) -> [Option<f64>; 3] {
    let stops = [Axis::X, Axis::Y, Axis::Z].map(|axis| config.homing_endstop(axis));
    let mut home = stops.map(|stop| stop.map(|stop| stop.homing_position.0));
    let [x, y, z] = &mut home;
    let both = x.is_some() && y.is_some();
    if both && (config.homing.delta || config.homing.move_to_origin) {
        (*x, *y) = (Some(0.0), Some(0.0));
    }
    // A delta goes down from its switches before it goes to the middle.
    if let (true, true, Some(z), Some(stop)) = (config.homing.delta, config.homing.move_to_origin, z.as_mut(), stops[2])
    {
        *z -= stop.retract.0;
    }
    home
}
