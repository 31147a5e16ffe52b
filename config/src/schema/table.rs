//! The table of all sections: the name of each, the form of its lines, and where its values go.

use super::section::{CannotCreate, Form, Instances, Scope, Section, UNREAD};
use crate::machine::{MAX_VOLTAGES, MachineConfig};
use crate::names::Name;
use crate::pin::VoltageInput;
use crate::sections::*;
use crate::setting::Setting;
use crate::setting::declare::Rows;
use crate::setting::value::Value;
use units::Actuator;

/// A section: its name, what an error in it puts out of service, the form of its lines, and each list of rows
/// with the way to the struct that they fill. Its documentation is that of the first list, unless another one
/// is named.
macro_rules! section {
    ($name:literal, $scope:ident, $form:expr, $first:ty: $reach_first:expr $(, $more:ty: $reach:expr)* $(,)?) => {
        section!($name, <$first as Rows>::DOCS, $scope, $form, $first: $reach_first $(, $more: $reach)*)
    };
    (
        $name:literal, $docs:expr, $scope:ident, $form:expr,
        $first:ty: $reach_first:expr $(, $more:ty: $reach:expr)* $(,)?
    ) => {
        Section {
            name: $name,
            docs: $docs,
            scope: Scope::$scope,
            form: $form,
            settings: {
                const COUNT: usize = <$first as Rows>::SETTINGS.len() $(+ <$more as Rows>::SETTINGS.len())*;
                const ALL: &[Setting; COUNT] = &joined([<$first as Rows>::SETTINGS $(, <$more as Rows>::SETTINGS)*]);
                ALL
            },
            store: |config, place, row, value| {
                let reach: fn(&mut MachineConfig, usize) -> Option<&mut <$first as Rows>::Target> = $reach_first;
                let Some(row) = put::<$first>(reach(config, place), row, value) else { return };
                $(
                    let reach: fn(&mut MachineConfig, usize) -> Option<&mut <$more as Rows>::Target> = $reach;
                    let Some(row) = put::<$more>(reach(config, place), row, value) else { return };
                )*
                let _ = row;
            },
        }
    };
}

/// Stores a value by the row at a place; returns the place among the rows behind when it is none of these.
/// Inlined, because there is one call of each instance.
#[inline(always)]
fn put<'v, R: Rows>(target: Option<&mut R::Target>, row: usize, value: &'v Value<'v>) -> Option<usize> {
    let Some(set) = R::SETTERS.get(row) else { return Some(row - R::SETTERS.len()) };
    if let Some(target) = target {
        set(target, value);
    }
    None
}

/// Lists behind one another, which have `COUNT` settings in all.
const fn joined<const COUNT: usize, const PARTS: usize>(parts: [&[Setting]; PARTS]) -> [Setting; COUNT] {
    let mut all = [parts[0][0]; COUNT];
    let (mut part, mut at) = (0, 0);
    while part < PARTS {
        let mut place = 0;
        while place < parts[part].len() {
            all[at] = parts[part][place];
            (place, at) = (place + 1, at + 1);
        }
        part += 1;
    }
    all
}

/// Lines `name.key = value` of instances that are a list of the description.
macro_rules! list {
    ($noun:literal, $list:ident) => {
        Form::Named(Instances {
            noun: $noun,
            find: |c, name| c.$list.iter().position(|one| one.name == name),
            create: |c, name| {
                let name = new_name(name)?;
                let place = c.$list.len();
                c.$list.push(Default::default()).map_err(|_| CannotCreate::Full(place))?;
                if let Some(one) = c.$list.last_mut() {
                    one.name = name;
                }
                Ok(place)
            },
            name: |c, i| c.$list.get(i).map_or("", |one| one.name.as_str()),
            is_live: |c, i| c.$list.get(i).is_some_and(|one| one.enable),
        })
    };
}

/// Drivers of a kind, each by its motor's name.
macro_rules! drivers {
    ($family:ident, $kind:expr) => {
        Form::Named(Instances {
            noun: "driver",
            find: |c, name| {
                let place = actuator_place(name).ok()?;
                c.$family.axes.0.get(place)?.present.then_some(place)
            },
            create: |c, name| {
                let place = actuator_place(name)?;
                if let Some(chip) = c.$family.axes.0.get_mut(place) {
                    chip.present = true;
                }
                Ok(place)
            },
            name: actuator_name,
            is_live: |c, i| c.actuators.0.get(i).is_some_and(|motor| motor.present && motor.driver == $kind),
        })
    };
}

