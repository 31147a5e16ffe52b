//! Fit of a delta's geometry: the touches of the bed lie at the same height, and distances on a printed part
//! are as they were measured.
//!
//! A touch tells the distance of each carriage from its switch. Unlike the height that follows from it, the
//! distance does not depend on the believed geometry. Gauss-Newton on these heights and on distances, with
//! derivatives by differences.
//!
//! Touches determine trims, radius and the angles of two towers. The third tower's angle only turns the part;
//! the towers' own radii add nothing, for the plan of three towers is a triangle, which has three numbers,
//! and the place of its middle shows nowhere. The lengths of the arms hardly change heights, so the touches
//! tell them poorly (20 um of noise, 0.9 mm) and distances well. Hence arms are held to about their written
//! lengths.

use base::least_squares::{self, LeastSquares};
use heapless::Vec;
use motion::Kinematics;
use units::{Axis, PerActuator, PerAxis};

/// Step of the differences, mm or degrees.
const DIFFERENCE: f64 = 0.01;
/// Number of iterations. Each leaves the square of the error before it: the third is at rounding.
const TURNS: u32 = 6;
/// Greatest error of a length of a machine that is worth calibrating, mm.
const MOST_CHANGE: f64 = 20.0;
/// Greatest error of an angle of such a machine, degrees.
const MOST_TURN: f64 = 5.0;
/// Standard deviation of a touch, of a distance measured with calipers, and of an arm from its written
/// length, mm.
const TOUCH: f64 = 0.02;
const DISTANCE: f64 = 0.05;
const ARM: f64 = 1.0;

/// Believed geometry of a linear delta.
#[derive(Clone, Copy, Debug)]
pub(super) struct Belief {
    pub kinematics: Kinematics,
    /// Trims of the switches (see `M666`), mm.
    pub trim: [f64; 3],
    /// Position of the tool with every carriage at the height of its switch, less the trims.
    pub home: PerAxis<f64>,
}

/// Distance of each carriage from its switch, mm.
pub(super) type Ways = [f64; 3];

/// A distance on a printed part, mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Distance {
    /// Carriage distances when the machine printed the ends.
    pub ends: [Ways; 2],
    /// Length as measured, mm.
    pub measured: f64,
}

/// Measurements from which the geometry is fitted.
#[derive(Clone, Copy, Debug)]
pub(super) struct Evidence<'a> {
    pub touches: &'a [Ways],
    pub distances: &'a [Distance],
}

/// Parameters that are fitted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Sought {
    pub trims: bool,
    pub radius: bool,
    /// Angles of two towers.
    pub angles: bool,
    pub arms: Arms,
}

/// Treatment of the arms' lengths.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Arms {
    /// Lengths as written, not fitted.
    Known,
    /// A common length for all.
    Alike,
    /// Each arm has its own length.
    Each,
}

/// A single parameter that is fitted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Unknown {
    Trim(usize),
    /// Parameter of the kinematics, by its letter.
    Parameter(char),
    /// Height of the bed in the believed geometry.
    Height,
}

type Unknowns = Vec<Unknown, { least_squares::MOST }>;

impl Sought {
    fn unknowns(self) -> Unknowns {
        let letters: &[char] = match self.arms {
            Arms::Known => &[],
            Arms::Alike => &['L'],
            Arms::Each => &['I', 'J', 'K'],
        };
        // With trims no height is fitted, since raising all of them raises the bed.
        let first = if self.trims { [0, 1, 2].map(Unknown::Trim) } else { [Unknown::Height; 3] };
        let first = first.into_iter().take(if self.trims { 3 } else { 1 });
        let of = |is_sought: bool, letters: &'static [char]| letters.iter().filter(move |_| is_sought);
        let parameters = of(self.radius, &['R']).chain(of(self.angles, &['D', 'E'])).chain(letters);
        first.chain(parameters.map(|letter| Unknown::Parameter(*letter))).collect()
    }

    /// Returns the number of fitted parameters.
    pub fn count(self) -> usize {
        self.unknowns().len()
    }
}

/// Result of a fit.
#[derive(Clone, Copy, Debug)]
pub(super) struct Found {
    pub belief: Belief,
    /// Standard deviation of an arm's length, mm, if it was fitted.
    pub arms_within: Option<f64>,
}

impl Belief {
    /// Returns the heights of the carriages at their switches, mm.
    pub fn switches(&self) -> [f64; 3] {
        let motors = self.kinematics.actuators(&self.home);
        let mut switches = [0.0; 3];
        for ((switch, motor), trim) in switches.iter_mut().zip(motors.0).zip(self.trim) {
            *switch = motor - trim;
        }
        switches
    }

