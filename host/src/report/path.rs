//! The executed path: positions at even times from the step edges, then only the corners that shape and
//! speed need.

use super::edges::Executed;
use super::machine::Machine;
use units::{Actuator, MAX_ACTUATORS};

/// Kind of motion on the way to a corner.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Moving without feeding filament.
    Travel,
    /// Moving and feeding filament, or cutting where there is no extruder.
    Work,
}

/// Corner of the executed path.
#[derive(Clone, Copy, Debug)]
pub struct Corner {
    /// Time since power-on, seconds.
    pub time_s: f64,
    /// X, Y, Z in mm.
    pub at: [f64; 3],
    /// Speed along the path, mm/s.
    pub speed: f64,
    /// Filament fed since the corner before, mm.
    pub fed: f64,
    /// Kind of motion on the way to this corner.
    pub kind: Kind,
}

/// Positions at even times.
#[derive(Debug)]
pub struct Samples {
    /// Time between two samples, seconds.
    pub period_s: f64,
    /// X, Y, Z of the machine in mm, and filament in mm.
    pub points: Vec<[f64; 4]>,
}

/// Number of samples on either side over which speeds are averaged.
const SPEED_WINDOW: usize = 4;
/// Filament speed below which a motor is only between two edges, mm/s.
const FEEDING_MM_PER_S: f64 = 0.03;
/// Speed along the path below which the machine stands, mm/s.
const MOVING_MM_PER_S: f64 = 0.05;

impl Samples {
    /// Reads positions every `period_s`. `origin`: each motor's position at power-on, in steps of the
    /// machine's own count. `filament` are the motors whose steps count as filament.
    pub fn take(
        executed: &Executed,
        machine: &Machine,
        origin: &[f64; MAX_ACTUATORS],
        filament: &[Actuator],
        period_s: f64,
    ) -> Self {
        let mut readers: Vec<_> = executed.tracks.iter().map(super::edges::Track::reader).collect();
        let count = (executed.end_ns as f64 * 1e-9 / period_s) as usize + 2;
        let points = (0..count)
            .map(|index| {
                let time_ns = (index as f64 * period_s * 1e9) as u64;
                let mut steps = [0.0; MAX_ACTUATORS];
                for (steps, reader) in steps.iter_mut().zip(&mut readers) {
                    *steps = reader.steps_at(time_ns);
                }
                let fed = |motor: &Actuator| Some(steps[*motor as usize] / machine.steps_per_mm[*motor as usize]?);
                let fed = filament.iter().filter_map(fed).sum();
                steps.iter_mut().zip(origin).for_each(|(steps, origin)| *steps += origin);
                let [x, y, z, ..] = machine.point(steps);
                [x, y, z, fed]
            })
            .collect();
        Self { period_s, points }
    }

    /// Returns X, Y and Z at a time, mm.
    pub fn at(&self, time_s: f64) -> [f64; 3] {
        let place = (time_s / self.period_s).clamp(0.0, (self.points.len() - 1) as f64);
        let before = (place as usize).min(self.points.len().saturating_sub(2));
        let (from, share) = (self.points[before], place - before as f64);
        let to = self.points.get(before + 1).unwrap_or(&from);
        std::array::from_fn(|axis| from[axis] + share * (to[axis] - from[axis]))
    }

    fn around(&self, index: usize, window: usize) -> ([f64; 4], [f64; 4], f64) {
        let first = index.saturating_sub(window);
        let last = (index + window).min(self.points.len() - 1);
        (self.points[first], self.points[last], (last - first).max(1) as f64 * self.period_s)
    }

    /// Returns the speed along the path at a sample, mm/s.
    pub fn speed(&self, index: usize) -> f64 {
        let (from, to, seconds) = self.around(index, SPEED_WINDOW);
        distance(&from, &to) / seconds
    }

    /// Returns the filament speed at a sample, mm/s.
    pub fn filament_speed(&self, index: usize) -> f64 {
        let (from, to, seconds) = self.around(index, SPEED_WINDOW);
        (to[3] - from[3]) / seconds
    }

    /// Returns the kind of motion at a sample of a machine that moves.
    pub fn moves(&self, index: usize, has_extruder: bool) -> Kind {
        let (from, to, seconds) = self.around(index.min(self.points.len() - 1), 1);
        let feeds = (to[3] - from[3]) / seconds > FEEDING_MM_PER_S;
        if feeds || !has_extruder { Kind::Work } else { Kind::Travel }
    }

    /// Returns the kind of motion at a sample; none if the machine stands.
    fn kind(&self, index: usize, has_extruder: bool) -> Option<Kind> {
        let (from, to, seconds) = self.around(index, 1);
        let speed = distance(&from, &to) / seconds;
        if speed < MOVING_MM_PER_S {
            return None;
        }
        Some(self.moves(index, has_extruder))
    }

