//! Straight moves on kinematics that bend lines: whether every place of a move can be reached, and the
//! greatest speed and bend of each motor's path.
//!
//! All bounds come from a fixed number of places, so in constant time: the ends, the quarters and eighths
//! where a family needs them, and the places where it is known to be worst (nearest to a polar machine's
//! middle, to a SCARA's tower, to an anchor). With the ends and these, linear delta, deltesian, polar and
//! winch are bounded exactly, as their modules say; for rotary delta and SCARA the slope between two places
//! is bounded by the bend there, half the distance further.

use units::{Actuator, PerActuator, PerAxis};

use super::{Kinematics, Morgan, RotaryDelta, morgan, polar, space::Axes, winch::Winch};
use crate::{
    compensation::{Lift, Over},
    greatest, least,
    path::primary,
    square_root,
};

/// Bounds over a straight move of X, Y and Z.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Strain {
    /// Greatest way of each motor for a millimetre of path.
    pub slope: PerActuator<f64>,
    /// Greatest change of that, for a millimetre of path.
    pub bend: PerActuator<f64>,
    /// Least [`Kinematics::clearance`], mm.
    pub clearance: f64,
}

/// Places looked at in equal distances where no better are known.
const EIGHTHS: usize = 8;
/// Most places of a move: the eighths with both ends, and one or three for each centre.
const MOST_PLACES: usize = 28;
/// Distance of the two slopes whose difference is the bend, as a share of the clearance.
const BEND_SHARE: f64 = 1e-4;

/// Shares of the way, 0 to 1, that are looked at.
struct Places {
    shares: [f64; MOST_PLACES],
    count: usize,
}

impl Places {
    fn add(&mut self, share: f64) {
        // A share that is not a number (a move without length) adds nothing.
        if let (true, Some(slot)) = (share > 0.0 && share < 1.0, self.shares.get_mut(self.count)) {
            *slot = share;
            self.count += 1;
        }
    }

    /// The nearest place to a centre, and where the angle seen from it bends most: at `1/sqrt 3` of the
    /// distance on both sides.
    fn around(&mut self, nearest: f64, distance: f64, length: f64) {
        let sideways = 0.577_350_269_189_625_8 * distance / length;
        self.add(nearest - sideways);
        self.add(nearest);
        self.add(nearest + sideways);
    }
}

fn at(from: &PerAxis<f64>, by: &PerAxis<f64>, share: f64) -> PerAxis<f64> {
    crate::trajectory::along(from, by, share)
}

impl Kinematics {
    /// Whether the machine can make this straight move.
    pub(crate) fn check_line(&self, from: &PerAxis<f64>, by: &PerAxis<f64>, length: f64, over: &Over) -> bool {
        self.is_linear()
            || self.places(from, by, length).all(|share| self.reaches_lifted(&at(from, by, share), over.lift.as_ref()))
    }

    /// Whether the machine can be here, whatever levelling adds to Z.
    pub(crate) fn reaches_lifted(&self, point: &PerAxis<f64>, lift: Option<&Lift>) -> bool {
        let Some(lift) = lift.filter(|_| !self.is_even_in_z()) else { return self.reaches(point) };
        let [x, y, z, a, b, c] = point.0;
        [lift.low, lift.high].iter().all(|by| self.reaches(&PerAxis([x, y, z + by, a, b, c])))
    }

    /// Whether a millimetre of Z turns the motors by the same amount everywhere.
    pub(crate) const fn is_even_in_z(&self) -> bool {
        !matches!(self, Self::RotaryDelta(_) | Self::Winch(_))
    }

    /// The bounds of a straight move from `from` by `by`, whose X, Y and Z are `length` mm long. `None` where
    /// every motor's way is straight. The compensation `over` the move comes on top; the skew of `from` and
    /// `by` has been taken back already.
    pub(crate) fn strain(&self, from: &PerAxis<f64>, by: &PerAxis<f64>, length: f64, over: &Over) -> Option<Strain> {
        if self.is_linear() && over.lift.is_none() {
            return None;
        }
        let unit = PerAxis(by.0.map(|part| part / length));
        let none = PerActuator([0.0; units::MAX_ACTUATORS]);
        let mut strain = Strain { slope: none, bend: none, clearance: f64::INFINITY };
        if self.is_linear() {
            strain.slope = PerActuator(self.velocities(from, &unit).0.map(libm::fabs));
        }
        let places = if self.is_linear() { None } else { Some(self.places(from, by, length)) };
        for share in places.into_iter().flatten() {
            strain.take(self, &at(from, by, share), &unit);
        }
        if matches!(self, Self::RotaryDelta(_) | Self::Morgan(_)) {
            let half = 0.5 * length / EIGHTHS as f64;
            for actuator in Actuator::ALL {
                strain.slope[actuator] += half * strain.bend[actuator];
            }
        }
        if let Some(lift) = &over.lift {
            let [x, y, z] = primary(&unit);
            let ends = [*from, at(from, by, 0.5), at(from, by, 1.0)];
            strain.lift(self, over, lift, (lift.slope_along(&[x, y, z]), lift.bend_along(&[x, y, z])), &ends);
        }
        Some(strain)
    }

