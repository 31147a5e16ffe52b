//! The leveling strategies' sections, and `[skew correction]`.

use super::build::{ANY, NOT_NEGATIVE, bool, integer, nowhere, number, numbers, places, text, word};
use super::{Docs, Form, Section, Setting, Words};
use crate::machine::{MAX_FAULTY, MeshInterpolation};
use units::Mm;

/// Points along a side of a grid; `motion` has room for no more.
const SIDE: &(i64, i64) = &(2, 50);
/// Skew factors: tangents of six degrees.
const SKEW: &(f64, f64) = &(-0.1, 0.1);

pub const THREE_POINT: Section = Section {
    name: "three point leveling strategy",
    store: None,
    docs: Docs::new("Levels the bed as a plane through three probed points."),
    form: Form::Plain,
    settings: &[
        point("point1", |c, _, v| c.leveling.points[0] = pair(v), "First probe point as X,Y. M557 P0 changes it.")
            .v1("leveling-strategy.three-point-leveling.point1"),
        point("point2", |c, _, v| c.leveling.points[1] = pair(v), "Second probe point as X,Y. M557 P1 changes it.")
            .v1("leveling-strategy.three-point-leveling.point2"),
        point("point3", |c, _, v| c.leveling.points[2] = pair(v), "Third probe point as X,Y. M557 P2 changes it.")
            .v1("leveling-strategy.three-point-leveling.point3"),
        offsets(|c, _, v| c.leveling.plane_offsets = triple(v))
            .v1("leveling-strategy.three-point-leveling.probe_offsets"),
        bool("home_first", "true", |c, _, v| c.leveling.home_first = v, "Homes X and Y before probing.")
            .v1("leveling-strategy.three-point-leveling.home_first"),
        number(
            "tolerance",
            "0.03",
            NOT_NEGATIVE,
            |c, _, v| c.leveling.tolerance = Mm(v),
            "Height spread up to which the bed counts as flat.",
        )
        .unit("mm")
        .v1("leveling-strategy.three-point-leveling.tolerance"),
        bool("save_plane", "false", |c, _, v| c.leveling.save_plane = v, "Lets M500 store the plane.")
            .v1("leveling-strategy.three-point-leveling.save_plane"),
    ],
};

pub const CARTESIAN_GRID: Section = Section {
    name: "cartesian grid leveling strategy",
    store: None,
    docs: Docs::new("Levels the bed by a rectangular grid of heights, through which a smooth surface is laid."),
    form: Form::Plain,
    settings: &[
        size("x_size", |c, _, v| c.leveling.grid.size[0] = Mm(v), "Width of the area from X0; may be negative.")
            .v1("leveling-strategy.rectangular-grid.x_size"),
        size("y_size", |c, _, v| c.leveling.grid.size[1] = Mm(v), "Depth of the area from Y0; may be negative.")
            .v1("leveling-strategy.rectangular-grid.y_size"),
        points("grid_x_size", |c, _, v| c.leveling.grid.count[0] = v as u8, "Grid points along X.")
            .v1("leveling-strategy.rectangular-grid.grid_x_size"),
        points("grid_y_size", |c, _, v| c.leveling.grid.count[1] = v as u8, "Grid points along Y.")
            .v1("leveling-strategy.rectangular-grid.grid_y_size"),
        number("tolerance", "0.03", ANY, nowhere, "Intended flatness tolerance.")
            .unit("mm")
            .v1("leveling-strategy.rectangular-grid.tolerance")
            .dormant(),
        bool(
            "save",
            "false",
            |c, _, v| c.leveling.grid.save = v,
            "Makes M500 add a command that reloads the saved grid.",
        )
        .v1("leveling-strategy.rectangular-grid.save"),
        bool(
            "do_home",
            "true",
            |c, _, v| c.leveling.grid.home = v,
            "Homes before the grid probe. With home_gcode it must have been homed.",
        )
        .v1("leveling-strategy.rectangular-grid.do_home"),
        bool(
            "only_by_two_corners",
            "false",
            |c, _, v| c.leveling.grid.two_corners = v,
            "Takes the area from the G31/G32 line instead of the config; such a grid is neither saved nor loaded.",
        )
        .v1("leveling-strategy.rectangular-grid.only_by_two_corners"),
        bool(
            "human_readable",
            "false",
            |c, _, v| c.leveling.grid.human_readable = v,
            "Prints the grid with coordinates along its edges.",
        )
        .v1("leveling-strategy.rectangular-grid.human_readable"),
        offsets(|c, _, v| c.leveling.grid.offsets = triple(v)).v1("leveling-strategy.rectangular-grid.probe_offsets"),
        number(
            "dampening_start",
            "0",
            ANY,
            |c, _, v| c.leveling.grid.fade_start = Mm(v),
            "Height from which the correction fades.",
        )
        .unit("mm")
        .klipper("[bed_mesh] fade_start")
        .v1("leveling-strategy.rectangular-grid.dampening_start"),
        number(
            "height_limit",
            "0",
            ANY,
            |c, _, v| c.leveling.grid.fade_end = Mm(v),
            "Height at which the correction has faded to fade_target; not above dampening_start: it never fades.",
        )
        .unit("mm")
        .klipper("[bed_mesh] fade_end")
        .v1("leveling-strategy.rectangular-grid.height_limit"),
        number(
            "fade_target",
            "0",
            ANY,
            |c, _, v| c.leveling.grid.fade_target = Mm(v),
            "The correction that is left at height_limit, the same everywhere: what fades is the difference from it. M376 T changes it.",
        )
        .unit("mm")
        .klipper("[bed_mesh] fade_target")
        .velvet(),
        number(
            "initial_height",
            "10",
            ANY,
            |c, _, v| c.leveling.grid.initial_height = Mm(v),
            "Height moved to fast before searching for the bed.",
        )
        .unit("mm")
        .v1("leveling-strategy.rectangular-grid.initial_height"),
        text(
            "before_probe_gcode",
            "",
            96,
            |c, _, v| c.probe_gcode[0] = line_of(v),
            "Line executed before probing: moves, waits, modes, switches.",
        ),
        text("after_probe_gcode", "", 96, |c, _, v| c.probe_gcode[1] = line_of(v), "Line executed after probing."),
    ],
};

