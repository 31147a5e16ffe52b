//! The typed machine description: what the rest of Velvet reads instead of text.
//!
//! Every field is filled from the schema: first with the schema's default, then with what the file says.
//! Units are the internal ones (mm, s, mm/s, degree Celsius, A); mm/min and mA end in the schema.

mod actuators;
mod alignment;
mod arms;
mod buttons;
mod calibration;
mod fans;
mod filament;
mod heat;
mod homing;
mod id;
mod led_strips;
mod leveling;
mod motion;
mod outputs;
mod spi_sensor;
mod stealth_drivers;
mod system;
mod temperature_switches;

pub use actuators::{
    ActuatorConfig, CoilConfig, CoolStepConfig, DriverFamily, DriverKind, ExtruderConfig, MotorsCommon, OnStall, Slave,
    StallRecoveryConfig, TmcConfig,
};
pub use alignment::{
    AxisTwist, BedScrews, MAX_POINTS, MAX_SCREWS, MAX_Z_MOTORS, MOST_TWIST_POINTS, Thread, ZAlignment,
};
pub use arms::{Arms, DeltesianArms, LinearDeltaArms, MorganArms, RotaryDeltaArms};
pub use buttons::{ButtonConfig, ButtonWord};
pub use calibration::{DeltaCalibrationConfig, ZThermalConfig};
pub use fans::{FanConfig, FanControl, FanDriveConfig, FanFollows, StoppedFan, TachometerConfig};
pub use filament::{FilamentChangeConfig, FilamentDetectorConfig, FilamentWidthConfig, Gauge};
pub use heat::{
    ControlLaw, MAX_VOLTAGE_POINTS, Pid, Runaway, SensorConfig, SensorKind, TemperatureConfig, TemperatureWait,
    ThermalModel, ThermistorConfig,
};
pub use homing::{
    EndstopConfig, EndstopPhaseConfig, EndstopStallConfig, HomingConfig, HomingDirection, ProbeConfig, SamplesConfig,
    SoftEndstops,
};
pub use led_strips::{LedStripConfig, StripShows};
pub use leveling::{
    CartesianGrid, DeltaGrid, Leveling, LevelingConfig, MAX_FAULTY, MeshConfig, MeshInterpolation, SkewConfig,
};
pub use motion::{ArmSolution, InputShaper, InputShaperConfig, MotionControl, PlannerConfig};
pub use outputs::{CommandCode, InputBehaviour, OutputKind, ServoConfig, SwitchConfig, VoltageMonitor};
pub use spi_sensor::{SpiSensorConfig, ThermocoupleType};
pub use stealth_drivers::{StealthConfig, StealthFamily};
pub use system::{
    BoardId, CyclesConfig, FileDialect, General, JobPreflight, KillButton, Parity, PlayerConfig, PowerLossConfig,
    PrinterDialect, SafetyDoor, SystemConfig, ToolChangeConfig, UartConfig, UpdateConfig,
};
pub use temperature_switches::{TemperatureSwitchConfig, Trigger};

use crate::module::{MAX_OFF, OffModule};
use crate::pin::Pin;
use heapless::{String, Vec};
use units::{Actuator, Axis, PerActuator};
pub use units::{HeaterId, ToolId};

/// The name of an instance: `hotend`, `fan`, `minx`.
pub type Name = String<24>;
/// A line of G-code or a console command kept in the configuration.
pub type Command = String<96>;

/// Temperature controllers at most.
pub const MAX_TEMPERATURES: usize = units::MAX_HEATERS;
/// Switches at most.
pub const MAX_SWITCHES: usize = 16;
/// Buttons of `[button box]` at most.
pub const MAX_BUTTONS: usize = 12;
/// Fans at most.
pub const MAX_FANS: usize = 8;
/// Strips of lights at most.
pub const MAX_STRIPS: usize = 4;
/// Lights of all strips at most.
pub const MOST_LIGHTS: u16 = 256;
/// Rules of `[temperature switch]` at most.
pub const MAX_TEMPERATURE_SWITCHES: usize = 8;
/// Endstops at most: two per axis.
pub const MAX_ENDSTOPS: usize = 12;
/// Extruders at most: actuators delta, epsilon and zeta.
pub const MAX_EXTRUDERS: usize = 3;
/// Voltage monitors at most: the six inputs.
pub const MAX_VOLTAGES: usize = 6;