/// Drivers on the board.
macro_rules! on_board {
    ($name:literal, $family:ident, $chip:ty, $kind:expr $(, $more:ty: $reach:expr)*) => {
        section!(
            $name,
            <$chip as Rows>::DOCS,
            Machine,
            drivers!($family, $kind),
            DriverFamily: |c, _| Some(&mut c.$family),
            TmcConfig: |c, i| c.$family.axes.0.get_mut(i),
            $chip: |c, i| c.$family.axes.0.get_mut(i)
            $(, $more: $reach)*
        )
    };
}

/// Drivers outside the board.
macro_rules! outside {
    ($name:literal, $family:ident, $chip:ty, $kind:expr, $bus:ty $(, $load:ty)?) => {
        section!(
            $name,
            <$chip as Rows>::DOCS,
            Machine,
            drivers!($family, $kind),
            $bus: |c, _| Some(&mut c.$family),
            StealthFamily: |c, _| Some(&mut c.$family),
            $chip: |c, i| c.$family.axes.0.get_mut(i)
            $(, $load: |c, i| c.$family.axes.0.get_mut(i))?
        )
    };
}

const ACTUATOR_NAMES: &[&str] = &["alpha", "beta", "gamma", "delta", "epsilon", "zeta"];

fn actuator_place(name: &str) -> Result<usize, CannotCreate> {
    Actuator::from_name(name).map(|actuator| actuator as usize).ok_or(CannotCreate::UnknownName(ACTUATOR_NAMES))
}

fn actuator_name(_: &MachineConfig, place: usize) -> &str {
    Actuator::from_index(place).map_or("", Actuator::name)
}

const MOTORS: Instances = Instances {
    noun: "motor",
    find: |c, name| {
        let place = actuator_place(name).ok()?;
        c.actuators.0.get(place)?.present.then_some(place)
    },
    create: |c, name| {
        let place = actuator_place(name)?;
        if let Some(motor) = c.actuators.0.get_mut(place) {
            motor.present = true;
        }
        Ok(place)
    },
    name: actuator_name,
    is_live: |c, i| c.actuators.0.get(i).is_some_and(|motor| motor.present),
};

/// Motors with a current, which may have no other setting.
const MOTOR_CURRENTS: Instances =
    Instances { find: |_, name| actuator_place(name).ok(), create: |_, name| actuator_place(name), ..MOTORS };

const VOLTAGES: Instances = Instances {
    noun: "voltage",
    find: |c, name| c.voltages.iter().position(|voltage| voltage.name == name),
    create: |c, name| {
        let voltage = VoltageMonitor { name: new_name(name)?, input: VoltageInput(0), scale: 11.0 };
        c.voltages.push(voltage).map_err(|_| CannotCreate::Full(MAX_VOLTAGES))?;
        Ok(c.voltages.len() - 1)
    },
    name: |c, i| c.voltages.get(i).map_or("", |voltage| voltage.name.as_str()),
    is_live: |c, i| c.voltages.get(i).is_some(),
};

/// Instances that nothing stores yet.
const UNREAD_INSTANCES: Instances =
    Instances { noun: UNREAD, find: |_, _| Some(0), create: |_, _| Ok(0), name: |_, _| "", is_live: |_, _| true };

