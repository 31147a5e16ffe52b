//! Generic cartesian kinematics: carriages are axes, and motors move sums of them.

use super::super::account::{Class, Verdict};
use super::super::migration::{Migration, text};
use super::super::source::{Section, number};
use super::endstops;

const AXES: [&str; 3] = ["x", "y", "z"];
const MOTORS: [&str; 3] = ["alpha", "beta", "gamma"];

/// Returns the axis of a carriage by its name; that of another carriage on the same rail counts as its own.
fn axis_of(m: &Migration<'_>, name: &str) -> Option<usize> {
    let named = |kind: &str| m.source.sections.iter().find(|of| of.kind() == kind && of.label() == name);
    if let Some(extra) = named("extra_carriage") {
        return axis_of_first(m, extra.get("primary_carriage")?.trim());
    }
    axis_of_first(m, name)
}

fn axis_of_first(m: &Migration<'_>, name: &str) -> Option<usize> {
    let carriage = m.source.sections.iter().find(|of| of.kind() == "carriage" && of.label() == name)?;
    let axis = carriage.get("axis").unwrap_or(name).trim().to_lowercase();
    AXES.iter().position(|known| *known == axis)
}

/// Reads `carriage_x-0.5*carriage_y` as what a millimetre of X, of Y and of Z adds.
fn factors(m: &Migration<'_>, sum: &str) -> Option<[f64; 3]> {
    let plain: String = sum.chars().filter(|c| !c.is_whitespace()).collect();
    let mut out = [0.0; 3];
    for part in plain.replace('-', "+-").split('+').filter(|part| !part.is_empty()) {
        let (sign, part) = part.strip_prefix('-').map_or((1.0, part), |rest| (-1.0, rest));
        let (factor, name) = match part.split_once('*') {
            Some((a, b)) if number(a).is_some() => (number(a)?, b),
            Some((a, b)) => (number(b)?, a),
            None => (1.0, part),
        };
        *out.get_mut(axis_of(m, name)?)? += sign * factor;
    }
    Some(out)
}

fn is_motor(section: &Section) -> bool {
    section.kind() == "stepper" && section.get("carriages").is_some()
}

/// Finds the motors: alpha, beta and gamma for X, Y and Z, first those that move one axis alone; what moves
/// the same way follows one of them.
pub fn plan(m: &mut Migration<'_>) {
    let all: Vec<(String, [f64; 3])> = (m.source.sections.iter())
        .filter(|section| is_motor(section))
        .filter_map(|section| Some((section.name.clone(), factors(m, section.get("carriages")?)?)))
        .collect();
    let mut rows: Vec<(&'static str, [f64; 3])> = Vec::new();
    let is_alone = |row: &[f64; 3]| row.iter().filter(|factor| **factor != 0.0).count() == 1;
    let (alone, mixed): (Vec<_>, Vec<_>) = all.into_iter().partition(|(_, row)| is_alone(row));
    for (name, row) in alone.into_iter().chain(mixed) {
        if let Some((master, _)) = rows.iter().find(|(_, known)| *known == row) {
            m.slaves.insert(name, *master);
            continue;
        }
        let is_free = |motor: &str| rows.iter().all(|(taken, _)| *taken != motor);
        if let Some(place) = (0..3).find(|axis| row[*axis] != 0.0 && is_free(MOTORS[*axis])) {
            rows.push((MOTORS[place], row));
            m.motors.insert(name, MOTORS[place]);
        }
    }
}

/// Converts what a motor moves.
pub fn motor(m: &mut Migration<'_>, section: usize, motor: &'static str) {
    let Some(row) = m.section(section).get("carriages").and_then(|sum| factors(m, sum)) else { return };
    let value = row.map(text).join(",");
    match m.slaves.contains_key(&m.section(section).name) {
        true => m.merged(section, "carriages", "it moves as another motor does", ""),
        false => m.put(section, "carriages", ("generic cartesian", "", motor), value),
    }
}

/// Converts `[carriage NAME]`: the switch and the travel of an axis.
pub fn carriage(m: &mut Migration<'_>, section: usize) {
    let Some(axis) = axis_of_first(m, &m.section(section).label()) else {
        return m.judge_rest(section, &Verdict::refused("it names no axis x, y or z", "[endstops]"));
    };
    m.merged(section, "axis", "the axis of its switch and its travel", "");
    endstops::of_axis(m, section, MOTORS[axis]);
    m.judge_section(section, Verdict::new(Class::Converted, "an axis: its switch and its travel"));
}
