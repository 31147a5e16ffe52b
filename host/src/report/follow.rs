//! Lays the executed path along the programmed one, and so finds the time at which each corner of the
//! program was passed.
//!
//! Both are walked forward together. From one sample to the next the machine comes about as far along the
//! program as it has moved; within that reach the nearest point of the program's path counts. So a path
//! that comes back over itself or passes close by is not confused with its later part. If the machine
//! leaves the path (it homes, parks, changes a tool), the walk waits until it is on the path again and
//! stays on it.

use super::path::Samples;
use super::program::Vertex;

/// Times at which the machine passed the corners or was off the path.
#[derive(Clone, Debug, Default)]
pub struct Followed {
    /// Time of passing each corner, seconds; not a number if the machine was not seen to pass.
    pub passed_s: Vec<f64>,
    /// Times in which the machine was on no programmed path.
    pub aside: Vec<Aside>,
    /// Greatest distance from the path while on it, mm.
    pub largest_mm: f64,
    /// Corners for which the machine was heading when it left the path, homing excepted.
    pub left: Vec<usize>,
}

/// Time away from the programmed path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aside {
    /// Beginning of the absence, seconds.
    pub from_s: f64,
    /// End of the absence, seconds.
    pub to_s: f64,
    /// The machine never came back, though the program had more to do: this time belongs to no line.
    pub is_lost: bool,
    /// The corner to which the machine goes then.
    pub then: usize,
}

/// Run and program to compare, with tolerances.
#[derive(Clone, Copy, Debug)]
pub struct Way<'a> {
    /// Executed path of the machine.
    pub samples: &'a Samples,
    /// Corners of the program's path.
    pub corners: &'a [Vertex],
    /// Distance beyond which the machine is off the path, mm.
    pub off_mm: f64,
    /// Distance within which the machine comes back onto the path, mm.
    pub trial_mm: f64,
    /// Weight of distances along Z: little if levelling moves Z.
    pub z_weight: f64,
}

/// Difference in distance below which two places count as equally near, mm: the earlier one wins.
const TIE_MM: f64 = 0.002;
/// Distance within which the machine is at a corner, mm: half a step each way, and a margin.
const NEAR_MM: f64 = 0.05;
/// Distance from the end of a stretch at which it is reached, mm.
const END_MM: f64 = 0.02;
/// Distance that the machine has to follow the path for coming back onto it to count, mm.
const TRIAL_MM: f64 = 2.0;
/// The same distance after homing, which touches its own path more often, mm.
const HOMED_TRIAL_MM: f64 = 20.0;
/// Number of corners ahead at which the machine may come onto the path again.
const AHEAD: usize = 4;

/// Place on the path: the piece that ends at a corner, and the distance from the piece's beginning.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Place {
    piece: usize,
    along: f64,
}

/// Return of the machine onto the path.
#[derive(Clone, Copy)]
struct On {
    /// Sample at which the machine came to the place.
    came: usize,
    /// Sample at which the machine goes on from the place.
    leaves: usize,
    place: Place,
}

/// End of a walk along the path.
struct Walked {
    sample: usize,
    place: Place,
    is_off: bool,
    largest_mm: f64,
}

/// Walks the whole program. `begins_unknown`: the machine's place is not known before its first homing.
pub fn follow(way: &Way<'_>, begins_unknown: bool) -> Followed {
    let count = way.corners.len();
    let mut followed = Followed { passed_s: vec![f64::NAN; count], ..Followed::default() };
    let homed = (1..count).filter(|corner| way.corners[*corner].is_homed);
    let mut firsts: Vec<usize> = std::iter::once(0).chain(homed).collect();
    firsts.push(count);
    let mut sample = 0;
    for pair in firsts.windows(2) {
        let (first, last) = (pair[0], pair[1] - 1);
        if first == 0 && begins_unknown {
            continue;
        }
        sample = stretch(way, first, last, sample, &mut followed);
    }
    let end_s = way.samples.points.len() as f64 * way.samples.period_s;
    let from_s = sample as f64 * way.samples.period_s;
    let aside = Aside { from_s, to_s: end_s, is_lost: false, then: count };
    followed.aside.push(aside);
    followed
}

