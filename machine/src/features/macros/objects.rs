//! Objects of `printer` in Klipper's names: the machine's state, in Klipper's units.

use ::macros::{Given, Object};
use base::ports::MotionPort as _;
use printer_cfg::Section;
use units::{Axis, PerAxis};

use super::hands::{MacroHands, Seen};
use super::look::{Look, kind_of};

/// Kind of an object with a state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Toolhead,
    Move,
    LiveMotion,
    Extruder,
    Heater,
    Sensor,
    Heaters,
    PartFan,
    Output,
    Pause,
    Idle,
    PrintStats,
    PrintInfo,
    Card,
    Probe,
    Endstops,
    Mesh,
    Retraction,
    Display,
    Filament,
    Host,
    /// Objects of the print that can be left out.
    Print,
    /// Motors of Z, aligned or not.
    Alignment,
}

/// Names of objects; a name that ends in a blank is followed by that of a part.
const KINDS: [(&str, Kind); 34] = [
    ("toolhead", Kind::Toolhead),
    ("gcode_move", Kind::Move),
    ("motion_report", Kind::LiveMotion),
    ("heaters", Kind::Heaters),
    ("pause_resume", Kind::Pause),
    ("idle_timeout", Kind::Idle),
    ("print_stats", Kind::PrintStats),
    ("virtual_sdcard", Kind::Card),
    ("query_endstops", Kind::Endstops),
    ("display_status", Kind::Display),
    ("webhooks", Kind::Host),
    ("exclude_object", Kind::Print),
    ("extruder", Kind::Extruder),
    ("heater_bed", Kind::Heater),
    ("fan", Kind::PartFan),
    ("probe", Kind::Probe),
    ("bed_mesh", Kind::Mesh),
    ("firmware_retraction", Kind::Retraction),
    ("extruder1", Kind::Extruder),
    ("extruder2", Kind::Extruder),
    ("heater_generic ", Kind::Heater),
    ("temperature_sensor ", Kind::Sensor),
    ("temperature_fan ", Kind::Heater),
    ("fan_generic ", Kind::Output),
    ("heater_fan ", Kind::Output),
    ("controller_fan ", Kind::Output),
    ("output_pin ", Kind::Output),
    ("pwm_tool ", Kind::Output),
    ("servo ", Kind::Output),
    ("filament_switch_sensor ", Kind::Filament),
    ("filament_motion_sensor ", Kind::Filament),
    ("bltouch", Kind::Probe),
    ("z_tilt", Kind::Alignment),
    ("quad_gantry_level", Kind::Alignment),
];

/// Objects that every machine has, which `printer` is gone through with.
pub(super) const NAMES: usize = 12;

/// Numbers by axis: X Y Z E.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Vector {
    Least,
    Greatest,
    Position,
    GcodePosition,
    Origin,
    Live,
}

/// Something that a macro can ask for parts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Thing {
    Printer,
    Parameters,
    Macro(Section),
    Configfile,
    /// All sections; their options as Klipper has read them, or as they are written.
    Settings(bool),
    Options(Section, bool),
    Saved,
    SavedVariables,
    /// An object with a state, and which of its kind it is.
    Status(Kind, u8),
    Vector(Vector),
    /// The objects of the print, as a list.
    PrintObjects,
    PrintObject(u8),
    /// Meshes on the card, by their names.
    Profiles,
}

const STATUS: [Kind; 23] = [
    Kind::Toolhead,
    Kind::Move,
    Kind::LiveMotion,
    Kind::Extruder,
    Kind::Heater,
    Kind::Sensor,
    Kind::Heaters,
    Kind::PartFan,
    Kind::Output,
    Kind::Pause,
    Kind::Idle,
    Kind::PrintStats,
    Kind::PrintInfo,
    Kind::Card,
    Kind::Probe,
    Kind::Endstops,
    Kind::Mesh,
    Kind::Retraction,
    Kind::Display,
    Kind::Filament,
    Kind::Host,
    Kind::Print,
    Kind::Alignment,
];
const VECTORS: [Vector; 6] =
    [Vector::Least, Vector::Greatest, Vector::Position, Vector::GcodePosition, Vector::Origin, Vector::Live];

impl Thing {
    /// The thing with a number.
    pub fn of(id: u32) -> Self {
        let section = Section((id >> 8) as u16);
        let kind = |index: u32| STATUS.get(index as usize & 0xFF).copied().unwrap_or(Kind::Host);
        match id & 0xFF {
            1 => Self::Parameters,
            2 => Self::Macro(section),
            3 => Self::Configfile,
            4 => Self::Settings(true),
            5 => Self::Settings(false),
            6 => Self::Options(section, true),
            7 => Self::Options(section, false),
            8 => Self::Saved,
            9 => Self::SavedVariables,
            10 => Self::Status(kind(id >> 8), (id >> 16) as u8),
            12 => Self::PrintObjects,
            13 => Self::PrintObject((id >> 8) as u8),
            14 => Self::Profiles,
            11 => Self::Vector(VECTORS.get((id >> 8) as usize).copied().unwrap_or(Vector::Position)),
            _ => Self::Printer,
        }
    }

