//! The leveling strategies and `[skew correction]`.

use heapless::Vec;
use units::Mm;

/// Method of bed leveling.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Leveling {
    /// Plane through three points.
    ThreePoint,
    /// Square grid around the middle.
    DeltaGrid,
    /// Rectangular grid of points.
    CartesianGrid,
}

/// Bed leveling and skew of the axes.
#[derive(Clone, Debug, Default)]
pub struct LevelingConfig {
    /// Strategy of bed leveling: `[zprobe] leveling`.
    pub strategy: Option<Leveling>,
    /// `[three point leveling strategy]` `point1` to `point3`: X and Y, mm.
    pub points: [[f64; 2]; 3],
    /// Probe offsets of the three-point strategy, mm.
    pub plane_offsets: [f64; 3],
    /// Whether X and Y home before the three-point probing.
    pub home_first: bool,
    /// Greatest difference of the three heights that counts as level.
    pub tolerance: Mm,
    /// Whether M500 stores the plane.
    pub save_plane: bool,
    /// Section `[cartesian grid leveling strategy]`.
    pub grid: CartesianGrid,
    /// Section `[delta grid leveling strategy]`.
    pub delta: DeltaGrid,
    /// Section `[bed mesh]`: interpolation and regions.
    pub mesh: MeshConfig,
    /// Section `[skew correction]`: XY, XZ, YZ.
    pub skew: [SkewConfig; 3],
}

/// Section `[cartesian grid leveling strategy]`.
#[derive(Clone, Copy, Debug, Default)]
pub struct CartesianGrid {
    /// Size of the probed area from the origin along X and Y.
    pub size: [Mm; 2],
    /// Points along X and Y.
    pub count: [u8; 2],
    /// Whether M500 adds a command that loads the grid.
    pub save: bool,
    /// Whether the area comes from the code of each probing instead.
    pub two_corners: bool,
    /// Whether the grid is printed with coordinates.
    pub human_readable: bool,
    /// Whether the machine homes before probing.
    pub home: bool,
    /// Height from which the search for the bed begins.
    pub initial_height: Mm,
    /// Position of the probe relative to the nozzle, mm.
    pub offsets: [f64; 3],
    /// Height from which the correction fades: `dampening_start`.
    pub fade_start: Mm,
    /// Height at which the fade ends: `height_limit`.
    pub fade_end: Mm,
    /// Correction that is left at `fade_end`.
    pub fade_target: Mm,
}

/// Section `[delta grid leveling strategy]`.
#[derive(Clone, Copy, Debug, Default)]
pub struct DeltaGrid {
    /// Radius of the probed circle.
    pub radius: Mm,
    /// Points along a side of the grid.
    pub count: u8,
    /// Whether M500 adds a command that loads the grid.
    pub save: bool,
    /// Whether the machine homes before probing.
    pub home: bool,
    /// Height from which the search for the bed begins.
    pub initial_height: Mm,
    /// Position of the probe relative to the nozzle, mm.
    pub offsets: [f64; 3],
}

/// Greatest number of regions of a bed that must not be touched.
pub const MAX_FAULTY: usize = 8;

/// Interpolation between the points of a bed mesh.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum MeshInterpolation {
    /// Smooth surface through the points.
    #[default]
    Spline,
    /// Straight lines between the points.
    Bilinear,
    /// Lagrange polynomial through all points of a line.
    Lagrange,
}

impl MeshInterpolation {
    /// Returns the greatest number of points along a side for this interpolation.
    #[must_use]
    pub const fn most_points(self) -> u8 {
        match self {
            Self::Spline => 50,
            Self::Bilinear => 25,
            Self::Lagrange => 6,
        }
    }
}

/// Section `[bed mesh]`: interpolation and regions.
#[derive(Clone, Debug, Default)]
pub struct MeshConfig {
    /// Interpolation between the points.
    pub interpolation: MeshInterpolation,
    /// Margin around the objects of a file, when the mesh covers only the objects.
    pub adaptive_margin: Mm,
    /// Opposite corners of each region that must not be touched, X and Y, mm.
    pub faulty_regions: Vec<[f64; 2], { 2 * MAX_FAULTY }>,
    /// Position at which the mesh has the height zero, X and Y, mm.
    pub zero_reference: Option<[f64; 2]>,
}

/// Skew of one axis towards another.
#[derive(Clone, Copy, Debug, Default)]
pub struct SkewConfig {
    /// Tangent of the skew angle.
    pub factor: f64,
    /// Lengths AC, BD and AD of a measured square, mm, from which the factor follows.
    pub measured: Option<[f64; 3]>,
}
