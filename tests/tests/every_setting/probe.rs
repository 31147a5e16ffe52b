//! Settings of the section `[zprobe]`.

use super::See::{Board, Boot, Edges, Look, Say};
use super::{Bench, Row, row};
use scenarios::DELTA;
use sim::models::surface::{Bed, Surface};

/// Probe settings; at power-on the tool is 10 mm above the bed.
const PROBE: &[&str] =
    &["[zprobe] enable = true", "[zprobe] probe_pin = PB10^", "[zprobe] slow_feedrate = 2", "[zprobe] max_travel = 30"];
const MOVED: &[&str] = &[
    "[zprobe] enable = true",
    "[zprobe] probe_pin = PB10^",
    "[zprobe] deploy_gcode = G4 P1",
    "[zprobe] stow_gcode = G4 P1",
];
const DELTA_PROBE: &[&str] = &[
    "[zprobe] enable = true",
    "[zprobe] probe_pin = PB10^",
    "[zprobe] calibration = delta",
    "[delta calibration strategy] radius = 60",
];
const GRID: &[&str] = &[
    "[zprobe] enable = true",
    "[zprobe] probe_pin = PB10^",
    "[zprobe] leveling = cartesian grid",
    "[cartesian grid leveling strategy] x_size = 40",
    "[cartesian grid leveling strategy] y_size = 30",
    "[cartesian grid leveling strategy] grid_x_size = 2",
    "[cartesian grid leveling strategy] grid_y_size = 2",
];
const POINTS: &[&str] = &[
    "[zprobe] enable = true",
    "[zprobe] probe_pin = PB10^",
    "[zprobe] leveling = three point",
    "[three point leveling strategy] point1 = 35,45",
    "[three point leveling strategy] point2 = 60,45",
    "[three point leveling strategy] point3 = 35,60",
];
const DELTA_GRID: &[&str] = &[
    "[zprobe] enable = true",
    "[zprobe] probe_pin = PB10^",
    "[zprobe] leveling = delta grid",
    "[delta grid leveling strategy] size = 2",
    "[delta grid leveling strategy] radius = 30",
];
/// Probe settings with three touches at each place.
const SAMPLED: &[&str] = &[
    "[zprobe] enable = true",
    "[zprobe] probe_pin = PB10^",
    "[zprobe] leveling = cartesian grid",
    "[zprobe] samples = 3",
    "[cartesian grid leveling strategy] x_size = 40",
    "[cartesian grid leveling strategy] y_size = 30",
    "[cartesian grid leveling strategy] grid_x_size = 2",
    "[cartesian grid leveling strategy] grid_y_size = 2",
];
const LEVEL: &[&str] = &["G32"];
const ROUND: &[&str] = &["G28", "G31"];
const DOWN: &[&str] = &["G30"];

