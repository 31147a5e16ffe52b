//! What trims and radius a delta must have for the points where it touched the bed to lie at one height.
//!
//! A touch tells how far each carriage was from its switch. That does not depend on what is believed about
//! the machine; the height that follows from it does. Gauss-Newton on these heights, with derivatives by
//! differences.

use motion::Kinematics;
use units::{Axis, PerActuator, PerAxis};

/// Trims X Y Z, radius, height of the bed.
const MOST_UNKNOWNS: usize = 5;
const RADIUS: usize = 3;
const HEIGHT: usize = 4;
/// Step of the differences, mm.
const DIFFERENCE: f64 = 0.01;
/// Each turn leaves the square of the error before it: the third is at rounding.
const TURNS: u32 = 5;
/// Errors of a machine that is worth calibrating, mm.
const MOST_CHANGE: f64 = 20.0;

/// What is believed about a linear delta.
#[derive(Clone, Copy, Debug)]
pub(super) struct Belief {
    pub kinematics: Kinematics,
    /// See `M666`, mm.
    pub trim: [f64; 3],
    /// Where the tool is with every carriage at the height of its switch, less the trims.
    pub home: PerAxis<f64>,
}

impl Belief {
    /// Where the carriages are at their switches, mm.
    pub fn switches(&self) -> [f64; 3] {
        let motors = self.kinematics.actuators(&self.home);
        let mut switches = [0.0; 3];
        for ((switch, motor), trim) in switches.iter_mut().zip(motors.0).zip(self.trim) {
            *switch = motor - trim;
        }
        switches
    }

    /// The ways of the carriages from their switches to a place of the tool, mm.
    pub fn ways_to(&self, place: &PerAxis<f64>) -> [f64; 3] {
        let motors = self.kinematics.actuators(place);
        let mut ways = self.switches();
        for (way, motor) in ways.iter_mut().zip(motors.0) {
            *way = motor - *way;
        }
        ways
    }

    /// The tool's height after these ways.
    pub fn height(&self, ways: &[f64; 3]) -> f64 {
        let mut motors = PerActuator([0.0; units::MAX_ACTUATORS]);
        for ((motor, switch), way) in motors.0.iter_mut().zip(self.switches()).zip(ways) {
            *motor = switch + way;
        }
        self.kinematics.point(&motors)[Axis::Z]
    }

    /// The radius of the arms.
    pub fn radius(&self) -> f64 {
        self.kinematics.parameters().iter().find(|(letter, _)| *letter == 'R').map_or(0.0, |(_, value)| value)
    }

    /// The same with one unknown greater by so much.
    fn with(&self, unknown: usize, by: f64) -> Self {
        let mut other = *self;
        if let Some(trim) = other.trim.get_mut(unknown) {
            *trim += by;
        } else if unknown == RADIUS {
            let mut parameters = self.kinematics.parameters();
            parameters.set('R', self.radius() + by);
            other.kinematics = self.kinematics.with_parameters(&parameters);
        }
        other
    }
}

/// Greatest less least height of these touches.
pub(super) fn spread(belief: &Belief, touches: &[[f64; 3]]) -> f64 {
    let heights = touches.iter().map(|ways| belief.height(ways));
    let (least, most) = heights.fold((f64::INFINITY, f64::NEG_INFINITY), |(least, most), height| {
        (if height < least { height } else { least }, if height > most { height } else { most })
    });
    most - least
}

/// The belief that lets all touches lie at one height. With trims among the unknowns that is their mean
/// height as believed before, since raising all trims only moves the bed. `None` when the touches do not
/// tell, or tell nonsense.
pub(super) fn fit(belief: &Belief, touches: &[[f64; 3]], trims: bool, radius: bool) -> Option<Belief> {
    let unknowns: &[usize] = match (trims, radius) {
        (true, true) => &[0, 1, 2, RADIUS],
        (true, false) => &[0, 1, 2],
        _ => &[RADIUS, HEIGHT],
    };
    let mut bed = touches.iter().map(|ways| belief.height(ways)).sum::<f64>() / touches.len() as f64;
    let mut found = *belief;
    for _ in 0..TURNS {
        let steps = turn(&found, touches, unknowns, bed)?;
        for (unknown, step) in unknowns.iter().zip(steps) {
            if *unknown == HEIGHT {
                bed += step;
            } else {
                found = found.with(*unknown, step);
            }
        }
    }
    let changes = found.trim.into_iter().zip(belief.trim).map(|(after, before)| after - before);
    let is_sane = |change: f64| change.is_finite() && libm::fabs(change) < MOST_CHANGE;
    changes.chain([found.radius() - belief.radius()]).all(is_sane).then_some(found)
}

/// One turn: by how much each unknown must grow.
fn turn(belief: &Belief, touches: &[[f64; 3]], unknowns: &[usize], bed: f64) -> Option<[f64; MOST_UNKNOWNS]> {
    let mut sums = [[0.0; MOST_UNKNOWNS + 1]; MOST_UNKNOWNS];
    for ways in touches {
        let mut row = [0.0; MOST_UNKNOWNS];
        for (slope, unknown) in row.iter_mut().zip(unknowns) {
            *slope = match *unknown {
                HEIGHT => -1.0,
                unknown => {
                    let beyond = |by| belief.with(unknown, by).height(ways);
                    (beyond(DIFFERENCE) - beyond(-DIFFERENCE)) / (2.0 * DIFFERENCE)
                }
            };
        }
        let missing = bed - belief.height(ways);
        for (sum, one) in sums.iter_mut().zip(row) {
            for (cell, other) in sum.iter_mut().zip(row) {
                *cell += one * other;
            }
            if let Some(last) = sum.last_mut() {
                *last += one * missing;
            }
        }
    }
    solve(sums, unknowns.len())
}

