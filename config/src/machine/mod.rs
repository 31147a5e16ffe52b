//! The typed machine description, which the rest of Velvet reads instead of text.
//!
//! Every field is filled from the schema: first with the schema's default, then with what the file says.
//! Units are the internal ones (mm, s, mm/s, degree Celsius, A); mm/min and mA end in the schema.

mod drivers;
mod id;

pub(crate) use drivers::GOOD_FULL_STEPS_PER_S;

pub use crate::names::{Command, Name};
pub use crate::sections::*;

use crate::off::{MAX_OFF, OffModule};
use crate::pin::Pin;
use heapless::Vec;
use units::{Actuator, Axis, CycleSetup, PerActuator};
pub use units::{HeaterId, ToolId};

/// A machine, completely described. Instances are in order of name, as Smoothieware visits them.
#[derive(Clone, Debug, Default)]
pub struct MachineConfig {
    /// Section `[general]`: dialects and saved settings.
    pub general: General,
    /// `[system]`, with the second USB port of `[consoles]`.
    pub system: SystemConfig,
    /// Section `[update]`: signed firmware.
    pub update: UpdateConfig,
    /// Section `[uart console]`: the auxiliary UART.
    pub uart: UartConfig,
    /// Section `[network]`: Ethernet and what it serves.
    pub network: NetworkConfig,
    /// Section `[motion control]`: path and kinematics.
    pub motion: MotionControl,
    /// Sections `[planner]` and `[conveyor]`.
    pub planner: PlannerConfig,
    /// Section `[input shaper]`, X Y Z.
    pub input_shapers: [InputShaperConfig; 3],
    /// Settings under `[actuator] common`.
    pub motors: MotorsCommon,
    /// Section `[actuator]` by motor; see [`MachineConfig::actuators`] for the motors that exist.
    pub actuators: PerActuator<ActuatorConfig>,
    /// Section `[tmc2590]`: on-board drivers.
    pub tmc2590: DriverFamily,
    /// Section `[tmc2660]`: on-board drivers.
    pub tmc2660: DriverFamily,
    /// Section `[tmc2130]`: external drivers on SPI.
    pub tmc2130: StealthFamily,
    /// Section `[tmc5160]`: external drivers on SPI.
    pub tmc5160: StealthFamily,
    /// Section `[tmc2240]`: external drivers on SPI.
    pub tmc2240: StealthFamily,
    /// Section `[tmc2208]`: external drivers on a UART.
    pub tmc2208: StealthFamily,
    /// Section `[tmc2209]`: external drivers on a UART.
    pub tmc2209: StealthFamily,
    /// Section `[tmc2226]`: external drivers on a UART.
    pub tmc2226: StealthFamily,
    /// Section `[extruder]`, enabled ones only after reading.
    pub extruders: Vec<ExtruderConfig, MAX_EXTRUDERS>,
    /// Section `[temperature control]`, enabled ones only after reading.
    pub temperatures: Vec<TemperatureConfig, MAX_TEMPERATURES>,
    /// Section `[endstops]`, enabled ones only after reading.
    pub endstops: Vec<EndstopConfig, MAX_ENDSTOPS>,
    /// Settings under `[endstops] common`.
    pub homing: HomingConfig,
    /// Section `[soft endstop]`: travel limits.
    pub soft_endstops: SoftEndstops,
    /// Section `[zprobe]`: the probe.
    pub probe: ProbeConfig,
    /// Section `[delta calibration strategy]`.
    pub delta_calibration: DeltaCalibrationConfig,
    /// Leveling strategies and `[skew correction]`.
    pub leveling: LevelingConfig,
    /// Section `[z alignment]`: leveling by Z motors.
    pub z_alignment: ZAlignment,
    /// Section `[bed screws]`: leveling by hand.
    pub bed_screws: BedScrews,
    /// Section `[z thermal adjust]`: growth of the frame.
    pub z_thermal: ZThermalConfig,
    /// Section `[axis twist compensation]`.
    pub axis_twist: AxisTwist,
    /// Lines executed before and after probing a cartesian grid.
    pub probe_gcode: [Command; 2],
    /// Lines that deploy the probe and stow the probe.
    pub probe_scripts: [Command; 2],
    /// Section `[switch]`, enabled ones only after reading.
    pub switches: Vec<SwitchConfig, MAX_SWITCHES>,
    /// Section `[button box]`, those in use only after reading.
    pub buttons: Vec<ButtonConfig, MAX_BUTTONS>,
    /// Polling rate of the buttons, Hz.
    pub button_poll_hz: u16,
    /// Section `[fan]`, enabled ones only after reading.
    pub fans: Vec<FanConfig, MAX_FANS>,
    /// Section `[led strip]`, enabled ones only after reading.
    pub led_strips: Vec<LedStripConfig, MAX_STRIPS>,
    /// Section `[temperature switch]`, enabled ones only after reading.
    pub temperature_switches: Vec<TemperatureSwitchConfig, MAX_TEMPERATURE_SWITCHES>,
    /// Timer frequencies of `[pwm1]` and `[pwm2]`, Hz, where the section exists.
    pub pwm_frequency_hz: [Option<u32>; 2],
    /// Section `[voltage monitor]`, with the built-in vmotor and vfet.
    pub voltages: Vec<VoltageMonitor, MAX_VOLTAGES>,
    /// Section `[kill button]`: the emergency stop.
    pub kill_button: KillButton,
    /// Section `[safety door]`: the door switch.
    pub safety_door: SafetyDoor,
    /// Section `[macros]`: Klipper's macros.
    pub macros: MacrosConfig,
    /// Section `[player]`: jobs from files.
    pub player: PlayerConfig,
    /// Section `[tool change]`: scripts and prompt.
    pub tool_change: ToolChangeConfig,
    /// Section `[laser]`.
    pub laser: LaserConfig,
    /// Section `[filament detector]`: run-out and jams.
    pub filament_detector: FilamentDetectorConfig,
    /// Lines of the detector: filament runs out, filament is put in.
    pub filament_lines: [Command; 2],
    /// Section `[filament width sensor]`.
    pub filament_width: FilamentWidthConfig,
    /// Section `[filament change]`: M600, M701 and M702.
    pub filament_change: FilamentChangeConfig,
    /// Section `[drillingcycles]`: canned cycles.
    pub cycles: CycleSetup,
    /// Parts that stay off because of an error in the file; see [`MachineConfig::off`].
    pub off: Vec<OffModule, MAX_OFF>,
}