pub const ROWS: &[Row] = &[
    row("[zprobe] probe_offsets", "0,0,0", "1,2,3", Say(&["M565"])).with(PROBE),
    row("[zprobe] enable", "true", "false", Say(DOWN)).with(PROBE),
    row("[zprobe] probe_pin", "PB10^", "PE1^", Boot).with(PROBE),
    row("[zprobe] probe_pin", "PB10^", "PJ9^", Board("probing.rs")).with(PROBE),
    row("[zprobe] slow_feedrate", "2", "4", Edges(DOWN)).with(PROBE),
    row("[zprobe] fast_feedrate", "100", "3", Edges(DOWN)).with(PROBE),
    row("[zprobe] return_feedrate", "0", "1", Edges(DOWN)).with(PROBE),
    row("[zprobe] max_travel", "30", "5", Say(DOWN)).with(PROBE),
    row("[zprobe] reverse_z", "false", "true", Edges(DOWN)).with(PROBE).built(),
    row("[zprobe] dwell_before_probing", "0", "0.5", Edges(DOWN)).with(PROBE),
    row("[zprobe] probe_height", "5", "2", Edges(LEVEL)).with(GRID),
    row("[zprobe] samples", "1", "3", Edges(LEVEL)).with(GRID),
    row("[zprobe] samples_result", "average", "median", Look(noisy)).with(SAMPLED),
    row("[zprobe] samples_tolerance", "0.1", "0.001", Look(noisy)).with(SAMPLED),
    row("[zprobe] samples_retries", "3", "0", Look(too_noisy)).with(SAMPLED),
    row("[zprobe] samples_retract", "2", "1", Edges(LEVEL)).with(SAMPLED),
    row("[three point leveling strategy] home_first", "true", "false", Edges(LEVEL)).with(POINTS),
    row("[three point leveling strategy] tolerance", "0.03", "0", Look(level_a_leaning_bed)).with(POINTS),
    row("[cartesian grid leveling strategy] do_home", "true", "false", Edges(LEVEL)).with(GRID),
    row("[cartesian grid leveling strategy] initial_height", "10", "8", Edges(LEVEL)).with(GRID),
    row("[cartesian grid leveling strategy] before_probe_gcode", "", "G91 G1 X1 F600 G90", Edges(LEVEL)).with(GRID),
    row("[cartesian grid leveling strategy] after_probe_gcode", "", "G91 G1 X1 F600 G90", Edges(LEVEL)).with(GRID),
    row("[delta grid leveling strategy] do_home", "true", "false", Edges(ROUND)).with(DELTA_GRID).on(DELTA),
    row("[delta grid leveling strategy] initial_height", "10", "8", Edges(ROUND)).with(DELTA_GRID).on(DELTA),
    row("[zprobe] calibration", "delta", "", Say(&["G28", "G29"])).with(DELTA_PROBE).on(DELTA),
    row("[delta calibration strategy] radius", "60", "50", Say(&["G28", "G29"])).with(DELTA_PROBE).on(DELTA),
    row("[delta calibration strategy] initial_height", "20", "10", Edges(&["G28", "G29"])).with(DELTA_PROBE).on(DELTA),
    row("[delta calibration strategy] tolerance", "0.03", "0.3", Say(&["G28", "M666 X0.2", "G32"]))
        .with(DELTA_PROBE)
        .on(DELTA),
    row("[delta calibration strategy] factors", "4", "6", Say(&["G28", "M666 X0.2", "G32"]))
        .with(DELTA_PROBE)
        .on(DELTA),
    row("[zprobe] deploy_gcode", "G4 P1", "G0 X35 F600", Edges(DOWN)).with(MOVED),
    row("[zprobe] stow_gcode", "G4 P1", "G0 X35 F600", Edges(DOWN)).with(MOVED),
    row("[zprobe] deployed_pin", "nc", "PJ9^", Say(DOWN)).with(PROBE),
    row("[zprobe] stowed_reads_triggered", "false", "true", Look(a_probe_in_its_dock)).with(PROBE),
    row("[zprobe] debounce_ms", "0", "30", Edges(DOWN)).with(PROBE),
];

/// Levels a bed that rises by 0.025 mm from point to point.
fn level_a_leaning_bed(bench: &mut Bench) -> String {
    let bed = Some(Bed::tilted(0.0, [0.001, 0.0]));
    bench.lay(Surface { bed, ..Surface::default() });
    bench.say("G32")
}

/// Runs G30 with the probe's contact triggered.
fn a_probe_in_its_dock(bench: &mut Bench) -> String {
    bench.world(|world| world.press(0, "probe", true)).expect("a probe");
    bench.hear(0.1);
    bench.say("G30")
}

/// Returns the result of a probe with scatter.
fn noisy(bench: &mut Bench) -> String {
    scattered(bench, 0.02)
}

fn too_noisy(bench: &mut Bench) -> String {
    scattered(bench, 0.5)
}

fn scattered(bench: &mut Bench, noise_mm: f64) -> String {
    bench.lay(Surface { noise_mm, ..Surface::default() });
    bench.say("G32")
}
