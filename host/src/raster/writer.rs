//! Strokes as G-code: raster lines, `G1 X12.8 S255@12:0@5:40`, with leads without power.
//!
//! Leads are G1 with S0 rather than G0: both are dark, and a G1 has the stroke's own speed, so that lead and
//! stroke are one move to the planner, whose speed does not change where the picture begins.

use std::fmt::Write as _;

use units::Axis;

use super::strokes::{Layout, Stroke};

/// Greatest length of a line, bytes. The machine takes 255: the rest is for a number and a checksum.
const MOST_BYTES: usize = 240;
/// Room for the words before the list of a line, bytes.
const WORDS_BYTES: usize = 24;
/// Greatest number of runs of a line.
const MOST_RUNS: usize = 32;
/// Greatest number of pixels of a run.
const LONGEST_RUN: usize = 65_535;

/// What is written beside the strokes.
#[derive(Clone, Debug)]
pub struct Frame {
    /// Comments at the beginning, a line each.
    pub comments: Vec<String>,
    /// Speed of strokes, mm/min.
    pub feed: f64,
    /// M3, constant power, rather than M4, power by the speed.
    pub is_constant: bool,
    /// M8 before the picture and M9 behind it.
    pub has_air: bool,
}

/// Powers of levels.
#[derive(Clone, Debug, PartialEq)]
pub struct Powers {
    /// S of full power.
    pub scale: f64,
    /// S of the darkest level and of the lightest that is burnt at all.
    pub most: f64,
    pub least: f64,
}

impl Powers {
    /// Returns the S of a share of darkness, which is zero for none.
    pub fn of(&self, share: f64) -> f64 {
        if share > 0.0 { self.least + (self.most - self.least) * share } else { 0.0 }
    }

    /// Returns an S as it is written, to a ten-thousandth of full power at least.
    fn text(&self, s: f64) -> String {
        let digits = (4.0 - self.scale.log10().floor()).clamp(0.0, 9.0) as usize;
        trimmed(format!("{s:.digits$}"))
    }
}

/// Returns the text of a file: comments, modes, a stroke after the other, the laser off.
pub fn write(frame: &Frame, layout: &Layout, strokes: &[Stroke], powers: &Powers, share: impl Fn(u8) -> f64) -> String {
    let texts: Vec<String> = (0..=u8::MAX).map(|level| powers.text(powers.of(share(level)))).collect();
    let mut text = String::new();
    for comment in &frame.comments {
        let _ = writeln!(text, "; {comment}");
    }
    let on = if frame.is_constant { "M3" } else { "M4" };
    let _ = writeln!(text, "G21 ; mm\nG90 ; absolute\nG94 ; mm/min\n{on} S0");
    if frame.has_air {
        text += "M8\n";
    }
    let feed = trimmed(format!("{:.2}", frame.feed));
    let letter = layout.axis.letter();
    for stroke in strokes {
        let [from, to] = layout.ends(stroke);
        let [x, y] = layout.place(from, layout.across(stroke.line)).map(place);
        let start = place(layout.along(stroke.start, stroke.backward));
        let _ = writeln!(text, "G0 X{x} Y{y}\nG1 {letter}{start} S0 F{feed}");
        raster_lines(&mut text, layout, stroke, &texts);
        let _ = writeln!(text, "G1 {letter}{} S0", place(to));
    }
    if frame.has_air {
        text += "M9\n";
    }
    text + "M5 S0\n"
}

/// Writes the runs of a stroke, on as many lines as they need, which end at pixel edges.
fn raster_lines(text: &mut String, layout: &Layout, stroke: &Stroke, texts: &[String]) {
    let mut edge = stroke.start;
    let (mut list, mut runs, mut passed) = (String::new(), 0, 0);
    let mut line = |list: &str, passed: usize| {
        edge = if stroke.backward { edge - passed } else { edge + passed };
        let end = place(layout.along(edge, stroke.backward));
        let _ = writeln!(text, "G1 {}{end} S{list}", layout.axis.letter());
    };
    for (level, length) in stroke.runs.iter().flat_map(|(level, length)| parts(*level, *length)) {
        let mut run = texts[usize::from(level)].clone();
        if length > 1 {
            let _ = write!(run, "@{length}");
        }
        if runs == MOST_RUNS || list.len() + 1 + run.len() + WORDS_BYTES > MOST_BYTES {
            line(&list, passed);
            (runs, passed) = (0, 0);
            list.clear();
        }
        if runs > 0 {
            list.push(':');
        }
        list += &run;
        (runs, passed) = (runs + 1, passed + length);
    }
    // A line of one power needs no count.
    let list = if runs == 1 { list.split('@').next().unwrap_or_default() } else { &list };
    line(list, passed);
}

/// Returns the parts of a run that are no longer than a run may be.
fn parts(level: u8, length: usize) -> impl Iterator<Item = (u8, usize)> {
    (0..length.div_ceil(LONGEST_RUN)).map(move |part| (level, (length - part * LONGEST_RUN).min(LONGEST_RUN)))
}

/// Returns a place as it is written: to a ten-thousandth of a mm.
fn place(mm: f64) -> String {
    trimmed(format!("{mm:.4}"))
}

/// Returns a number without the zeros behind its point.
pub fn trimmed(number: String) -> String {
    if !number.contains('.') {
        return number;
    }
    match number.trim_end_matches('0').trim_end_matches('.') {
        "-0" => "0".to_owned(),
        short => short.to_owned(),
    }
}

/// Returns a name that a comment can hold.
pub fn in_comment(name: &str) -> String {
    name.chars().map(|letter| if letter.is_ascii_graphic() || letter == ' ' { letter } else { '_' }).take(80).collect()
}

/// Returns the letters of the axes along and across strokes.
pub const fn letters(axis: Axis) -> [char; 2] {
    if matches!(axis, Axis::X) { ['X', 'Y'] } else { ['Y', 'X'] }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short_and_exact() {
        let powers = |scale| Powers { scale, most: scale, least: 0.1 * scale };
        assert_eq!(powers(1.0).text(1.0 / 3.0), "0.3333");
        assert_eq!(powers(1_000.0).text(powers(1_000.0).of(0.5)), "550");
        assert_eq!(powers(255.0).text(100.456), "100.46");
        assert_eq!((powers(1.0).of(0.0), powers(1.0).of(1e-9) > 0.09), (0.0, true));
        assert_eq!([place(1.0), place(-0.00001), place(10.0), place(0.12345)], ["1", "0", "10", "0.1235"]);
        assert_eq!(in_comment("a\nG1 X5; \u{e9}.png"), "a_G1 X5; _.png");
    }

    #[test]
    fn a_long_run_is_cut_where_a_pixel_ends() {
        let layout = Layout {
            pixel: 0.001,
            at: [0.0; 2],
            axis: Axis::Y,
            both_directions: false,
            reverse_offset: 0.0,
            lead: 2.0,
        };
        let stroke = Stroke { line: 0, start: 0, backward: false, runs: vec![(1, 140_000)] };
        let frame = Frame { comments: vec!["c".into()], feed: 600.0, is_constant: true, has_air: true };
        let powers = Powers { scale: 255.0, most: 255.0, least: 0.0 };
        let text = write(&frame, &layout, &[stroke], &powers, f64::from);
        assert_eq!(
            text,
            "; c\nG21 ; mm\nG90 ; absolute\nG94 ; mm/min\nM3 S0\nM8\nG0 X0.0005 Y-2\nG1 Y0 S0 F600\n\
             G1 Y140 S255@65535:255@65535:255@8930\nG1 Y142 S0\nM9\nM5 S0\n"
        );
    }
}
