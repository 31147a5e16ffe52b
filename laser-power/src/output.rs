//! Output of the filters along a segment: where X, Y and Z are, and how fast, at each share of its time.

use units::{Axis, MAX_AXES, PerAxis, seconds_of};

use crate::{greatest, least};

/// Distance from its place, mm, at which a change counts as being there; and the greatest part of the speed
/// that may go the other way, for rounding.
const NEAR: f64 = 1e-6;
/// Halvings of half a millisecond: to half a nanosecond.
const HALVINGS: u32 = 20;

/// Output of the filters along a segment: a cubic of each axis over the time.
#[derive(Clone, Copy, Debug)]
pub struct Output<'a> {
    /// Position at the beginning.
    pub start: &'a PerAxis<f64>,
    /// Position at the end.
    pub point: &'a PerAxis<f64>,
    /// Velocities at the beginning, mm/s.
    pub entry: &'a PerAxis<f64>,
    /// Velocities at the end, mm/s.
    pub exit: &'a PerAxis<f64>,
    /// Duration of the piece, seconds.
    pub seconds: f64,
}

impl Output<'_> {
    /// Returns the square of the speed at a share of the segment's time, mm/s: of X, Y and Z, or of all
    /// axes.
    #[must_use]
    #[inline(never)]
    pub fn speed_sq_at(&self, share: f64, all_axes: bool) -> f64 {
        let count = if all_axes { MAX_AXES } else { Axis::PRIMARY.len() };
        let mean = self.entry.0.iter().zip(&self.exit.0).map(|(entry, exit)| entry + share * (exit - entry));
        mean.take(count).map(|speed| speed * speed).sum()
    }

    /// Returns the shares of a segment that begins at `start`, `from` at least, at which the output comes to
    /// the place where the trajectory was at this time, by the least and by the greatest delay of an axis.
    #[must_use]
    #[inline(never)]
    pub fn reach(&self, time: u64, start: u64, from: f64, delays: [u64; 2]) -> [f64; 2] {
        delays.map(|delay| {
            let ahead = time.wrapping_add(delay).wrapping_sub(start) as i64;
            let share = seconds_of(ahead.unsigned_abs()) / self.seconds;
            greatest(if ahead < 0 { -share } else { share }, from)
        })
    }

    /// Returns the share within `reach` at which the output passes the place on this way, or is nearest to
    /// it; `None` where that is in no share of this segment.
    #[must_use]
    #[inline(never)]
    pub fn share_past(&self, way: &([f64; 3], [f64; 3]), reach: [f64; 2], ends: bool) -> Option<f64> {
        let [earliest, latest] = reach;
        let passed = |share: f64| self.has_passed(&way.0, &way.1, share, ends);
        if passed(earliest) {
            return Some(earliest);
        }
        let mut bounds = (earliest, least(latest, 1.0));
        if !passed(bounds.1) {
            return if latest <= 1.0 { Some(latest) } else { None };
        }
        for _ in 0..HALVINGS {
            let middle = 0.5 * (bounds.0 + bounds.1);
            if passed(middle) { bounds.1 = middle } else { bounds.0 = middle }
        }
        Some(bounds.1)
    }

    /// Whether the output, at a share of the segment's time, moves this way and comes no nearer to the place.
    /// (It goes another way where a path comes back on itself, and it may round the place.) Where it rests it
    /// has passed the place if it is there and the path `ends` there, not if the path begins there.
    #[inline(never)]
    fn has_passed(&self, place: &[f64; 3], direction: &[f64; 3], share: f64, ends: bool) -> bool {
        let (mut nearing, mut along, mut speed_sq, mut left_sq) = (0.0, 0.0, 0.0, 0.0);
        for (axis, (place, direction)) in Axis::PRIMARY.into_iter().zip(place.iter().zip(direction)) {
            let (start, way) = (self.start[axis], self.point[axis] - self.start[axis]);
            let (entry, exit) = (self.entry[axis] * self.seconds, self.exit[axis] * self.seconds);
            let (square, cube) = (3.0 * way - 2.0 * entry - exit, entry + exit - 2.0 * way);
            let left = place - start - share * (entry + share * (square + share * cube));
            let speed = entry + share * (2.0 * square + share * 3.0 * cube);
            nearing += left * speed;
            along += direction * speed;
            speed_sq += speed * speed;
            left_sq += left * left;
        }
        if speed_sq == 0.0 {
            return ends && left_sq <= NEAR * NEAR;
        }
        let is_small = |part: f64| part * part <= NEAR * NEAR * speed_sq;
        (nearing <= 0.0 || is_small(nearing)) && (along >= 0.0 || is_small(along))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn along_x(x: f64) -> PerAxis<f64> {
        let mut place = PerAxis([0.0; MAX_AXES]);
        place[Axis::X] = x;
        place
    }

    #[test]
    fn a_place_is_passed_at_its_share_and_one_beyond_is_not() {
        let (start, point, speed) = (along_x(10.0), along_x(10.1), along_x(200.0));
        let output = Output { start: &start, point: &point, entry: &speed, exit: &speed, seconds: 5e-4 };
        let at = |x: f64, reach| output.share_past(&([x, 0.0, 0.0], [1.0, 0.0, 0.0]), reach, false);
        assert!((at(10.03, [0.0, 2.0]).expect("it is passed") - 0.3).abs() < 1e-5);
        assert_eq!((at(9.9, [0.2, 2.0]), at(10.2, [0.0, 2.0]), at(10.2, [0.0, 0.7])), (Some(0.2), None, Some(0.7)));
        assert_eq!(output.speed_sq_at(0.5, false), 40_000.0);
    }

    #[test]
    fn an_output_that_rests_has_passed_where_the_path_ends_there() {
        let (here, still) = (along_x(5.0), along_x(0.0));
        let output = Output { start: &here, point: &here, entry: &still, exit: &still, seconds: 5e-4 };
        let way = ([5.0, 0.0, 0.0], [1.0, 0.0, 0.0]);
        assert_eq!(
            (output.share_past(&way, [0.1, 2.0], true), output.share_past(&way, [0.1, 2.0], false)),
            (Some(0.1), None)
        );
    }

    #[test]
    fn reach_is_the_time_of_the_place_and_an_axis_s_delay() {
        let (here, still) = (along_x(5.0), along_x(0.0));
        let output = Output { start: &here, point: &here, entry: &still, exit: &still, seconds: 5e-4 };
        // 100,000 ticks are half a millisecond.
        let tick = 1_u64 << 32;
        let reach = output.reach(7 * tick, 7 * tick, 0.0, [0, 50_000 * tick]);
        assert!(reach[0] == 0.0 && (reach[1] - 0.5).abs() < 1e-12, "{reach:?}");
        assert_eq!(output.reach(0, 7 * tick, 0.25, [0, 0]), [0.25; 2]);
    }
}
