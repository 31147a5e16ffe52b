//! Predefined named parameters, which give the modes in force (LinuxCNC's G-code overview, "Predefined named
//! parameters" and "System Parameters").

use units::Axis;

use crate::interpreter::Interpreter;
use crate::parameters::coordinate;
use crate::state::auxiliary::Spindle;
use crate::state::cycle::Retract;
use crate::state::modal::{FeedMode, MotionMode};

/// Parses a part of the version from `Cargo.toml`.
const fn part(text: &str) -> f64 {
    let (bytes, mut value, mut place) = (text.as_bytes(), 0.0, 0);
    while place < bytes.len() {
        value = value * 10.0 + (bytes[place] - b'0') as f64;
        place += 1;
    }
    value
}

/// Major and minor version as one number: 0.1.
const MAJOR: f64 = part(env!("CARGO_PKG_VERSION_MAJOR")) + part(env!("CARGO_PKG_VERSION_MINOR")) / 10.0;
/// Patch level of the version, as tenths.
const MINOR: f64 = part(env!("CARGO_PKG_VERSION_PATCH")) / 10.0;

/// Returns the value of a predefined parameter; `None` for an unknown name.
pub(crate) fn predefined(program: &Interpreter, name: &str) -> Option<f64> {
    let modal = &program.modal;
    let auxiliary = &modal.auxiliary;
    let truth = |is: bool| f64::from(u8::from(is));
    let tenfold = |code: gcode::Code| f64::from(code.number) * 10.0 + f64::from(code.subcode);
    Some(match name.strip_prefix('_')? {
        axis @ ("x" | "y" | "z" | "a" | "b" | "c") => {
            coordinate(modal, axis_named(axis)?, &modal.work(&program.position))
        }
        axis @ ("abs_x" | "abs_y" | "abs_z" | "abs_a" | "abs_b" | "abs_c") => {
            coordinate(modal, axis_named(axis.strip_prefix("abs_")?)?, &program.position)
        }
        "u" | "v" | "w" | "abs_u" | "abs_v" | "abs_w" => 0.0,
        "vmajor" => MAJOR,
        "vminor" => MINOR,
        "feed" if modal.feed_mode == FeedMode::PerRevolution => modal.in_program_units(modal.feed_per_turn),
        "feed" => modal.in_program_units(modal.feed_rate.0) * 60.0,
        "rpm" => f64::from(modal.auxiliary.speed.unwrap_or(0.0)),
        "metric" => truth(!modal.inches),
        "imperial" => truth(modal.inches),
        "metric_machine" => 1.0,
        "absolute" => truth(modal.absolute),
        "incremental" => truth(!modal.absolute),
        "inverse_time" => truth(modal.feed_mode == FeedMode::InverseTime),
        "units_per_minute" => truth(modal.feed_mode == FeedMode::PerMinute),
        "units_per_rev" => truth(modal.feed_mode == FeedMode::PerRevolution),
        "motion_mode" => tenfold(modal.motion_code()),
        "plane" => match modal.plane {
            units::Plane::Xy => 170.0,
            units::Plane::Xz => 180.0,
            units::Plane::Yz => 190.0,
        },
        "ccomp" => 400.0,
        "coord_system" => 540.0 + 10.0 * modal.system.min(5) as f64 + modal.system.saturating_sub(5) as f64,
        "tool_offset" => truth(modal.has_tool_length),
        "retract_old_z" => truth(modal.retract == Retract::Initial),
        "retract_r_plane" => truth(modal.retract == Retract::RPlane),
        "ijk_absolute_mode" => truth(modal.arc_absolute),
        "lathe_diameter_mode" => truth(modal.diameters),
        "lathe_radius_mode" => truth(!modal.diameters),
        "spindle_rpm_mode" => truth(!auxiliary.surface_speed),
        "spindle_css_mode" => truth(auxiliary.surface_speed),
        "spindle_on" => truth(auxiliary.spindle != Spindle::Stopped),
        "spindle_cw" => truth(auxiliary.spindle == Spindle::Clockwise),
        "mist" => truth(auxiliary.mist),
        "flood" => truth(auxiliary.flood),
        "feed_override" => truth(auxiliary.feed_override),
        "speed_override" => truth(auxiliary.spindle_override),
        "adaptive_feed" => 0.0,
        "feed_hold" => 1.0,
        "current_tool" => f64::from(program.tools.number()),
        "selected_tool" => f64::from(program.tools.selected),
        "current_pocket" => program.tools.pocket(program.tools.in_spindle),
        "selected_pocket" => program.tools.pocket(program.tools.selected),
        "line" => f64::from(program.line),
        "call_level" => program.flow.depth() as f64,
        "remap_level" => 0.0,
        "task" => truth(!program.setup.is_preview),
        "is_rapid" => truth(modal.motion == MotionMode::Rapid),
        _ => return None,
    })
}

fn axis_named(letter: &str) -> Option<Axis> {
    Axis::ALL.into_iter().find(|axis| letter.eq_ignore_ascii_case(axis.letter().encode_utf8(&mut [0; 4])))
}
