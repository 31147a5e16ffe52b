//! The machine's state as objects of Moonraker's API, which pages and slicers know, and `velvet` with what
//! that lacks.
//!
//! Shapes are Klipper's status reference and Moonraker's "printer objects" documentation.

use base::snapshot::{FanShown, HeaterShown, JobEnd, JobShown, Snapshot};
use http::Made;
use http::json::{Next, Parts, Writer};
use program::State;
use units::{Axis, MAX_HEATERS};

use crate::assets::fnv;
use crate::mesh::{self, Heights};
use crate::messages::{MESSAGES, Messages};

mod velvet;

/// Object of the machine's state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Object {
    Webhooks,
    Toolhead,
    GcodeMove,
    MotionReport,
    Heaters,
    PrintStats,
    VirtualSdcard,
    DisplayStatus,
    IdleTimeout,
    Messages,
    BedMesh,
    Velvet,
    /// Heater or sensor, by its place in the snapshot.
    Heater(u8),
    /// Fan, by its place in the snapshot.
    Fan(u8),
}

const FIXED: [(Object, &str); 12] = [
    (Object::Webhooks, "webhooks"),
    (Object::Toolhead, "toolhead"),
    (Object::GcodeMove, "gcode_move"),
    (Object::MotionReport, "motion_report"),
    (Object::Heaters, "heaters"),
    (Object::PrintStats, "print_stats"),
    (Object::VirtualSdcard, "virtual_sdcard"),
    (Object::DisplayStatus, "display_status"),
    (Object::IdleTimeout, "idle_timeout"),
    (Object::Messages, "velvet_messages"),
    (Object::BedMesh, "bed_mesh"),
    (Object::Velvet, "velvet"),
];

/// Most objects of a machine.
pub const MAX_OBJECTS: usize = FIXED.len() + MAX_HEATERS + base::snapshot::MAX_SHOWN_FANS;
/// Longest name of an object: `heater_generic` and a name.
pub const NAME_BYTES: usize = 48;

/// Longest text of an object that is looked at for changes.
const OBJECT_BYTES: usize = 960;

/// Set of objects, a bit for each place.
pub type Objects = u32;

/// Name of an object.
pub type Name = heapless::String<NAME_BYTES>;

/// Returns the object at a place; none if this machine has none there.
#[must_use]
pub fn at(place: usize, of: &Snapshot) -> Option<Object> {
    if let Some((object, _)) = FIXED.get(place) {
        return Some(*object);
    }
    let rest = place - FIXED.len();
    if rest < MAX_HEATERS {
        return (rest < of.heaters.len()).then_some(Object::Heater(rest as u8));
    }
    let fan = rest - MAX_HEATERS;
    (fan < of.fans.len()).then_some(Object::Fan(fan as u8))
}

/// Returns the name of the object at a place.
#[must_use]
pub fn name(place: usize, of: &Snapshot) -> Option<Name> {
    let mut name = Name::new();
    // The names fit: the longest prefix has 19 bytes, a name 24.
    let mut add = |prefix: &str, own: &str| {
        let _ = name.push_str(prefix);
        let _ = name.push_str(own);
    };
    match at(place, of)? {
        Object::Heater(heater) => match heater_kind(of, usize::from(heater))? {
            (HeaterKind::Bed, _) => add("heater_bed", ""),
            (HeaterKind::Extruder, 0) => add("extruder", ""),
            (HeaterKind::Extruder, 1) => add("extruder1", ""),
            (HeaterKind::Extruder, _) => add("extruder2", ""),
            (HeaterKind::Other, _) => add("heater_generic ", &of.heaters.get(usize::from(heater))?.name),
            (HeaterKind::Sensor, _) => add("temperature_sensor ", &of.heaters.get(usize::from(heater))?.name),
        },
        Object::Fan(0) => add("fan", ""),
        Object::Fan(fan) => add("fan_generic ", &of.fans.get(usize::from(fan))?.name),
        _ => add(FIXED.get(place)?.1, ""),
    }
    Some(name)
}