    /// Returns the ways of the carriages from their switches to a place of the tool, mm.
    pub fn ways_to(&self, place: &PerAxis<f64>) -> Ways {
        let motors = self.kinematics.actuators(place);
        let mut ways = self.switches();
        for (way, motor) in ways.iter_mut().zip(motors.0) {
            *way = motor - *way;
        }
        ways
    }

    /// Returns the tool's position after these ways.
    pub fn place(&self, ways: &Ways) -> PerAxis<f64> {
        let mut motors = PerActuator([0.0; units::MAX_ACTUATORS]);
        for ((motor, switch), way) in motors.0.iter_mut().zip(self.switches()).zip(ways) {
            *motor = switch + way;
        }
        self.kinematics.point(&motors)
    }

    /// Returns the tool's height after these ways.
    pub fn height(&self, ways: &Ways) -> f64 {
        self.place(ways)[Axis::Z]
    }

    /// Returns the length of a distance in this geometry, mm.
    pub fn distance(&self, distance: &Distance) -> f64 {
        let [from, to] = distance.ends.map(|ways| self.place(&ways));
        let [x, y, z] = Axis::PRIMARY.map(|axis| to[axis] - from[axis]);
        libm::sqrt(x * x + y * y + z * z)
    }

    /// Returns a parameter of the kinematics.
    pub fn parameter(&self, letter: char) -> f64 {
        self.kinematics.parameters().iter().find(|(known, _)| *known == letter).map_or(0.0, |(_, value)| value)
    }

    /// Returns the radius of the arms.
    pub fn radius(&self) -> f64 {
        self.parameter('R')
    }

    fn set(&mut self, letter: char, value: f64) {
        let mut parameters = self.kinematics.parameters();
        parameters.set(letter, value);
        self.kinematics = self.kinematics.with_parameters(&parameters);
    }

    /// Returns the geometry with an unknown increased by this amount.
    fn with(&self, unknown: Unknown, by: f64) -> Self {
        let mut other = *self;
        match unknown {
            Unknown::Trim(tower) => other.trim.get_mut(tower).into_iter().for_each(|trim| *trim += by),
            Unknown::Parameter(letter) => other.set(letter, self.parameter(letter) + by),
            Unknown::Height => {}
        }
        other
    }

    /// Returns the same machine, with the arms' mean length in their common length.
    fn with_even_arms(&self) -> Self {
        let mean = ['I', 'J', 'K'].map(|letter| self.parameter(letter)).iter().sum::<f64>() / 3.0;
        let mut other = self.with(Unknown::Parameter('L'), mean);
        ['I', 'J', 'K'].into_iter().for_each(|letter| other = other.with(Unknown::Parameter(letter), -mean));
        other
    }
}

/// Returns the difference of the greatest and the least height of these touches.
pub(super) fn spread(belief: &Belief, touches: &[Ways]) -> f64 {
    let heights = touches.iter().map(|ways| belief.height(ways));
    let (least, most) = heights.fold((f64::INFINITY, f64::NEG_INFINITY), |(least, most), height| {
        (if height < least { height } else { least }, if height > most { height } else { most })
    });
    most - least
}

/// Returns the standard deviation of the heights of these touches.
pub(super) fn deviation(belief: &Belief, touches: &[Ways]) -> f64 {
    let mean = mean_height(belief, touches);
    let squares = touches.iter().map(|ways| belief.height(ways) - mean).map(|part| part * part).sum::<f64>();
    libm::sqrt(squares / touches.len() as f64)
}

fn mean_height(belief: &Belief, touches: &[Ways]) -> f64 {
    touches.iter().map(|ways| belief.height(ways)).sum::<f64>() / touches.len() as f64
}