/// A machine, completely described. Instances are in order of name, as Smoothieware visits them.
#[derive(Clone, Debug, Default)]
pub struct MachineConfig {
    /// `[general]`
    pub general: General,
    /// `[system]`, with the second USB port of `[consoles]`.
    pub system: SystemConfig,
    /// `[update]`
    pub update: UpdateConfig,
    /// `[uart console]`
    pub uart: UartConfig,
    /// `[motion control]`
    pub motion: MotionControl,
    /// `[planner]` and `[conveyor]`
    pub planner: PlannerConfig,
    /// `[input shaper]`, X Y Z.
    pub input_shapers: [InputShaperConfig; 3],
    /// `[actuator]` `common.*`
    pub motors: MotorsCommon,
    /// `[actuator]` by motor; see [`MachineConfig::actuators`] for those that exist.
    pub actuators: PerActuator<ActuatorConfig>,
    /// `[tmc2590]`
    pub tmc2590: DriverFamily,
    /// `[tmc2660]`
    pub tmc2660: DriverFamily,
    /// `[tmc2130]`
    pub tmc2130: StealthFamily,
    /// `[tmc5160]`
    pub tmc5160: StealthFamily,
    /// `[tmc2240]`
    pub tmc2240: StealthFamily,
    /// `[tmc2208]`
    pub tmc2208: StealthFamily,
    /// `[tmc2209]`
    pub tmc2209: StealthFamily,
    /// `[tmc2226]`
    pub tmc2226: StealthFamily,
    /// `[extruder]`, enabled ones only after reading.
    pub extruders: Vec<ExtruderConfig, MAX_EXTRUDERS>,
    /// `[temperature control]`, enabled ones only after reading.
    pub temperatures: Vec<TemperatureConfig, MAX_TEMPERATURES>,
    /// `[endstops]`, enabled ones only after reading.
    pub endstops: Vec<EndstopConfig, MAX_ENDSTOPS>,
    /// `[endstops]` `common.*`
    pub homing: HomingConfig,
    /// `[soft endstop]`
    pub soft_endstops: SoftEndstops,
    /// `[zprobe]`
    pub probe: ProbeConfig,
    /// `[delta calibration strategy]`
    pub delta_calibration: DeltaCalibrationConfig,
    /// The leveling strategies and `[skew correction]`.
    pub leveling: LevelingConfig,
    /// `[z alignment]`
    pub z_alignment: ZAlignment,
    /// `[bed screws]`
    pub bed_screws: BedScrews,
    /// `[z thermal adjust]`
    pub z_thermal: ZThermalConfig,
    /// `[axis twist compensation]`
    pub axis_twist: AxisTwist,
    /// Lines run before and after probing a cartesian grid.
    pub probe_gcode: [Command; 2],
    /// Lines that bring a probe out, and put it away.
    pub probe_scripts: [Command; 2],
    /// `[switch]`, enabled ones only after reading.
    pub switches: Vec<SwitchConfig, MAX_SWITCHES>,
    /// `[button box]`, those in use only after reading.
    pub buttons: Vec<ButtonConfig, MAX_BUTTONS>,
    /// How often they are looked at, in Hz.
    pub button_poll_hz: u16,
    /// `[fan]`, enabled ones only after reading.
    pub fans: Vec<FanConfig, MAX_FANS>,
    /// `[led strip]`, enabled ones only after reading.
    pub led_strips: Vec<LedStripConfig, MAX_STRIPS>,
    /// `[temperature switch]`, enabled ones only after reading.
    pub temperature_switches: Vec<TemperatureSwitchConfig, MAX_TEMPERATURE_SWITCHES>,
    /// `[pwm1]` and `[pwm2]`: the timers' frequencies in hertz, where the section exists.
    pub pwm_frequency_hz: [Option<u32>; 2],
    /// `[voltage monitor]`, with the built-in vmotor and vfet.
    pub voltages: Vec<VoltageMonitor, MAX_VOLTAGES>,
    /// `[kill button]`
    pub kill_button: KillButton,
    /// `[safety door]`
    pub safety_door: SafetyDoor,
    /// `[player]`
    pub player: PlayerConfig,
    /// `[tool change]`
    pub tool_change: ToolChangeConfig,
    /// `[filament detector]`
    pub filament_detector: FilamentDetectorConfig,
    /// `[filament width sensor]`
    pub filament_width: FilamentWidthConfig,
    /// `[filament change]`
    pub filament_change: FilamentChangeConfig,
    /// Canned cycles.
    pub cycles: CyclesConfig,
    /// What stays off because of an error in the file; see [`MachineConfig::off`].
    pub off: Vec<OffModule, MAX_OFF>,
}