    /// Returns the corners: straight pieces between them are within `error_mm` of the samples, and speed
    /// changes evenly along them but for `error_speed` mm/s. Both errors are doubled until there are at
    /// most `at_most` corners.
    pub fn corners(&self, has_extruder: bool, error_mm: f64, error_speed: f64, at_most: usize) -> Vec<Corner> {
        let runs = self.runs(has_extruder);
        let (mut error_mm, mut error_speed) = (error_mm, error_speed);
        loop {
            let mut corners = Vec::new();
            for (first, last, kind) in &runs {
                let kept = simplify(self, *first, *last, error_mm, error_speed);
                let mut before = *first;
                for (place, index) in kept.into_iter().enumerate() {
                    corners.push(Corner {
                        time_s: index as f64 * self.period_s,
                        at: [self.points[index][0], self.points[index][1], self.points[index][2]],
                        speed: self.speed(index),
                        fed: self.points[index][3] - self.points[before][3],
                        // The first corner of a run is its beginning: nothing is drawn towards it.
                        kind: if place == 0 { Kind::Travel } else { *kind },
                    });
                    before = index;
                }
            }
            if corners.len() <= at_most {
                return corners;
            }
            error_mm *= 2.0;
            error_speed *= 2.0;
        }
    }

    /// Returns stretches of moving samples of one kind, each beginning at the end of the one before.
    fn runs(&self, has_extruder: bool) -> Vec<(usize, usize, Kind)> {
        let mut runs: Vec<(usize, usize, Kind)> = Vec::new();
        let mut moving = false;
        for index in 1..self.points.len() {
            let kind = self.kind(index, has_extruder);
            match (kind, runs.last_mut()) {
                (Some(kind), Some(run)) if moving && run.2 == kind => run.1 = index,
                (Some(kind), _) => runs.push((index - 1, index, kind)),
                (None, _) => {}
            }
            moving = kind.is_some();
        }
        runs
    }
}

fn distance(from: &[f64; 4], to: &[f64; 4]) -> f64 {
    ((to[0] - from[0]).powi(2) + (to[1] - from[1]).powi(2) + (to[2] - from[2]).powi(2)).sqrt()
}

/// Simplifies by U. Ramer (1972), D. Douglas and T. Peucker (1973): splits at the worst sample until every
/// sample is close enough.
fn simplify(samples: &Samples, first: usize, last: usize, error_mm: f64, error_speed: f64) -> Vec<usize> {
    let mut kept = vec![first];
    let mut open = vec![(first, last)];
    while let Some((from, to)) = open.pop() {
        let mut worst = (1.0, None);
        let (speed_from, speed_to) = (samples.speed(from), samples.speed(to));
        for index in from + 1..to {
            let (apart, share) = from_chord(&samples.points[from], &samples.points[to], &samples.points[index]);
            let speed_error = (samples.speed(index) - speed_from - share * (speed_to - speed_from)).abs();
            let error = (apart / error_mm).max(speed_error / error_speed);
            if error > worst.0 {
                worst = (error, Some(index));
            }
        }
        match worst.1 {
            // The later half is put aside, so corners come out in order.
            Some(split) => open.extend([(split, to), (from, split)]),
            None => kept.push(to),
        }
    }
    kept
}

/// Returns the distance of a point from a chord, and the point's place along the chord, 0 to 1.
fn from_chord(from: &[f64; 4], to: &[f64; 4], point: &[f64; 4]) -> (f64, f64) {
    let mut along = 0.0;
    let mut length = 0.0;
    for axis in 0..3 {
        along += (point[axis] - from[axis]) * (to[axis] - from[axis]);
        length += (to[axis] - from[axis]).powi(2);
    }
    let share = if length > 0.0 { (along / length).clamp(0.0, 1.0) } else { 0.0 };
    let mut apart = 0.0;
    for axis in 0..3 {
        apart += (point[axis] - from[axis] - share * (to[axis] - from[axis])).powi(2);
    }
    (apart.sqrt(), share)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn samples(points: impl IntoIterator<Item = [f64; 4]>) -> Samples {
        Samples { period_s: 0.001, points: points.into_iter().collect() }
    }

    /// Moves along X, then along Y, 20 mm/s each, feeding on the second leg.
    fn corner_path() -> Samples {
        let leg_x = (0..1_000).map(|n| [f64::from(n) * 0.02, 0.0, 0.0, 0.0]);
        let leg_y = (0..=1_000).map(|n| [20.0, f64::from(n) * 0.02, 0.0, f64::from(n) * 0.001]);
        samples(leg_x.chain(leg_y))
    }

    #[test]
    fn a_corner_is_kept_and_straight_legs_are_not() {
        let corners = corner_path().corners(true, 0.01, 5.0, 1_000);
        assert!(corners.len() < 12, "{} corners", corners.len());
        assert!(corners.iter().any(|corner| (corner.at[0] - 20.0).abs() < 0.05 && corner.at[1].abs() < 0.05));
        let work: f64 = corners.iter().filter(|corner| corner.kind == Kind::Work).map(|corner| corner.fed).sum();
        assert!((work - 1.0).abs() < 0.01, "{work}");
        assert!(corners.windows(2).all(|pair| pair[0].time_s <= pair[1].time_s));
    }

    #[test]
    fn standing_still_draws_nothing() {
        assert!(samples((0..1_000).map(|_| [1.0; 4])).corners(true, 0.01, 1.0, 10).is_empty());
    }

    #[test]
    fn too_many_corners_are_made_fewer() {
        let circle = (0..6_283).map(|n| {
            let angle = f64::from(n) * 0.001;
            [10.0 * angle.cos(), 10.0 * angle.sin(), 0.0, 0.0]
        });
        let corners = samples(circle).corners(false, 0.000_01, 0.1, 50);
        assert!((8..=50).contains(&corners.len()), "{}", corners.len());
    }
}
