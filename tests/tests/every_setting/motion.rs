//! Settings of the sections `[motion control]`, `[planner]`, `[conveyor]` and `[input shaper]`.

use super::See::{Edges, Look, Say};
use super::{Bench, Row, row};

const LINE: &[&str] = &["G91", "G1 X20 F9000"];
const LINE_Y: &[&str] = &["G91", "G1 Y20 F9000"];
const LINE_Z: &[&str] = &["G91", "G1 Z5 F900"];
const ARC: &[&str] = &["G91", "G2 X20 Y0 I10 J0 F3000"];
const CORNER: &[&str] = &["G91", "G1 X5 F3000", "G1 Y5", "G1 X5"];
/// Moves of Z alone after a slope: the junction between is Z's own.
const STAIRS: &[&str] = &["G91", "G1 X2 Z2 F600", "G1 Z1"];
const SHORT: &[&str] = &[
    "G91",
    "G1 X0.5 F9000",
    "G1 X0.5",
    "G1 X0.5",
    "G1 X0.5",
    "G1 X0.5",
    "G1 X0.5",
    "G1 X0.5",
    "G1 X0.5",
    "G1 X0.5",
    "G1 X0.5",
    "G1 X0.5",
    "G1 X0.5",
    "G1 X0.5",
    "G1 X0.5",
    "G1 X0.5",
    "G1 X0.5",
];
const SHAPED: &[&str] =
    &["[input shaper] shaper_freq_x = 40", "[input shaper] shaper_freq_y = 40", "[input shaper] shaper_freq_z = 40"];
const POLAR: &[&str] = &["[motion control] arm_solution = polar"];

pub const ROWS: &[Row] = &[
    row("[motion control] nist_G30", "false", "true", Say(&["G30"])).with(&["[general] grbl_mode = true"]),
    row("[motion control] default_feed_rate", "3000", "1500", Edges(&["G91", "G1 X5"])),
    row("[motion control] default_seek_rate", "9000", "1500", Edges(&["G91", "G0 X5"])),
    row("[motion control] compliant_seek_rate", "false", "true", Edges(&["G91", "G0 X1 F600", "G0 X3"])),
    row("[motion control] mm_per_line_segment", "0", "0.5", Edges(POLAR_LINE)).with(POLAR),
    row("[motion control] delta_segments_per_second", "0", "100", Edges(POLAR_LINE)).with(POLAR),
    row("[motion control] mm_per_arc_segment", "0", "5", Edges(ARC)),
    row("[motion control] mm_max_arc_error", "0.01", "0.5", Edges(ARC)),
    row("[motion control] x_axis_max_speed", "18000", "1200", Edges(LINE)),
    row("[motion control] y_axis_max_speed", "18000", "1200", Edges(LINE_Y)),
    row("[motion control] z_axis_max_speed", "900", "300", Edges(LINE_Z)),
    row("[motion control] max_speed", "0", "1200", Edges(LINE)),
    row("[motion control] default_acceleration", "2000", "500", Edges(LINE)),
    row("[motion control] segment_z_moves", "true", "false", Edges(LINE_Z))
        .with(&["[motion control] mm_per_line_segment = 0.5", "[planner] planner_queue_size = 4"]),
    row("[motion control] save_wcs", "false", "true", Look(saved)),
    row("[motion control] save_g92", "false", "true", Look(saved)),
    row("[motion control] set_g92", "", "1,2,3", Say(&["M114", "$#"])),
    row("[motion control] must_be_homed", "false", "true", Say(&["G1 X1 F600"])),
    row("[motion control] arm_solution", "cartesian", "corexy", Edges(&["G91", "G1 X5 Y1 F3000"])),
    row("[planner] junction_deviation", "0.02", "0.2", Edges(CORNER)),
    row("[planner] z_junction_deviation", "-1", "0", Edges(STAIRS)),
    row("[planner] minimum_planner_speed", "0", "5", Edges(CORNER)),
    row("[planner] planner_queue_size", "32", "4", Edges(SHORT)).with(&["[motion control] default_acceleration = 500"]),
    row("[planner] jerk", "0", "20000", Edges(LINE)),
    row("[planner] x_axis_max_jerk", "0", "20000", Edges(LINE)),
    row("[planner] y_axis_max_jerk", "0", "20000", Edges(LINE_Y)),
    row("[planner] z_axis_max_jerk", "0", "2000", Edges(LINE_Z)),
    row("[planner] square_corner_velocity", "0", "15", Edges(CORNER)),
    row("[planner] minimum_cruise_ratio", "0", "0.5", Edges(LINE)),
    row("[conveyor] queue_delay_time_ms", "100", "500", Look(started)),
    row("[input shaper] shaper_freq_x", "0", "40", Edges(LINE)),
    row("[input shaper] shaper_freq_y", "0", "40", Edges(LINE_Y)),
    row("[input shaper] shaper_freq_z", "0", "40", Edges(LINE_Z)),
    row("[input shaper] shaper_type_x", "zv", "ei", Edges(LINE)).with(SHAPED),
    row("[input shaper] shaper_type_y", "zv", "ei", Edges(LINE_Y)).with(SHAPED),
    row("[input shaper] shaper_type_z", "zv", "ei", Edges(LINE_Z)).with(SHAPED),
    row("[input shaper] damping_ratio_x", "0.1", "0.05", Edges(LINE)).with(SHAPED),
    row("[input shaper] damping_ratio_y", "0.1", "0.05", Edges(LINE_Y)).with(SHAPED),
    row("[input shaper] damping_ratio_z", "0.1", "0.05", Edges(LINE_Z)).with(SHAPED),
];

/// A line past the middle of a turning bed, where a whole line is as slow as its slowest part.
const POLAR_LINE: &[&str] = &["G28.3 X30 Y3", "G90", "G1 X-30 Y3 F6000"];

fn saved(bench: &mut Bench) -> String {
    for line in ["G10 L2 P2 X10", "G92.3 X1.5", "M500"] {
        bench.say(line);
    }
    bench.read_card("config-override").unwrap_or_default()
}

/// Returns the number of edges 0.3 s after the start of a move without a successor.
fn started(bench: &mut Bench) -> String {
    bench.type_in("G1 X50 F600\n");
    bench.hear(0.3);
    bench.world(|world| world.trace().total()).to_string()
}
