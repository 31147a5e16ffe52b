//! The schema: one table that names every setting once.
//!
//! A row holds a setting's type, range, unit, default, meaning, its name in the previous generation, and the
//! function that puts a value into [`MachineConfig`]. The reader fills a description with the defaults
//! through the same functions, so what the reference says is what a missing line means.

mod actuators;
mod alignment;
mod build;
mod buttons;
mod coil;
mod cycles;
pub(crate) mod declare;
mod docs;
mod driver_load;
mod endstop_phase;
mod endstop_stall;
mod endstops;
#[cfg(any(test, feature = "std"))]
mod examples;
mod extruder;
#[cfg(test)]
mod facts;
mod fans;
pub(crate) mod field;
mod filament;
mod filament_width;
mod heat;
mod heat_control;
#[cfg(any(test, feature = "std"))]
mod json;
mod kinematics;
mod led_strips;
mod leveling;
mod lists;
#[cfg(any(test, feature = "std"))]
mod markdown;
mod modules;
mod outside_stall;
mod probe;
pub(crate) mod row;
mod soft_endstops;
mod spi_sensors;
mod stall;
mod stealth_drivers;
mod switches;
mod system;
mod temperature_switches;
#[cfg(test)]
mod tests;

use crate::diagnostic::Severity;
use crate::machine::MachineConfig;
use crate::machine::{MotionControl, PlannerConfig};
use crate::pin::PinName;
use crate::sections::motion::{Conveyor, InputShapers};
use crate::value::Value;
#[allow(unused_imports)]
use build::new_name;
use declare::Rows;
pub use docs::Docs;
#[cfg(any(test, feature = "std"))]
pub use json::json_schema;
pub use lists::{KlipperSection, Unit};
#[cfg(any(test, feature = "std"))]
pub use markdown::markdown;

/// A section whose settings are declared by `settings!`: its name, the form of its lines, and each struct that
/// it fills with the way there.
macro_rules! section {
    ($name:literal, $form:expr, $first:ty: $reach_first:expr $(, $more:ty: $reach:expr)* $(,)?) => {
        Section {
            name: $name,
            docs: <$first as Rows>::DOCS,
            form: $form,
            settings: {
                const COUNT: usize = <$first as Rows>::SETTINGS.len() $(+ <$more as Rows>::SETTINGS.len())*;
                const ALL: &[Setting; COUNT] = &joined([<$first as Rows>::SETTINGS $(, <$more as Rows>::SETTINGS)*]);
                ALL
            },
            store: Some(|config, place, row, value| {
                let reach: fn(&mut MachineConfig, usize) -> Option<&mut <$first as Rows>::Target> = $reach_first;
                let Some(row) = put::<$first>(reach(config, place), row, value) else { return };
                $(
                    let reach: fn(&mut MachineConfig, usize) -> Option<&mut <$more as Rows>::Target> = $reach;
                    let Some(row) = put::<$more>(reach(config, place), row, value) else { return };
                )*
                let _ = row;
            }),
        }
    };
}

/// Stores a value by the row at a place; returns the place among the rows behind when it is none of these.
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

/// Every section, in the order of the reference.
pub const SECTIONS: &[Section] = &[
    system::GENERAL,
    system::SYSTEM,
    system::UPDATE,
    system::CONSOLES,
    system::UART_CONSOLE,
    section!("motion control", Form::Plain, MotionControl: |c, _| Some(&mut c.motion)),
    section!("planner", Form::Plain, PlannerConfig: |c, _| Some(&mut c.planner)),
    section!("conveyor", Form::Plain, Conveyor: |c, _| Some(&mut c.planner)),
    section!("input shaper", Form::Plain, InputShapers: |c, _| Some(&mut c.input_shapers)),
    actuators::ACTUATOR,
    actuators::TMC2590,
    actuators::TMC2660,
    stealth_drivers::TMC2130,
    stealth_drivers::TMC5160,
    stealth_drivers::TMC2240,
    stealth_drivers::TMC2208,
    stealth_drivers::TMC2209,
    stealth_drivers::TMC2226,
    actuators::CURRENT_CONTROL,
    extruder::EXTRUDER,
    heat::TEMPERATURE_CONTROL,
    endstops::ENDSTOPS,
    soft_endstops::SOFT_ENDSTOP,
    switches::SWITCH,
    fans::FAN,
    led_strips::LED_STRIP,
    switches::PWM1,
    switches::PWM2,
    switches::VOLTAGE_MONITOR,
    probe::ZPROBE,
    leveling::THREE_POINT,
    leveling::CARTESIAN_GRID,
    leveling::DELTA_GRID,
    leveling::BED_MESH,
    probe::DELTA_CALIBRATION,
    leveling::SKEW_CORRECTION,
    alignment::Z_ALIGNMENT,
    alignment::BED_SCREWS,
    alignment::AXIS_TWIST,
    alignment::Z_THERMAL,
    system::KILL_BUTTON,
    system::SAFETY_DOOR,
    system::PLAYER,
    system::TOOL_CHANGE,
    kinematics::LINEAR_DELTA,
    kinematics::ROTARY_DELTA,
    kinematics::MORGAN_SCARA,
    kinematics::COREXZ,
    kinematics::DELTESIAN,
    kinematics::GENERIC_CARTESIAN,
    kinematics::WINCH,
    modules::LASER,
    cycles::DRILLING_CYCLES,
    filament::FILAMENT_DETECTOR,
    filament_width::FILAMENT_WIDTH_SENSOR,
    filament::FILAMENT_CHANGE,
    temperature_switches::TEMPERATURE_SWITCH,
    buttons::BUTTON_BOX,
    modules::LATHE,
    modules::ELS,
    modules::ST7920,
    modules::TM1638,
    modules::MPG,
    modules::NETWORK,
];

