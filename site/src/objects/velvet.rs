//! Fields that Moonraker has no words for: `docs/api.md`, object `velvet`.

use base::snapshot::{LaserShown, Snapshot, SpindleShown};
use http::json::Writer;
use program::{Spindle, State};

use super::{under_way, write_numbers};
use crate::remedies::remedy;

/// Names of the coordinate systems.
const SYSTEMS: [&str; 9] = ["G54", "G55", "G56", "G57", "G58", "G59", "G59.1", "G59.2", "G59.3"];

/// Writes the first part of the object, which stays open.
pub(super) fn write(of: &Snapshot, json: &mut Writer<'_, '_>) {
    json.key("machine");
    json.text(match of.laser {
        _ if !of.heaters.is_empty() => "printer",
        Some(_) if of.spindle.is_none() => "laser",
        _ => "mill",
    });
    json.key("mode");
    json.text(if of.state == State::Invalid { "Alarm" } else { of.state.name() });
    json.key("axes");
    json.begin_array();
    ["x", "y", "z"].into_iter().for_each(|axis| json.text(axis));
    json.end_array();
    json.key("work_position");
    write_numbers(of.work.0.into_iter().take(3), json);
    json.key("coordinates");
    json.begin_object();
    json.key("active");
    json.text(SYSTEMS.get(usize::from(of.system)).unwrap_or(&"G54"));
    json.key("offsets");
    json.begin_array();
    for (name, offset) in SYSTEMS.into_iter().zip(of.systems) {
        json.begin_object();
        json.key("name");
        json.text(name);
        json.key("at");
        write_numbers(offset, json);
        json.end_object();
    }
    json.end_array();
    json.end_object();
    json.key("overrides");
    json.begin_object();
    for (key, factor) in [
        ("feed", of.feed_factor),
        ("rapid", of.rapid_factor),
        ("spindle", of.spindle.as_ref().map_or(1.0, |spindle| f64::from(spindle.factor))),
    ] {
        json.key(key);
        json.float(factor, 3);
    }
    json.end_object();
    write_job(of, json);
}

fn write_job(of: &Snapshot, json: &mut Writer<'_, '_>) {
    let job = under_way(of);
    json.key("job");
    json.begin_object();
    json.key("left_s");
    json.float(job.and_then(|job| job.left_s).map_or(f64::NAN, f64::from), 0);
    json.key("line");
    json.number(job.map_or(0, |job| u64::from(job.line)));
    json.key("is_heating");
    json.bool(job.is_some_and(|job| job.is_heating));
    json.key("is_suspended");
    json.bool(of.is_suspended);
    json.end_object();
}

/// Writes the rest of the object. `fault` is what the machine said when it halted.
pub(super) fn write_rest(of: &Snapshot, fault: Option<&str>, json: &mut Writer<'_, '_>) {
    json.key("fault");
    match fault.filter(|_| of.state == State::Alarm) {
        Some(text) => {
            json.begin_object();
            for (key, text) in [("code", "halt"), ("text", text), ("remedy", remedy(text))] {
                json.key(key);
                json.text(text);
            }
            json.end_object();
        }
        None => json.null(),
    }
    json.key("tool");
    match of.tool {
        Some((number, length)) => {
            json.begin_object();
            json.key("number");
            json.number(u64::from(number));
            json.key("name");
            json.text("");
            json.key("length");
            json.float(length, 3);
            json.end_object();
        }
        None => json.null(),
    }
    write_spindle(of.spindle.as_ref(), json);
    write_laser(of.laser.as_ref(), json);
    json.key("coolant");
    match of.coolant {
        Some(on) => {
            json.begin_object();
            for (key, on) in ["flood", "mist"].into_iter().zip(on) {
                json.key(key);
                json.bool(on);
            }
            json.end_object();
        }
        None => json.null(),
    }
    write_inputs(of, json);
    json.key("macros");
    json.number(u64::from(of.macros));
}

fn write_spindle(spindle: Option<&SpindleShown>, json: &mut Writer<'_, '_>) {
    json.key("spindle");
    let Some(spindle) = spindle else { return json.null() };
    json.begin_object();
    for (key, speed) in [("rpm", spindle.set), ("target", spindle.asked), ("max_rpm", spindle.most)] {
        json.key(key);
        json.float(f64::from(speed), 1);
    }
    json.key("direction");
    json.text(match spindle.direction {
        Spindle::Stopped => "off",
        Spindle::Clockwise => "clockwise",
        Spindle::CounterClockwise => "counterclockwise",
    });
    json.end_object();
}

fn write_laser(laser: Option<&LaserShown>, json: &mut Writer<'_, '_>) {
    json.key("laser");
    let Some(laser) = laser else { return json.null() };
    json.begin_object();
    json.key("power");
    json.float(f64::from(laser.power), 3);
    json.key("mode");
    json.text(match laser.mode {
        Spindle::Stopped => "off",
        Spindle::Clockwise => "M3",
        Spindle::CounterClockwise => "M4",
    });
    for (key, is_so) in [("on", laser.power > 0.0), ("test", laser.is_test), ("framing", laser.is_framing)] {
        json.key(key);
        json.bool(is_so);
    }
    json.key("open");
    json.begin_array();
    laser.open.split_terminator(',').for_each(|name| json.text(name));
    json.end_array();
    json.end_object();
}

fn write_inputs(of: &Snapshot, json: &mut Writer<'_, '_>) {
    json.key("limits");
    json.begin_object();
    for limit in &of.limits {
        let mut name = heapless::String::<8>::new();
        // A letter and its end fit.
        let _ = name.push(limit.axis.letter().to_ascii_lowercase());
        let _ = name.push_str(match limit.end {
            Some(false) => "_min",
            Some(true) => "_max",
            None => "_limit",
        });
        json.key(&name);
        json.bool(limit.is_pressed);
    }
    json.end_object();
    json.key("probe");
    match &of.probe {
        Some(probe) => {
            json.begin_object();
            json.key("is_triggered");
            json.bool(probe.touches);
            json.key("last");
            match probe.last {
                Some(place) => write_numbers(place, json),
                None => json.null(),
            }
            json.end_object();
        }
        None => json.null(),
    }
}