impl MachineConfig {
    /// Returns the fan of a switch, when something else than the switch's codes controls the fan.
    #[must_use]
    pub fn automatic_fan(&self, switch: &str) -> Option<&FanConfig> {
        self.fans.iter().find(|fan| fan.enable && fan.name == switch && fan.follows != FanFollows::Codes)
    }

    /// Returns the strip that has the switch as a colour.
    #[must_use]
    pub fn strip_of_switch(&self, switch: &str) -> Option<&LedStripConfig> {
        self.led_strips.iter().find(|strip| strip.enable && strip.switches.iter().any(|name| name == switch))
    }

    /// Returns whether the timer of PWM1 or PWM2 (1, 2) serves the laser and so can do nothing else.
    #[must_use]
    pub fn timer_burns(&self, timer: u8) -> bool {
        self.laser.enable && self.laser.pwm_pin.is_some_and(|pin| pin.timer == timer)
    }

    /// Returns whether the timer of PWM1 or PWM2 (1, 2) sends data to strips and so can do nothing else.
    #[must_use]
    pub fn timer_sends(&self, timer: u8) -> bool {
        self.led_strips.iter().any(|strip| strip.enable && strip.pin.is_some_and(|pin| pin.timer == timer))
    }

    /// Returns why a part of the machine stays off; none when it works. `name` is the instance's, empty where
    /// there are none.
    #[must_use]
    pub fn off(&self, section: &str, name: &str) -> Option<&OffModule> {
        self.off.iter().find(|off| off.section == section && (off.name.is_empty() || off.name == name))
    }

