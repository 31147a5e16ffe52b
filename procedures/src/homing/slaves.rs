//! Homing of an axis that two motors move, each with a switch of its own.
//!
//! A gantry that is racked closes the slave's switch before the master's. Going on would drive the slave into
//! its stop, so it may go on only as far as past any switch; after that the axis is called racked.

use units::{Axis, AxisSet, PerAxis};

use super::overtravel::RUN_ON;

/// Axes whose slave's switch has closed before the master's own: they may go on a little, and no further.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct SlavesAhead {
    axes: AxisSet,
    /// Position at which each axis must end, mm, and its direction.
    bounds: PerAxis<(f64, f64)>,
}

impl SlavesAhead {
    pub(super) const fn axes(&self) -> AxisSet {
        self.axes
    }

    /// Notes that the slave's switch of this axis closed here, on its way `towards` (1 or -1).
    pub(super) fn closed(&mut self, axis: Axis, at: f64, towards: f64) {
        self.axes = self.axes.with(axis);
        self.bounds[axis] = (at + towards * RUN_ON, towards);
    }

    /// Returns a target that ends at the bounds; an axis that is past its bound already stays.
    pub(super) fn bounded(&self, mut target: PerAxis<f64>, here: &PerAxis<f64>) -> PerAxis<f64> {
        for axis in self.axes.axes() {
            let (bound, towards) = self.bounds[axis];
            if (target[axis] - bound) * towards > 0.0 {
                target[axis] = if (here[axis] - bound) * towards > 0.0 { here[axis] } else { bound };
            }
        }
        target
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn x(mm: f64) -> PerAxis<f64> {
        let mut position = PerAxis([0.0; units::MAX_AXES]);
        position[Axis::X] = mm;
        position
    }

    #[test]
    fn the_axis_goes_on_by_what_any_switch_gives_way_and_no_further() {
        for (towards, at) in [(-1.0, 2.0), (1.0, 198.0)] {
            let mut slaves = SlavesAhead::default();
            let far = x(at + towards * 50.0);
            assert_eq!(slaves.bounded(far, &x(at)), far);
            slaves.closed(Axis::X, at, towards);
            let bound = at + towards * 0.25;
            assert_eq!(slaves.bounded(far, &x(at)), x(bound));
            assert_eq!(slaves.bounded(x(at), &x(at)), x(at), "a nearer target is left alone");
            let past = x(bound + towards * 0.05);
            assert_eq!(slaves.bounded(far, &past), past, "it never turns back");
        }
    }
}