/// The first `count` equations of that many unknowns; the right-hand sides stand in the last column.
fn solve(mut rows: [[f64; MOST_UNKNOWNS + 1]; MOST_UNKNOWNS], count: usize) -> Option<[f64; MOST_UNKNOWNS]> {
    let used = rows.get_mut(..count)?;
    for column in 0..count {
        let size = |row: &[f64; MOST_UNKNOWNS + 1]| row.get(column).map_or(0.0, |cell| libm::fabs(*cell));
        let best = (column..count).max_by(|a, b| {
            let of = |index: &usize| used.get(*index).map_or(0.0, size);
            of(a).total_cmp(&of(b))
        })?;
        used.swap(column, best);
        let pivot = *used.get(column)?;
        if size(&pivot) < 1e-9 {
            return None;
        }
        for (_, row) in used.iter_mut().enumerate().filter(|(index, _)| *index != column) {
            let share = row.get(column)? / pivot.get(column)?;
            for (cell, other) in row.iter_mut().zip(pivot) {
                *cell -= share * other;
            }
        }
    }
    let mut values = [0.0; MOST_UNKNOWNS];
    for (index, (value, row)) in values.iter_mut().zip(used.iter()).enumerate() {
        *value = row.last()? / row.get(index)?;
    }
    Some(values)
}

#[cfg(test)]
mod tests {
    use super::*;
    use motion::kinematics::{LinearDelta, LinearDeltaGeometry};
    use proptest::prelude::*;

    fn belief(radius: f64, trim: [f64; 3]) -> Belief {
        let geometry = LinearDeltaGeometry { arm_radius: radius, ..LinearDeltaGeometry::default() };
        let home = PerAxis([0.0, 0.0, 250.0, 0.0, 0.0, 0.0]);
        Belief { kinematics: Kinematics::LinearDelta(LinearDelta::new(geometry)), trim, home }
    }

    /// The middle, the towers, and opposite to each.
    fn points(radius: f64) -> Vec<[f64; 2]> {
        let around = (0..6).map(|n| (30.0 + 60.0 * f64::from(n)).to_radians());
        let around = around.map(|angle| [radius * angle.cos(), radius * angle.sin()]);
        core::iter::once([0.0; 2]).chain(around).collect()
    }

    /// Goes straight down, as believed, until the real machine is at the bed.
    fn touch(real: &Belief, believed: &Belief, [x, y]: [f64; 2], bed: f64) -> [f64; 3] {
        let (mut low, mut high) = (-40.0, 40.0);
        for _ in 0..80 {
            let z = 0.5 * (low + high);
            let ways = believed.ways_to(&PerAxis([x, y, z, 0.0, 0.0, 0.0]));
            if real.height(&ways) > bed { high = z } else { low = z }
        }
        believed.ways_to(&PerAxis([x, y, 0.5 * (low + high), 0.0, 0.0, 0.0]))
    }

    proptest! {
        #[test]
        fn trims_and_radius_are_found_again(
            wrong in -3.0..3.0_f64, trim in proptest::array::uniform3(-2.0..2.0_f64), bed in -5.0..5.0_f64,
            radius in 50.0..90.0_f64,
        ) {
            let (real, believed) = (belief(124.0 + wrong, trim), belief(124.0, [0.0; 3]));
            let touches: Vec<_> = points(radius).into_iter().map(|point| touch(&real, &believed, point, bed)).collect();
            let found = fit(&believed, &touches, true, true).expect("an answer");
            prop_assert!(spread(&found, &touches) < 1e-6, "{}", spread(&found, &touches));
            prop_assert!((found.radius() - real.radius()).abs() < 1e-4, "{} for {}", found.radius(), real.radius());
            for tower in 1..3 {
                let (is, shall) = (found.trim[tower] - found.trim[0], trim[tower] - trim[0]);
                prop_assert!((is - shall).abs() < 1e-4, "{is} for {shall}");
            }
        }

        #[test]
        fn each_kind_is_found_without_the_other(wrong in -3.0..3.0_f64, trim in proptest::array::uniform3(-2.0..2.0_f64)) {
            let believed = belief(124.0, [0.0; 3]);
            let touches = |real: &Belief| -> Vec<_> { points(80.0).into_iter().map(|point| touch(real, &believed, point, 0.3)).collect() };
            let by_radius = touches(&belief(124.0 + wrong, [0.0; 3]));
            let found = fit(&believed, &by_radius, false, true).expect("an answer");
            prop_assert!(spread(&found, &by_radius) < 1e-6 && found.trim == [0.0; 3]);
            let by_trim = touches(&belief(124.0, trim));
            let found = fit(&believed, &by_trim, true, false).expect("an answer");
            prop_assert!(spread(&found, &by_trim) < 1e-6 && (found.radius() - 124.0).abs() < 1e-12);
        }
    }

    #[test]
    fn touches_of_one_place_tell_nothing() {
        let believed = belief(124.0, [0.0; 3]);
        let touches = [believed.ways_to(&PerAxis([10.0, 5.0, 1.0, 0.0, 0.0, 0.0])); 7];
        assert!(fit(&believed, &touches, true, true).is_none());
    }
}