impl MachineConfig {
    /// The motors this machine has, in order, slaves included.
    pub fn actuators(&self) -> impl Iterator<Item = (Actuator, &ActuatorConfig)> {
        Actuator::ALL.into_iter().map(|actuator| (actuator, &self.actuators[actuator])).filter(|(_, a)| a.present)
    }

    /// The driver chip's settings of a motor, when an on-board driver moves it.
    #[must_use]
    pub fn driver(&self, actuator: Actuator) -> Option<&TmcConfig> {
        Some(&self.driver_family(self.actuators[actuator].driver)?.axes[actuator])
    }

    /// The settings that all chips of a kind on the board share; none for drivers outside.
    #[must_use]
    pub const fn driver_family(&self, kind: DriverKind) -> Option<&DriverFamily> {
        match kind {
            DriverKind::Tmc2590 => Some(&self.tmc2590),
            DriverKind::Tmc2660 => Some(&self.tmc2660),
            _ => None,
        }
    }

    /// Where the probe is, seen from the nozzle, mm: as the leveling strategy says, or `[zprobe]`.
    #[must_use]
    pub fn probe_offsets(&self) -> [f64; 3] {
        let leveling = &self.leveling;
        let of_strategy = match leveling.strategy {
            Some(Leveling::CartesianGrid) => leveling.grid.offsets,
            Some(Leveling::DeltaGrid) => leveling.delta.offsets,
            _ => leveling.plane_offsets,
        };
        if of_strategy == [0.0; 3] { self.probe.offsets } else { of_strategy }
    }

    /// The endstop an axis homes to. A slaved motor is no axis: it goes where its master goes.
    #[must_use]
    pub fn homing_endstop(&self, axis: Axis) -> Option<&EndstopConfig> {
        if self.actuators.0.get(axis as usize).is_some_and(|motor| motor.slaved_to.is_some()) {
            return None;
        }
        self.endstops.iter().find(|stop| stop.axis == Some(axis) && stop.homing_direction != HomingDirection::None)
    }

    /// Something is made of the load that drivers measure.
    #[must_use]
    pub fn looks_at_stalls(&self) -> bool {
        self.endstops.iter().any(|stop| stop.stall.homing) || self.watched_for_stalls().next().is_some()
    }

    /// Motors whose stalls are watched for, each with the input that says so.
    pub fn watched_for_stalls(&self) -> impl Iterator<Item = (Actuator, Pin)> {
        self.actuators().filter_map(|(motor, _)| {
            let pin = match (self.driver(motor), self.stealth_driver(motor)) {
                (Some(driver), _) => crate::board::stall_pin(motor).filter(|_| driver.stall_watch),
                (None, outside) => {
                    let driver = outside.filter(|driver| driver.stall_watch)?;
                    driver.stall_pin.or_else(|| self.stall_endstop_pin(motor))
                }
            };
            Some((motor, pin?))
        })
    }

    /// The input by which a motor's axis homes without a switch: its driver's output.
    fn stall_endstop_pin(&self, motor: Actuator) -> Option<Pin> {
        let is_its = |stop: &&EndstopConfig| stop.axis.is_some_and(|axis| axis as usize == motor as usize);
        self.endstops.iter().find(|stop| stop.enable && stop.stall.homing && is_its(stop))?.pin
    }

    /// What follows a stall of a motor that is watched.
    #[must_use]
    pub fn on_stall(&self, motor: Actuator) -> OnStall {
        let usual = if self.motors.halt_on_stall { OnStall::Halt } else { OnStall::Tell };
        self.actuators[motor].on_stall.unwrap_or(usual)
    }

    /// The endstop that a pin belongs to, by its place in [`Self::endstops`].
    #[must_use]
    pub fn endstop_of_pin(&self, pin: Pin) -> Option<usize> {
        self.endstops.iter().position(|stop| stop.enable && stop.pin.is_some_and(|own| own.is_same_pad(pin)))
    }

    /// The switches of motors that are slaved to this axis' motor, with their places in [`Self::endstops`].
    pub fn slave_endstops(&self, axis: Axis) -> impl Iterator<Item = (usize, &EndstopConfig)> {
        let is_slave = move |letter: Axis| {
            let master = self.actuators.0.get(letter as usize).and_then(|motor| motor.slaved_to);
            master.is_some_and(|master| master as usize == axis as usize)
        };
        self.endstops.iter().enumerate().filter(move |(_, stop)| stop.axis.is_some_and(is_slave))
    }
}