/// Walks the path from one homing to the next, from sample `from` on; returns the sample at which it ended.
fn stretch(way: &Way<'_>, first: usize, last: usize, from: usize, followed: &mut Followed) -> usize {
    let period_s = way.samples.period_s;
    let begin = Place { piece: first + 1, along: 0.0 };
    let trial = if way.corners[first].is_homed { HOMED_TRIAL_MM } else { TRIAL_MM };
    let aside = |from: usize, found: Option<On>| {
        let (to, then) = found.map_or((way.samples.points.len(), last + 1), |on| (on.came, on.place.piece));
        Aside { from_s: from as f64 * period_s, to_s: to as f64 * period_s, is_lost: found.is_none(), then }
    };
    let found = way.come_on(from, begin, last, trial);
    followed.aside.push(aside(from, found));
    let Some(On { came, leaves: mut sample, mut place }) = found else {
        followed.left.push(first);
        return from;
    };
    followed.passed_s[first..place.piece].fill(came as f64 * period_s);
    loop {
        let passed = &mut followed.passed_s;
        let walked = way.walk(sample, place, last, f64::INFINITY, &mut |corner, time_s| passed[corner] = time_s);
        followed.largest_mm = followed.largest_mm.max(walked.largest_mm);
        if !walked.is_off {
            return walked.sample;
        }
        followed.left.push(walked.place.piece);
        let found = way.come_on(walked.sample, walked.place, last, TRIAL_MM);
        followed.aside.push(aside(walked.sample, found));
        let Some(on) = found else { return walked.sample };
        followed.passed_s[walked.place.piece..on.place.piece].fill(on.came as f64 * period_s);
        (sample, place) = (on.leaves, on.place);
    }
}

impl Way<'_> {
    fn apart(&self, a: [f64; 3], b: [f64; 3]) -> f64 {
        let z = self.z_weight * (a[2] - b[2]);
        ((a[0] - b[0]).powi(2) + (a[1] - b[1]).powi(2) + z * z).sqrt()
    }

    fn point(&self, sample: usize) -> [f64; 3] {
        let [x, y, z, _] = self.samples.points[sample];
        [x, y, z]
    }

    /// Returns the point at a place of a piece, and the piece's length.
    fn at(&self, place: Place) -> ([f64; 3], f64) {
        let (from, to) = (self.corners[place.piece - 1].at, self.corners[place.piece].at);
        let length = length(from, to);
        let share = if length > 0.0 { place.along / length } else { 0.0 };
        (std::array::from_fn(|axis| from[axis] + share * (to[axis] - from[axis])), length)
    }

    /// Returns the nearest place on the path, at most `reach` ahead, and the distance to it.
    fn nearest(&self, from: Place, reach: f64, last: usize, point: [f64; 3]) -> (Place, f64) {
        let mut found: Vec<(Place, f64)> = Vec::new();
        let (mut at, mut left) = (from, reach);
        loop {
            let (begin, end) = (self.corners[at.piece - 1].at, self.corners[at.piece].at);
            let length = length(begin, end);
            let to = length.min(at.along + left).max(at.along);
            let inner: f64 = (0..3).map(|axis| (point[axis] - begin[axis]) * (end[axis] - begin[axis])).sum();
            let along = if length > 0.0 { (inner / length).clamp(at.along, to) } else { 0.0 };
            let place = Place { piece: at.piece, along };
            found.push((place, self.apart(self.at(place).0, point)));
            left -= length - at.along;
            if left <= 0.0 || at.piece >= last {
                break;
            }
            at = Place { piece: at.piece + 1, along: 0.0 };
        }
        let least = found.iter().map(|(_, apart)| *apart).fold(f64::INFINITY, f64::min);
        found.into_iter().find(|(_, apart)| *apart <= least + TIE_MM).unwrap_or((from, f64::INFINITY))
    }

    /// Follows the path until the machine is off it, at the last corner, or has come `most` mm along.
    fn walk(&self, from: usize, at: Place, last: usize, most: f64, passed: &mut dyn FnMut(usize, f64)) -> Walked {
        let period_s = self.samples.period_s;
        let (mut place, mut sample, mut come) = (at, from, 0.0);
        // A distance counts only if the machine comes back without having been off the path.
        let (mut largest_mm, mut away_mm) = (0.0_f64, 0.0_f64);
        if place.piece > last {
            return Walked { sample, place, is_off: false, largest_mm };
        }
        while sample + 1 < self.samples.points.len() {
            let (before, point) = (self.point(sample), self.point(sample + 1));
            let moved = length(before, point);
            let (next, apart) = self.nearest(place, 2.0 * moved + NEAR_MM, last, point);
            if apart > self.off_mm + 0.5 * moved {
                return Walked { sample, place, is_off: true, largest_mm };
            }
            away_mm = away_mm.max(apart);
            if apart <= NEAR_MM {
                (largest_mm, away_mm) = (largest_mm.max(away_mm), 0.0);
            }
            let distance = self.distance(place, next);
            let mut so_far = -place.along;
            for corner in place.piece..next.piece {
                so_far += self.at(Place { piece: corner, along: 0.0 }).1;
                passed(corner, (sample as f64 + (so_far / distance).clamp(0.0, 1.0)) * period_s);
            }
            come += distance;
            (place, sample) = (next, sample + 1);
            if place.piece == last && self.at(place).1 - place.along < END_MM {
                passed(last, sample as f64 * period_s);
                break;
            }
            if come >= most {
                break;
            }
        }
        Walked { sample, place, is_off: false, largest_mm: largest_mm.max(away_mm) }
    }

    /// Returns the length of the path from a place to a later one, mm.
    fn distance(&self, from: Place, to: Place) -> f64 {
        let between: f64 = (from.piece..to.piece).map(|piece| self.at(Place { piece, along: 0.0 }).1).sum();
        between - from.along + to.along
    }

    /// Finds the first sample from which the machine goes on along the path: from `place` or from one of
    /// the next corners, for at least `trial` mm or to the end.
    fn come_on(&self, from: usize, place: Place, last: usize, trial: f64) -> Option<On> {
        if place.piece > last {
            // A stretch without length ends at the sample in which the machine has come to its point.
            let here = self.corners[last].at;
            return (from..self.samples.points.len())
                .find(|sample| self.apart(self.point(*sample), here) <= NEAR_MM)
                .map(|sample| On { came: sample, leaves: sample, place });
        }
        let corners =
            (place.piece..last.min(place.piece + AHEAD)).map(|corner| Place { piece: corner + 1, along: 0.0 });
        let places: Vec<(Place, [f64; 3])> =
            std::iter::once(place).chain(corners).map(|place| (place, self.at(place).0)).collect();
        let near = |sample: usize, at: [f64; 3]| {
            sample < self.samples.points.len() && self.apart(self.point(sample), at) <= NEAR_MM
        };
        let trial_way = Way { off_mm: self.trial_mm, ..*self };
        for sample in from..self.samples.points.len() {
            for (place, at) in &places {
                // The machine leaves this corner with the next sample.
                let leaves = near(sample, *at) && !near(sample + 1, *at);
                if leaves && !trial_way.walk(sample, *place, last, trial, &mut |_, _| {}).is_off {
                    let before = (from..sample).rev().take_while(|before| near(*before, *at)).last();
                    return Some(On { came: before.unwrap_or(sample), leaves: sample, place: *place });
                }
            }
        }
        None
    }
}

