//! `[zprobe]` and the leveling strategies.

use super::build::{
    ANY, NOT_NEGATIVE, POSITIVE, bool, integer, no_numbers, no_text, nowhere, number, numbers, pin, text, word,
};
use super::endstops::millis;
use super::{Form, PinRole, Section};
use crate::pin::PinName;
use units::{Micros, Mm, MmPerSecond};

const NO_LEVELING: &str = "leave it out; bed leveling is not part of Velvet yet";

pub const ZPROBE: Section = Section {
    name: "zprobe",
    summary: "A probe that finds the bed or the work piece.",
    form: Form::Plain,
    settings: &[
        bool("enable", "false", |c, _, v| c.probe.enable = v, "There is a probe.").v1("zprobe.enable"),
        pin(
            "probe_pin",
            "nc",
            PinRole::Input,
            |c, _, v| c.probe.pin = v.and_then(PinName::digital),
            "Input, logically high when triggered. The board's probe connector is PB10.",
        )
        .klipper("[probe] pin")
        .v1("zprobe.probe_pin"),
        number(
            "slow_feedrate",
            "5",
            POSITIVE,
            |c, _, v| c.probe.slow_rate = MmPerSecond(v),
            "Speed of the search. M670 S changes it.",
        )
        .klipper("[probe] speed")
        .unit("mm/s")
        .typical(0.1, 50.0)
        .v1("zprobe.slow_feedrate"),
        number(
            "fast_feedrate",
            "100",
            POSITIVE,
            |c, _, v| c.probe.fast_rate = MmPerSecond(v),
            "Speed of travel between probed points. M670 K changes it.",
        )
        .unit("mm/s")
        .typical(1.0, 500.0)
        .v1("zprobe.fast_feedrate"),
        number(
            "return_feedrate",
            "0",
            NOT_NEGATIVE,
            |c, _, v| c.probe.return_rate = MmPerSecond(v),
            "Speed of lifting after a touch; 0: twice slow_feedrate, at most fast_feedrate. M670 R changes it.",
        )
        .klipper("[probe] lift_speed")
        .unit("mm/s")
        .typical(0.1, 500.0)
        .v1("zprobe.return_feedrate"),
        number(
            "probe_height",
            "5",
            NOT_NEGATIVE,
            |c, _, v| c.probe.height = Mm(v),
            "Clearance over the bed between touches. M670 H changes it.",
        )
        .unit("mm")
        .v1("zprobe.probe_height")
        .dormant(),
        number(
            "max_travel",
            "200",
            POSITIVE,
            |c, _, v| c.probe.max_travel = Mm(v),
            "Longest search; no touch within it is a miss. M670 Z changes it.",
        )
        .unit("mm")
        .v1("zprobe.max_z"),
        bool("reverse_z", "false", |c, _, v| c.probe.reverse_z = v, "Search towards positive Z.")
            .v1("zprobe.reverse_z"),
        number(
            "dwell_before_probing",
            "0",
            (0.0, 60.0),
            |c, _, v| c.probe.dwell = Micros((v * 1e6) as u64),
            "Pause before each search. M670 D changes it.",
        )
        .unit("s")
        .v1("zprobe.dwell_before_probing"),
        number(
            "debounce_ms",
            "0",
            (0.0, 1_000.0),
            |c, _, v| c.probe.debounce = millis(v),
            "How long the probe must stay triggered to count; 0 stops at once.",
        )
        .unit("ms")
        .v1("zprobe.debounce_ms"),
        word(
            "leveling",
            "",
            &["three point", "delta grid", "cartesian grid"],
            nowhere,
            "How G29, G31 and G32 level the bed; the strategy has a section of its own.",
        )
        .not_yet(NO_LEVELING),
        word(
            "calibration",
            "",
            &["delta"],
            |c, _, _| c.delta_calibration.enable = true,
            "How G32 calibrates the machine; the strategy has a section of its own.",
        ),
    ],
};

pub const THREE_POINT: Section = Section {
    name: "three point leveling strategy",
    summary: "Levels the bed as a plane through three probed points.",
    form: Form::Plain,
    settings: &[
        numbers("point1", 2, no_numbers, "First probe point as X,Y.")
            .unit("mm")
            .v1("leveling-strategy.three-point-leveling.point1")
            .dormant(),
        numbers("point2", 2, no_numbers, "Second probe point as X,Y.")
            .unit("mm")
            .v1("leveling-strategy.three-point-leveling.point2")
            .dormant(),
        numbers("point3", 2, no_numbers, "Third probe point as X,Y.")
            .unit("mm")
            .v1("leveling-strategy.three-point-leveling.point3")
            .dormant(),
        numbers("probe_offsets", 3, no_numbers, "Probe position relative to the nozzle as X,Y,Z.")
            .unit("mm")
            .v1("leveling-strategy.three-point-leveling.probe_offsets")
            .dormant(),
        bool("home_first", "true", nowhere, "Homes X and Y before probing.")
            .v1("leveling-strategy.three-point-leveling.home_first")
            .dormant(),
        number("tolerance", "0.03", ANY, nowhere, "Height spread below which the bed counts as flat.")
            .unit("mm")
            .v1("leveling-strategy.three-point-leveling.tolerance")
            .dormant(),
        bool("save_plane", "false", nowhere, "Lets M500 store the plane.")
            .v1("leveling-strategy.three-point-leveling.save_plane")
            .dormant(),
    ],
};

