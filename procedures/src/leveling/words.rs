//! Skew, planes and fading from configuration and words, kept apart so that a preflight without a machine can
//! use them too.

use base::failure::{Failure, Texts};
use config::{Leveling, LevelingConfig};
use motion::{Fade, Plane, Skew};
use program::Words;

/// Resolution of skew factors, parts of one, so that they are saved exactly.
const SKEW_PARTS: f64 = 1e8;
/// Least size of a word of a plane that Smoothieware saved as the bits of a single-precision number.
const LEAST_BITS: f64 = 1e6;

/// Rounds a number to a multiple of 1/`parts`, so that it is saved exactly.
pub(super) fn rounded(value: f64, parts: f64) -> f64 {
    libm::floor(value * parts + 0.5) / parts
}

/// Returns the skew of the configuration.
pub fn configured(leveling: &LevelingConfig) -> Skew {
    let [xy, xz, yz] = leveling.skew.map(|skew| {
        let factor = match skew.measured {
            Some([ac, bd, ad]) => Skew::from_square(ac, bd, ad).unwrap_or(0.0),
            None => skew.factor,
        };
        rounded(factor, SKEW_PARTS)
    });
    Skew { xy, xz, yz }
}

/// Returns the skew as M852 changes it, or `None` if M852 only asks.
///
/// # Errors
/// When the lengths are no square's.
pub fn skew_of(texts: &Texts, before: Skew, words: &Words<'_>) -> Result<Option<Skew>, Failure> {
    let (measured, mut skew, mut any) = (square(texts, words)?, before, false);
    let plane = words.get('P').map_or(0, |plane| plane as usize);
    for (index, (letter, factor)) in
        [('I', &mut skew.xy), ('J', &mut skew.xz), ('K', &mut skew.yz)].into_iter().enumerate()
    {
        let by_square = measured.filter(|_| index == plane);
        if let Some(word) = words.get(letter).or(by_square) {
            *factor = rounded(word, SKEW_PARTS);
            any = true;
        }
    }
    Ok((any && words.code().subcode != 1).then_some(skew))
}

pub(super) const SQUARE: &str = "a square needs A, B and D: both diagonals AC and BD, and the side AD";

/// Returns the factor for the square's lengths in the words, if any.
pub(super) fn square(texts: &Texts, words: &Words<'_>) -> Result<Option<f64>, Failure> {
    let [ac, bd, ad] = ['A', 'B', 'D'].map(|letter| words.as_length(letter));
    match (ac, bd, ad) {
        (None, None, None) => Ok(None),
        (Some(ac), Some(bd), Some(ad)) => {
            let factor = Skew::from_square(ac, bd, ad);
            let text = format_args!("no nearly square figure has diagonals of {ac} and {bd} mm and a side of {ad} mm");
            factor.map(Some).ok_or_else(|| texts.refused(text))
        }
        _ => Err(Failure::refused(&SQUARE)),
    }
}

/// Returns the plane of M561, or `None` without words.
///
/// # Errors
/// When words are missing, or are no bed's.
pub fn plane_of(words: &Words<'_>) -> Result<Option<Plane>, Failure> {
    let parts = ['A', 'B', 'C', 'D'].map(|letter| words.get(letter));
    if parts.iter().all(Option::is_none) {
        return Ok(None);
    }
    let [Some(a), Some(b), Some(c), Some(d)] = parts else {
        return Err(Failure::refused(&"M561 takes A, B, C and D, or none of them"));
    };
    let plane = Plane::from_equation(plane_words([a, b, c, d]));
    plane.map(Some).ok_or_else(|| Failure::refused(&"M561: that plane stands upright"))
}

/// Returns the words of M561 as numbers, also from the bits of single-precision numbers that Smoothieware
/// saved.
pub(super) fn plane_words(words: [f64; 4]) -> [f64; 4] {
    let is_bits = |word: &f64| libm::floor(*word) == *word && libm::fabs(*word) <= f64::from(u32::MAX);
    let is_saved = words.iter().all(is_bits) && words.iter().any(|word| libm::fabs(*word) > LEAST_BITS);
    if is_saved { words.map(|word| f64::from(f32::from_bits(word as i64 as u32))) } else { words }
}

/// Returns the fade of the mesh: up to this height, and to this rest, mm, or as configured.
pub fn fade_up_to(leveling: &LevelingConfig, height: Option<f64>, target: Option<f64>) -> Option<Fade> {
    let target = target.unwrap_or(leveling.grid.fade_target.0);
    if let Some(end) = height {
        return (end > 0.0).then_some(Fade { start: 0.0, end, target });
    }
    let is_meant = leveling.strategy == Some(Leveling::CartesianGrid);
    let fade = Fade { start: leveling.grid.fade_start.0, end: leveling.grid.fade_end.0, target };
    (is_meant && fade.end > fade.start).then_some(fade)
}