    /// Returns the motors of the machine in order, slaves included.
    pub fn actuators(&self) -> impl Iterator<Item = (Actuator, &ActuatorConfig)> {
        Actuator::ALL.into_iter().map(|actuator| (actuator, &self.actuators[actuator])).filter(|(_, a)| a.present)
    }

    /// Returns the driver chip's settings of a motor, when an on-board driver moves the motor.
    #[must_use]
    pub fn driver(&self, actuator: Actuator) -> Option<&TmcConfig> {
        Some(&self.driver_family(self.actuators[actuator].driver)?.axes[actuator])
    }

    /// Returns the settings that all on-board chips of a kind share; none for external drivers.
    #[must_use]
    pub const fn driver_family(&self, kind: DriverKind) -> Option<&DriverFamily> {
        match kind {
            DriverKind::Tmc2590 => Some(&self.tmc2590),
            DriverKind::Tmc2660 => Some(&self.tmc2660),
            _ => None,
        }
    }

    /// Returns the probe's position relative to the nozzle, mm: from the leveling strategy, or else from
    /// `[zprobe]`.
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

    /// Returns the endstop an axis homes to. A slaved motor is no axis and follows its master, so has none.
    #[must_use]
    pub fn homing_endstop(&self, axis: Axis) -> Option<&EndstopConfig> {
        if self.actuators.0.get(axis as usize).is_some_and(|motor| motor.slaved_to.is_some()) {
            return None;
        }
        self.endstops.iter().find(|stop| stop.axis == Some(axis) && stop.homing_direction != HomingDirection::None)
    }

    /// Returns whether any motor homes by stalls or is monitored for stalls.
    #[must_use]
    pub fn looks_at_stalls(&self) -> bool {
        self.endstops.iter().any(|stop| stop.stall.homing) || self.watched_for_stalls().next().is_some()
    }

    /// Returns the motors monitored for stalls, each with the input that signals a stall.
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

    /// Returns the stall output of the motor's driver that serves as the pin of an endstop for sensorless
    /// homing.
    fn stall_endstop_pin(&self, motor: Actuator) -> Option<Pin> {
        let is_its = |stop: &&EndstopConfig| stop.axis.is_some_and(|axis| axis as usize == motor as usize);
        self.endstops.iter().find(|stop| stop.enable && stop.stall.homing && is_its(stop))?.pin
    }

    /// Returns the response to a stall of a monitored motor.
    #[must_use]
    pub fn on_stall(&self, motor: Actuator) -> OnStall {
        let usual = if self.motors.halt_on_stall { OnStall::Halt } else { OnStall::Tell };
        self.actuators[motor].on_stall.unwrap_or(usual)
    }

    /// Returns the place in [`Self::endstops`] of the endstop on a pin.
    #[must_use]
    pub fn endstop_of_pin(&self, pin: Pin) -> Option<usize> {
        self.endstops.iter().position(|stop| stop.enable && stop.pin.is_some_and(|own| own.is_same_pad(pin)))
    }

    /// Returns the switches of motors slaved to this axis' motor, with their places in [`Self::endstops`].
    pub fn slave_endstops(&self, axis: Axis) -> impl Iterator<Item = (usize, &EndstopConfig)> {
        let is_slave = move |letter: Axis| {
            let master = self.actuators.0.get(letter as usize).and_then(|motor| motor.slaved_to);
            master.is_some_and(|master| master as usize == axis as usize)
        };
        self.endstops.iter().enumerate().filter(move |(_, stop)| stop.axis.is_some_and(is_slave))
    }
}