pub const DELTA_GRID: Section = Section {
    name: "delta grid leveling strategy",
    store: None,
    docs: Docs::new("Levels the bed of a delta by a square grid of heights around the middle."),
    form: Form::Plain,
    settings: &[
        number(
            "radius",
            "50",
            &(1.0, 10_000.0),
            |c, _, v| c.leveling.delta.radius = Mm(v),
            "Radius of the probed circle.",
        )
        .unit("mm")
        .v1("leveling-strategy.delta-grid.radius"),
        points("size", |c, _, v| c.leveling.delta.count = v as u8, "Points per side of the square grid.")
            .v1("leveling-strategy.delta-grid.size"),
        number("tolerance", "0.03", ANY, nowhere, "Intended flatness tolerance.")
            .unit("mm")
            .v1("leveling-strategy.delta-grid.tolerance")
            .dormant(),
        bool(
            "save",
            "false",
            |c, _, v| c.leveling.delta.save = v,
            "Makes M500 add a command that reloads the saved grid.",
        )
        .v1("leveling-strategy.delta-grid.save"),
        bool(
            "do_home",
            "true",
            |c, _, v| c.leveling.delta.home = v,
            "Homes before probing. With home_gcode it must have been homed.",
        )
        .v1("leveling-strategy.delta-grid.do_home"),
        number(
            "initial_height",
            "10",
            ANY,
            |c, _, v| c.leveling.delta.initial_height = Mm(v),
            "Height moved to fast before searching for the bed.",
        )
        .unit("mm")
        .v1("leveling-strategy.delta-grid.initial_height"),
        offsets(|c, _, v| c.leveling.delta.offsets = triple(v)).v1("leveling-strategy.delta-grid.probe_offsets"),
    ],
};

