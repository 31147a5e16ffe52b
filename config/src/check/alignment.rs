//! Checks of `[z alignment]`, `[bed screws]` and related sections: motors exist, points suffice, and the
//! probe can reach them.

use super::findings::Checks;
use crate::machine::{HomingDirection, MachineConfig};
use heapless::{String, Vec};
use units::{Actuator, Axis};

const ALIGNMENT: &str = "z alignment";
const SCREWS: &str = "bed screws";
/// Points nearer than this to one line tell nothing of what lies beside it, mm.
const LEAST_ASIDE: f64 = 10.0;

pub(super) fn check(checks: &mut Checks<'_, '_>) {
    alignment(checks);
    screws(checks);
    twist(checks);
    thermal(checks);
}

fn alignment(checks: &mut Checks<'_, '_>) {
    let config = checks.config;
    let ours = &config.z_alignment;
    if ours.motors.is_empty() && ours.points.is_empty() {
        return;
    }
    let count = ours.motors.len();
    let motors = z_motors(config);
    if count != motors.len() || count < 2 {
        let mut names: String<64> = String::new();
        for motor in &motors {
            // The names of all motors fit.
            let _ = names.push_str(if names.is_empty() { "" } else { " " }).and_then(|()| names.push_str(motor.name()));
        }
        let reason = format_args!("{count} places are written, but the motors of Z are {}: {names}", motors.len());
        let fix = format_args!("write one place for gamma and one for each motor with slaved_to = gamma, two at least");
        checks.error((ALIGNMENT, 0, "motors"), reason, fix);
    } else if !tells(&ours.motors, count) {
        let reason = format_args!("the motors stand in one line or in one place");
        checks.error((ALIGNMENT, 0, "motors"), reason, format_args!("write where each carries the bed or the gantry"));
    }
    if !config.probe.enable {
        let reason = format_args!("there is no probe to align by");
        checks.error((ALIGNMENT, 0, "points"), reason, format_args!("configure [zprobe], or leave the section out"));
    }
    if ours.points.len() < count {
        let reason = format_args!("{} points are too few for {count} motors", ours.points.len());
        checks.error((ALIGNMENT, 0, "points"), reason, format_args!("write one near each motor"));
    } else if !tells(&ours.points, count) {
        let reason = format_args!("points in one line do not tell how {count} motors stand");
        checks.error((ALIGNMENT, 0, "points"), reason, format_args!("write one near each motor"));
    }
    reach(checks, (ALIGNMENT, "points"), true);
}

fn thermal(checks: &mut Checks<'_, '_>) {
    const SECTION: &str = "z thermal adjust";
    let config = checks.config;
    let ours = &config.z_thermal;
    if ours.sensor.is_empty() {
        if ours.coefficient != 0.0 {
            let reason = format_args!("nothing tells how warm the frame is");
            checks.error((SECTION, 0, "coefficient"), reason, format_args!("write sensor, a [temperature control]"));
        }
        return;
    }
    if !config.temperatures.iter().any(|control| control.enable && control.name == ours.sensor) {
        let reason = format_args!("there is no [temperature control] {}", ours.sensor);
        checks.error((SECTION, 0, "sensor"), reason, format_args!("write the name of one that is enabled"));
    }
}

fn twist(checks: &mut Checks<'_, '_>) {
    const SECTION: &str = "axis twist compensation";
    let config = checks.config;
    let ours = &config.axis_twist;
    let is_measured = ours.start != ours.end;
    if (is_measured || !ours.points.is_empty()) && !config.probe.enable {
        let reason = format_args!("there is no probe that could read wrongly");
        checks.error((SECTION, 0, "points"), reason, format_args!("configure [zprobe], or leave the section out"));
    }
    if is_measured && config.homing.delta {
        let reason = format_args!("a delta has no rail that twists");
        checks.error((SECTION, 0, "start"), reason, format_args!("leave the section out; G32 calibrates a delta"));
    }
    if ours.points.windows(2).any(|pair| matches!(pair, [[a, _], [b, _]] if b <= a)) {
        let reason = format_args!("the places do not rise");
        checks.error(
            (SECTION, 0, "points"),
            reason,
            format_args!("write them from the lowest on, place,difference each"),
        );
    }
}