/// Returns the geometry with which all touches lie at the same height and all distances are as measured, as
/// far as can be. With trims among the unknowns that height is their mean as believed before, since raising
/// all trims only moves the bed. `None` when the evidence does not determine it, or gives nonsense.
pub(super) fn fit(belief: &Belief, evidence: Evidence<'_>, sought: Sought) -> Option<Found> {
    let unknowns = sought.unknowns();
    let mut bed = mean_height(belief, evidence.touches);
    let mut found = *belief;
    let mut within = 0.0;
    for _ in 0..TURNS {
        let sums = turn(belief, &found, evidence, &unknowns, bed)?;
        for (unknown, step) in unknowns.iter().zip(sums.solve(unknowns.len())?) {
            found = found.with(*unknown, step);
            if *unknown == Unknown::Height {
                bed += step;
            }
        }
        within = libm::sqrt(sums.variance(unknowns.len(), unknowns.len() - 1)?);
    }
    let is_sane = |change: f64, most: f64| change.is_finite() && libm::fabs(change) < most;
    let trims = found.trim.into_iter().zip(belief.trim).all(|(after, before)| is_sane(after - before, MOST_CHANGE));
    let changed = |letter: char| found.parameter(letter) - belief.parameter(letter);
    let lengths = ['R', 'L', 'I', 'J', 'K'].into_iter().all(|letter| is_sane(changed(letter), MOST_CHANGE));
    let angles = ['D', 'E'].into_iter().all(|letter| is_sane(changed(letter), MOST_TURN));
    if sought.arms == Arms::Each {
        found = found.with_even_arms();
    }
    // An arm is the last unknown, so its deviation is at hand.
    let arms_within = (sought.arms != Arms::Known).then_some(within);
    (trims && lengths && angles).then_some(Found { belief: found, arms_within })
}

/// Runs an iteration: returns the sums that give the step of each unknown.
fn turn(
    written: &Belief,
    belief: &Belief,
    evidence: Evidence<'_>,
    unknowns: &[Unknown],
    bed: f64,
) -> Option<LeastSquares> {
    let mut sums = LeastSquares::default();
    let mut add = |value: &dyn Fn(&Belief) -> f64, of_height: f64, wanted: f64, deviation: f64| {
        let mut row = [0.0; least_squares::MOST];
        for (slope, unknown) in row.iter_mut().zip(unknowns) {
            *slope = match *unknown {
                Unknown::Height => of_height,
                unknown => {
                    let beyond = |by| value(&belief.with(unknown, by));
                    (beyond(DIFFERENCE) - beyond(-DIFFERENCE)) / (2.0 * DIFFERENCE)
                }
            } / deviation;
        }
        sums.add(row.get(..unknowns.len())?, (wanted - value(belief)) / deviation);
        Some(())
    };
    for ways in evidence.touches {
        add(&|belief| belief.height(ways), -1.0, bed, TOUCH)?;
    }
    for distance in evidence.distances {
        add(&|belief| belief.distance(distance), 0.0, distance.measured, DISTANCE)?;
    }
    for unknown in unknowns {
        if let Unknown::Parameter(letter @ ('L' | 'I' | 'J' | 'K')) = *unknown {
            add(&|belief| belief.parameter(letter), 0.0, written.parameter(letter), ARM)?;
        }
    }
    Some(sums)
}

#[cfg(test)]
mod tests {
    use super::*;
    use motion::kinematics::{LinearDelta, LinearDeltaGeometry};
    use proptest::prelude::*;
    use std::vec::Vec;

    fn belief(radius: f64, trim: [f64; 3]) -> Belief {
        let geometry = LinearDeltaGeometry { arm_radius: radius, ..LinearDeltaGeometry::default() };
        let home = PerAxis([0.0, 0.0, 250.0, 0.0, 0.0, 0.0]);
        Belief { kinematics: Kinematics::LinearDelta(LinearDelta::new(geometry)), trim, home }
    }

    const FOUR: Sought = Sought { trims: true, radius: true, angles: false, arms: Arms::Known };

