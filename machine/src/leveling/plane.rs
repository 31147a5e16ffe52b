//! M561: the bed as a plane.

use motion::Plane;
use program::Words;

use super::compensation::{level_off, recompensate};
use super::words::{plane_of, rounded};
use crate::executor::Hands;
use crate::failure::Outcome;
use crate::ports::Ports;

/// Numbers of a plane are kept to as many parts of one: so they are saved exactly.
const PLANE_PARTS: f64 = 1e9;

/// Levels by a plane.
pub(crate) fn adopt_plane<P: Ports>(hands: &mut Hands<'_, '_, P>, plane: Plane) -> Outcome {
    let [x, y, z] = [plane.x, plane.y, plane.z].map(|part| rounded(part, PLANE_PARTS));
    recompensate(hands, |motion| motion.level_by_plane(Plane { x, y, z }))
}

/// M561: no leveling; with A B C D the plane `A X + B Y + C Z + D = 0`, in mm whatever the program counts in,
/// for these are the words that M500 saves.
pub(crate) fn bed_plane<P: Ports>(hands: &mut Hands<'_, '_, P>, words: &Words<'_>) -> Outcome {
    match plane_of(words)? {
        None => level_off(hands),
        Some(plane) => adopt_plane(hands, plane),
    }
}
