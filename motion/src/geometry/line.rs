//! Cutting a straight move into equal pieces, for leveling and for kinematics that bend lines.

use units::{Axis, LineSettings, MmPerSecond, PerAxis};

use crate::planner::SMALLEST;
use crate::square_root;

/// Moves of X Y Z shorter than this, mm, are one piece.
const SHORTEST: f64 = 0.000_01;
/// More pieces than this serve no machine; a bound for nonsense settings.
const MOST_PIECES: f64 = 1e7;

/// The end points of the pieces of a straight move, the last being its target.
#[derive(Clone, Copy, Debug)]
pub struct Line {
    from: PerAxis<f64>,
    to: PerAxis<f64>,
    pieces: u32,
    taken: u32,
}

impl Line {
    /// Returns the length of a straight move, as its feed rate counts it: the way of X Y Z, or that of A B C
    /// where X Y Z stand still. In mm, or in the unit of A B C.
    #[must_use]
    pub fn length(from: &PerAxis<f64>, to: &PerAxis<f64>) -> f64 {
        let square = |axis: Axis| (to[axis] - from[axis]) * (to[axis] - from[axis]);
        let along = |axes: [Axis; 3]| square_root(axes.into_iter().map(square).sum());
        let primary = along(Axis::PRIMARY);
        if primary < SMALLEST { along([Axis::A, Axis::B, Axis::C]) } else { primary }
    }

    /// Returns the move as a single piece, without cutting.
    #[must_use]
    pub const fn whole(from: PerAxis<f64>, to: PerAxis<f64>) -> Self {
        Self { from, to, pieces: 1, taken: 0 }
    }

    /// Cut according to the settings; every axis is divided evenly.
    #[must_use]
    pub fn cut(from: PerAxis<f64>, to: PerAxis<f64>, feed_rate: MmPerSecond, settings: &LineSettings) -> Self {
        let square = |axis: Axis| (to[axis] - from[axis]) * (to[axis] - from[axis]);
        let length = square_root(square(Axis::X) + square(Axis::Y) + square(Axis::Z));
        let wanted = match (settings.segments_per_second, settings.segment_length) {
            _ if length < SHORTEST => 1.0,
            (Some(rate), _) if feed_rate.get() > 0.0 => libm::ceil(rate * length / feed_rate.get()),
            (_, Some(longest)) => libm::ceil(length / longest),
            _ => 1.0,
        };
        // A value that is not a number compares false and leaves the line whole.
        let pieces = if wanted >= 1.0 { crate::least(wanted, MOST_PIECES) as u32 } else { 1 };
        Self { from, to, pieces, taken: 0 }
    }
}

impl Iterator for Line {
    type Item = PerAxis<f64>;

    fn next(&mut self) -> Option<PerAxis<f64>> {
        if self.taken >= self.pieces {
            return None;
        }
        self.taken += 1;
        if self.taken == self.pieces {
            return Some(self.to);
        }
        let share = f64::from(self.taken) / f64::from(self.pieces);
        let mut point = self.from;
        for axis in Axis::ALL {
            point[axis] += (self.to[axis] - self.from[axis]) * share;
        }
        Some(point)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FROM: PerAxis<f64> = PerAxis([0.0; 6]);
    const TO: PerAxis<f64> = PerAxis([3.0, 4.0, 0.0, 1.0, 0.0, 0.0]);

    #[test]
    fn pieces_are_even_and_end_at_the_exact_target() {
        let settings = LineSettings { segment_length: Some(1.2), segments_per_second: None };
        let points: std::vec::Vec<_> = Line::cut(FROM, TO, MmPerSecond(10.0), &settings).collect();
        assert_eq!(points.len(), 5);
        assert!((points[1].0[0] - 1.2).abs() < 1e-12 && (points[1].0[3] - 0.4).abs() < 1e-12);
        assert_eq!(points[4], TO);
    }

    #[test]
    fn pieces_per_second_outrank_their_length() {
        let settings = LineSettings { segment_length: Some(1.0), segments_per_second: Some(100.0) };
        assert_eq!(Line::cut(FROM, TO, MmPerSecond(10.0), &settings).count(), 50);
    }

    #[test]
    fn nonsense_leaves_the_line_whole() {
        for settings in [
            LineSettings { segment_length: Some(f64::NAN), segments_per_second: None },
            LineSettings { segment_length: Some(-1.0), segments_per_second: None },
            LineSettings::default(),
        ] {
            assert_eq!(Line::cut(FROM, TO, MmPerSecond(10.0), &settings).count(), 1);
        }
        let lone_extruder = PerAxis([0.0, 0.0, 0.0, 5.0, 0.0, 0.0]);
        let fine = LineSettings { segment_length: Some(0.1), segments_per_second: None };
        assert_eq!(Line::cut(FROM, lone_extruder, MmPerSecond(1.0), &fine).count(), 1);
    }
}