/// The noun of instances that nothing keeps yet.
pub(crate) const UNREAD: &str = "entry";

/// A section of the file.
pub struct Section {
    /// The text between the brackets.
    pub name: &'static str,
    /// Documentation of the section.
    pub docs: Docs,
    /// Form of the section's lines.
    pub form: Form,
    /// Settings of the section.
    pub settings: &'static [Setting],
    /// Stores a value of the setting at a place, for sections that are declared by `settings!`.
    pub(crate) store: Option<Store>,
}

/// Stores a value in the description: the place of the instance, the place of the setting, the value.
pub(crate) type Store = for<'v> fn(&mut MachineConfig, usize, usize, &'v Value<'v>);

/// Form of the lines in a section.
#[derive(Clone, Copy)]
pub enum Form {
    /// Lines `key = value` without instances.
    Plain,
    /// Lines `name.key = value`, with `common.key` where a setting says so.
    Named(Instances),
    /// Lines `name = value`: each key is an instance's name, and there is one setting.
    Keyed(Instances),
}

/// Access to the instances of a section in the description.
#[derive(Clone, Copy)]
pub struct Instances {
    /// Noun for an instance in messages: `motor`, `switch`.
    pub noun: &'static str,
    /// Finds the place of an existing instance.
    pub find: fn(&MachineConfig, &str) -> Option<usize>,
    /// Makes a place for a new instance.
    pub create: fn(&mut MachineConfig, &str) -> Result<usize, CannotCreate>,
    /// Returns the name of the instance at a place.
    pub name: fn(&MachineConfig, usize) -> &str,
    /// Returns whether the instance at a place takes part, so that its pins are claimed.
    pub is_live: fn(&MachineConfig, usize) -> bool,
}

/// Reason why an instance cannot be made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CannotCreate {
    /// There are this many already.
    Full(usize),
    /// Only these names exist.
    UnknownName(&'static [&'static str]),
    /// The name is longer than 24 characters.
    NameTooLong,
}

/// A setting of the schema. There are some 700 rows, so rare or often repeated data is behind a reference.
#[derive(Clone, Copy)]
pub struct Setting {
    /// The key, without the instance's name.
    pub key: &'static str,
    /// Whether the key is `common.key` rather than `name.key` (or `key`, in a plain section).
    pub is_common: bool,
    /// Type, range and place in the description.
    pub kind: Kind,
    /// Unit of the value in the file.
    pub unit: Unit,
    /// Typical range of machines, where a wrong unit is an easy slip. Values beyond it are taken, with a
    /// warning.
    pub typical: Option<&'static (f64, f64)>,
    /// Whether Velvet can do no more than `typical`: a value beyond is taken as the nearest within, with a
    /// warning.
    pub is_limited: bool,
    /// Default for [`Setting::fallback`]: the text, and whether a missing text is derived.
    default: Option<&'static str>,
    is_derived: bool,
    /// Defaults of instances with these names, and of boards with these drivers (`tmc2660 board`).
    pub by_name: &'static ByName,
    /// Documentation of the setting.
    pub docs: Docs,
    /// Name in Smoothieware v1, with `<axis>` or `<name>`; empty for none.
    pub v1: &'static str,
    /// Section of Klipper with the nearest setting.
    pub klipper_section: KlipperSection,
    /// Whether Velvet acts on it.
    pub support: &'static Support,
}

