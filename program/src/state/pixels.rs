//! Pixels of a line: powers with colons between, `S0.8:0:0`, that divide a straight move into equal parts.

use heapless::Vec;
use units::PerAxis;

/// Most pixels of a line.
pub(crate) const MOST_PIXELS: usize = 32;

/// Pixels that are left of a line.
#[derive(Clone, Debug, Default)]
pub(crate) struct Pixels {
    /// S of each pixel, the last one first.
    powers: Vec<f32, MOST_PIXELS>,
    /// End of the whole line, machine position.
    end: PerAxis<f64>,
    /// Way of a pixel.
    way: PerAxis<f64>,
}

impl Pixels {
    /// Creates the pixels of the way between two machine positions. `list` is what follows the first power,
    /// `:0:0.5`. `None` when it is no list, or too long.
    pub(crate) fn new(first: f32, list: &str, from: &PerAxis<f64>, to: &PerAxis<f64>) -> Option<Self> {
        let mut powers = Vec::new();
        powers.push(first).ok()?;
        for text in list.strip_prefix(':')?.split(':') {
            let power = gcode::read_f64(text).filter(|power| *power >= 0.0)?;
            powers.push(power as f32).ok()?;
        }
        powers.reverse();
        let count = powers.len() as f64;
        Some(Self { powers, end: *to, way: PerAxis(core::array::from_fn(|axis| (to.0[axis] - from.0[axis]) / count)) })
    }

    /// Whether no pixel is left.
    pub(crate) fn is_empty(&self) -> bool {
        self.powers.is_empty()
    }

    /// Returns the end of the line, while a pixel is left.
    pub(crate) fn end(&self) -> Option<PerAxis<f64>> {
        (!self.is_empty()).then_some(self.end)
    }

    /// Forgets what is left.
    pub(crate) fn clear(&mut self) {
        self.powers.clear();
    }

    /// Takes the next pixel: its S and its end. The last one ends where the line does.
    pub(crate) fn next(&mut self) -> Option<(f32, PerAxis<f64>)> {
        let power = self.powers.pop()?;
        let left = self.powers.len() as f64;
        Some((power, PerAxis(core::array::from_fn(|axis| self.end.0[axis] - self.way.0[axis] * left))))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pixels_divide_the_way_and_end_at_its_end() {
        let [from, to] = [PerAxis([1.0, 2.0, 0.0, 0.0, 0.0, 0.0]), PerAxis([2.0, 1.1, 0.0, 0.0, 0.0, 0.0])];
        let mut pixels = Pixels::new(0.8, ":0:0.25", &from, &to).expect("a list");
        let drawn: std::vec::Vec<_> = core::iter::from_fn(|| pixels.next()).collect();
        assert_eq!(drawn.iter().map(|(power, _)| *power).collect::<std::vec::Vec<_>>(), [0.8, 0.0, 0.25]);
        assert_eq!(drawn[2].1, to);
        assert!((drawn[0].1.0[0] - 4.0 / 3.0).abs() < 1e-12 && (drawn[1].1.0[1] - 1.4).abs() < 1e-12);
        assert!(pixels.is_empty());
    }

    #[test]
    fn a_wrong_list_is_none() {
        let place = PerAxis([0.0; units::MAX_AXES]);
        let long = ":0".repeat(MOST_PIXELS);
        for list in ["", ":", ":0:", ":-1", ":x", ":0 1", &long] {
            assert!(Pixels::new(0.0, list, &place, &place).is_none(), "{list}");
        }
    }
}
