//! Settings of the leveling strategies and of `[skew correction]`.

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
    row("[cartesian grid leveling strategy] x_start", "0", "20", Edges(HILL)).with(GRID),
    row("[cartesian grid leveling strategy] y_start", "0", "-10", Edges(HILL)).with(GRID),
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
    row("[cartesian grid leveling strategy] fade_target", "0", "0.2", Edges(HILL)).with(FADING),
    row("[delta grid leveling strategy] radius", "50", "60", Edges(HILL)).with(DELTA),
    row("[delta grid leveling strategy] size", "7", "5", Say(SHOWN)).with(DELTA),
    row("[delta grid leveling strategy] save", "false", "true", Look(saved_grid)).with(DELTA),
    row("[delta grid leveling strategy] probe_offsets", "0,0,0", "1,2,3", Say(OFFSETS)).with(DELTA),
    row("[bed mesh] interpolation", "spline", "bilinear", Edges(HILL)).with(GRID),
    row("[bed mesh] adaptive_margin", "5", "20", Look(adaptive)).with(PROBED),
    row("[bed mesh] faulty_regions", "", "30,30 70,60", Look(probed)).with(PROBED),
    row("[bed mesh] zero_reference", "", "50,40", Look(probed)).with(PROBED),
    row("[z alignment] motors", "-20,100 220,100", "-20,100 150,100", Look(align_racked)).with(GANTRY).built(),
    row("[z alignment] points", "15,15 185,15", "15,15 150,15", Edges(ALIGN)).with(GANTRY),
    row("[z alignment] twist", "true", "false", Look(align_racked)).with(TWISTED),
    row("[z alignment] tolerance", "0.02", "2", Look(align_racked)).with(GANTRY),
    row("[z alignment] retries", "5", "0", Look(align_racked)).with(GANTRY),
    row("[z alignment] max_adjust", "5", "0.5", Look(align_racked)).with(GANTRY),
    row("[z alignment] initial_height", "10", "30", Edges(ALIGN)).with(GANTRY),
    row("[bed screws] screws", "20,20 180,20", "20,20 20,180", Say(TURN)).with(SCREWS),
    row("[bed screws] thread", "CW-M3", "CCW-M4", Look(turn_screws)).with(SCREWS),
    row("[bed screws] pitch", "0", "1.25", Look(turn_screws)).with(SCREWS),
    row("[bed screws] tolerance", "0.02", "1", Look(turn_screws)).with(SCREWS),
    row("[bed screws] initial_height", "10", "30", Edges(TURN)).with(SCREWS),
    row("[bed screws] paper_height", "0", "1", Edges(WALK)).with(SCREWS),
    row("[axis twist compensation] axis", "x", "y", Say(TWIST_SAID)).with(TWISTED_AXIS),
    row("[axis twist compensation] points", "20,0.1 180,-0.1", "20,0.2 180,-0.1", Say(TWIST_SAID)).with(TWISTED_AXIS),
    row("[axis twist compensation] start", "30", "40", Edges(TWIST)).with(TWISTED_AXIS),
    row("[axis twist compensation] end", "150", "100", Edges(TWIST_ON)).with(TWISTED_AXIS),
    row("[axis twist compensation] line", "100", "90", Edges(TWIST)).with(TWISTED_AXIS),
    row("[axis twist compensation] samples", "3", "4", Say(TWIST)).with(TWISTED_AXIS),
    row("[axis twist compensation] initial_height", "10", "12", Edges(TWIST)).with(TWISTED_AXIS),
    row("[z thermal adjust] sensor", "bed", "hotend", Look(warm_frame)).with(FRAME),
    row("[z thermal adjust] coefficient", "0.01", "0.005", Look(warm_frame)).with(FRAME),
    row("[z thermal adjust] smooth_time", "2", "500", Look(warm_frame)).with(FRAME),
    row("[z thermal adjust] max_adjust", "0.5", "0.1", Look(warm_frame)).with(FRAME),
    row("[skew correction] xy", "0", "0.02", Edges(SKEWED)),
    row("[skew correction] xz", "0", "0.02", Edges(SKEWED)),
    row("[skew correction] yz", "0", "0.02", Edges(SKEWED)),
    row("[skew correction] xy_measured", "", "142.5,140.4,100", Edges(SKEWED)),
    row("[skew correction] xz_measured", "", "142.5,140.4,100", Edges(SKEWED)),
    row("[skew correction] yz_measured", "", "142.5,140.4,100", Edges(SKEWED)),
];

/// A grid of 5 by 5 points and a probe.
const PROBED: &[&str] = &[
    "[zprobe] enable = true",
    "[zprobe] probe_pin = PB10^",
    "[zprobe] leveling = cartesian grid",
    "[cartesian grid leveling strategy] x_size = 100",
    "[cartesian grid leveling strategy] y_size = 80",
    "[cartesian grid leveling strategy] grid_x_size = 5",
    "[cartesian grid leveling strategy] grid_y_size = 5",
];