    fn by_touch(touches: &[Ways]) -> Evidence<'_> {
        Evidence { touches, distances: &[] }
    }

    /// Returns the middle, the towers, and the places opposite to each.
    fn points(radius: f64) -> Vec<[f64; 2]> {
        let around = (0..6).map(|n| (30.0 + 60.0 * f64::from(n)).to_radians());
        let around = around.map(|angle| [radius * angle.cos(), radius * angle.sin()]);
        core::iter::once([0.0; 2]).chain(around).collect()
    }

    /// Goes straight down in the believed geometry, until the real machine is at the bed.
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
            let found = fit(&believed, by_touch(&touches), FOUR).expect("an answer").belief;
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
            let found = fit(&believed, by_touch(&by_radius), Sought { trims: false, ..FOUR }).expect("an answer").belief;
            prop_assert!(spread(&found, &by_radius) < 1e-6 && found.trim == [0.0; 3]);
            let by_trim = touches(&belief(124.0, trim));
            let found = fit(&believed, by_touch(&by_trim), Sought { radius: false, ..FOUR }).expect("an answer").belief;
            prop_assert!(spread(&found, &by_trim) < 1e-6 && (found.radius() - 124.0).abs() < 1e-12);
        }
    }

    /// Returns a machine that is wrong in every parameter that the touches determine.
    fn crooked() -> impl Strategy<Value = Belief> {
        let (small, angle) = (proptest::array::uniform3(-1.0..1.0_f64), proptest::array::uniform2(-0.8..0.8_f64));
        (small.clone(), -2.0..2.0_f64, angle, small).prop_map(|(trim, radius, [d, e], arm_offset)| {
            let geometry = LinearDeltaGeometry {
                arm_radius: 124.0 + radius,
                tower_angle: [d, e, 0.0],
                arm_offset,
                ..LinearDeltaGeometry::default()
            };
            Belief { kinematics: Kinematics::LinearDelta(LinearDelta::new(geometry)), ..belief(124.0, trim) }
        })
    }

    /// Returns the distance that calipers find between two places that this machine prints.
    fn printed(real: &Belief, believed: &Belief, from: [f64; 2], to: [f64; 2]) -> Distance {
        let ends = [from, to].map(|[x, y]| believed.ways_to(&PerAxis([x, y, 0.3, 0.0, 0.0, 0.0])));
        let measured = real.distance(&Distance { ends, measured: 0.0 });
        Distance { ends, measured }
    }

    /// Returns the points with the middle, and a second ring halfway.
    fn thirteen(radius: f64) -> Vec<[f64; 2]> {
        points(radius).into_iter().chain(points(radius / 2.0).into_iter().skip(1)).collect()
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(48))]

        #[test]
        fn angles_are_found_by_touches(wrong in crooked()) {
            // The arms are as written: nothing else is wrong.
            let mut real = wrong;
            ['I', 'J', 'K'].into_iter().for_each(|letter| real.set(letter, 0.0));
            let believed = belief(124.0, [0.0; 3]);
            let touches: Vec<_> = thirteen(85.0).into_iter().map(|at| touch(&real, &believed, at, 0.4)).collect();
            let found = fit(&believed, by_touch(&touches), Sought { angles: true, ..FOUR }).expect("an answer").belief;
            prop_assert!(spread(&found, &touches) < 1e-6);
            for letter in ['R', 'D', 'E'] {
                let (is, shall) = (found.parameter(letter), real.parameter(letter));
                prop_assert!((is - shall).abs() < 1e-4, "{letter}: {is} for {shall}");
            }
        }

        #[test]
        fn arms_are_found_by_touches_and_distances(real in crooked()) {
            let believed = belief(124.0, [0.0; 3]);
            let touches: Vec<_> = thirteen(85.0).into_iter().map(|at| touch(&real, &believed, at, 0.4)).collect();
            let ring = points(70.0);
            let across = (1..7).map(|n| printed(&real, &believed, ring[0], ring[n]));
            let around = (1..7).map(|n| printed(&real, &believed, ring[n], ring[n % 6 + 1]));
            let distances: Vec<_> = across.chain(around).collect();
            let evidence = Evidence { touches: &touches, distances: &distances };
            let found = fit(&believed, evidence, Sought { angles: true, arms: Arms::Each, ..FOUR }).expect("an answer");
            let (found, within) = (found.belief, found.arms_within.expect("arms"));
            prop_assert!(spread(&found, &touches) < 0.01, "{}", spread(&found, &touches));
            prop_assert!(within > 0.1 && within < 0.5, "{within}");
            // Holding arms to 1 mm pulls the result a little.
            for n in 0..3 {
                let letter = ['I', 'J', 'K'][n];
                let (is, shall) = (found.parameter('L') + found.parameter(letter), 250.0 + real.parameter(letter));
                prop_assert!((is - shall).abs() < 0.3, "{letter}: {is} for {shall}");
            }
            for distance in &distances {
                prop_assert!((found.distance(distance) - distance.measured).abs() < 0.02);
            }
            let rest = found.parameter('I') + found.parameter('J') + found.parameter('K');
            prop_assert!(rest.abs() < 1e-9, "what is common belongs to L");
        }
    }

    #[test]
    fn touches_of_one_place_tell_nothing() {
        let believed = belief(124.0, [0.0; 3]);
        let touches = [believed.ways_to(&PerAxis([10.0, 5.0, 1.0, 0.0, 0.0, 0.0])); 7];
        assert!(fit(&believed, by_touch(&touches), FOUR).is_none());
    }
}
