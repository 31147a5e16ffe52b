//! M375.2: the bed as a picture of letters.

use core::fmt::Write as _;

use base::failure::{Answer, Failure, Outcome};
use base::ports::MotionPort;
use base::sessions::Reply;
use config::MachineConfig;
use heapless::String;
use motion::{GridShape, Motion};

use super::findings::{Means, sentence};
use super::form::Form;
use base::hands::Hands;

/// Width of the picture, letters.
const WIDTH: usize = 64;
/// Least and greatest number of lines.
const LINES: (f64, f64) = (6.0, 28.0);
/// Height of a letter as a multiple of its width.
const LETTER: f64 = 2.0;
/// Letters of heights, from low to high.
const SHADES: &[u8; 10] = b" .:-=+*#%@";

/// A line of the map.
pub type Line = String<176>;

/// Reports a line of the map, from 0. Returns true while more lines follow.
///
/// # Errors
/// When no grid is in force.
pub fn map_line(
    motion: &mut impl MotionPort,
    means: Means,
    index: usize,
    reply: &mut Reply<'_>,
) -> Result<bool, Failure> {
    let line = motion.motion(|motion| line_of(motion, means, index))?;
    if let Some(line) = &line {
        reply.say(format_args!("{line}\n"));
    }
    Ok(line.is_some())
}

/// Returns the machine's means of leveling its bed.
#[must_use]
pub fn means(config: &MachineConfig) -> Means {
    Means { z_motors: config.z_alignment.motors.len(), screws: !config.bed_screws.screws.is_empty() }
}

/// Shows the whole map, at the end of a sequence.
pub fn show_map<'c>(hands: &mut impl Hands<'c>) -> Outcome {
    say_from(hands, 0)
}

/// Reports the findings on the mesh in force, without the picture.
pub fn say_findings<'c>(hands: &mut impl Hands<'c>) -> Outcome {
    let lines = hands.motion(|motion| motion.compensation().grid().map(|grid| Picture::of(grid.shape()).lines));
    say_from(hands, lines.map_or(0, |lines| lines + 2))
}

fn say_from<'c>(hands: &mut impl Hands<'c>, first: usize) -> Outcome {
    let means = means(hands.config());
    for index in first.. {
        let Some(line) = hands.motion(|motion| line_of(motion, means, index))? else { break };
        hands.say(format_args!("{line}\n"));
        hands.drain();
    }
    Ok(Answer::Ok)
}

/// Returns a line of the map of the grid in force.
fn line_of(motion: &Motion, means: Means, index: usize) -> Result<Option<Line>, Failure> {
    let none = || Failure::refused(&"no grid levels the machine: load one with M375, or measure with G32");
    let grid = motion.compensation().grid().ok_or_else(none)?;
    let form = Form::of(grid.shape(), grid.heights()).ok_or_else(none)?;
    Ok(line(grid.shape(), &form, &|x, y| motion.compensation().height(x, y).z, means, index))
}

/// Returns a line of a map, from 0, of a mesh with the height `at` X and Y; `None` behind the last.
#[must_use]
pub fn line(shape: &GridShape, form: &Form, at: &dyn Fn(f64, f64) -> f64, means: Means, index: usize) -> Option<Line> {
    let picture = Picture::of(shape);
    let mut line = Line::new();
    // The line has room for every text.
    let _ = match index.checked_sub(picture.lines) {
        None => return Some(picture.line(at, form, index)),
        Some(0) => {
            let ([left, _], [right, _]) = (picture.low, picture.high);
            write!(line, "{:>9}{left:<9.1}{:>width$.1}", "X", right, width = WIDTH - 9)
        }
        Some(1) => legend(&mut line, form),
        Some(number) => match sentence(form, means, number - 2) {
            Some(text) => line.push_str(&text).map_err(|_| core::fmt::Error),
            None => return None,
        },
    };
    Some(line)
}

fn legend(line: &mut Line, form: &Form) -> core::fmt::Result {
    let letters = core::str::from_utf8(SHADES).unwrap_or("");
    let (low, high) = (form.lowest[2], form.highest[2]);
    write!(line, "{:>9}'{letters}' from {low:.3} to {high:.3} mm, {:.3} mm each", "", form.range() / 10.0)
}

