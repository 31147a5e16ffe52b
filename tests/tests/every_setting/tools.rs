//! Settings of the sections `[extruder]` and `[drillingcycles]`.

use super::See::{Edges, Say};
use super::{Row, row};

/// A second extruder, on a driver of its own.
const SECOND: &[&str] = &[
    "[extruder] second.enable = true",
    "[extruder] second.tool_id = 1",
    "[actuator] epsilon.driver = external",
    "[actuator] epsilon.steps_per_mm = 400",
    "[actuator] epsilon.step_pin = PJ5",
    "[actuator] epsilon.dir_pin = PJ1",
];
const FEED: &[&str] = &["G91", "M83", "G1 E5 F600"];
const RETRACT: &[&str] = &["G91", "G1 Z1 F300", "G10", "G11"];
const LIFTED: &[&str] =
    &["[extruder] hotend.retract_zlift_length = 1", "[extruder] hotend.retract_zlift_feedrate = 600"];
const ADVANCED: &[&str] = &["G91", "M83", "G1 X20 E1 F3000"];

const DRILL: &[&str] = &["G91", "G82 X2 Z-1 R2 P0.2 F600"];

pub const ROWS: &[Row] = &[
    row("[extruder] hotend.enable", "true", "false", Say(&["G1 E1 F300"])),
    row("[extruder] hotend.tool_id", "0", "1", Edges(&["G91", "M83", "T1", "T0", "G1 E5 F600"])).with(&[
        "[actuator] epsilon.driver = external",
        "[actuator] epsilon.steps_per_mm = 400",
        "[actuator] epsilon.step_pin = PJ5",
        "[actuator] epsilon.dir_pin = PJ1",
    ]),
    row("[extruder] second.x_offset", "0", "3", Edges(&["G90", "T1", "G1 X10 F3000"])).with(SECOND),
    row("[extruder] second.y_offset", "0", "3", Edges(&["G90", "T1", "G1 Y10 F3000"])).with(SECOND),
    row("[extruder] second.z_offset", "0", "3", Edges(&["G90", "T1", "G1 Z10 F600"])).with(SECOND),
    row("[extruder] hotend.filament_diameter", "0", "1.75", Edges(FEED)),
    row("[extruder] hotend.retract_length", "3", "1", Edges(RETRACT)),
    row("[extruder] hotend.retract_feedrate", "45", "10", Edges(RETRACT)),
    row("[extruder] hotend.retract_recover_length", "0", "0.5", Edges(RETRACT)),
    row("[extruder] hotend.retract_recover_feedrate", "30", "8", Edges(RETRACT)),
    row("[extruder] hotend.retract_zlift_length", "0", "1", Edges(RETRACT)),
    row("[extruder] hotend.retract_zlift_feedrate", "600", "120", Edges(RETRACT)).with(LIFTED),
    row("[extruder] hotend.min_extrude_temp", "0", "170", Say(&["G1 E1 F300"])),
    row("[extruder] hotend.max_extrude_only_distance", "0", "50", Say(&["G1 E60 F300"])),
    row("[drillingcycles] enable", "true", "false", Say(DRILL)),
    row("[drillingcycles] dwell_units", "S", "P", Edges(DRILL)),
    row("[extruder] hotend.pressure_advance", "0", "0.05", Edges(ADVANCED)),
    row("[extruder] hotend.pressure_advance_smooth_time", "0.04", "0.02", Edges(ADVANCED))
        .with(&["[extruder] hotend.pressure_advance = 0.05"]),
];
