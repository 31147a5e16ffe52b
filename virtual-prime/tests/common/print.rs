//! A part that is printed, and what of it was laid where: read off the step edges.

use sim::trace::StepEdge;
use units::Direction;

/// Motors of the sample printer: X, Y, Z and the hot end's filament.
pub const MOTORS: usize = 4;
const FILAMENT: usize = 3;
/// Their steps per mm.
const STEPS_PER_MM: [f64; MOTORS] = [80.0, 80.0, 400.0, 415.0];
/// Places nearer than this along the path are one, mm.
pub const GRAIN_MM: f64 = 0.05;

/// Where filament was laid: X, Y and Z of the carriages, mm.
pub type Laid = Vec<[f64; 3]>;

/// Carriages that follow the step edges.
#[derive(Clone, Debug)]
pub struct Carriages {
    places: [f64; MOTORS],
    laid: Laid,
}

impl Carriages {
    /// They stand here, mm.
    pub fn new(places: &[f64]) -> Self {
        let mut start = [0.0; MOTORS];
        start.iter_mut().zip(places).for_each(|(to, from)| *to = *from);
        Self { places: start, laid: Laid::new() }
    }

    /// Takes a step.
    pub fn step(&mut self, edge: &StepEdge) {
        let motor = edge.actuator as usize;
        let Some((place, steps)) = self.places.get_mut(motor).zip(STEPS_PER_MM.get(motor)) else { return };
        *place += f64::from(edge.direction.sign()) / steps;
        let [x, y, z, _] = self.places;
        let has_moved = self.laid.last().is_none_or(|last| (last[0] - x).hypot(last[1] - y) > GRAIN_MM || last[2] != z);
        if motor == FILAMENT && edge.direction == Direction::Forward && has_moved {
            self.laid.push([x, y, z]);
        }
    }

    /// Where they stand, mm.
    pub const fn places(&self) -> &[f64; MOTORS] {
        &self.places
    }

    /// What was laid so far.
    pub const fn laid(&self) -> &Laid {
        &self.laid
    }
}

/// The farthest that a place of the one is from all places of the other in X and Y, mm, at most `z_slack` mm
/// higher or lower; infinite where there is none at this height.
pub fn farthest(one: &Laid, other: &Laid, z_slack: f64) -> f64 {
    let from = |[x, y, z]: &[f64; 3]| {
        let there = other.iter().filter(|place| (place[2] - z).abs() < z_slack);
        there.map(|[a, b, _]| (a - x).hypot(b - y)).fold(f64::INFINITY, f64::min)
    };
    one.iter().map(from).fold(0.0, f64::max)
}