/// Defaults of some instances: name and value.
pub struct ByName(pub &'static [(&'static str, &'static str)]);

/// The words that a setting takes.
#[derive(Debug, PartialEq, Eq)]
pub struct Words(pub &'static [&'static str]);

/// Meaning of a missing line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fallback {
    /// The default value, read as if the file contained it.
    Value(&'static str),
    /// The value is worked out from other settings.
    Derived,
    /// No default: the line must be there when the instance is used.
    Required,
}

/// Firmware that had a setting first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Since {
    /// Setting taken over from Smoothieware.
    Smoothieware,
    /// Setting of Velvet only.
    Velvet,
}

/// Whether Velvet acts on a setting.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Support {
    /// Velvet acts on the setting.
    Now,
    /// Not yet: a value other than the default is reported, with this advice.
    NotYet {
        /// Severity of going without the setting.
        severity: Severity,
        /// Advice for a replacement.
        advice: &'static str,
    },
    /// Never: there is nothing left for it to change. A value other than the default is reported with the
    /// reason.
    Needless {
        /// Reason why nothing needs the setting.
        why: &'static str,
    },
    /// Part of a function whose own switch is [`Support::NotYet`]; without that switch it does nothing
    /// anyway.
    Dormant,
}

/// Puts a value of type `T` into the description; the number is the instance's place.
pub type Set<T> = fn(&mut MachineConfig, usize, T);

/// The type of a setting, the values it takes, and where they go.
#[derive(Clone, Copy)]
pub enum Kind {
    /// Boolean, `true` or `false`.
    Bool(Set<bool>),
    /// A whole number from `.0` to `.1`.
    Integer(&'static (i64, i64), Set<i64>),
    /// A number from `.0` to `.1`.
    Number(&'static (f64, f64), Set<f64>),
    /// Given number of numbers, with commas between; an empty value stands for none.
    Numbers(usize, for<'v> fn(&mut MachineConfig, usize, &'v [f64])),
    /// Up to the given number of places, X and Y each, with commas or blanks between the numbers; an empty
    /// value stands for none.
    Places(usize, for<'v> fn(&mut MachineConfig, usize, &'v [[f64; 2]])),
    /// Word of the list, in either case.
    Word(&'static Words, Set<usize>),
    /// Text of at most this many bytes.
    Text(usize, for<'v> fn(&mut MachineConfig, usize, &'v str)),
    /// A G or M code such as `M106` or `M106.1`; an empty value stands for none.
    Command(Set<Option<crate::machine::CommandCode>>),
    /// Five hexadecimal numbers with commas between; an empty value stands for none.
    Registers(Set<Option<[u32; 5]>>),
    /// Axis letters, as in `ZXY`.
    Axes(for<'v> fn(&mut MachineConfig, usize, &'v [units::Axis])),
    /// Pin with the given capability.
    Pin(PinRole, Set<Option<PinName>>),
    /// A voltage input and an optional scale: `ADC3_5,11`.
    Voltage(Set<(crate::pin::VoltageInput, f64)>),
}

/// Capability that a setting needs of its pin.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PinRole {
    /// A GPIO output pin.
    Output,
    /// A GPIO input, read now and then.
    Input,
    /// A GPIO input, read now and then, or `external`.
    Button,
    /// A GPIO input that needs an interrupt line of its own.
    Interrupt,
    /// A GPIO output or a timer channel.
    OutputOrPwm,
    /// A channel of a PWM timer.
    Pwm,
    /// An analogue thermistor input.
    Thermistor,
}

impl Section {
    /// Returns the instances, when the section has any.
    #[must_use]
    pub const fn instances(&self) -> Option<&Instances> {
        match &self.form {
            Form::Plain => None,
            Form::Named(instances) | Form::Keyed(instances) => Some(instances),
        }
    }

    /// Returns the place of a setting in [`Section::settings`].
    #[must_use]
    pub fn position(&self, key: &str, is_common: bool) -> Option<usize> {
        self.settings.iter().position(|setting| setting.key == key && setting.is_common == is_common)
    }
}

impl Setting {
    /// Returns the meaning of a missing line.
    #[must_use]
    pub const fn fallback(&self) -> Fallback {
        match (self.default, self.is_derived) {
            (Some(text), _) => Fallback::Value(text),
            (None, true) => Fallback::Derived,
            (None, false) => Fallback::Required,
        }
    }

    /// Returns the default of the instance with this name, as text; none when it has to be derived or
    /// written.
    #[must_use]
    pub fn default_for(&self, instance: &str) -> Option<&'static str> {
        let own = self.by_name.0.iter().find(|(name, _)| *name == instance);
        own.map_or(self.default, |&(_, value)| Some(value))
    }
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