/// Returns the name of the heater or sensor at a place of the snapshot.
#[must_use]
pub fn heater_name(heater: usize, of: &Snapshot) -> Option<Name> {
    name(FIXED.len() + heater, of)
}

/// Kind of a heater.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum HeaterKind {
    Extruder,
    Bed,
    Other,
    /// A sensor without a heater.
    Sensor,
}

fn kind(heater: &HeaterShown) -> HeaterKind {
    match heater.designator.as_bytes().first() {
        _ if !heater.heats => HeaterKind::Sensor,
        Some(b'T') => HeaterKind::Extruder,
        Some(b'B') if heater.designator.len() == 1 => HeaterKind::Bed,
        _ => HeaterKind::Other,
    }
}

/// Returns the kind of a heater, and how many of its kind precede.
fn heater_kind(of: &Snapshot, place: usize) -> Option<(HeaterKind, usize)> {
    let own = kind(of.heaters.get(place)?);
    let before = of.heaters.iter().take(place).filter(|heater| kind(heater) == own).count();
    // A second bed is a heater as any other.
    Some(if own == HeaterKind::Bed && before > 0 { (HeaterKind::Other, before) } else { (own, before) })
}

/// Returns the object of this name, as a set of one; empty if there is none.
#[must_use]
pub fn named(asked: &str, of: &Snapshot) -> Objects {
    let place = (0..MAX_OBJECTS).find(|place| name(*place, of).is_some_and(|name| name == asked));
    place.map_or(0, |place| 1 << place)
}

/// Objects of the machine, with what is told of it beside the snapshot.
#[derive(Clone, Copy, Debug)]
pub struct Told<'t> {
    /// The machine as it was shown last.
    pub of: &'t Snapshot,
    /// Words of the machine when it halted.
    pub fault: Option<&'t str>,
    /// Heights of the bed.
    pub heights: &'t Heights,
    /// Messages of the machine.
    pub messages: &'t Messages,
}

/// Parts in which objects are written: one for each, and a second one for `velvet`; those of the mesh; one
/// for each message.
const MESH: usize = MAX_OBJECTS + 1;
const WORDS: usize = MESH + 1 + mesh::PARTS;
/// Most parts in which objects are written.
pub const PARTS: usize = WORDS + MESSAGES;
/// Part that has the rest of `velvet`, behind its first.
const REST: usize = FIXED.len();
/// Places of the mesh and of messages, which are written behind all others.
const MESH_PLACE: usize = REST - 2;
const WORDS_PLACE: usize = REST - 3;

/// Writes a part of the objects of a set.
pub fn write_part(part: usize, set: Objects, told: &Told<'_>, json: &mut Writer<'_, '_>) {
    let Told { of, fault, heights, messages } = *told;
    let place = match part {
        ..REST => part,
        REST..MESH => part - 1,
        MESH..WORDS => MESH_PLACE,
        _ => WORDS_PLACE,
    };
    if set & 1 << place == 0 || matches!(place, MESH_PLACE | WORDS_PLACE) && part < MESH {
        return;
    }
    if part == REST {
        velvet::write_rest(of, fault, json);
        json.end_object();
    } else if part >= WORDS {
        if part == WORDS {
            write(place, of, fault, json);
        }
        messages.write(part - WORDS, json);
        if part + 1 == PARTS {
            json.end_array();
            json.end_object();
        }
    } else if part > MESH {
        mesh::write(part - MESH - 1, of, heights, json);
    } else {
        write(place, of, fault, json);
    }
}

