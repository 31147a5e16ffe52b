//! The leveling strategies and `[skew correction]`.

use heapless::Vec;
use units::Mm;

/// How the bed is leveled.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Leveling {
    /// As a plane through three points.
    ThreePoint,
    /// By a square grid around the middle.
    DeltaGrid,
    /// By a rectangular grid.
    CartesianGrid,
}

/// What levels the machine, and how its axes lean.
#[derive(Clone, Debug, Default)]
pub struct LevelingConfig {
    /// `[zprobe] leveling`
    pub strategy: Option<Leveling>,
    /// `[three point leveling strategy]` `point1` to `point3`: X and Y, mm.
    pub points: [[f64; 2]; 3],
    /// Its `probe_offsets`, mm.
    pub plane_offsets: [f64; 3],
    /// It homes X and Y first.
    pub home_first: bool,
    /// Its heights are one when they differ by no more.
    pub tolerance: Mm,
    /// M500 stores the plane.
    pub save_plane: bool,
    /// `[cartesian grid leveling strategy]`
    pub grid: CartesianGrid,
    /// `[delta grid leveling strategy]`
    pub delta: DeltaGrid,
    /// `[bed mesh]`
    pub mesh: MeshConfig,
    /// `[skew correction]`: XY, XZ, YZ.
    pub skew: [SkewConfig; 3],
}

/// `[cartesian grid leveling strategy]`
#[derive(Clone, Copy, Debug, Default)]
pub struct CartesianGrid {
    /// Of the area, from the origin along X and Y.
    pub size: [Mm; 2],
    /// Points along X and Y.
    pub count: [u8; 2],
    /// M500 adds a command that loads the grid.
    pub save: bool,
    /// The area comes with each probing.
    pub two_corners: bool,
    /// Printed with coordinates.
    pub human_readable: bool,
    /// It homes first.
    pub home: bool,
    /// Height from which the bed is searched for.
    pub initial_height: Mm,
    /// Probe relative to the nozzle, mm.
    pub offsets: [f64; 3],
    /// `dampening_start`
    pub fade_start: Mm,
    /// `height_limit`
    pub fade_end: Mm,
    /// The correction that is left there.
    pub fade_target: Mm,
}

/// `[delta grid leveling strategy]`
#[derive(Clone, Copy, Debug, Default)]
pub struct DeltaGrid {
    /// Of the probed circle.
    pub radius: Mm,
    /// Points along a side.
    pub count: u8,
    /// M500 adds a command that loads the grid.
    pub save: bool,
    /// It homes first.
    pub home: bool,
    /// Height from which the bed is searched for.
    pub initial_height: Mm,
    /// Probe relative to the nozzle, mm.
    pub offsets: [f64; 3],
}

/// Regions of a bed that cannot be touched, at most.
pub const MAX_FAULTY: usize = 8;

/// What lies between the points of a grid.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum MeshInterpolation {
    /// A smooth surface.
    #[default]
    Spline,
    /// Straight lines.
    Bilinear,
    /// One polynomial through all points of a line.
    Lagrange,
}

impl MeshInterpolation {
    /// Points along a side that it takes at most.
    #[must_use]
    pub const fn most_points(self) -> u8 {
        match self {
            Self::Spline => 50,
            Self::Bilinear => 25,
            Self::Lagrange => 6,
        }
    }
}

/// `[bed mesh]`
#[derive(Clone, Debug, Default)]
pub struct MeshConfig {
    /// What lies between the points.
    pub interpolation: MeshInterpolation,
    /// Around the objects of a file, where the mesh is measured for them alone.
    pub adaptive_margin: Mm,
    /// Two opposite corners of each region that is not touched, X and Y, mm.
    pub faulty_regions: Vec<[f64; 2], { 2 * MAX_FAULTY }>,
    /// Heights are told from that of the bed here, X and Y, mm.
    pub zero_reference: Option<[f64; 2]>,
}

/// How one axis leans towards another.
#[derive(Clone, Copy, Debug, Default)]
pub struct SkewConfig {
    /// The tangent.
    pub factor: f64,
    /// AC, BD and AD of a square, mm, which the factor follows from.
    pub measured: Option<[f64; 3]>,
}