fn length(from: [f64; 3], to: [f64; 3]) -> f64 {
    (0..3).map(|axis| (to[axis] - from[axis]).powi(2)).sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests {
    use super::super::program::Program;
    use super::*;

    /// Returns the path of a machine that goes at 20 mm/s through these points and stands at each for so
    /// many milliseconds.
    fn machine(points: &[([f64; 3], usize)]) -> Samples {
        let mut path = vec![[points[0].0[0], points[0].0[1], points[0].0[2], 0.0]; points[0].1 + 1];
        for pair in points.windows(2) {
            let (from, to) = (pair[0].0, pair[1].0);
            let count = (length(from, to) / 0.02).round() as usize;
            for n in 1..=count {
                let at = |axis: usize| from[axis] + (to[axis] - from[axis]) * n as f64 / count as f64;
                path.push([at(0), at(1), at(2), 0.0]);
            }
            path.extend(std::iter::repeat_n([to[0], to[1], to[2], 0.0], pair[1].1));
        }
        Samples { period_s: 0.001, points: path }
    }

    fn followed(text: &str, home: [f64; 3], points: &[([f64; 3], usize)]) -> Followed {
        let program = Program::parse(text.as_bytes(), home.map(Some));
        let samples = machine(points);
        let way = Way { samples: &samples, corners: &program.corners, off_mm: 0.3, trial_mm: 0.1, z_weight: 1.0 };
        follow(&way, program.homes)
    }

    fn times(followed: &Followed) -> Vec<Option<f64>> {
        followed.passed_s.iter().map(|time| time.is_finite().then_some((time * 100.0).round() / 100.0)).collect()
    }

    #[test]
    fn a_way_there_and_back_again_is_told_apart() {
        let found = followed(
            "G1 X10\nG1 X0\nG1 X10\nG1 Y2",
            [0.0; 3],
            &[([0.0; 3], 0), ([10.0, 0.0, 0.0], 0), ([0.0; 3], 0), ([10.0, 0.0, 0.0], 0), ([10.0, 2.0, 0.0], 0)],
        );
        assert_eq!(times(&found), [0.0, 0.5, 1.0, 1.5, 1.6].map(Some));
    }

    #[test]
    fn standing_at_a_corner_changes_only_what_comes_later() {
        let found = followed(
            "G1 X2\nG1 X4 Y1\nG1 X4 Y5",
            [0.0; 3],
            &[([0.0; 3], 0), ([2.0, 0.0, 0.0], 1_000), ([4.0, 1.0, 0.0], 0), ([4.0, 5.0, 0.0], 0)],
        );
        let passed = times(&found);
        assert!((0.1..=1.1).contains(&passed[1].unwrap()), "{passed:?}");
        assert_eq!((passed[2], passed[3]), (Some(1.21), Some(1.41)));
    }

    #[test]
    fn homing_is_aside_though_it_comes_by_the_beginning_more_than_once() {
        let home = [0.0; 3];
        let found = followed(
            "G1 Z3\nG28\nG1 X30\nG1 Y10",
            home,
            &[
                ([9.0, 9.0, 0.0], 10),
                (home, 5),
                ([5.0, 0.0, 0.0], 5),
                (home, 100),
                ([30.0, 0.0, 0.0], 0),
                ([30.0, 10.0, 0.0], 0),
            ],
        );
        let passed = times(&found);
        assert_eq!(passed[..2], [None; 2], "before homing no place is known");
        let begin = found.aside[0].to_s;
        assert!(!found.aside[0].is_lost && begin > 1.1, "{found:?}");
        assert!((found.passed_s[4] - begin - 0.1 - 2.0).abs() < 0.02, "{found:?}");
    }

    #[test]
    fn a_machine_that_parks_and_comes_back_is_followed_on() {
        let found = followed(
            "G1 X10\nM600\nG1 X20\nG1 X20 Y5",
            [0.0; 3],
            &[
                ([0.0; 3], 0),
                ([10.0, 0.0, 0.0], 50),
                ([10.0, 40.0, 0.0], 500),
                ([10.0, 0.0, 0.0], 50),
                ([20.0, 0.0, 0.0], 0),
                ([20.0, 5.0, 0.0], 0),
            ],
        );
        let away: f64 = found.aside.iter().map(|aside| aside.to_s - aside.from_s).sum();
        assert!((4.4..4.65).contains(&away), "{found:?}");
        assert!((found.passed_s[3] - found.aside[1].to_s - 0.05 - 0.75).abs() < 0.02, "{found:?}");
        assert!(found.aside.iter().all(|aside| !aside.is_lost));
    }

    #[test]
    fn the_distance_is_that_from_the_programmed_line_and_short_cuts_are_seen() {
        let program = "G1 X20\nG1 Y20";
        let corner = [([0.0; 3], 0), ([20.0, 0.0, 0.0], 0), ([20.0, 20.0, 0.0], 0)];
        assert!(followed(program, [0.0; 3], &corner).largest_mm < 1e-9);
        let bulge =
            [corner[0], ([9.0, 0.0, 0.0], 0), ([10.0, 0.2, 0.0], 0), ([11.0, 0.0, 0.0], 0), corner[1], corner[2]];
        let found = followed(program, [0.0; 3], &bulge);
        assert!((found.largest_mm - 0.2).abs() < 0.01 && found.left.is_empty(), "{found:?}");
        assert_eq!(followed(program, [0.0; 3], &[corner[0], bulge[1], corner[2]]).left, [1]);
    }

    #[test]
    fn what_never_comes_back_is_lost_and_said_so() {
        let found = followed(
            "G1 X10\nG1 X20\nG1 X20 Y20",
            [0.0; 3],
            &[([0.0; 3], 0), ([10.0, 0.0, 0.0], 0), ([10.0, -30.0, 0.0], 0)],
        );
        assert_eq!(times(&found)[2..], [None; 2]);
        let lost: Vec<_> = found.aside.iter().filter(|aside| aside.is_lost).collect();
        assert!(lost.len() == 1 && (lost[0].from_s - 0.5).abs() < 0.03, "{found:?}");
    }
}
