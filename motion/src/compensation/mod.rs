//! Compensation: between the machine space of the program and the space in which the motors' axes are
//! straight.
//!
//! Order, from the program to the motors: work offsets and tool offsets (outside this crate), trajectory,
//! filters, **levelling, skew**, kinematics. Levelling adds the bed's height at the program's X and Y to Z,
//! less the higher Z is ([`Fade`]): `z' = z + share(z) h(x, y)`. Skew ([`Skew`]) then takes back that the
//! axes lean, at the height where Z really is. Shapers come first because they are for the vibrations of the
//! axes as programmed, and because a moved average would take the surface to another place.
//!
//! Nothing is cut into pieces: at each knot the point goes through this map and the velocity through its
//! derivative, so steps are as exact as without. The map is smooth (second derivatives are continuous);
//! `Lift` bounds what it adds to a motor's way.

mod b_spline;
mod fade;
mod interpolation;
mod lift;
mod limits;
mod skew;
mod surface;
#[cfg(test)]
mod tests;

pub use fade::Fade;
pub(crate) use lift::{Lift, Over};
pub use limits::{CompensationError, LEAST_STEP, MOST_HEIGHT, MOST_POINTS, MOST_SKEW, MOST_SLOPE};
pub use skew::Skew;
pub use surface::{GridShape, Height, Surface};
pub use units::{Interpolation, MOST_SIDE};

use units::{Axis, PerAxis};

use crate::{elsewhere::Elsewhere, greatest};
use surface::Bounds;

/// A tilted bed: its height is `x X + y Y + z`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Plane {
    /// Rise for each mm along X.
    pub x: f64,
    /// Rise for each mm along Y.
    pub y: f64,
    /// Height at the origin, mm.
    pub z: f64,
}

impl Plane {
    /// The plane `a X + b Y + c Z + d = 0`. `None` when it stands upright.
    #[must_use]
    pub fn from_equation([a, b, c, d]: [f64; 4]) -> Option<Self> {
        let plane = Self { x: -a / c, y: -b / c, z: -d / c };
        [plane.x, plane.y, plane.z].iter().all(|part| part.is_finite()).then_some(plane)
    }

    fn check(&self) -> Result<(), CompensationError> {
        let is_level = |slope: &f64| libm::fabs(*slope) <= MOST_SLOPE;
        if ![self.x, self.y].iter().all(is_level) {
            return Err(CompensationError::PlaneSteep);
        }
        if libm::fabs(self.z) <= MOST_HEIGHT { Ok(()) } else { Err(CompensationError::PlaneHigh) }
    }
}

/// Surface that levels the machine.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Bed {
    /// No levelling: the bed counts as flat.
    #[default]
    Flat,
    /// A plane through the bed.
    Plane(Plane),
    /// The grid that [`Surface`] holds.
    Grid,
}

/// A point as the motors see it, and the change of directions there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Warped {
    pub point: PerAxis<f64>,
    /// Change of the motors' Z for a mm along X, Y and Z.
    z_slope: [f64; 3],
}

/// The compensation in force.
#[derive(Debug)]
pub struct Compensation {
    skew: Skew,
    bed: Bed,
    fade: Option<Fade>,
    suspended: bool,
    active: bool,
    surface: Elsewhere<Surface>,
    /// Number of changes so far, wrapping.
    changes: u32,
}

impl Compensation {
    /// Creates a compensation that changes nothing.
    pub(crate) const fn new(surface: Elsewhere<Surface>) -> Self {
        Self { skew: Skew::NONE, bed: Bed::Flat, fade: None, suspended: false, active: false, surface, changes: 0 }
    }

    /// Copies another compensation. A grid that is still being measured there is not copied.
    pub(crate) fn copy(&mut self, other: &Self) {
        (self.skew, self.bed, self.fade) = (other.skew, other.bed, other.fade);
        (self.suspended, self.active, self.changes) = (other.suspended, other.active, other.changes);
        let Self { surface, .. } = other;
        if other.bed == Bed::Grid {
            self.surface.copy_in_force(surface);
        }
    }

