//! The leveling strategies, `[bed mesh]` and `[skew correction]`.

use crate::names::Command;
use crate::setting::Words;
use crate::setting::build::{ANY, NOT_NEGATIVE, bool, integer, number, numbers, places, text, word};
use crate::setting::declare::{settings, words};
use crate::setting::field::word_field;
use heapless::Vec;
use units::{Interpolation, Mm};

words! {
    /// Method of bed leveling.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub enum Leveling {
        /// Plane through three points.
        ThreePoint = "three point",
        /// Square grid around the middle.
        DeltaGrid = "delta grid",
        /// Rectangular grid of points.
        CartesianGrid = "cartesian grid",
    }
}

settings! {
    /// Levels the bed as a plane through three probed points.
    #[derive(Clone, Debug, Default)]
    pub struct LevelingConfig {
        /// Strategy of bed leveling: `[zprobe] leveling`.
        strategy: Option<Leveling>;
        /// `[three point leveling strategy]` `point1` to `point3`: X and Y, mm.
        points: [[f64; 2]; 3];
        /// First probe point as X,Y. M557 P0 changes it.
        "point1" points[0] = numbers(2).unit("mm").v1("leveling-strategy.three-point-leveling.point1");
        /// Second probe point as X,Y. M557 P1 changes it.
        "point2" points[1] = numbers(2).unit("mm").v1("leveling-strategy.three-point-leveling.point2");
        /// Third probe point as X,Y. M557 P2 changes it.
        "point3" points[2] = numbers(2).unit("mm").v1("leveling-strategy.three-point-leveling.point3");
        /// Probe position relative to the nozzle as X,Y and how high the nozzle is as the contact closes.
        /// M565 changes it.
        "probe_offsets" plane_offsets: [f64; 3] = numbers(3)
            .unit("mm").v1("leveling-strategy.three-point-leveling.probe_offsets");
        /// Homes X and Y before probing.
        home_first: bool = bool("true").v1("leveling-strategy.three-point-leveling.home_first");
        /// Height spread up to which the bed counts as flat.
        tolerance: Mm = number("0.03", NOT_NEGATIVE).unit("mm").v1("leveling-strategy.three-point-leveling.tolerance");
        /// Lets M500 store the plane.
        save_plane: bool = bool("false").v1("leveling-strategy.three-point-leveling.save_plane");
        /// Section `[cartesian grid leveling strategy]`.
        grid: CartesianGrid;
        /// Section `[delta grid leveling strategy]`.
        delta: DeltaGrid;
        /// Section `[bed mesh]`: interpolation and regions.
        mesh: MeshConfig;
        /// Section `[skew correction]`: XY, XZ, YZ.
        skew: [SkewConfig; 3];
    }
}

settings! {
    /// Levels the bed by a rectangular grid of heights, through which a smooth surface is laid.
    #[derive(Clone, Copy, Debug, Default)]
    pub struct CartesianGrid {
        /// Corner at which the probed area begins.
        start: [Mm; 2];
        /// X at which the probed area begins.
        "x_start" start[0] = number("0", ANY).unit("mm").klipper("[bed_mesh] mesh_min").velvet();
        /// Y at which the probed area begins.
        "y_start" start[1] = number("0", ANY).unit("mm").klipper("[bed_mesh] mesh_min").velvet();
        /// Size of the probed area from its start along X and Y.
        size: [Mm; 2];
        /// Width of the area from x_start; may be negative.
        "x_size" size[0] = number("0", &(-10_000.0, 10_000.0))
            .unit("mm").v1("leveling-strategy.rectangular-grid.x_size");
        /// Depth of the area from y_start; may be negative.
        "y_size" size[1] = number("0", &(-10_000.0, 10_000.0))
            .unit("mm").v1("leveling-strategy.rectangular-grid.y_size");
        /// Points along X and Y.
        count: [u8; 2];
        /// Grid points along X.
        "grid_x_size" count[0] = integer("7", SIDE)
            .unit("points").klipper("[bed_mesh] probe_count").v1("leveling-strategy.rectangular-grid.grid_x_size");
        /// Grid points along Y.
        "grid_y_size" count[1] = integer("7", SIDE)
            .unit("points").klipper("[bed_mesh] probe_count").v1("leveling-strategy.rectangular-grid.grid_y_size");
        /// Intended flatness tolerance.
        "tolerance" = number("0.03", ANY).unit("mm").v1("leveling-strategy.rectangular-grid.tolerance").dormant();
        /// Makes M500 add a command that reloads the saved grid.
        save: bool = bool("false").v1("leveling-strategy.rectangular-grid.save");
        /// Homes before the grid probe. With home_gcode it must have been homed.
        "do_home" home: bool = bool("true").v1("leveling-strategy.rectangular-grid.do_home");
        /// Takes the area from the G31/G32 line instead of the config; such a grid is neither saved nor
        /// loaded.
        "only_by_two_corners" two_corners: bool = bool("false")
            .v1("leveling-strategy.rectangular-grid.only_by_two_corners");
        /// Prints the grid with coordinates along its edges.
        human_readable: bool = bool("false").v1("leveling-strategy.rectangular-grid.human_readable");
        /// Probe position relative to the nozzle as X,Y and how high the nozzle is as the contact closes.
        /// M565 changes it.
        "probe_offsets" offsets: [f64; 3] = numbers(3)
            .unit("mm").v1("leveling-strategy.rectangular-grid.probe_offsets");
        /// Height from which the correction fades.
        "dampening_start" fade_start: Mm = number("0", ANY)
            .unit("mm").klipper("[bed_mesh] fade_start").v1("leveling-strategy.rectangular-grid.dampening_start");
        /// Height at which the correction has faded to fade_target; not above dampening_start: it never
        /// fades.
        "height_limit" fade_end: Mm = number("0", ANY)
            .unit("mm").klipper("[bed_mesh] fade_end").v1("leveling-strategy.rectangular-grid.height_limit");
        /// The correction that is left at height_limit, the same everywhere: what fades is the difference
        /// from it. M376 T changes it.
        fade_target: Mm = number("0", ANY).unit("mm").klipper("[bed_mesh] fade_target").velvet();
        /// Height moved to fast before searching for the bed.
        initial_height: Mm = number("10", ANY).unit("mm").v1("leveling-strategy.rectangular-grid.initial_height");
    }
}

