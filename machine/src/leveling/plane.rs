//! M561: the bed as a plane.

use motion::Plane;
use program::Words;

use super::compensation::{level_off, recompensate, rounded};
use crate::executor::Hands;
use crate::failure::{Failure, Outcome};
use crate::ports::Ports;

/// Numbers of a plane are kept to as many parts of one: so they are saved exactly.
const PLANE_PARTS: f64 = 1e9;
/// Planes that Smoothieware saved are the bits of single-precision numbers: integers beyond this.
const LEAST_BITS: f64 = 1e6;

/// Levels by a plane.
pub(crate) async fn adopt_plane<P: Ports>(hands: &mut Hands<'_, '_, P>, plane: Plane) -> Outcome {
    let [x, y, z] = [plane.x, plane.y, plane.z].map(|part| rounded(part, PLANE_PARTS));
    recompensate(hands, |motion| motion.level_by_plane(Plane { x, y, z })).await
}

/// M561: no leveling; with A B C D the plane `A X + B Y + C Z + D = 0`, in mm whatever the program counts in,
/// for these are the words that M500 saves.
pub(crate) async fn bed_plane<P: Ports>(hands: &mut Hands<'_, '_, P>, words: &Words<'_>) -> Outcome {
    let parts = ['A', 'B', 'C', 'D'].map(|letter| words.get(letter));
    if parts.iter().all(Option::is_none) {
        return level_off(hands).await;
    }
    let [Some(a), Some(b), Some(c), Some(d)] = parts else {
        return Err(Failure::refused("M561 takes A, B, C and D, or none of them"));
    };
    let plane = Plane::from_equation(plane_words([a, b, c, d]));
    let plane = plane.ok_or_else(|| Failure::refused("M561: that plane stands upright"))?;
    adopt_plane(hands, plane).await
}

/// The words of M561: numbers, or what Smoothieware saved, the bits of single-precision numbers.
pub(super) fn plane_words(words: [f64; 4]) -> [f64; 4] {
    let is_bits = |word: &f64| libm::floor(*word) == *word && libm::fabs(*word) <= f64::from(u32::MAX);
    let is_saved = words.iter().all(is_bits) && words.iter().any(|word| libm::fabs(*word) > LEAST_BITS);
    if is_saved { words.map(|word| f64::from(f32::from_bits(word as i64 as u32))) } else { words }
}
