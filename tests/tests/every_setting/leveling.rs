//! The leveling strategies and `[skew correction]`.

use super::See::{Edges, Look, Say};
use super::{Bench, Row, row};

const GRID: &[&str] = &[
    "[zprobe] leveling = cartesian grid",
    "[cartesian grid leveling strategy] x_size = 100",
    "[cartesian grid leveling strategy] y_size = 80",
    "[cartesian grid leveling strategy] grid_x_size = 5",
    "[cartesian grid leveling strategy] grid_y_size = 5",
];
const FADING: &[&str] = &[
    "[zprobe] leveling = cartesian grid",
    "[cartesian grid leveling strategy] x_size = 100",
    "[cartesian grid leveling strategy] y_size = 80",
    "[cartesian grid leveling strategy] dampening_start = 1",
    "[cartesian grid leveling strategy] height_limit = 10",
];
const DELTA: &[&str] = &["[zprobe] leveling = delta grid"];
const PLANE: &[&str] = &["[zprobe] leveling = three point"];
const HILL: &[&str] = &["M421 I2 J2 Z0.3", "G90", "G1 X40 Y30 Z3 F6000"];
const SHOWN: &[&str] = &["M421 I2 J2 Z0.3", "M375.1"];
const POINTS: &[&str] = &["M557"];
const OFFSETS: &[&str] = &["M565"];
const SKEWED: &[&str] = &["G90", "G1 X10 Y30 Z3 F6000"];

pub const ROWS: &[Row] = &[
    row("[zprobe] leveling", "cartesian grid", "delta grid", Say(SHOWN)).with(&[
        "[cartesian grid leveling strategy] x_size = 100",
        "[cartesian grid leveling strategy] y_size = 100",
        "[cartesian grid leveling strategy] human_readable = true",
    ]),
    row("[three point leveling strategy] point1", "0,0", "5,6", Say(POINTS)).with(PLANE),
    row("[three point leveling strategy] point2", "0,0", "5,6", Say(POINTS)).with(PLANE),
    row("[three point leveling strategy] point3", "0,0", "5,6", Say(POINTS)).with(PLANE),
    row("[three point leveling strategy] probe_offsets", "0,0,0", "1,2,3", Say(OFFSETS)).with(PLANE),
    row("[three point leveling strategy] save_plane", "false", "true", Look(saved_plane)).with(PLANE),
    row("[cartesian grid leveling strategy] x_size", "100", "70", Edges(HILL)).with(GRID),
    row("[cartesian grid leveling strategy] y_size", "80", "-60", Edges(HILL)).with(GRID),
    row("[cartesian grid leveling strategy] grid_x_size", "5", "4", Say(SHOWN)).with(GRID),
    row("[cartesian grid leveling strategy] grid_y_size", "5", "4", Say(SHOWN)).with(GRID),
    row("[cartesian grid leveling strategy] save", "false", "true", Look(saved_grid)).with(GRID),
    row("[cartesian grid leveling strategy] only_by_two_corners", "false", "true", Say(&["M421 I0 J0 Z0.1"]))
        .with(GRID),
    row("[cartesian grid leveling strategy] human_readable", "false", "true", Say(SHOWN)).with(GRID),
    row("[cartesian grid leveling strategy] probe_offsets", "0,0,0", "1,2,3", Say(OFFSETS)).with(GRID),
    row("[cartesian grid leveling strategy] dampening_start", "1", "2", Edges(HILL)).with(FADING),
    row("[cartesian grid leveling strategy] height_limit", "10", "0", Edges(HILL)).with(FADING),
    row("[delta grid leveling strategy] radius", "50", "60", Edges(HILL)).with(DELTA),
    row("[delta grid leveling strategy] size", "7", "5", Say(SHOWN)).with(DELTA),
    row("[delta grid leveling strategy] save", "false", "true", Look(saved_grid)).with(DELTA),
    row("[delta grid leveling strategy] probe_offsets", "0,0,0", "1,2,3", Say(OFFSETS)).with(DELTA),
    row("[skew correction] xy", "0", "0.02", Edges(SKEWED)),
    row("[skew correction] xz", "0", "0.02", Edges(SKEWED)),
    row("[skew correction] yz", "0", "0.02", Edges(SKEWED)),
    row("[skew correction] xy_measured", "", "142.5,140.4,100", Edges(SKEWED)),
    row("[skew correction] xz_measured", "", "142.5,140.4,100", Edges(SKEWED)),
    row("[skew correction] yz_measured", "", "142.5,140.4,100", Edges(SKEWED)),
];

fn saved_plane(bench: &mut Bench) -> String {
    bench.say("M561 A0.01 B0.02 C1 D-0.1");
    bench.say("M503")
}

fn saved_grid(bench: &mut Bench) -> String {
    bench.say("M421 I2 J2 Z0.3");
    bench.say("M503")
}