/// Writes the object at a place: its name and its fields; of `velvet` the first part.
fn write(place: usize, of: &Snapshot, fault: Option<&str>, json: &mut Writer<'_, '_>) {
    let (Some(object), Some(name)) = (at(place, of), name(place, of)) else { return };
    json.key(&name);
    json.begin_object();
    match object {
        Object::Webhooks => write_webhooks(of.state, json),
        Object::Toolhead => write_toolhead(of, json),
        Object::GcodeMove => write_gcode_move(of, json),
        Object::MotionReport => {
            json.key("live_position");
            write_numbers(of.position.0.into_iter().take(4), json);
            json.key("live_velocity");
            json.float(of.speed.0, 2);
        }
        Object::Heaters => write_heaters(of, json),
        Object::PrintStats => write_print_stats(of, fault, json),
        Object::VirtualSdcard => write_card(of.job.as_ref(), json),
        Object::DisplayStatus => {
            json.key("progress");
            json.float(of.job.as_ref().map_or(0.0, share), 4);
            json.key("message");
            json.null();
        }
        Object::IdleTimeout => {
            json.key("state");
            json.text(if under_way(of).is_some() || of.speed.0 > 0.0 { "Printing" } else { "Ready" });
        }
        Object::Messages => {
            json.key("messages");
            return json.begin_array();
        }
        Object::BedMesh => return mesh::begin(of, json),
        Object::Velvet => return velvet::write(of, json),
        Object::Heater(heater) => {
            of.heaters.get(usize::from(heater)).into_iter().for_each(|heater| write_heater(heater, json))
        }
        Object::Fan(fan) => of.fans.get(usize::from(fan)).into_iter().for_each(|fan| write_fan(fan, json)),
    }
    json.end_object();
}

/// Writes a list of numbers, in thousandths.
pub fn write_numbers(numbers: impl IntoIterator<Item = f64>, json: &mut Writer<'_, '_>) {
    json.begin_array();
    numbers.into_iter().for_each(|number| json.float(number, 3));
    json.end_array();
}

/// Returns the state of the machine as Klipper names it.
#[must_use]
pub const fn klippy_state(state: State) -> &'static str {
    match state {
        State::Alarm | State::Sleep => "shutdown",
        State::Invalid => "error",
        _ => "ready",
    }
}

fn write_webhooks(state: State, json: &mut Writer<'_, '_>) {
    json.key("state");
    json.text(klippy_state(state));
    json.key("state_message");
    json.text(match state {
        State::Alarm => "The machine is halted: see the console for why, then release it (M999).",
        State::Sleep => "The machine sleeps until it is reset.",
        State::Invalid => "The configuration has errors: see the console.",
        _ => "Printer is ready",
    });
}

fn write_toolhead(of: &Snapshot, json: &mut Writer<'_, '_>) {
    json.key("position");
    write_numbers(of.position.0.into_iter().take(4), json);
    json.key("homed_axes");
    let mut axes = heapless::String::<3>::new();
    // There is room for three letters.
    Axis::PRIMARY.into_iter().filter(|axis| of.homed.has(*axis)).for_each(|axis| drop(axes.push(axis.letter())));
    axes.make_ascii_lowercase();
    json.text(&axes);
    for (key, ends) in ["axis_minimum", "axis_maximum"].into_iter().zip(&of.ends) {
        json.key(key);
        write_numbers(ends.0.into_iter().take(3), json);
    }
    let (speed, acceleration) = of.most;
    json.key("max_velocity");
    json.float(speed.unwrap_or(f64::NAN), 1);
    json.key("max_accel");
    json.float(acceleration, 0);
}

/// Returns the job that is played or paused.
fn under_way(of: &Snapshot) -> Option<&JobShown> {
    of.job.as_ref().filter(|job| job.end.is_none())
}

fn write_gcode_move(of: &Snapshot, json: &mut Writer<'_, '_>) {
    json.key("gcode_position");
    write_numbers(of.work.0.into_iter().take(4), json);
    json.key("speed_factor");
    json.float(of.feed_factor, 3);
    json.key("speed");
    json.float(of.feed_rate.per_minute(), 1);
    json.key("extrude_factor");
    json.float(of.flow_factor, 3);
    json.key("homing_origin");
    write_numbers(of.shift, json);
    for (key, is_absolute) in ["absolute_coordinates", "absolute_extrude"].into_iter().zip(of.absolute) {
        json.key(key);
        json.bool(is_absolute);
    }
}