/// Lines executed before and after probing.
type GridScripts = [Command; 2];

settings! {
    /// What is done around the probing of a grid.
    rows CartesianGridScripts of GridScripts {
        /// Line executed before probing: moves, waits, modes, switches.
        "before_probe_gcode" [0] = text("", 96);
        /// Line executed after probing.
        "after_probe_gcode" [1] = text("", 96);
    }
}

settings! {
    /// Levels the bed of a delta by a square grid of heights around the middle.
    #[derive(Clone, Copy, Debug, Default)]
    pub struct DeltaGrid {
        /// Radius of the probed circle.
        radius: Mm = number("50", &(1.0, 10_000.0)).unit("mm").v1("leveling-strategy.delta-grid.radius");
        /// Points per side of the square grid.
        "size" count: u8 = integer("7", SIDE)
            .unit("points").klipper("[bed_mesh] probe_count").v1("leveling-strategy.delta-grid.size");
        /// Intended flatness tolerance.
        "tolerance" = number("0.03", ANY).unit("mm").v1("leveling-strategy.delta-grid.tolerance").dormant();
        /// Makes M500 add a command that reloads the saved grid.
        save: bool = bool("false").v1("leveling-strategy.delta-grid.save");
        /// Homes before probing. With home_gcode it must have been homed.
        "do_home" home: bool = bool("true").v1("leveling-strategy.delta-grid.do_home");
        /// Height moved to fast before searching for the bed.
        initial_height: Mm = number("10", ANY).unit("mm").v1("leveling-strategy.delta-grid.initial_height");
        /// Probe position relative to the nozzle as X,Y and how high the nozzle is as the contact closes.
        /// M565 changes it.
        "probe_offsets" offsets: [f64; 3] = numbers(3).unit("mm").v1("leveling-strategy.delta-grid.probe_offsets");
    }
}

/// Greatest number of regions of a bed that must not be touched.
pub const MAX_FAULTY: usize = 8;

word_field!(Interpolation);

settings! {
    /// What the grids of both strategies have in common. docs/leveling.md tells more.
    #[derive(Clone, Debug, Default)]
    pub struct MeshConfig {
        /// What lies between the points: a smooth surface, straight lines (25 points along a side at most),
        /// or one polynomial through all points of a line (6 at most).
        interpolation: Interpolation = word("spline", &Words(Interpolation::WORDS))
            .klipper("[bed_mesh] algorithm").velvet();
        /// How far around the objects of a file the mesh goes that is measured for them alone. G31 D changes
        /// it.
        adaptive_margin: Mm = number("5", NOT_NEGATIVE)
            .unit("mm").typical(&(0.0, 50.0)).klipper("[bed_mesh] adaptive_margin").velvet();
        /// Where the bed must not be touched, as over a magnet: two opposite corners of each rectangle.
        /// Points in one are worked out from its edges.
        faulty_regions: Vec<[f64; 2], { 2 * MAX_FAULTY }> = places(2 * MAX_FAULTY)
            .klipper("[bed_mesh] faulty_region_1_min").velvet();
        /// Where the mesh has the height zero; none: at its first point, on a delta in the middle.
        zero_reference: Option<[f64; 2]> = numbers(2)
            .unit("mm").klipper("[bed_mesh] zero_reference_position").velvet();
    }
}

/// Skew of one axis towards another.
#[derive(Clone, Copy, Debug, Default)]
pub struct SkewConfig {
    /// Tangent of the skew angle.
    pub factor: f64,
    /// Lengths AC, BD and AD of a measured square, mm, from which the factor follows.
    pub measured: Option<[f64; 3]>,
}

settings! {
    /// Takes back that two axes of the machine are not at right angles. For each plane either the factor (the
    /// tangent of the angle by which the second axis leans towards the first) or three lengths measured on a
    /// square made with the machine.
    rows SkewCorrection of LevelingConfig {
        /// How far Y leans towards X. M852 I changes it.
        "xy" skew[0].factor = number("0", SKEW).velvet();
        /// How far Z leans towards X. M852 J changes it.
        "xz" skew[1].factor = number("0", SKEW).velvet();
        /// How far Z leans towards Y. M852 K changes it.
        "yz" skew[2].factor = number("0", SKEW).velvet();
        /// AC,BD,AD of a square with AB along X and AD along Y.
        "xy_measured" skew[0].measured = numbers(3).unit("mm").velvet();
        /// AC,BD,AD of a square with AB along X and AD along Z.
        "xz_measured" skew[1].measured = numbers(3).unit("mm").velvet();
        /// AC,BD,AD of a square with AB along Y and AD along Z.
        "yz_measured" skew[2].measured = numbers(3).unit("mm").velvet();
    }
}

/// Points along a side of a grid; `motion` has room for no more.
const SIDE: &(i64, i64) = &(2, 50);
/// Skew factors: tangents of six degrees.
const SKEW: &(f64, f64) = &(-0.1, 0.1);

settings! {
    /// The choice of the strategy.
    rows ProbeLeveling of LevelingConfig {
        /// How the bed is leveled; the strategy has a section of its own. M374 and M375 save and load its
        /// grid.
        "leveling" strategy = word("", Leveling::WORDS);
    }
}
