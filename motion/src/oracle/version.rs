//! A version of the trajectory, before the filters, valid until some of it is taken back.

use std::{sync::Arc, vec::Vec};

use units::PerAxis;

use super::{compensation::Warp, path};
use crate::{FilterConfig, PressureAdvance, trajectory::Piece};

/// Longest time that a filter looks back, ns.
pub(super) const LONGEST_LOOK_BACK_NS: f64 = 1e9;

/// A piece of trajectory, and what holds while it is followed.
#[derive(Clone, Debug)]
pub(super) struct Timed {
    /// Time of the beginning, nanoseconds from boot.
    pub start: f64,
    pub piece: Piece,
    /// Filters in force when the piece came: they hold until the next piece. Filters only change at rest.
    pub filters: FilterConfig,
    pub warp: Option<Arc<Warp>>,
    /// Table of its spline, if it has one.
    pub table: Option<Arc<path::Table>>,
}

/// Pieces of trajectory, in order of time.
#[derive(Clone, Debug)]
pub(super) struct Version {
    /// Time, ns, from which the filters' output is of this version.
    pub from: f64,
    /// Pieces in order of time.
    pub pieces: Vec<Timed>,
}

impl Version {
    /// Returns the first version, which holds from the beginning of time.
    pub const fn first() -> Self {
        Self { from: f64::NEG_INFINITY, pieces: Vec::new() }
    }

    /// The version that is the same up to `from`, and put out from `out` on.
    pub fn followed_by(&self, from: f64, out: f64) -> Self {
        let first = self.index(out - LONGEST_LOOK_BACK_NS);
        let mut next = Self { from: out, pieces: self.pieces[first..].to_vec() };
        next.cut(from);
        next
    }

    /// Ends the trajectory with a rest from `at` on.
    pub fn cut(&mut self, at: f64) {
        // At least the beginning of the first piece is left.
        self.pieces.truncate(self.pieces.partition_point(|timed| timed.start < at).max(1));
        if let Some(last) = self.pieces.last_mut() {
            last.piece.duration = last.piece.duration.min((at - last.start) * 1e-9).max(0.0);
        }
    }

    /// Forgets the pieces that have ended before `at` ns, but for one.
    pub fn forget_before(&mut self, at: f64) {
        let keep = self.index(at).saturating_sub(1);
        self.pieces.drain(..keep);
    }

    /// Returns the index of the piece that holds at `at` ns.
    pub fn index(&self, at: f64) -> usize {
        self.pieces.partition_point(|timed| timed.start <= at).saturating_sub(1)
    }

    /// An extruder's advanced position and speed, averaged with a triangular weight around `at` ns:
    /// numerically, from the definition. Between the ends of pieces the integrand is of degree four at most,
    /// for which three Gauss points are exact.
    pub fn averaged(&self, axis: usize, advance: PressureAdvance, at: f64) -> Option<(f64, f64)> {
        let half = advance.smooth_time / 2.0 * 1e9;
        let (from, to) = (at - half, at + half);
        let mut cuts = std::vec![from, at, to];
        for timed in &self.pieces[self.index(from)..=self.index(to)] {
            cuts.extend([timed.start, timed.start + timed.piece.duration * 1e9]);
        }
        cuts.retain(|cut| (from..=to).contains(cut));
        cuts.sort_by(f64::total_cmp);
        let near = self.planned(at)?.0.0[axis];
        let (mut place, mut speed) = (0.0, 0.0);
        for cut in cuts.windows(2) {
            let (middle, reach) = ((cut[0] + cut[1]) / 2.0, (cut[1] - cut[0]) / 2.0);
            for (node, weight) in [(-0.6_f64.sqrt(), 5.0 / 9.0), (0.0, 8.0 / 9.0), (0.6_f64.sqrt(), 5.0 / 9.0)] {
                let x = middle + node * reach;
                let share = weight * reach * (self.advanced(axis, advance.factor, x)? - near) / (half * half);
                place += share * (half - (at - x).abs());
                speed += share * (x - at).signum();
            }
        }
        Some((near + place, speed * 1e9))
    }

    /// Position plus K times speed, where X or Y move and filament is pushed.
    fn advanced(&self, axis: usize, factor: f64, at: f64) -> Option<f64> {
        let (position, velocity) = self.planned(at)?;
        let pushes = velocity.0[axis] > 0.0 && (velocity.0[0] != 0.0 || velocity.0[1] != 0.0);
        Some(position.0[axis] + if pushes { factor * velocity.0[axis] } else { 0.0 })
    }

    /// The trajectory before the filters.
    pub fn planned(&self, at: f64) -> Option<(PerAxis<f64>, PerAxis<f64>)> {
        let Timed { start, piece, table, .. } = self.pieces.get(self.index(at))?;
        let seconds = (at - start) * 1e-9;
        let resting = seconds > piece.duration || seconds < 0.0;
        let t = seconds.clamp(0.0, piece.duration);
        let way = piece.speed * t + piece.acceleration * t.powi(2) / 2.0 + piece.jerk * t.powi(3) / 6.0;
        let rate = piece.speed + piece.acceleration * t + piece.jerk * t.powi(2) / 2.0;
        let speed = if resting { 0.0 } else { rate };
        let (position, mut velocity) = path::place(&piece.path, table.as_deref(), piece.base + way);
        for axis in units::Axis::ALL {
            velocity[axis] *= speed;
        }
        Some((position, velocity))
    }
}