    // --- what is in force ---

    /// Returns whether program and motors have different spaces.
    #[must_use]
    pub const fn is_active(&self) -> bool {
        self.active
    }

    /// Returns whether compensation is suspended ([`crate::Motion::suspend_compensation`]).
    #[must_use]
    pub const fn is_suspended(&self) -> bool {
        self.suspended
    }

    /// Returns the number of changes so far: a holder of a copy compares it to see whether the copy is old.
    #[must_use]
    pub const fn changes(&self) -> u32 {
        self.changes
    }

    /// Skew factors, in force unless suspended.
    #[must_use]
    pub const fn skew(&self) -> Skew {
        self.skew
    }

    /// The bed's shape, in force unless suspended.
    #[must_use]
    pub const fn bed(&self) -> Bed {
        self.bed
    }

    /// Heights between which levelling fades out.
    #[must_use]
    pub const fn fade(&self) -> Option<Fade> {
        self.fade
    }

    /// Returns the correction that is left above the end of fading, mm.
    pub(crate) fn target(&self) -> f64 {
        self.fade.map_or(0.0, |fade| fade.target)
    }

    /// The grid, while one levels the machine.
    #[must_use]
    pub fn grid(&self) -> Option<&Surface> {
        (self.bed == Bed::Grid).then_some(&*self.surface)
    }

    /// The bed's height at X and Y, whether suspended or not.
    #[must_use]
    pub fn height(&self, x: f64, y: f64) -> Height {
        match self.bed {
            Bed::Plane(plane) => Height { z: plane.x * x + plane.y * y + plane.z, slope: [plane.x, plane.y] },
            Bed::Grid => self.surface.at(x, y),
            Bed::Flat => Height::default(),
        }
    }

    // --- the map ---

    /// Whether a straight way stays straight and even.
    pub(crate) fn is_linear(&self) -> bool {
        !self.active || self.bed == Bed::Flat || (matches!(self.bed, Bed::Plane(_)) && self.fade.is_none())
    }

    /// Returns the motors' place for a place of the program.
    #[must_use]
    pub fn motors(&self, point: &PerAxis<f64>) -> PerAxis<f64> {
        if self.active { self.at(point).point } else { *point }
    }

    /// Returns the motors' place for a place of the program, and the slopes there.
    pub(crate) fn at(&self, point: &PerAxis<f64>) -> Warped {
        let [x, y, z, ..] = point.0;
        let height = self.height(x, y);
        let (share, change) = self.fade.map_or((1.0, 0.0), |fade| fade.share(z));
        let (target, fading) = (self.target(), height.z - self.target());
        let mut lifted = *point;
        lifted[Axis::Z] += target + share * fading;
        let [dx, dy] = height.slope;
        Warped { point: self.skew.apply(&lifted), z_slope: [share * dx, share * dy, 1.0 + change * fading] }
    }

    /// A direction or velocity at a place, as the motors see it.
    pub(crate) fn along(&self, at: &Warped, direction: &PerAxis<f64>) -> PerAxis<f64> {
        let ([x, y, z, ..], [dx, dy, dz]) = (direction.0, at.z_slope);
        let mut lifted = *direction;
        lifted[Axis::Z] = dx * x + dy * y + dz * z;
        self.skew.apply(&lifted)
    }

    /// Returns the program's place for a place of the motors.
    #[must_use]
    pub fn program(&self, point: &PerAxis<f64>) -> PerAxis<f64> {
        if !self.active {
            return *point;
        }
        let mut place = self.skew.undo(point);
        let [x, y, z, ..] = place.0;
        let target = self.target();
        place[Axis::Z] = self.without_height(z - target, self.height(x, y).z - target);
        place
    }

