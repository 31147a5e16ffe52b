//! A printed part, with the places where filament was laid: taken from the step edges.

use sim::trace::StepEdge;
use units::Direction;

/// Motors of the sample printer: X, Y, Z and the hot end's filament.
pub const MOTORS: usize = 4;
const FILAMENT: usize = 3;
/// Steps per mm of these motors.
const STEPS_PER_MM: [f64; MOTORS] = [80.0, 80.0, 400.0, 415.0];
/// Distance along the path below which places count as the same, mm.
pub const GRAIN_MM: f64 = 0.05;

/// Places where filament was laid: X, Y and Z of the carriages, mm.
pub type Laid = Vec<[f64; 3]>;

/// Carriages that follow the step edges.
#[derive(Clone, Debug)]
pub struct Carriages {
    places: [f64; MOTORS],
    laid: Laid,
}

impl Carriages {
    /// Creates carriages at these places, mm.
    pub fn new(places: &[f64]) -> Self {
        let mut start = [0.0; MOTORS];
        start.iter_mut().zip(places).for_each(|(to, from)| *to = *from);
        Self { places: start, laid: Laid::new() }
    }

    /// Moves a carriage by a step.
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

    /// Returns the places of the carriages, mm.
    pub const fn places(&self) -> &[f64; MOTORS] {
        &self.places
    }

    /// Returns the places where filament was laid so far.
    pub const fn laid(&self) -> &Laid {
        &self.laid
    }
}

/// Returns the greatest distance in X and Y of a place of `one` from all places of `other`, mm, at most
/// `z_slack` mm higher or lower; infinite where there is none at this height.
pub fn farthest(one: &Laid, other: &Laid, z_slack: f64) -> f64 {
    let from = |[x, y, z]: &[f64; 3]| {
        let there = other.iter().filter(|place| (place[2] - z).abs() < z_slack);
        there.map(|[a, b, _]| (a - x).hypot(b - y)).fold(f64::INFINITY, f64::min)
    };
    one.iter().map(from).fold(0.0, f64::max)
}
