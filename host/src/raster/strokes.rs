//! The way over a picture: strokes along its rows or columns, each from its first burnt pixel to its last.

use anyhow::{Result, bail};
use units::Axis;

use super::dither::Levels;
use super::machine::Limits;

/// Way at full speed before and behind a stroke, mm.
const SPARE_MM: f64 = 1.0;

/// Place and direction of a picture on the machine.
#[derive(Clone, Copy, Debug)]
pub struct Layout {
    /// Side of a pixel, mm.
    pub pixel: f64,
    /// Lower left corner of the picture, mm.
    pub at: [f64; 2],
    /// Axis along which strokes go, X or Y.
    pub axis: Axis,
    /// Every second stroke goes back.
    pub both_directions: bool,
    /// Way by which strokes that go back are moved along the axis, mm.
    pub reverse_offset: f64,
    /// Way before and behind each stroke, mm.
    pub lead: f64,
}

/// Stroke along a row or a column.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Stroke {
    /// Number of the row, from below, or of the column, from the left.
    pub line: usize,
    /// Pixel edge at which the stroke begins, from the left or from below.
    pub start: usize,
    /// The stroke goes to lower pixels.
    pub backward: bool,
    /// Levels and how many pixels have them, in the order in which they are burnt.
    pub runs: Vec<(u8, usize)>,
}

impl Stroke {
    /// Returns the number of pixels from the first burnt one to the last.
    pub fn pixels(&self) -> usize {
        self.runs.iter().map(|(_, length)| length).sum()
    }

    /// Returns the pixel edge at which the stroke ends.
    pub fn end(&self) -> usize {
        if self.backward { self.start - self.pixels() } else { self.start + self.pixels() }
    }
}

impl Layout {
    /// Returns the length of the lead before and behind each stroke: the speed is reached on it, with some to
    /// spare.
    pub fn lead(limits: &Limits, speed: f64) -> f64 {
        limits.run_up(speed) + SPARE_MM
    }

    /// Returns the strokes of a picture, from below or from the left. Lines without a burnt pixel have none.
    pub fn strokes(&self, levels: &Levels) -> Vec<Stroke> {
        let lines = if self.axis == Axis::X { levels.rows } else { levels.columns };
        let mut strokes: Vec<Stroke> = Vec::new();
        for line in 0..lines {
            let backward = self.both_directions && strokes.len() % 2 == 1;
            strokes.extend(stroke(&self.line(levels, line), line, backward));
        }
        strokes
    }

    /// Returns the levels of a row from the left, or of a column from below.
    fn line(&self, levels: &Levels, line: usize) -> Vec<u8> {
        let width = levels.columns;
        if self.axis == Axis::X {
            let begin = (levels.rows - 1 - line) * width;
            return levels.of[begin..begin + width].to_vec();
        }
        levels.of.iter().skip(line).step_by(width).rev().copied().collect()
    }

    /// Returns the place of a pixel edge along the strokes, mm.
    pub fn along(&self, edge: usize, backward: bool) -> f64 {
        let offset = if backward { self.reverse_offset } else { 0.0 };
        self.at[self.axis as usize] + edge as f64 * self.pixel + offset
    }

    /// Returns the place of the middle of a row or column, mm.
    pub fn across(&self, line: usize) -> f64 {
        self.at[1 - self.axis as usize] + (line as f64 + 0.5) * self.pixel
    }

    /// Returns X and Y of a place along a stroke and of its middle.
    pub fn place(&self, along: f64, across: f64) -> [f64; 2] {
        if self.axis == Axis::X { [along, across] } else { [across, along] }
    }

    /// Returns where the lead before a stroke begins and where that behind it ends, along the strokes, mm.
    pub fn ends(&self, stroke: &Stroke) -> [f64; 2] {
        let lead = if stroke.backward { -self.lead } else { self.lead };
        [self.along(stroke.start, stroke.backward) - lead, self.along(stroke.end(), stroke.backward) + lead]
    }

    /// Returns the least and greatest X and Y of all strokes with their leads; none without strokes.
    pub fn bounds(&self, strokes: &[Stroke]) -> Option<[[f64; 2]; 2]> {
        let places = strokes
            .iter()
            .flat_map(|stroke| self.ends(stroke).map(|along| self.place(along, self.across(stroke.line))));
        let both = |a: [f64; 2], b: [f64; 2], pick: fn(f64, f64) -> f64| [pick(a[0], b[0]), pick(a[1], b[1])];
        places.map(|place| [place, place]).reduce(|a, b| [both(a[0], b[0], f64::min), both(a[1], b[1], f64::max)])
    }

    /// Fails when a stroke with its leads leaves the travel, with what would stay within.
    pub fn check(&self, strokes: &[Stroke], travel: &[[f64; 2]; 2], limits: &Limits, speed: f64) -> Result<()> {
        let Some(bounds) = self.bounds(strokes) else { return Ok(()) };
        for (index, axis) in [Axis::X, Axis::Y].into_iter().enumerate() {
            let [least, most] = [bounds[0][index], bounds[1][index]];
            let [low, high] = [travel[0][index], travel[1][index]];
            if least >= low - 1e-4 && most <= high + 1e-4 {
                continue;
            }
            let letter = axis.letter();
            let lead = if axis == self.axis { self.lead } else { 0.0 };
            let why = format!(
                "{letter} goes from {least:.2} to {most:.2} mm, and travel from {low:.2} to {high:.2}{}",
                if lead > 0.0 { self.reason(limits, speed) } else { String::new() }
            );
            let mut ways = Vec::new();
            if most - least <= high - low {
                let at = self.at[index];
                let [from, to] = [at + low - least, at + high - most];
                // A picture that ends nowhere on one side may stand anywhere on it.
                ways.push(match [from.is_finite(), to.is_finite()] {
                    [true, true] => format!("--at with {letter} from {:.2} to {:.2}", up(from), down(to)),
                    [true, false] => format!("--at with {letter} from {:.2} on", up(from)),
                    _ => format!("--at with {letter} up to {:.2}", down(to)),
                });
            }
            let room = (least + lead - low).min(high - (most - lead)) - SPARE_MM;
            if lead > 0.0 && room > 0.0 {
                ways.push(format!("--feed up to {:.0}", (limits.fastest(room) * 60.0).floor()));
            }
            if ways.is_empty() {
                ways.push(format!("a smaller picture: with its leads it is {:.2} mm long", most - least));
            }
            bail!("{why}. What would do: {}", ways.join(", or "));
        }
        Ok(())
    }

