//! Places and turns in words that a person can act on.

use core::fmt;

/// A place among others, named as somebody in front of the machine calls it: `front left`, `rear`.
#[derive(Clone, Copy, Debug)]
pub struct Corner {
    place: [f64; 2],
    low: [f64; 2],
    high: [f64; 2],
}

impl Corner {
    /// X grows to the right and Y to the rear.
    pub fn among(place: [f64; 2], places: &[[f64; 2]]) -> Self {
        let ends = |axis: usize, pick: fn(f64, f64) -> f64| {
            places.iter().filter_map(|other| other.get(axis)).copied().reduce(pick).unwrap_or(0.0)
        };
        Self { place, low: [ends(0, f64::min), ends(1, f64::min)], high: [ends(0, f64::max), ends(1, f64::max)] }
    }

    /// Returns the third of an axis in which the place lies: -1, 0 or 1; always 0 where all places coincide.
    fn third(&self, axis: usize) -> i8 {
        let get = |values: [f64; 2]| values.get(axis).copied().unwrap_or(0.0);
        let (low, length) = (get(self.low), get(self.high) - get(self.low));
        let share = (get(self.place) - low) / length;
        if length < 1.0 {
            0
        } else if share < 1.0 / 3.0 {
            -1
        } else {
            i8::from(share > 2.0 / 3.0)
        }
    }
}

impl fmt::Display for Corner {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let depth = ["front", "", "rear"];
        let width = ["left", "", "right"];
        let word = |words: [&'static str; 3], third: i8| words.get((third + 1) as usize).copied().unwrap_or("");
        let (depth, width) = (word(depth, self.third(1)), word(width, self.third(0)));
        match (depth, width) {
            ("", "") => f.write_str("middle"),
            (depth, "") => f.write_str(depth),
            ("", width) => f.write_str(width),
            (depth, width) => write!(f, "{depth} {width}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn corners_are_called_as_one_sees_them() {
        let names =
            |places: &[[f64; 2]]| places.iter().map(|at| Corner::among(*at, places).to_string()).collect::<Vec<_>>();
        let square = [[10.0, 10.0], [200.0, 12.0], [195.0, 190.0], [8.0, 200.0]];
        assert_eq!(names(&square), ["front left", "front right", "rear right", "rear left"]);
        assert_eq!(names(&[[0.0, 0.0], [250.0, 0.0], [125.0, 250.0]]), ["front left", "front right", "rear"]);
        assert_eq!(names(&[[-20.0, 100.0], [220.0, 100.0]]), ["left", "right"]);
        assert_eq!(names(&[[5.0, 5.0], [5.0, 5.0]]), ["middle", "middle"]);
        assert_eq!(names(&[[0.0, 0.0], [100.0, 100.0], [50.0, 50.0]]), ["front left", "rear right", "middle"]);
    }
}
