//! From any darkness to a few levels of power, such that the eye sees the darkness again.

use super::picture::Picture;

/// Greatest number of levels.
pub const MOST_LEVELS: u16 = 256;

/// Way from darkness to levels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
pub enum Dither {
    /// The nearest level
    None,
    /// Black or white, whichever is nearer
    Threshold,
    /// By an ordered pattern of 8 x 8
    Bayer,
    /// The error goes to four neighbours
    #[default]
    FloydSteinberg,
    /// Three quarters of the error go to six neighbours: clear whites and blacks
    Atkinson,
    /// The error goes to twelve neighbours (Jarvis, Judice and Ninke)
    Jarvis,
}

/// Levels of power, rows from the top.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Levels {
    /// Pixels of a row.
    pub columns: usize,
    pub rows: usize,
    /// Number of levels, 0 (not burnt) among them.
    pub count: u16,
    pub of: Vec<u8>,
}

/// Share of an error for a pixel: so many to the right and so many down, in parts.
type Share = (isize, usize, f32);

const FLOYD_STEINBERG: [Share; 4] = [(1, 0, 7.0 / 16.0), (-1, 1, 3.0 / 16.0), (0, 1, 5.0 / 16.0), (1, 1, 1.0 / 16.0)];
const ATKINSON: [Share; 6] =
    [(1, 0, 0.125), (2, 0, 0.125), (-1, 1, 0.125), (0, 1, 0.125), (1, 1, 0.125), (0, 2, 0.125)];
const JARVIS: [Share; 12] = [
    (1, 0, 7.0 / 48.0),
    (2, 0, 5.0 / 48.0),
    (-2, 1, 3.0 / 48.0),
    (-1, 1, 5.0 / 48.0),
    (0, 1, 7.0 / 48.0),
    (1, 1, 5.0 / 48.0),
    (2, 1, 3.0 / 48.0),
    (-2, 2, 1.0 / 48.0),
    (-1, 2, 3.0 / 48.0),
    (0, 2, 5.0 / 48.0),
    (1, 2, 3.0 / 48.0),
    (2, 2, 1.0 / 48.0),
];

impl Dither {
    /// Returns the number of levels where none is asked for.
    pub const fn usual_levels(self) -> u16 {
        match self {
            Self::None => MOST_LEVELS,
            _ => 2,
        }
    }

    /// Returns the way's name on the command line.
    pub const fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Threshold => "threshold",
            Self::Bayer => "bayer",
            Self::FloydSteinberg => "floyd-steinberg",
            Self::Atkinson => "atkinson",
            Self::Jarvis => "jarvis",
        }
    }

    /// Returns the levels of a picture's darkness, from 2 to [`MOST_LEVELS`] of them.
    pub fn levels(self, darkness: &Picture, count: u16) -> Levels {
        let of = match self {
            Self::None | Self::Threshold => darkness.light.iter().map(|dark| nearest(*dark, count)).collect(),
            Self::Bayer => ordered(darkness, count),
            Self::FloydSteinberg => diffused(darkness, count, &FLOYD_STEINBERG),
            Self::Atkinson => diffused(darkness, count, &ATKINSON),
            Self::Jarvis => diffused(darkness, count, &JARVIS),
        };
        Levels { columns: darkness.columns, rows: darkness.rows, count, of }
    }
}

impl Levels {
    /// Returns the darkness of a level.
    pub fn share(&self, level: u8) -> f64 {
        f64::from(level) / f64::from(self.count - 1)
    }
}

fn nearest(dark: f32, count: u16) -> u8 {
    (dark.clamp(0.0, 1.0) * f32::from(count - 1)).round() as u8
}

/// Returns the rank of a place in the ordered pattern, 0 to 63 (Bayer 1973): the bits of y and of x ^ y,
/// the lowest ones first.
const fn rank(x: usize, y: usize) -> u8 {
    let (mut rank, mut bit) = (0, 0);
    while bit < 3 {
        let (low, high) = (y >> bit & 1, (x ^ y) >> bit & 1);
        rank = rank << 2 | (high << 1 | low) as u8;
        bit += 1;
    }
    rank
}

