//! `[zprobe]`.

use super::See::{Board, Boot, Edges, Say};
use super::{Row, row};
use scenarios::DELTA;

/// At power-on the tool is 10 mm above the bed.
const PROBE: &[&str] =
    &["[zprobe] enable = true", "[zprobe] probe_pin = PB10^", "[zprobe] slow_feedrate = 2", "[zprobe] max_travel = 30"];
const DELTA_PROBE: &[&str] = &[
    "[zprobe] enable = true",
    "[zprobe] probe_pin = PB10^",
    "[zprobe] calibration = delta",
    "[delta calibration strategy] radius = 60",
];
const DOWN: &[&str] = &["G30"];

pub const ROWS: &[Row] = &[
    row("[zprobe] enable", "true", "false", Say(DOWN)).with(PROBE),
    row("[zprobe] probe_pin", "PB10^", "PE1^", Boot).with(PROBE),
    row("[zprobe] probe_pin", "PB10^", "PJ9^", Board("probing.rs")).with(PROBE),
    row("[zprobe] slow_feedrate", "2", "4", Edges(DOWN)).with(PROBE),
    row("[zprobe] fast_feedrate", "100", "3", Edges(DOWN)).with(PROBE),
    row("[zprobe] return_feedrate", "0", "1", Edges(DOWN)).with(PROBE),
    row("[zprobe] max_travel", "30", "5", Say(DOWN)).with(PROBE),
    row("[zprobe] reverse_z", "false", "true", Edges(DOWN)).with(PROBE).built(),
    row("[zprobe] dwell_before_probing", "0", "0.5", Edges(DOWN)).with(PROBE),
    row("[zprobe] probe_height", "5", "9", Edges(&["G28", "G29"])).with(DELTA_PROBE).on(DELTA),
    row("[zprobe] calibration", "delta", "", Say(&["G28", "G29"])).with(DELTA_PROBE).on(DELTA),
    row("[delta calibration strategy] radius", "60", "50", Say(&["G28", "G29"])).with(DELTA_PROBE).on(DELTA),
    row("[delta calibration strategy] initial_height", "20", "10", Edges(&["G28", "G29"])).with(DELTA_PROBE).on(DELTA),
    row("[delta calibration strategy] tolerance", "0.03", "0.3", Say(&["G28", "M666 X0.2", "G32"]))
        .with(DELTA_PROBE)
        .on(DELTA),
    row("[zprobe] debounce_ms", "0", "30", Edges(DOWN)).with(PROBE),
];