fn write_heaters(of: &Snapshot, json: &mut Writer<'_, '_>) {
    for (key, is_heaters) in [("available_heaters", true), ("available_sensors", false)] {
        json.key(key);
        json.begin_array();
        for (place, heater) in of.heaters.iter().enumerate() {
            if heater.heats || !is_heaters {
                heater_name(place, of).into_iter().for_each(|name| json.text(&name));
            }
        }
        json.end_array();
    }
}

/// Returns the share of the file that is done, 0 to 1.
fn share(job: &JobShown) -> f64 {
    f64::from(job.done) / f64::from(job.size.max(1))
}

fn write_print_stats(of: &Snapshot, fault: Option<&str>, json: &mut Writer<'_, '_>) {
    json.key("state");
    let state = of.job.as_ref().map_or("standby", |job| match job.end {
        Some(JobEnd::Complete) => "complete",
        Some(JobEnd::Cancelled) => "cancelled",
        Some(JobEnd::Halted) => "error",
        None if job.is_paused => "paused",
        None => "printing",
    });
    json.text(state);
    json.key("message");
    json.text(fault.filter(|_| state == "error").unwrap_or_default());
    let none = JobShown::default();
    let job = of.job.as_ref().unwrap_or(&none);
    json.key("filename");
    json.text(job.path.strip_prefix("/sd/").unwrap_or(&job.path));
    for key in ["total_duration", "print_duration"] {
        json.key(key);
        json.signed(i64::from(job.elapsed_s));
    }
    json.key("filament_used");
    json.float(f64::from(job.filament), 1);
    json.key("info");
    json.begin_object();
    for (key, layer) in [("total_layer", job.layers), ("current_layer", (job.layer > 0).then_some(job.layer))] {
        json.key(key);
        match layer {
            Some(layer) => json.number(u64::from(layer)),
            None => json.null(),
        }
    }
    json.end_object();
}

fn write_card(job: Option<&JobShown>, json: &mut Writer<'_, '_>) {
    json.key("progress");
    json.float(job.map_or(0.0, share), 4);
    json.key("is_active");
    json.bool(job.is_some_and(|job| !job.is_paused && job.end.is_none()));
    json.key("file_position");
    json.signed(job.map_or(0, |job| i64::from(job.done)));
    json.key("file_size");
    json.signed(job.map_or(0, |job| i64::from(job.size)));
}

fn write_heater(heater: &HeaterShown, json: &mut Writer<'_, '_>) {
    json.key("temperature");
    json.float(heater.reading.map_or(f64::NAN, |reading| f64::from(reading.0)), 1);
    if !heater.heats {
        return;
    }
    json.key("target");
    json.float(f64::from(heater.target.0), 1);
    json.key("power");
    json.float(f64::from(heater.power), 2);
    json.key("max_temp");
    json.float(f64::from(heater.max.0), 0);
}

fn write_fan(fan: &FanShown, json: &mut Writer<'_, '_>) {
    json.key("speed");
    json.float(f64::from(fan.power), 2);
    json.key("rpm");
    json.float(fan.rpm.map_or(f64::NAN, f64::from), 0);
}

/// Hash that tells whether an object is another than before.
#[must_use]
pub fn hash(place: usize, told: &Told<'_>) -> u32 {
    if place == MESH_PLACE {
        // The number changes with the heights.
        return told.of.mesh.map_or(0, |mesh| mesh.number ^ fnv(mesh.name.as_str().as_bytes()) as u32);
    }
    if place == WORDS_PLACE {
        return told.messages.taken();
    }
    let mut text = [0; OBJECT_BYTES];
    let mut hash = |part| {
        let made = Parts::new().make(&mut text, |_, json: &mut Writer<'_, '_>| {
            write_part(part, 1 << place, told, json);
            Next::End
        });
        let (Made::Part(used) | Made::Last(used)) = made else { return 0 };
        fnv(text.get(..used).unwrap_or_default()) as u32
    };
    let own = hash(if place < REST { place } else { place + 1 });
    if place + 1 == REST { own.rotate_left(1) ^ hash(REST) } else { own }
}

#[cfg(test)]
mod tests;
