//! Settings for the geometry of each arm solution.

use super::See::{Edges, Say};
use super::{Row, row};
use scenarios::DELTA;

/// Lines that home first, so that the tool is where the geometry says.
const DRAW: &[&str] = &["G28", "G1 Z20 F6000", "G1 X20 Y-15 F6000"];
const AWAY: &[&str] = &["G28", "G1 X900 F6000", "G1 X1"];
const ROTARY: &[&str] = &["[motion control] arm_solution = rotary_delta", "[motion control] must_be_homed = false"];
const MORGAN: &[&str] = &["[motion control] arm_solution = morgan"];
const COREXZ: &[&str] = &["[motion control] arm_solution = corexz"];
const DELTESIAN: &[&str] = &["[motion control] arm_solution = deltesian"];
const GENERIC: &[&str] = &[
    "[motion control] arm_solution = generic_cartesian",
    "[generic cartesian] alpha = 1,0,0",
    "[generic cartesian] beta = 0,1,0",
    "[generic cartesian] gamma = 0,0,1",
];
const WINCH: &[&str] = &[
    "[motion control] arm_solution = winch",
    "[winch] alpha = 0,-1000,-100",
    "[winch] beta = 1000,500,-100",
    "[winch] gamma = -1000,500,-100",
    "[winch] delta = 0,0,2000",
    "[extruder] hotend.enable = false",
];
const SIX_WINCHES: &[&str] = &[
    "[motion control] arm_solution = winch",
    "[winch] alpha = 0,-1000,-100",
    "[winch] beta = 1000,500,-100",
    "[winch] gamma = -1000,500,-100",
    "[winch] delta = 0,0,2000",
    "[winch] epsilon = 500,500,2000",
    "[winch] zeta = -500,500,2000",
    "[extruder] hotend.enable = false",
    "[actuator] epsilon.driver = external",
    "[actuator] epsilon.step_pin = PJ5",
    "[actuator] epsilon.dir_pin = PJ1",
    "[actuator] zeta.driver = external",
    "[actuator] zeta.step_pin = PJ3",
    "[actuator] zeta.dir_pin = PJ7",
];
const SHIFT: &[&str] = &["G91", "G1 X6 Y4 Z1 F3000"];

pub const ROWS: &[Row] = &[
    row("[linear delta] arm_length", "250", "245", Edges(DRAW)).on(DELTA),
    row("[linear delta] arm_radius", "124", "120", Edges(DRAW)).on(DELTA),
    row("[linear delta] delta_tower1_offset", "0", "1", Edges(DRAW)).on(DELTA),
    row("[linear delta] delta_tower2_offset", "0", "1", Edges(DRAW)).on(DELTA),
    row("[linear delta] delta_tower3_offset", "0", "1", Edges(DRAW)).on(DELTA),
    row("[linear delta] delta_tower1_angle", "0", "1", Edges(DRAW)).on(DELTA),
    row("[linear delta] delta_tower2_angle", "0", "1", Edges(DRAW)).on(DELTA),
    row("[linear delta] delta_tower3_angle", "0", "1", Edges(DRAW)).on(DELTA),
    row("[linear delta] delta_arm1_offset", "0", "1", Edges(DRAW)).on(DELTA),
    row("[linear delta] delta_arm2_offset", "0", "1", Edges(DRAW)).on(DELTA),
    row("[linear delta] delta_arm3_offset", "0", "1", Edges(DRAW)).on(DELTA),
    row("[linear delta] halt_on_error", "true", "false", Say(AWAY)).on(DELTA),
    row("[rotary delta] delta_e", "131.636", "120", Edges(SHIFT)).with(ROTARY),
    row("[rotary delta] delta_f", "190.526", "180", Edges(SHIFT)).with(ROTARY),
    row("[rotary delta] delta_re", "270", "265", Edges(SHIFT)).with(ROTARY),
    row("[rotary delta] delta_rf", "90", "95", Edges(SHIFT)).with(ROTARY),
    row("[rotary delta] delta_z_offset", "290.7", "285", Edges(SHIFT)).with(ROTARY),
    row("[rotary delta] delta_ee_offs", "15", "10", Edges(SHIFT)).with(ROTARY),
    row("[rotary delta] delta_tool_offset", "30.5", "25", Edges(SHIFT)).with(ROTARY),
    row("[rotary delta] min_angle", "-45", "69", Say(SHIFT)).with(ROTARY),
    row("[rotary delta] max_angle", "70", "-44", Say(SHIFT)).with(ROTARY),
    row("[rotary delta] delta_mirror_xy", "true", "false", Edges(SHIFT)).with(ROTARY),
    row("[rotary delta] halt_on_error", "true", "false", Say(&["G91", "G1 X900 F6000", "G1 X1"])).with(ROTARY),
    row("[morgan scara] arm1_length", "150", "140", Edges(SHIFT)).with(MORGAN),
    row("[morgan scara] arm2_length", "150", "140", Edges(SHIFT)).with(MORGAN),
    row("[morgan scara] morgan_offset_x", "100", "90", Edges(SHIFT)).with(MORGAN),
    row("[morgan scara] morgan_offset_y", "-60", "-70", Edges(SHIFT)).with(MORGAN),
    row("[morgan scara] morgan_scaling_x", "1", "1.1", Edges(SHIFT)).with(MORGAN),
    row("[morgan scara] morgan_scaling_y", "1", "1.1", Edges(SHIFT)).with(MORGAN),
    row("[morgan scara] morgan_undefined_min", "0.95", "0.2", Say(SHIFT)).with(MORGAN),
    row("[morgan scara] morgan_undefined_max", "0.95", "-0.9", Say(SHIFT)).with(MORGAN),
    row("[corexz] x_reduction", "1", "2", Edges(SHIFT)).with(COREXZ),
    row("[corexz] z_reduction", "3", "2", Edges(SHIFT)).with(COREXZ),
    row("[deltesian] left_arm_length", "250", "245", Edges(SHIFT)).with(DELTESIAN),
    row("[deltesian] right_arm_length", "250", "245", Edges(SHIFT)).with(DELTESIAN),
    row("[deltesian] left_arm_x_length", "124", "120", Edges(SHIFT)).with(DELTESIAN),
    row("[deltesian] right_arm_x_length", "124", "120", Edges(SHIFT)).with(DELTESIAN),
    row("[generic cartesian] alpha", "1,0,0", "1,0.5,0", Edges(SHIFT)).with(GENERIC),
    row("[generic cartesian] beta", "0,1,0", "0.5,1,0", Edges(SHIFT)).with(GENERIC),
    row("[generic cartesian] gamma", "0,0,1", "0,0,2", Edges(SHIFT)).with(GENERIC),
    row("[winch] alpha", "0,-1000,-100", "0,-900,-100", Edges(SHIFT)).with(WINCH),
    row("[winch] beta", "1000,500,-100", "900,500,-100", Edges(SHIFT)).with(WINCH),
    row("[winch] gamma", "-1000,500,-100", "-900,500,-100", Edges(SHIFT)).with(WINCH),
    row("[winch] delta", "0,0,2000", "0,0,1500", Edges(SHIFT)).with(WINCH),
    row("[winch] epsilon", "500,500,2000", "400,500,2000", Edges(SHIFT)).with(SIX_WINCHES),
    row("[winch] zeta", "-500,500,2000", "-400,500,2000", Edges(SHIFT)).with(SIX_WINCHES),
];