/// Rectangle of the machine that a picture shows, and its number of lines.
struct Picture {
    low: [f64; 2],
    high: [f64; 2],
    lines: usize,
}

impl Picture {
    fn of(shape: &GridShape) -> Self {
        let [first, last] = [shape.place(0), shape.place(shape.points().saturating_sub(1))];
        let [fx, fy] = first;
        let [lx, ly] = last;
        let (low, high) = ([fx.min(lx), fy.min(ly)], [fx.max(lx), fy.max(ly)]);
        let ratio = (high[1] - low[1]) / (high[0] - low[0]);
        let lines = units::within(libm::round(ratio * WIDTH as f64 / LETTER), LINES.0, LINES.1);
        Self { low, high, lines: lines as usize }
    }

    /// Returns a line of the picture, the rear first, as on the machine.
    fn line(&self, at: &dyn Fn(f64, f64) -> f64, form: &Form, index: usize) -> Line {
        let share = 1.0 - index as f64 / (self.lines - 1) as f64;
        let ([left, near], [right, far]) = (self.low, self.high);
        let y = near + share * (far - near);
        let mut line = Line::new();
        let is_labelled = index == 0 || index + 1 == self.lines;
        let _ = if is_labelled { write!(line, "Y{y:>7.1}|") } else { write!(line, "{:>8}|", "") };
        for column in 0..WIDTH {
            let x = left + (right - left) * column as f64 / (WIDTH - 1) as f64;
            let _ = line.push(shade(at(x, y), form));
        }
        let _ = line.push('|');
        line
    }
}

fn shade(z: f64, form: &Form) -> char {
    let range = form.range();
    let share = if range > 0.0 { (z - form.lowest[2]) / range } else { 0.5 };
    let index = units::within(share * SHADES.len() as f64, 0.0, (SHADES.len() - 1) as f64);
    SHADES.get(index as usize).copied().unwrap_or(b'?') as char
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec::Vec;

    fn map(shape: &GridShape, height: impl Fn(f64, f64) -> f64) -> Vec<std::string::String> {
        let places = (0..shape.points()).map(|index| shape.place(index));
        let heights: Vec<f32> = places.map(|[x, y]| height(x, y) as f32).collect();
        let form = Form::of(shape, &heights).expect("a mesh");
        let line = |index| line(shape, &form, &height, Means::default(), index);
        (0..).map_while(line).map(|line| line.as_str().into()).collect()
    }

    #[test]
    fn the_map_fits_a_terminal_and_shows_where_the_bed_is_high() {
        let shape = GridShape { origin: [0.0, 0.0], step: [50.0, 50.0], count: [5, 5] };
        let lines = map(&shape, |x, y| 0.001 * x + 0.0001 * y);
        let picture: Vec<_> = lines.iter().filter(|line| line.ends_with('|')).collect();
        assert_eq!(picture.len(), 28);
        assert!(picture.iter().all(|line| line.len() == 9 + WIDTH + 1), "{lines:#?}");
        assert!(picture[0].starts_with("Y  200.0|") && picture[27].starts_with("Y    0.0|"));
        assert!(picture.iter().all(|line| line.ends_with("@|") || line.ends_with("%|")), "{lines:#?}");
        assert!(lines.iter().all(|line| line.len() <= 110) && lines.iter().take(30).all(|line| line.len() <= 80));
        assert!(lines.iter().any(|line| line.contains("X0.0") && line.ends_with("200.0")), "{lines:#?}");
        assert!(lines.iter().any(|line| line.contains("the right side is 0.200 mm higher")), "{lines:#?}");
    }

    #[test]
    fn wide_beds_and_grids_that_go_back_are_shown_as_they_lie() {
        let shape = GridShape { origin: [400.0, 50.0], step: [-100.0, -25.0], count: [5, 3] };
        let lines = map(&shape, |_, y| if y > 40.0 { 0.4 } else { 0.0 });
        let picture: Vec<_> = lines.iter().filter(|line| line.ends_with('|')).collect();
        assert_eq!(picture.len(), 6);
        assert!(picture[0].contains("@@@@@") && picture[5].contains("     "), "the rear is high: {lines:#?}");
    }
}