fn screws(checks: &mut Checks<'_, '_>) {
    let screws = &checks.config.bed_screws.screws;
    if screws.len() == 1 || (screws.len() > 2 && !tells(screws, 3)) {
        let reason = format_args!("these screws level nothing");
        let fix = format_args!("write where each of them is, two at least, and not all in one line");
        checks.error((SCREWS, 0, "screws"), reason, fix);
    }
    reach(checks, (SCREWS, "screws"), false);
}

/// Gamma and its slaves, in their order.
fn z_motors(config: &MachineConfig) -> Vec<Actuator, 6> {
    let of_z =
        |motor: &Actuator| *motor == Actuator::Gamma || config.actuators[*motor].slaved_to == Some(Actuator::Gamma);
    Actuator::ALL.into_iter().filter(|motor| config.actuators[*motor].present).filter(of_z).collect()
}

/// Whether places are apart (two motors), and not all near one line (more).
fn tells(places: &[[f64; 2]], motors: usize) -> bool {
    let Some(first) = places.first() else { return false };
    let from_first = |place: &[f64; 2]| [place[0] - first[0], place[1] - first[1]];
    let size_sq = |way: [f64; 2]| way[0] * way[0] + way[1] * way[1];
    let furthest = places.iter().map(from_first).fold([0.0; 2], |a, b| if size_sq(b) > size_sq(a) { b } else { a });
    if size_sq(furthest) < LEAST_ASIDE * LEAST_ASIDE {
        return false;
    }
    // Twice the triangle's area is its base times its height: squares, which need no root.
    let aside = |place: &[f64; 2]| {
        let way = from_first(place);
        let area = way[0] * furthest[1] - way[1] * furthest[0];
        area * area >= LEAST_ASIDE * LEAST_ASIDE * size_sq(furthest)
    };
    motors < 3 || places.iter().any(aside)
}

/// Checks that the probe, or the nozzle, can reach every point.
fn reach(checks: &mut Checks<'_, '_>, (section, key): (&'static str, &'static str), by_probe: bool) {
    let config = checks.config;
    let places: &[[f64; 2]] = if section == ALIGNMENT { &config.z_alignment.points } else { &config.bed_screws.screws };
    let offsets = if by_probe { config.probe_offsets() } else { [0.0; 3] };
    for place in places {
        for axis in [Axis::X, Axis::Y] {
            let at = axis as usize;
            let [wanted, offset] = [place.get(at), offsets.get(at)].map(|value| value.copied().unwrap_or(0.0));
            let nozzle = wanted - offset;
            let Some([least, most]) = travel(config, axis) else { continue };
            if nozzle < least || nozzle > most {
                let letter = axis.letter();
                let reason = format_args!(
                    "at {},{} the nozzle would be at {letter}{nozzle}, and {letter} goes from {least} to {most}",
                    place[0], place[1]
                );
                let fix = format_args!("move the point, or write [soft endstop] and probe_offsets as they are");
                return checks.error((section, 0, key), reason, fix);
            }
        }
    }
}

/// Returns the travel of an axis, where it is limited: see `[soft endstop]`.
fn travel(config: &MachineConfig, axis: Axis) -> Option<[f64; 2]> {
    if !config.soft_endstops.enable || config.homing.delta || config.homing.rotary_delta || config.homing.scara {
        return None;
    }
    let stop = config.homing_endstop(axis)?;
    let (at, way) = (stop.homing_position.0, stop.max_travel.0);
    let [least, most] = match stop.homing_direction {
        HomingDirection::ToMin => [at, at + way],
        HomingDirection::ToMax => [at - way, at],
        HomingDirection::None => return None,
    };
    let written = |ends: &[Option<units::Mm>; 3]| ends.get(axis as usize).copied().flatten().map(|mm| mm.0);
    Some([written(&config.soft_endstops.least).unwrap_or(least), written(&config.soft_endstops.most).unwrap_or(most)])
}