    /// The thing as it is handed to a macro.
    pub const fn given(self) -> Given<'static> {
        let id = match self {
            Self::Printer => 0,
            Self::Parameters => 1,
            Self::Macro(section) => 2 | (section.0 as u32) << 8,
            Self::Configfile => 3,
            Self::Settings(true) => 4,
            Self::Settings(false) => 5,
            Self::Options(section, true) => 6 | (section.0 as u32) << 8,
            Self::Options(section, false) => 7 | (section.0 as u32) << 8,
            Self::Saved => 8,
            Self::SavedVariables => 9,
            Self::Status(kind, instance) => 10 | (kind as u32) << 8 | (instance as u32) << 16,
            Self::Vector(which) => 11 | (which as u32) << 8,
            Self::PrintObjects => 12,
            Self::Profiles => 14,
            Self::PrintObject(place) => 13 | (place as u32) << 8,
        };
        Given::Object(Object { id, kind: kind_of(self) })
    }
}

/// Returns the name of an object that every machine has.
pub(super) fn name_at(place: usize) -> Option<&'static str> {
    KINDS.get(place).filter(|_| place < NAMES).map(|(name, _)| *name)
}

/// Finds an object by its name.
pub(super) fn find<'c, H: MacroHands<'c>>(look: &mut Look<'_, 'c, H>, name: &str) -> Option<Given<'static>> {
    let (part, kind) = KINDS.into_iter().find_map(|(known, kind)| match known.ends_with(' ') {
        true => name.strip_prefix(known).map(|part| (part.trim(), kind)),
        false => (known == name).then_some((name, kind)),
    })?;
    let config = look.hands.world().config;
    let instance = match kind {
        Kind::Extruder | Kind::Heater | Kind::Sensor => heater(look, part)?,
        Kind::Output => output(config, part)?,
        Kind::PartFan => output(config, "fan")?,
        Kind::Probe => look.snapshot.probe.map(|_| 0)?,
        Kind::Filament => config.filament_detector.enable.then_some(0)?,
        Kind::Mesh | Kind::Retraction | Kind::Alignment => look.hands.macros().memory.store.section(name).map(|_| 0)?,
        _ => 0,
    };
    Some(Thing::Status(kind, instance).given())
}

/// Returns the place of a heater among those shown, by Klipper's name or by that of the configuration.
fn heater<'c, H: MacroHands<'c>>(look: &mut Look<'_, 'c, H>, name: &str) -> Option<u8> {
    let config = look.hands.world().config;
    let number = name.strip_prefix("extruder").map(|number| if number.is_empty() { "0" } else { number });
    let tool = number.and_then(|number| number.parse::<u8>().ok());
    let found = config.heaters().position(|(_, heater)| match tool {
        Some(tool) => heater.tool_id.0 == tool,
        None if name == "heater_bed" => heater.set_m_code == 140,
        None => heater.name.eq_ignore_ascii_case(name),
    });
    found.map(|place| place as u8)
}

/// Returns the place of an output among the switches.
fn output(config: &config::MachineConfig, name: &str) -> Option<u8> {
    let outputs = || config.switches.iter().enumerate().filter(|(_, switch)| !switch.is_input());
    let named = outputs().find(|(_, switch)| switch.name.eq_ignore_ascii_case(name));
    let part_fan = || outputs().find(|(_, switch)| switch.input_on_command == Some(gcode::Code::m(106)));
    named.or_else(|| if name == "fan" { part_fan() } else { None }).map(|(place, _)| place as u8)
}

/// Numbers of each axis, as a list.
pub(super) fn vector<'c, H: MacroHands<'c>>(look: &mut Look<'_, 'c, H>, which: Vector) -> [f64; 4] {
    let snapshot = look.snapshot;
    let Seen { program, world, .. } = look.hands.seen();
    let axis = program.tools().active().map_or(Axis::A, |tool| tool.settings.axis);
    let of = |places: &PerAxis<f64>| [places[Axis::X], places[Axis::Y], places[Axis::Z], places[axis]];
    let [least, greatest] = &snapshot.ends;
    let bounded = |places: [f64; 4]| places.map(|place| if place.is_finite() { place } else { 0.0 });
    match which {
        Vector::Least => bounded(of(least)),
        Vector::Greatest => bounded(of(greatest)),
        Vector::Position => of(&world.ports.motion(|motion| motion.commanded_position())),
        Vector::GcodePosition => {
            let [x, y, z, _] = of(&program.modal().work(program.position()));
            [x, y, z, program.tools().active().map_or(0.0, |tool| tool.e)]
        }
        Vector::Origin => {
            let [x, y, z] = snapshot.shift;
            [x, y, z, 0.0]
        }
        Vector::Live => of(&snapshot.position),
    }
}