    /// Returns the reason for the length of a lead.
    pub fn reason(&self, limits: &Limits, speed: f64) -> String {
        let jerk =
            if limits.jerk.is_finite() { format!(" with a jerk of {} mm/s^3", limits.jerk) } else { String::new() };
        let Self { lead, .. } = self;
        format!(
            "; {lead:.2} mm of each end are for getting to {speed:.1} mm/s at {:.0} mm/s^2{jerk}",
            limits.acceleration
        )
    }
}

/// Rounds a place up to what is printed of it.
fn up(place: f64) -> f64 {
    (place * 100.0 - 1e-6).ceil() / 100.0
}

/// Rounds a place down to what is printed of it.
fn down(place: f64) -> f64 {
    (place * 100.0 + 1e-6).floor() / 100.0
}

/// Returns the stroke over a line's levels, none where none is burnt.
fn stroke(levels: &[u8], line: usize, backward: bool) -> Option<Stroke> {
    let first = levels.iter().position(|level| *level > 0)?;
    let last = levels.iter().rposition(|level| *level > 0)?;
    let burnt = levels.get(first..=last)?;
    let mut runs: Vec<(u8, usize)> =
        burnt.chunk_by(|left, right| left == right).map(|run| (run[0], run.len())).collect();
    if backward {
        runs.reverse();
    }
    Some(Stroke { line, start: if backward { last + 1 } else { first }, backward, runs })
}

#[cfg(test)]
mod tests {
    use super::*;

    const LIMITS: Limits =
        Limits { speed: 500.0, acceleration: 1_000.0, jerk: f64::INFINITY, seek: 500.0, spread: 0.0 };

    fn layout(axis: Axis) -> Layout {
        Layout { pixel: 0.5, at: [10.0, 20.0], axis, both_directions: true, reverse_offset: 0.25, lead: 6.0 }
    }

    fn levels() -> Levels {
        Levels { columns: 4, rows: 3, count: 3, of: vec![0, 2, 2, 0, 0, 0, 0, 0, 1, 0, 2, 0] }
    }

    #[test]
    fn strokes_begin_and_end_at_burnt_pixels_and_white_lines_have_none() {
        let along_x = layout(Axis::X).strokes(&levels());
        let first = Stroke { line: 0, start: 0, backward: false, runs: vec![(1, 1), (0, 1), (2, 1)] };
        let second = Stroke { line: 2, start: 3, backward: true, runs: vec![(2, 2)] };
        assert_eq!(along_x, [first, second]);
        let along_y = layout(Axis::Y).strokes(&levels());
        let columns: Vec<_> = along_y.iter().map(|stroke| (stroke.line, stroke.start, stroke.runs.clone())).collect();
        assert_eq!(columns, [(0, 0, vec![(1, 1)]), (1, 3, vec![(2, 1)]), (2, 0, vec![(2, 1), (0, 1), (2, 1)])]);
    }

    #[test]
    fn leads_stand_at_both_ends_and_what_goes_back_is_moved() {
        let layout = layout(Axis::X);
        let strokes = layout.strokes(&levels());
        assert_eq!(layout.ends(&strokes[0]), [4.0, 17.5]);
        assert_eq!(layout.ends(&strokes[1]), [10.0 + 1.5 + 0.25 + 6.0, 10.0 + 0.5 + 0.25 - 6.0]);
        assert_eq!(layout.bounds(&strokes), Some([[4.0, 20.25], [17.75, 21.25]]));
        assert_eq!(layout.bounds(&[]), None);
    }

    #[test]
    fn what_leaves_the_travel_is_refused_with_what_would_not() {
        let layout = layout(Axis::X);
        let strokes = layout.strokes(&levels());
        let why = |travel| {
            let checked = layout.check(&strokes, &travel, &LIMITS, 100.0);
            checked.map_or_else(|error| error.to_string(), |()| String::new())
        };
        assert_eq!(why([[4.0, 0.0], [18.0, 100.0]]), "");
        let left = why([[5.0, 0.0], [f64::INFINITY, 100.0]]);
        assert!(left.starts_with("X goes from 4.00 to 17.75 mm, and travel from 5.00 to inf; 6.00 mm of"), "{left}");
        assert!(left.ends_with("What would do: --at with X from 11.00 on, or --feed up to 5366"), "{left}");
        assert!(layout.check(&strokes, &[[5.0, 0.0], [99.0, 99.0]], &LIMITS, 100.0).is_err());
        let narrow = why([[9.5, 0.0], [11.0, 100.0]]);
        assert!(narrow.ends_with("a smaller picture: with its leads it is 13.75 mm long"), "{narrow}");
        let above = why([[0.0, 0.0], [99.0, 21.0]]);
        assert!(
            above.starts_with("Y goes from 20.25") && above.ends_with("--at with Y from -0.25 to 19.75"),
            "{above}"
        );
    }
}