    fn places(&self, from: &PerAxis<f64>, by: &PerAxis<f64>, length: f64) -> impl Iterator<Item = f64> {
        let mut places = Places { shares: [0.0; MOST_PLACES], count: 1 };
        let ([x, y, z, ..], [dx, dy, dz, ..]) = (from.0, by.0);
        let (start, way) = ([x, y, z], [dx, dy, dz]);
        match self {
            Self::RotaryDelta(RotaryDelta { .. }) => add_eighths(&mut places),
            Self::Morgan(arm) => {
                add_eighths(&mut places);
                add_tower(&mut places, arm, start, way);
            }
            Self::Polar => {
                let nearest = polar::nearest(start, way);
                let distance = polar::clearance([x + nearest * dx, y + nearest * dy, z]);
                places.around(nearest, distance, square_root(dx * dx + dy * dy));
            }
            Self::Winch(ropes) => add_anchors(&mut places, ropes, start, way, length),
            _ => {}
        }
        if let Some(last) = places.shares.get_mut(places.count) {
            *last = 1.0;
            places.count += 1;
        }
        places.shares.into_iter().take(places.count)
    }
}

fn add_eighths(places: &mut Places) {
    (1..EIGHTHS).for_each(|index| places.add(index as f64 / EIGHTHS as f64));
}

fn add_tower(places: &mut Places, arm: &Morgan, start: Axes, way: Axes) {
    places.add(morgan::nearest(arm, start, way));
}

fn add_anchors(places: &mut Places, ropes: &Winch, start: Axes, way: Axes, length: f64) {
    for anchor in 0..super::MOST_ANCHORS {
        if let (Some(nearest), true) = (ropes.nearest(anchor, start, way), length > 0.0) {
            places.add(nearest);
        }
    }
}

impl Strain {
    /// Adds what levelling adds to Z: so much slope and bend at most, looked at in these places.
    pub(crate) fn lift(
        &mut self,
        kinematics: &Kinematics,
        over: &Over,
        lift: &Lift,
        (slope, bend): (f64, f64),
        places: &[PerAxis<f64>],
    ) {
        let up = over.skewed(&PerAxis([0.0, 0.0, 1.0, 0.0, 0.0, 0.0]));
        let leans = over.skew.is_some_and(|skew| skew.xz != 0.0 || skew.yz != 0.0);
        if !kinematics.is_linear() && (leans || !kinematics.is_even_in_z()) {
            // The way is another one, higher by as much and turned by so little: motors bend along it as
            // along any way here.
            let most = greatest(libm::fabs(lift.low), libm::fabs(lift.high));
            for actuator in Actuator::ALL {
                self.slope[actuator] += most * self.bend[actuator];
                self.bend[actuator] *= (1.0 + slope) * (1.0 + slope);
            }
        }
        let mut raised = PerActuator([0.0; units::MAX_ACTUATORS]);
        for place in places {
            let turned = kinematics.velocities(place, &up);
            for actuator in Actuator::ALL {
                raised[actuator] = greatest(raised[actuator], libm::fabs(turned[actuator]));
            }
        }
        for actuator in Actuator::ALL {
            self.slope[actuator] += raised[actuator] * slope;
            self.bend[actuator] += raised[actuator] * bend;
        }
        self.clearance = least(self.clearance, lift.scale);
    }

    /// Takes one place into the bounds.
    fn take(&mut self, kinematics: &Kinematics, point: &PerAxis<f64>, unit: &PerAxis<f64>) {
        let clearance = kinematics.clearance(point);
        let step = BEND_SHARE * least(clearance, 100.0);
        let slope = kinematics.velocities(point, unit);
        let before = kinematics.velocities(&at(point, unit, -step), unit);
        let after = kinematics.velocities(&at(point, unit, step), unit);
        for actuator in Actuator::ALL {
            let bend = libm::fabs(after[actuator] - before[actuator]) / (2.0 * step);
            self.slope[actuator] = greatest(self.slope[actuator], libm::fabs(slope[actuator]));
            self.bend[actuator] = greatest(self.bend[actuator], bend);
        }
        self.clearance = least(self.clearance, clearance);
    }
}