pub const BED_MESH: Section = Section {
    name: "bed mesh",
    store: None,
    docs: Docs::new("What the grids of both strategies have in common. docs/leveling.md tells more."),
    form: Form::Plain,
    settings: &[
        word(
            "interpolation",
            "spline",
            &Words(&["spline", "bilinear", "lagrange"]),
            |c, _, v| c.leveling.mesh.interpolation = interpolation(v),
            "What lies between the points: a smooth surface, straight lines (25 points along a side at most), or one polynomial \
             through all points of a line (6 at most).",
        )
        .klipper("[bed_mesh] algorithm")
        .velvet(),
        number(
            "adaptive_margin",
            "5",
            NOT_NEGATIVE,
            |c, _, v| c.leveling.mesh.adaptive_margin = Mm(v),
            "How far around the objects of a file the mesh goes that is measured for them alone. G31 D changes it.",
        )
        .unit("mm")
        .typical(&(0.0, 50.0))
        .klipper("[bed_mesh] adaptive_margin")
        .velvet(),
        places(
            "faulty_regions",
            2 * MAX_FAULTY,
            |c, _, v| c.leveling.mesh.faulty_regions = heapless::Vec::from_slice(v).unwrap_or_default(),
            "Where the bed must not be touched, as over a magnet: two opposite corners of each rectangle. Points in one are \
             worked out from its edges.",
        )
        .klipper("[bed_mesh] faulty_region_1_min")
        .velvet(),
        numbers(
            "zero_reference",
            2,
            |c, _, v| c.leveling.mesh.zero_reference = v.try_into().ok(),
            "Where the mesh has the height zero; none: at its first point, on a delta in the middle.",
        )
        .unit("mm")
        .klipper("[bed_mesh] zero_reference_position")
        .velvet(),
    ],
};

const fn interpolation(word: usize) -> MeshInterpolation {
    match word {
        0 => MeshInterpolation::Spline,
        1 => MeshInterpolation::Bilinear,
        _ => MeshInterpolation::Lagrange,
    }
}

pub const SKEW_CORRECTION: Section = Section {
    name: "skew correction",
    store: None,
    docs: Docs::new(
        "Takes back that two axes of the machine are not at right angles. For each plane either the factor (the tangent of the \
              angle by which the second axis leans towards the first) or three lengths measured on a square made with the machine.",
    ),
    form: Form::Plain,
    settings: &[
        factor("xy", |c, _, v| c.leveling.skew[0].factor = v, "How far Y leans towards X. M852 I changes it."),
        factor("xz", |c, _, v| c.leveling.skew[1].factor = v, "How far Z leans towards X. M852 J changes it."),
        factor("yz", |c, _, v| c.leveling.skew[2].factor = v, "How far Z leans towards Y. M852 K changes it."),
        lengths(
            "xy_measured",
            |c, _, v| c.leveling.skew[0].measured = triple_or_none(v),
            "AC,BD,AD of a square with AB along X and AD along Y.",
        ),
        lengths(
            "xz_measured",
            |c, _, v| c.leveling.skew[1].measured = triple_or_none(v),
            "AC,BD,AD of a square with AB along X and AD along Z.",
        ),
        lengths(
            "yz_measured",
            |c, _, v| c.leveling.skew[2].measured = triple_or_none(v),
            "AC,BD,AD of a square with AB along Y and AD along Z.",
        ),
    ],
};

type SetNumbers = for<'v> fn(&mut crate::MachineConfig, usize, &'v [f64]);

const fn point(key: &'static str, set: SetNumbers, summary: &'static str) -> Setting {
    numbers(key, 2, set, summary).unit("mm")
}

const fn offsets(set: SetNumbers) -> Setting {
    numbers("probe_offsets", 3, set, "Probe position relative to the nozzle as X,Y and how high the nozzle is as the contact closes. M565 changes it.").unit("mm")
}

const fn size(key: &'static str, set: super::Set<f64>, summary: &'static str) -> Setting {
    number(key, "0", &(-10_000.0, 10_000.0), set, summary).unit("mm")
}

const fn points(key: &'static str, set: super::Set<i64>, summary: &'static str) -> Setting {
    integer(key, "7", SIDE, set, summary).unit("points").klipper("[bed_mesh] probe_count")
}

const fn factor(key: &'static str, set: super::Set<f64>, summary: &'static str) -> Setting {
    number(key, "0", SKEW, set, summary).velvet()
}

const fn lengths(key: &'static str, set: SetNumbers, summary: &'static str) -> Setting {
    numbers(key, 3, set, summary).unit("mm").velvet()
}

fn pair(values: &[f64]) -> [f64; 2] {
    values.try_into().unwrap_or_default()
}

fn triple(values: &[f64]) -> [f64; 3] {
    values.try_into().unwrap_or_default()
}

fn triple_or_none(values: &[f64]) -> Option<[f64; 3]> {
    values.try_into().ok()
}

/// As long as the schema lets it be.
pub(super) fn line_of(text: &str) -> crate::machine::Command {
    crate::machine::Command::try_from(text).unwrap_or_default()
}
