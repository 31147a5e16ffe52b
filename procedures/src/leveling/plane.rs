//! M561: leveling by a plane.

use base::failure::Outcome;
use motion::Plane;
use program::Words;

use super::compensation::{level_off, recompensate};
use super::words::{plane_of, rounded};
use base::hands::Hands;

/// Resolution of a plane's numbers, parts of one, so that they are saved exactly.
const PLANE_PARTS: f64 = 1e9;

/// Levels by a plane, at once.
pub fn adopt_plane<'c>(hands: &mut impl Hands<'c>, plane: Plane) -> Outcome {
    let [x, y, z] = [plane.x, plane.y, plane.z].map(|part| rounded(part, PLANE_PARTS));
    recompensate(hands, |motion| motion.level_by_plane(Plane { x, y, z }))
}

/// M561: switches leveling off; with A B C D sets the plane `A X + B Y + C Z + D = 0`, always in mm, for M500
/// saves these words.
pub fn bed_plane<'c>(hands: &mut impl Hands<'c>, words: &Words<'_>) -> Outcome {
    match plane_of(words)? {
        None => level_off(hands),
        Some(plane) => adopt_plane(hands, plane),
    }
}