pub const CARTESIAN_GRID: Section = Section {
    name: "cartesian grid leveling strategy",
    summary: "Levels the bed by a rectangular grid of probed points.",
    form: Form::Plain,
    settings: &[
        number("x_size", "0", ANY, nowhere, "Width of the probed area.")
            .unit("mm")
            .v1("leveling-strategy.rectangular-grid.x_size")
            .dormant(),
        number("y_size", "0", ANY, nowhere, "Depth of the probed area.")
            .unit("mm")
            .v1("leveling-strategy.rectangular-grid.y_size")
            .dormant(),
        integer("grid_x_size", "7", (0, 1_000_000), nowhere, "Grid points along X.")
            .unit("points")
            .v1("leveling-strategy.rectangular-grid.grid_x_size")
            .dormant(),
        integer("grid_y_size", "7", (0, 1_000_000), nowhere, "Grid points along Y.")
            .unit("points")
            .v1("leveling-strategy.rectangular-grid.grid_y_size")
            .dormant(),
        number("tolerance", "0.03", ANY, nowhere, "Intended flatness tolerance.")
            .unit("mm")
            .v1("leveling-strategy.rectangular-grid.tolerance")
            .dormant(),
        bool("save", "false", nowhere, "Makes M500 add a command that reloads the saved grid.")
            .v1("leveling-strategy.rectangular-grid.save")
            .dormant(),
        bool("do_home", "true", nowhere, "Homes before the grid probe.")
            .v1("leveling-strategy.rectangular-grid.do_home")
            .dormant(),
        bool("only_by_two_corners", "false", nowhere, "Takes the area from the G31/G32 line instead of the config.")
            .v1("leveling-strategy.rectangular-grid.only_by_two_corners")
            .dormant(),
        bool("human_readable", "false", nowhere, "Prints the grid with coordinates along its edges.")
            .v1("leveling-strategy.rectangular-grid.human_readable")
            .dormant(),
        numbers("probe_offsets", 3, no_numbers, "Probe position relative to the nozzle as X,Y,Z.")
            .unit("mm")
            .v1("leveling-strategy.rectangular-grid.probe_offsets")
            .dormant(),
        number("dampening_start", "0", ANY, nowhere, "Height from which the correction fades.")
            .unit("mm")
            .v1("leveling-strategy.rectangular-grid.dampening_start")
            .dormant(),
        number("height_limit", "0", ANY, nowhere, "Height at which the correction has faded to nothing.")
            .unit("mm")
            .v1("leveling-strategy.rectangular-grid.height_limit")
            .dormant(),
        number("initial_height", "10", ANY, nowhere, "Height moved to fast before searching for the bed.")
            .unit("mm")
            .v1("leveling-strategy.rectangular-grid.initial_height")
            .dormant(),
        text("before_probe_gcode", "", 96, no_text, "Line executed before probing.").dormant(),
        text("after_probe_gcode", "", 96, no_text, "Line executed after probing.").dormant(),
    ],
};

pub const DELTA_GRID: Section = Section {
    name: "delta grid leveling strategy",
    summary: "Levels the bed of a delta by a grid of probed points.",
    form: Form::Plain,
    settings: &[
        number("radius", "50", ANY, nowhere, "Radius of the probed circle.")
            .unit("mm")
            .v1("leveling-strategy.delta-grid.radius")
            .dormant(),
        integer("size", "7", (0, 1_000_000), nowhere, "Points per side of the square grid.")
            .unit("points")
            .v1("leveling-strategy.delta-grid.size")
            .dormant(),
        number("tolerance", "0.03", ANY, nowhere, "Intended flatness tolerance.")
            .unit("mm")
            .v1("leveling-strategy.delta-grid.tolerance")
            .dormant(),
        bool("save", "false", nowhere, "Makes M500 add a command that reloads the saved grid.")
            .v1("leveling-strategy.delta-grid.save")
            .dormant(),
        bool("do_home", "true", nowhere, "Homes before probing.").v1("leveling-strategy.delta-grid.do_home").dormant(),
        number("initial_height", "10", ANY, nowhere, "Height moved to fast before searching for the bed.")
            .unit("mm")
            .v1("leveling-strategy.delta-grid.initial_height")
            .dormant(),
        numbers("probe_offsets", 3, no_numbers, "Probe position relative to the nozzle as X,Y,Z.")
            .unit("mm")
            .v1("leveling-strategy.delta-grid.probe_offsets")
            .dormant(),
    ],
};

pub const DELTA_CALIBRATION: Section = Section {
    name: "delta calibration strategy",
    summary: "Finds the endstop trims and the radius of a delta by probing.",
    form: Form::Plain,
    settings: &[
        number(
            "radius",
            "100",
            POSITIVE,
            |c, _, v| c.delta_calibration.radius = Mm(v),
            "Distance of the probed points from the centre. G32 J changes it.",
        )
        .unit("mm")
        .v1("leveling-strategy.delta-calibration.radius"),
        number(
            "initial_height",
            "20",
            POSITIVE,
            |c, _, v| c.delta_calibration.initial_height = Mm(v),
            "Height moved to fast before searching for the bed.",
        )
        .unit("mm")
        .v1("leveling-strategy.delta-calibration.initial_height"),
        number(
            "tolerance",
            "0.03",
            POSITIVE,
            |c, _, v| c.delta_calibration.tolerance = Mm(v),
            "Spread of the points' heights that is good enough. G32 I changes it.",
        )
        .unit("mm")
        .v1("leveling-strategy.delta-calibration.tolerance"),
    ],
};
