//! Bounds for one move of the motion that compensation adds to the program's own path.

use units::PerAxis;

use super::{Compensation, Skew, surface::Bounds};
use crate::{
    greatest, least,
    path::{Path, primary},
    square_root,
};

/// Places along a curve from which the box around it is made.
const INTERVALS: u32 = 16;

/// Bounds of the way that levelling adds to Z along a move.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Lift {
    slope: [f64; 2],
    bend: [f64; 3],
    /// First and second derivative of fading, times the greatest height.
    fading: [f64; 2],
    /// First derivative of fading alone, for each mm.
    change: f64,
    /// Least and greatest of what is added, mm.
    pub low: f64,
    pub high: f64,
    /// Way over which the surface may change its bend, mm: it bounds the distance of knots.
    pub scale: f64,
}

impl Lift {
    /// Returns the greatest change of Z for each mm in this direction (of X, Y and Z).
    pub fn slope_along(&self, unit: &[f64; 3]) -> f64 {
        let [x, y, z] = unit.map(libm::fabs);
        x * self.slope[0] + y * self.slope[1] + z * self.fading[0]
    }

    /// Returns the sizes of a direction with the greatest addition to its Z.
    pub fn on_top_of(&self, unit: &[f64; 3]) -> [f64; 3] {
        let [x, y, z] = unit.map(libm::fabs);
        [x, y, z + self.slope_along(unit)]
    }

    /// Returns the greatest change of the slope for each mm straight on in this direction.
    pub fn bend_along(&self, unit: &[f64; 3]) -> f64 {
        let [x, y, z] = unit.map(libm::fabs);
        let ([xx, yy, xy], [first, second]) = (self.bend, [self.change, self.fading[1]]);
        let across = 2.0 * z * first * (x * self.slope[0] + y * self.slope[1]);
        x * x * xx + y * y * yy + 2.0 * x * y * xy + across + z * z * second
    }

    /// Returns the greatest change of Z for each mm in any direction.
    pub fn slope(&self) -> f64 {
        let [x, y] = self.slope;
        square_root(x * x + y * y + self.fading[0] * self.fading[0])
    }

    /// Returns the greatest change of the slope for each mm in any direction.
    pub fn bend(&self) -> f64 {
        let ([xx, yy, xy], [x, y]) = (self.bend, self.slope);
        let flat = greatest(xx, yy) + xy;
        flat + self.change * square_root(x * x + y * y) + self.fading[1]
    }
}

/// Compensation over one move: skew, and the bounds of levelling.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Over {
    pub skew: Option<Skew>,
    pub lift: Option<Lift>,
}

impl Over {
    /// No compensation.
    pub const NONE: Self = Self { skew: None, lift: None };

    /// Returns a point or direction with its skew taken back.
    pub fn skewed(&self, of: &PerAxis<f64>) -> PerAxis<f64> {
        self.skew.map_or(*of, |skew| skew.apply(of))
    }
}

/// A box around a move.
struct Extent {
    low: [f64; 3],
    high: [f64; 3],
}

impl Extent {
    const NOTHING: Self = Self { low: [f64::INFINITY; 3], high: [-f64::INFINITY; 3] };

    fn take(&mut self, point: &PerAxis<f64>) {
        for ((low, high), place) in self.low.iter_mut().zip(&mut self.high).zip(primary(point)) {
            (*low, *high) = (least(*low, place), greatest(*high, place));
        }
    }

    fn widen(&mut self, by: f64) {
        self.low = self.low.map(|place| place - by);
        self.high = self.high.map(|place| place + by);
    }
}

impl Compensation {
    /// Returns the compensation over a straight move.
    pub(crate) fn over_line(&self, from: &PerAxis<f64>, to: &PerAxis<f64>) -> Over {
        if !self.is_active() {
            return Over::NONE;
        }
        let mut extent = Extent::NOTHING;
        extent.take(from);
        extent.take(to);
        self.over(&extent)
    }

    /// Returns the compensation over a move along a curve.
    pub(crate) fn over_path(&self, path: &Path, length: f64) -> Over {
        if !self.is_active() {
            return Over::NONE;
        }
        let mut extent = Extent::NOTHING;
        for index in 0..=INTERVALS {
            extent.take(&path.point(length * f64::from(index) / f64::from(INTERVALS)));
        }
        // Between two sampled places the path is no farther from one of them than half the distance along it.
        extent.widen(0.5 * length / f64::from(INTERVALS));
        self.over(&extent)
    }

    fn over(&self, extent: &Extent) -> Over {
        let skew = (self.skew != Skew::NONE).then_some(self.skew);
        let ([left, near, bottom], [right, far, top]) = (extent.low, extent.high);
        let Bounds { low, high, slope, bend } = self.bounds_of([left, near], [right, far]);
        let target = self.target();
        let most = greatest(libm::fabs(low - target), libm::fabs(high - target));
        let mut lift = Lift { slope, bend, fading: [0.0; 2], change: 0.0, low, high, scale: f64::INFINITY };
        if let Some(grid) = self.grid() {
            let [x, y] = grid.fine.step.map(libm::fabs);
            lift.scale = least(x, y);
        }
        if let Some(fade) = self.fade {
            if bottom >= fade.end {
                let (low, high, fading) = (target, target, [0.0; 2]);
                let lift =
                    Lift { slope: [0.0; 2], bend: [0.0; 3], fading, change: 0.0, low, high, scale: f64::INFINITY };
                return Over { skew, lift: (target != 0.0).then_some(lift) };
            }
            let (first, second) = fade.derivatives(bottom, top);
            (lift.fading, lift.change) = ([first * most, second * most], first);
            lift.scale = if first > 0.0 { least(lift.scale, fade.end - fade.start) } else { lift.scale };
            // Fading moves the correction towards its target, so the target bounds it too.
            (lift.low, lift.high) = (least(low, target), greatest(high, target));
        }
        let is_flat = self.bed == super::Bed::Flat;
        Over { skew, lift: (!is_flat).then_some(lift) }
    }
}