/// Every section, in the order of the reference.
pub const SECTIONS: &[Section] = &[
    section!("general", Machine, Form::Plain, General: |c, _| Some(&mut c.general)),
    section!("system", Machine, Form::Plain, SystemConfig: |c, _| Some(&mut c.system)),
    section!("update", Section, Form::Plain, UpdateConfig: |c, _| Some(&mut c.update)),
    section!("consoles", Section, Form::Plain, Consoles: |c, _| Some(&mut c.system)),
    section!("uart console", Section, Form::Plain, UartConfig: |c, _| Some(&mut c.uart)),
    section!("motion control", Machine, Form::Plain, MotionControl: |c, _| Some(&mut c.motion)),
    section!("planner", Machine, Form::Plain, PlannerConfig: |c, _| Some(&mut c.planner)),
    section!("conveyor", Machine, Form::Plain, Conveyor: |c, _| Some(&mut c.planner)),
    section!("input shaper", Section, Form::Plain, InputShapers: |c, _| Some(&mut c.input_shapers)),
    section!(
        "actuator",
        Machine, Form::Named(MOTORS),
        ActuatorConfig: |c, i| c.actuators.0.get_mut(i),
        MotorsCommon: |c, _| Some(&mut c.motors),
        StallRecoveryConfig: |c, _| Some(&mut c.motors.stall),
        MotorsEnable: |c, _| Some(&mut c.motors),
    ),
    on_board!("tmc2590", tmc2590, Tmc2590, DriverKind::Tmc2590, Tmc2590Board: |c, _| Some(&mut c.tmc2590)),
    on_board!("tmc2660", tmc2660, Tmc2660, DriverKind::Tmc2660),
    outside!("tmc2130", tmc2130, Tmc2130, DriverKind::Tmc2130, SpiBus, Tmc2130Load),
    outside!("tmc5160", tmc5160, Tmc5160, DriverKind::Tmc5160, SpiBus, Tmc5160Load),
    outside!("tmc2240", tmc2240, Tmc2240, DriverKind::Tmc2240, SpiBus, Tmc2240Load),
    outside!("tmc2208", tmc2208, Tmc2208, DriverKind::Tmc2208, UartLine),
    outside!("tmc2209", tmc2209, Tmc2209, DriverKind::Tmc2209, UartLine, Tmc2209Load),
    outside!("tmc2226", tmc2226, Tmc2226, DriverKind::Tmc2226, UartLine, Tmc2226Load),
    section!("current control", Machine, Form::Named(MOTOR_CURRENTS), CurrentControl: |c, i| c.actuators.0.get_mut(i)),
    section!("extruder", Instance, list!("extruder", extruders), ExtruderConfig: |c, i| c.extruders.get_mut(i)),
    section!(
        "temperature control",
        Instance, list!("temperature control", temperatures),
        TemperatureConfig: |c, i| c.temperatures.get_mut(i),
        ThermistorConfig: |c, i| c.temperatures.get_mut(i).map(|heater| &mut heater.sensor.thermistor),
        TemperatureCurve: |c, i| c.temperatures.get_mut(i),
        SpiSensorConfig: |c, i| c.temperatures.get_mut(i).map(|heater| &mut heater.sensor.spi),
        TemperatureOutput: |c, i| c.temperatures.get_mut(i),
        PidGains: |c, i| c.temperatures.get_mut(i).map(|heater| &mut heater.pid),
        TemperatureLaw: |c, i| c.temperatures.get_mut(i),
        ModelSettings: |c, i| c.temperatures.get_mut(i).map(|heater| &mut heater.model),
        TemperatureLimits: |c, i| c.temperatures.get_mut(i),
        Runaway: |c, i| c.temperatures.get_mut(i).map(|heater| &mut heater.runaway),
        Verify: |c, i| c.temperatures.get_mut(i).map(|heater| &mut heater.verify),
        TemperatureReadings: |c, i| c.temperatures.get_mut(i),
        TemperatureWait: |c, i| c.temperatures.get_mut(i).map(|heater| &mut heater.wait),
        TemperatureCodes: |c, i| c.temperatures.get_mut(i),
    ),
    section!(
        "endstops",
        Machine, list!("endstop", endstops),
        EndstopConfig: |c, i| c.endstops.get_mut(i),
        EndstopPhaseConfig: |c, i| c.endstops.get_mut(i).map(|stop| &mut stop.phase),
        EndstopStallConfig: |c, i| c.endstops.get_mut(i).map(|stop| &mut stop.stall),
        HomingConfig: |c, _| Some(&mut c.homing),
    ),
    section!("soft endstop", Machine, Form::Plain, SoftEndstops: |c, _| Some(&mut c.soft_endstops)),
    section!(
        "switch",
        Instance,
        list!("switch", switches),
        SwitchConfig: |c, i| c.switches.get_mut(i),
        Servo: |c, i| c.switches.get_mut(i).map(|switch| &mut switch.servo),
        SwitchHalt: |c, i| c.switches.get_mut(i),
    ),
    section!(
        "fan",
        Instance,
        list!("fan", fans),
        FanConfig: |c, i| c.fans.get_mut(i),
        FanControl: |c, i| c.fans.get_mut(i).map(|fan| &mut fan.control),
        FanDriveConfig: |c, i| c.fans.get_mut(i).map(|fan| &mut fan.drive),
        TachometerConfig: |c, i| c.fans.get_mut(i).map(|fan| &mut fan.tachometer),
    ),
    section!("led strip", Instance, list!("strip", led_strips), LedStripConfig: |c, i| c.led_strips.get_mut(i)),
    section!("pwm1", Section, Form::Plain, Pwm1: |c, _| Some(&mut c.pwm_frequency_hz)),
    section!("pwm2", Section, Form::Plain, Pwm2: |c, _| Some(&mut c.pwm_frequency_hz)),
    section!("voltage monitor", Instance, Form::Keyed(VOLTAGES), VoltageMonitor: |c, i| c.voltages.get_mut(i)),
    section!(
        "zprobe",
        Section, Form::Plain,
        ProbeConfig: |c, _| Some(&mut c.probe),
        ProbeScripts: |c, _| Some(&mut c.probe_scripts),
        ProbeContact: |c, _| Some(&mut c.probe),
        SamplesConfig: |c, _| Some(&mut c.probe.samples),
        ProbeLeveling: |c, _| Some(&mut c.leveling),
        ProbeCalibration: |c, _| Some(&mut c.delta_calibration),
    ),
    section!("three point leveling strategy", Section, Form::Plain, LevelingConfig: |c, _| Some(&mut c.leveling)),
    section!(
        "cartesian grid leveling strategy",
        Section, Form::Plain,
        CartesianGrid: |c, _| Some(&mut c.leveling.grid),
        CartesianGridScripts: |c, _| Some(&mut c.probe_gcode),
    ),
    section!("delta grid leveling strategy", Section, Form::Plain, DeltaGrid: |c, _| Some(&mut c.leveling.delta)),
    section!("bed mesh", Section, Form::Plain, MeshConfig: |c, _| Some(&mut c.leveling.mesh)),
    section!(
        "delta calibration strategy",
        Section, Form::Plain,
        DeltaCalibrationConfig: |c, _| Some(&mut c.delta_calibration),
    ),
    section!("skew correction", Section, Form::Plain, SkewCorrection: |c, _| Some(&mut c.leveling)),
    section!("z alignment", Section, Form::Plain, ZAlignment: |c, _| Some(&mut c.z_alignment)),
    section!("bed screws", Section, Form::Plain, BedScrews: |c, _| Some(&mut c.bed_screws)),
    section!("axis twist compensation", Section, Form::Plain, AxisTwist: |c, _| Some(&mut c.axis_twist)),
    section!("z thermal adjust", Section, Form::Plain, ZThermalConfig: |c, _| Some(&mut c.z_thermal)),
    section!("kill button", Machine, Form::Plain, KillButton: |c, _| Some(&mut c.kill_button)),
    section!("safety door", Machine, Form::Plain, SafetyDoor: |c, _| Some(&mut c.safety_door)),
    section!("macros", Section, Form::Plain, MacrosConfig: |c, _| Some(&mut c.macros)),
    section!(
        "player",
        Section,
        Form::Plain,
        PlayerConfig: |c, _| Some(&mut c.player),
        PowerLossConfig: |c, _| Some(&mut c.player.power_loss),
    ),
    section!("tool change", Machine, Form::Plain, ToolChangeConfig: |c, _| Some(&mut c.tool_change)),
    section!(
        "linear delta",
        Machine, Form::Plain,
        LinearDeltaArms: |c, _| Some(&mut c.motion.arms.linear_delta),
        LinearDeltaHalt: |c, _| Some(&mut c.motion.arms),
    ),
    section!(
        "rotary delta",
        Machine, Form::Plain,
        RotaryDeltaArms: |c, _| Some(&mut c.motion.arms.rotary_delta),
        RotaryDeltaHalt: |c, _| Some(&mut c.motion.arms),
    ),
    section!("morgan scara", Machine, Form::Plain, MorganArms: |c, _| Some(&mut c.motion.arms.morgan)),
    section!("corexz", Machine, Form::Plain, CoreXz: |c, _| Some(&mut c.motion.arms)),
    section!("deltesian", Machine, Form::Plain, DeltesianArms: |c, _| Some(&mut c.motion.arms.deltesian)),
    section!("generic cartesian", Machine, Form::Plain, GenericCartesian: |c, _| Some(&mut c.motion.arms)),
    section!("winch", Machine, Form::Plain, Winch: |c, _| Some(&mut c.motion.arms)),
    section!("laser", Section, Form::Plain, LaserConfig: |c, _| Some(&mut c.laser)),
    section!("drillingcycles", Section, Form::Plain, Cycles: |c, _| Some(&mut c.cycles)),
    section!(
        "filament detector",
        Section, Form::Plain,
        FilamentDetectorConfig: |c, _| Some(&mut c.filament_detector),
        DetectorLines: |c, _| Some(&mut c.filament_lines),
    ),
    section!("filament width sensor", Section, Form::Plain, FilamentWidthConfig: |c, _| Some(&mut c.filament_width)),
    section!("filament change", Section, Form::Plain, FilamentChangeConfig: |c, _| Some(&mut c.filament_change)),
    section!(
        "temperature switch",
        Instance, list!("temperature switch", temperature_switches),
        TemperatureSwitchConfig: |c, i| c.temperature_switches.get_mut(i),
    ),
    section!(
        "button box",
        ButtonConfig::DOCS,
        Instance,
        list!("button", buttons),
        ButtonBox: |c, _| Some(&mut c.button_poll_hz),
        ButtonConfig: |c, i| c.buttons.get_mut(i),
    ),
    section!("lathe", Section, Form::Plain, Lathe: |_, _| None),
    section!("els", Section, Form::Plain, LeadScrew: |_, _| None),
    section!("st7920", Section, Form::Plain, GraphicDisplay: |_, _| None),
    section!("tm1638", Section, Form::Plain, KeyModule: |_, _| None),
    section!("mpg", Section, Form::Named(UNREAD_INSTANCES), Handwheels: |_, _| None),
    section!(
        "network",
        Section,
        Form::Plain,
        NetworkConfig: |c, _| Some(&mut c.network),
        NetworkToCome: |_, _| None,
    ),
];

