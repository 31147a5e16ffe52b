//! Pixels of a line: powers that divide a straight move into equal parts, each for one pixel or for a run of
//! them, `S0.8:0:0` and `S0.8@12:0@5`.

use units::PerAxis;

/// Most powers of a line.
pub(crate) const MOST_RUNS: usize = 32;

/// Pixels of a line, as runs of one power.
#[derive(Clone, Debug, Default)]
pub(crate) struct Pixels {
    /// S of each run.
    powers: [f32; MOST_RUNS],
    /// Number of pixels of each run.
    lengths: [u16; MOST_RUNS],
    /// Number of runs, and number of those that were taken.
    count: u8,
    taken: u8,
    /// Number of pixels that are left.
    left: u32,
    /// End of the whole line, machine position.
    end: PerAxis<f64>,
    /// Way of a pixel.
    way: PerAxis<f64>,
}

impl Pixels {
    /// Creates the pixels of the way between two machine positions. `list` is what follows the first power,
    /// `:0:0.5` or `@12:0@5`. `None` when it is no list, or too long.
    pub(crate) fn new(first: f32, list: &str, from: &PerAxis<f64>, to: &PerAxis<f64>) -> Option<Self> {
        let mut pixels = Self { end: *to, ..Self::default() };
        let (mut power, mut length, mut rest) = (first, None, list);
        loop {
            let Some(mark) = rest.bytes().next() else {
                pixels.push(power, length)?;
                let count = f64::from(pixels.left);
                pixels.way = PerAxis(core::array::from_fn(|axis| (to.0[axis] - from.0[axis]) / count));
                return Some(pixels);
            };
            let behind = rest.get(1..)?;
            let end = behind.bytes().position(|byte| matches!(byte, b':' | b'@')).unwrap_or(behind.len());
            let number;
            (number, rest) = behind.split_at_checked(end)?;
            let number = gcode::read_f64(number)?;
            if mark == b'@' {
                if length.replace(number).is_some() {
                    return None;
                }
            } else {
                pixels.push(power, length.take())?;
                power = number as f32;
            }
        }
    }

    /// Appends a run of one pixel, or of so many.
    fn push(&mut self, power: f32, length: Option<f64>) -> Option<()> {
        let length = length.unwrap_or(1.0);
        let whole = length as u16;
        let index = usize::from(self.count);
        let is_run = power >= 0.0 && whole > 0 && f64::from(whole) == length;
        *self.powers.get_mut(index).filter(|_| is_run)? = power;
        *self.lengths.get_mut(index)? = whole;
        self.left += u32::from(whole);
        self.count += 1;
        Some(())
    }

    /// Whether no pixel is left.
    pub(crate) fn is_empty(&self) -> bool {
        self.taken == self.count
    }

    /// Returns the end of the line, while a pixel is left.
    pub(crate) fn end(&self) -> Option<PerAxis<f64>> {
        (!self.is_empty()).then_some(self.end)
    }

    /// Forgets what is left.
    pub(crate) fn clear(&mut self) {
        self.taken = self.count;
    }

    /// Takes the next run: its S and its end. The last one ends where the line does.
    pub(crate) fn next(&mut self) -> Option<(f32, PerAxis<f64>)> {
        let index = usize::from(self.taken);
        let (power, length) = (*self.powers.get(index)?, *self.lengths.get(index)?);
        if self.is_empty() {
            return None;
        }
        self.taken += 1;
        self.left -= u32::from(length);
        let left = f64::from(self.left);
        Some((power, PerAxis(core::array::from_fn(|axis| self.end.0[axis] - self.way.0[axis] * left))))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::fmt::Write as _;

    fn drawn(pixels: &mut Pixels) -> std::vec::Vec<(f32, PerAxis<f64>)> {
        core::iter::from_fn(|| pixels.next()).collect()
    }

    #[test]
    fn pixels_divide_the_way_and_end_at_its_end() {
        let [from, to] = [PerAxis([1.0, 2.0, 0.0, 0.0, 0.0, 0.0]), PerAxis([2.0, 1.1, 0.0, 0.0, 0.0, 0.0])];
        let mut pixels = Pixels::new(0.8, ":0:0.25", &from, &to).expect("a list");
        let drawn = drawn(&mut pixels);
        assert_eq!(drawn.iter().map(|(power, _)| *power).collect::<std::vec::Vec<_>>(), [0.8, 0.0, 0.25]);
        assert_eq!(drawn[2].1, to);
        assert!((drawn[0].1.0[0] - 4.0 / 3.0).abs() < 1e-12 && (drawn[1].1.0[1] - 1.4).abs() < 1e-12);
        assert!(pixels.is_empty());
    }

    proptest! {
        #[test]
        fn a_run_is_one_move_that_ends_where_its_last_pixel_does(
            runs in proptest::collection::vec((0..1_001_u16, prop_oneof![Just(1), 1..=u16::MAX]), 1..=MOST_RUNS),
            ends in any::<[i16; 4]>(),
        ) {
            let [x0, y0, x1, y1] = ends.map(|end| f64::from(end) / 64.0);
            let [from, to] = [[x0, y0], [x1, y1]].map(|[x, y]| PerAxis([x, y, 0.0, 0.0, 0.0, 0.0]));
            let mut list = std::string::String::new();
            for (index, (power, length)) in runs.iter().enumerate() {
                if index > 0 {
                    write!(list, ":{power}").expect("a string has room");
                }
                if *length > 1 {
                    write!(list, "@{length}").expect("a string has room");
                }
            }
            let drawn = drawn(&mut Pixels::new(f32::from(runs[0].0), &list, &from, &to).expect("a list"));
            prop_assert_eq!(drawn.len(), runs.len());
            let all: f64 = runs.iter().map(|(_, length)| f64::from(*length)).sum();
            let mut passed = 0.0;
            for ((power, length), (drawn_power, end)) in runs.iter().zip(&drawn) {
                passed += f64::from(*length);
                prop_assert_eq!(f32::from(*power), *drawn_power);
                for axis in 0..2 {
                    let place = from.0[axis] + (to.0[axis] - from.0[axis]) * passed / all;
                    prop_assert!((end.0[axis] - place).abs() < 1e-9, "{} for {place}", end.0[axis]);
                }
            }
            prop_assert_eq!(drawn[drawn.len() - 1].1, to);
        }
    }

    #[test]
    fn a_wrong_list_is_none() {
        let place = PerAxis([0.0; units::MAX_AXES]);
        let long = ":0".repeat(MOST_RUNS);
        let wrong = [":", ":0:", ":-1", ":x", ":0 1", "@", "@0", "@1.5", "@-1", "@65536", "@2@2", "@2:", ":@2", &long];
        for list in wrong {
            assert!(Pixels::new(0.0, list, &place, &place).is_none(), "{list}");
        }
    }
}