    /// Returns the Z for which `z' = z + share(z) height` is `lifted`.
    fn without_height(&self, lifted: f64, height: f64) -> f64 {
        let whole = lifted - height;
        let Some(fade) = self.fade else { return whole };
        if whole <= fade.start {
            return whole;
        }
        if lifted >= fade.end {
            return lifted;
        }
        // The sum rises with Z everywhere, by half as much at least, so halving finds the only solution.
        let (mut low, mut high) = if height > 0.0 { (whole, lifted) } else { (lifted, whole) };
        for _ in 0..60 {
            let middle = low + 0.5 * (high - low);
            if middle + fade.share(middle).0 * height < lifted {
                low = middle;
            } else {
                high = middle;
            }
        }
        low + 0.5 * (high - low)
    }

    fn bounds_of(&self, low: [f64; 2], high: [f64; 2]) -> Bounds {
        match self.bed {
            Bed::Plane(plane) => {
                let mut bounds = Bounds { low: f64::INFINITY, high: -f64::INFINITY, ..Bounds::NONE };
                for [x, y] in [low, [low[0], high[1]], [high[0], low[1]], high] {
                    let z = plane.x * x + plane.y * y + plane.z;
                    (bounds.low, bounds.high) = (crate::least(bounds.low, z), greatest(bounds.high, z));
                }
                Bounds { slope: [libm::fabs(plane.x), libm::fabs(plane.y)], ..bounds }
            }
            Bed::Grid => self.surface.bounds_of(low, high),
            Bed::Flat => Bounds::NONE,
        }
    }

    // --- changing it, by the motion object at rest ---

    /// Returns the heights that are being gathered.
    pub(crate) fn draft(&mut self) -> &mut [f32] {
        &mut self.surface.draft
    }

    /// Begins a draft with the heights in force, or with a flat bed.
    pub(crate) fn copy_to_draft(&mut self) {
        let surface = &mut *self.surface;
        if self.bed == Bed::Grid {
            surface.draft.copy_from_slice(&surface.heights);
        } else {
            surface.draft.fill(0.0);
        }
    }

    /// Suspends the compensation, or puts it in force again.
    pub(crate) fn set_suspended(&mut self, suspended: bool) {
        self.suspended = suspended;
        self.changed();
    }

    /// Sets the skew factors.
    pub(crate) fn set_skew(&mut self, skew: Skew) -> Result<(), CompensationError> {
        skew.check()?;
        self.skew = skew;
        self.changed();
        Ok(())
    }

    /// Ends levelling.
    pub(crate) fn set_flat(&mut self) {
        self.bed = Bed::Flat;
        self.fade = None;
        self.changed();
    }

    /// Levels by a plane.
    pub(crate) fn set_plane(&mut self, plane: Plane) -> Result<(), CompensationError> {
        plane.check()?;
        (self.bed, self.fade) = (Bed::Plane(plane), None);
        self.changed();
        Ok(())
    }

    /// Levels by the heights gathered in the surface's draft.
    pub(crate) fn set_grid(
        &mut self,
        shape: &GridShape,
        interpolation: Interpolation,
        fade: Option<Fade>,
    ) -> Result<(), CompensationError> {
        self.surface.adopt(shape, interpolation, fade)?;
        (self.bed, self.fade) = (Bed::Grid, fade);
        self.changed();
        Ok(())
    }

    /// Levels by the grid that did last, moved by so much.
    pub(crate) fn set_last_grid(&mut self, [x, y]: [f64; 2], fade: Option<Fade>) -> Result<(), CompensationError> {
        let (mut shape, interpolation) = (*self.surface.shape(), self.surface.interpolation());
        let [ox, oy] = shape.origin;
        shape.origin = [ox + x, oy + y];
        self.surface.draft = self.surface.heights;
        self.set_grid(&shape, interpolation, fade)
    }

    fn changed(&mut self) {
        self.active = !self.suspended && (self.bed != Bed::Flat || self.skew != Skew::NONE);
        self.changes = self.changes.wrapping_add(1);
    }
}