/// An instance's name, when it is short enough.
fn new_name(name: &str) -> Result<Name, CannotCreate> {
    Name::try_from(name).map_err(|_| CannotCreate::NameTooLong)
}

/// Returns the setting that a Smoothieware v1 name stands for, and the instance when the name holds one.
#[must_use]
pub fn by_v1_name(name: &str) -> Option<(&'static Section, &'static Setting, Option<&str>)> {
    let rows = SECTIONS.iter().flat_map(|section| section.settings.iter().map(move |row| (section, row)));
    for (section, row) in rows.filter(|(_, row)| !row.v1.is_empty()) {
        if row.v1 == name {
            return Some((section, row, None));
        }
        if let Some(instance) = instance_of(row.v1, name) {
            return Some((section, row, Some(instance)));
        }
    }
    None
}

/// Returns the part of `name` at the place of `<axis>` or `<name>` in the v1 name `pattern`. Motors have
/// names of their own.
pub(crate) fn instance_of<'n>(pattern: &str, name: &'n str) -> Option<&'n str> {
    let (start, rest) = pattern.split_once('<')?;
    let (kind, end) = rest.split_once('>')?;
    let instance = name.strip_prefix(start)?.strip_suffix(end)?;
    let exists = match kind {
        "axis" => units::Actuator::from_name(instance).is_some(),
        _ => !instance.is_empty() && !instance.contains('.'),
    };
    exists.then_some(instance)
}

/// Returns the section of this name and its place in [`SECTIONS`].
#[must_use]
pub fn section(name: &str) -> Option<(usize, &'static Section)> {
    SECTIONS.iter().enumerate().find(|(_, section)| section.name == name)
}