fn ordered(darkness: &Picture, count: u16) -> Vec<u8> {
    let rows = darkness.light.chunks_exact(darkness.columns).enumerate();
    let level = |x: usize, y: usize, dark: f32| {
        let threshold = (f32::from(rank(x % 8, y % 8)) + 0.5) / 64.0;
        (dark.clamp(0.0, 1.0) * f32::from(count - 1) + threshold) as u8
    };
    rows.flat_map(|(y, row)| row.iter().enumerate().map(move |(x, dark)| level(x, y, *dark))).collect()
}

/// Goes through the rows there and back, and hands the error of each pixel on to pixels to come.
fn diffused(darkness: &Picture, count: u16, shares: &[Share]) -> Vec<u8> {
    let (columns, rows) = (darkness.columns, darkness.rows);
    let mut wanted = darkness.light.clone();
    let mut levels = vec![0; wanted.len()];
    for y in 0..rows {
        let backward = y % 2 == 1;
        for step in 0..columns {
            let x = if backward { columns - 1 - step } else { step };
            let dark = wanted[y * columns + x];
            let level = nearest(dark, count);
            levels[y * columns + x] = level;
            let error = dark - f32::from(level) / f32::from(count - 1);
            for (right, down, share) in shares {
                let there = x.checked_add_signed(if backward { -right } else { *right });
                if let Some(x) = there.filter(|x| *x < columns && y + down < rows) {
                    wanted[(y + down) * columns + x] += error * share;
                }
            }
        }
    }
    levels
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::collections::BTreeSet;

    fn mean(levels: &Levels) -> f64 {
        levels.of.iter().map(|level| levels.share(*level)).sum::<f64>() / levels.of.len() as f64
    }

    #[test]
    fn the_pattern_has_every_rank_once_and_neighbours_far_apart() {
        let ranks: BTreeSet<u8> = (0..64).map(|place| rank(place % 8, place / 8)).collect();
        assert_eq!((ranks.len(), ranks.last()), (64, Some(&63)));
        let far = (0..64).all(|place| rank(place % 8, place / 8).abs_diff(rank((place + 1) % 8, place / 8)) >= 8);
        assert!(far);
    }

    proptest! {
        #[test]
        fn a_grey_keeps_its_mean(dark in 0.0..=1.0_f32, count in 2..=16_u16, size in (40..90_usize, 40..90_usize)) {
            let (columns, rows) = size;
            let grey = Picture { columns, rows, light: vec![dark; columns * rows] };
            let step = 1.0 / f64::from(count - 1);
            // Half of the ways hand on all of the error: what is lost leaves at the edges. The pattern fits
            // as often as it goes into the picture, and has 64 steps.
            let ways = [(Dither::FloydSteinberg, 0.02), (Dither::Jarvis, 0.03), (Dither::Bayer, 0.06)];
            for (way, tolerance) in ways {
                let off = (mean(&way.levels(&grey, count)) - f64::from(dark)).abs();
                prop_assert!(off <= tolerance * step, "{way:?}: {off} of {step}");
            }
            // A quarter of the error is dropped: up to a fifth of a level.
            let off = (mean(&Dither::Atkinson.levels(&grey, count)) - f64::from(dark)).abs();
            prop_assert!(off <= 0.2 * step, "Atkinson: {off} of {step}");
            let nearest = mean(&Dither::None.levels(&grey, count));
            prop_assert!((nearest - f64::from(dark)).abs() <= 0.5 * step + 1e-6);
        }

        #[test]
        fn what_a_level_has_exactly_stays(count in 2..=256_u16, levels in proptest::collection::vec(any::<u8>(), 64)) {
            let levels: Vec<u8> = levels.into_iter().map(|level| (u16::from(level) % count) as u8).collect();
            let light = levels.iter().map(|level| f32::from(*level) / f32::from(count - 1)).collect();
            let picture = Picture { columns: 8, rows: 8, light };
            for way in [Dither::None, Dither::Bayer, Dither::FloydSteinberg, Dither::Atkinson, Dither::Jarvis] {
                prop_assert_eq!(&way.levels(&picture, count).of, &levels, "{:?}", way);
            }
        }
    }

    #[test]
    fn a_threshold_is_black_or_white() {
        let picture = Picture { columns: 4, rows: 1, light: vec![0.0, 0.49, 0.51, 1.0] };
        assert_eq!(Dither::Threshold.levels(&picture, 2).of, [0, 0, 1, 1]);
    }
}