/// Returns the probing result on a tilted bed.
fn probed(bench: &mut Bench) -> String {
    on_a_tilt(bench, "G32")
}

fn adaptive(bench: &mut Bench) -> String {
    bench.say("EXCLUDE_OBJECT_DEFINE NAME=cube POLYGON=[[40,30],[60,50]]");
    on_a_tilt(bench, "G32 D")
}

fn on_a_tilt(bench: &mut Bench, code: &str) -> String {
    bench.say("G28");
    let bed = Some(sim::models::surface::Bed::tilted(0.2, [0.002, 0.001]));
    bench.lay(sim::models::surface::Surface { bed, ..Default::default() });
    bench.say(code)
}

/// Settings for a gantry with two Z motors.
const GANTRY: &[&str] = &[
    "[extruder] hotend.enable = false",
    "[actuator] delta.slaved_to = gamma",
    "[actuator] delta.steps_per_mm = 400",
    "[actuator] delta.max_rate = 900",
    "[zprobe] enable = true",
    "[zprobe] probe_pin = PB10^",
    "[z alignment] motors = -20,100 220,100",
    "[z alignment] points = 15,15 185,15",
];
/// Settings for four Z motors: the last two are on external drivers.
const TWISTED: &[&str] = &[
    "[extruder] hotend.enable = false",
    "[actuator] delta.slaved_to = gamma",
    "[actuator] delta.steps_per_mm = 400",
    "[actuator] delta.max_rate = 900",
    "[actuator] epsilon.slaved_to = gamma",
    "[actuator] epsilon.steps_per_mm = 400",
    "[actuator] epsilon.max_rate = 900",
    "[actuator] epsilon.microsteps = 16",
    "[actuator] epsilon.step_pin = PJ1",
    "[actuator] epsilon.dir_pin = PJ5",
    "[actuator] epsilon.en_pin = PJ4!",
    "[actuator] zeta.slaved_to = gamma",
    "[actuator] zeta.steps_per_mm = 400",
    "[actuator] zeta.max_rate = 900",
    "[actuator] zeta.microsteps = 16",
    "[actuator] zeta.step_pin = PJ7",
    "[actuator] zeta.dir_pin = PJ10",
    "[actuator] zeta.en_pin = PJ9!",
    "[zprobe] enable = true",
    "[zprobe] probe_pin = PB10^",
    "[z alignment] motors = -20,0 220,0 220,200 -20,200",
    "[z alignment] points = 15,15 185,15 185,185 15,185",
];
const ALIGN: &[&str] = &["G28", "G34"];
const SCREWS: &[&str] =
    &["[zprobe] enable = true", "[zprobe] probe_pin = PB10^", "[bed screws] screws = 20,20 180,20 180,180"];
const WALK: &[&str] = &["G28", "BED_SCREWS_ADJUST"];
const TWISTED_AXIS: &[&str] = &[
    "[zprobe] enable = true",
    "[zprobe] probe_pin = PB10^",
    "[axis twist compensation] points = 20,0.1 180,-0.1",
    "[axis twist compensation] start = 30",
    "[axis twist compensation] end = 150",
    "[axis twist compensation] line = 100",
];
const TWIST_SAID: &[&str] = &["M851.6"];
const TWIST: &[&str] = &["G28", "M851.1 P4"];
const TWIST_ON: &[&str] = &["G28", "M851.1 P4", "M851.3"];
const FRAME: &[&str] = &["[z thermal adjust] sensor = bed", "[z thermal adjust] coefficient = 0.01"];
const TURN: &[&str] = &["G28", "G35"];

fn align_racked(bench: &mut Bench) -> String {
    bench.say("G28");
    let at_ns = (bench.now_s() * 1e9) as u64;
    let stands = bench.carriage(units::Actuator::Delta) + 0.8;
    bench.world(|world| world.place_carriage(at_ns, units::Actuator::Delta, stands));
    bench.say("G34")
}

/// Warms the bed's sensor; Z then follows the temperature.
fn warm_frame(bench: &mut Bench) -> String {
    bench.run(&["G28"]);
    bench.say("M190 S60");
    bench.run(&["G1 Z10 F600", "M400"]);
    format!("{:.3}", bench.carriage(units::Actuator::Gamma))
}

fn turn_screws(bench: &mut Bench) -> String {
    bench.say("G28");
    let bed = sim::models::surface::Bed::tilted(0.3, [0.002, 0.001]);
    let surface = sim::models::surface::Surface { bed: Some(bed), ..Default::default() };
    bench.lay(surface);
    bench.say("G35")
}

fn saved_plane(bench: &mut Bench) -> String {
    bench.say("M561 A0.01 B0.02 C1 D-0.1");
    bench.say("M503")
}

fn saved_grid(bench: &mut Bench) -> String {
    bench.say("M421 I2 J2 Z0.3");
    bench.say("M503")
}
