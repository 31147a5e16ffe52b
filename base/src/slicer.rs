//! Durations that slicers write into a file of G-code: in comments, and by M73.
//!
//! - Cura: `;TIME:6345`, seconds in all, and `;TIME_ELAPSED:123.4` behind each layer;
//! - PrusaSlicer, SuperSlicer, OrcaSlicer: `; estimated printing time (normal mode) = 1d 2h 3m 4s`, at the
//!   end of the file;
//! - OrcaSlicer, Bambu Studio: `; model printing time: 13m 43s; total estimated time: 20m 5s`;
//! - Simplify3D: `;   Build time: 1 hour 23 minutes`;
//! - ideaMaker: `;Print Time: 6345`;
//! - M73: `M73 P12 R34`, minutes that are left.

/// Times that a slicer has stated.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SlicerTimes {
    /// Time of the whole job, seconds.
    pub total: Option<f32>,
    /// Time left at the line that stated it, seconds.
    pub left: Option<f32>,
}

impl SlicerTimes {
    /// Looks at a line that may say something: a comment or M73.
    pub fn read(&mut self, line: &[u8]) {
        let Ok(text) = core::str::from_utf8(line) else { return };
        match text.trim_start().strip_prefix(';') {
            Some(comment) => self.read_comment(comment.trim()),
            None => self.read_progress(text.trim_start()),
        }
    }

    fn read_progress(&mut self, text: &str) {
        let Some(words) = text.strip_prefix("M73 ") else { return };
        let minutes = words.split_whitespace().find_map(|word| gcode::read_f32(word.strip_prefix('R')?));
        if let Some(minutes) = minutes.filter(|minutes| minutes.is_finite() && *minutes >= 0.0) {
            self.left = Some(60.0 * minutes);
            // The first M73 tells the whole time.
            self.total = self.total.or(self.left);
        }
    }

    fn read_comment(&mut self, text: &str) {
        if let Some(seconds) = text.strip_prefix("TIME_ELAPSED:").and_then(number) {
            self.left = self.total.map(|total| if total > seconds { total - seconds } else { 0.0 });
            return;
        }
        let words = match text.split_once(['=', ':']) {
            Some(("TIME" | "Print Time", seconds)) => return self.total = number(seconds).or(self.total),
            Some((name, rest)) if name.trim_end() == "estimated printing time (normal mode)" => rest,
            Some((name, rest)) if name.eq_ignore_ascii_case("build time") => rest,
            Some(("model printing time", rest)) => match rest.split_once("total estimated time:") {
                Some((_, rest)) => rest,
                None => return,
            },
            _ => return,
        };
        self.total = in_words(words).or(self.total);
    }
}

/// Reads a number that is not negative.
#[must_use]
pub fn number(text: &str) -> Option<f32> {
    gcode::read_f32(text.trim()).filter(|number| number.is_finite() && *number >= 0.0)
}

/// Reads `1d 2h 3m 4s`, or `1 hour 23 minutes`, in seconds.
fn in_words(text: &str) -> Option<f32> {
    let (mut rest, mut sum) = (text.trim_start(), None);
    loop {
        let digits = rest.find(|letter: char| !letter.is_ascii_digit() && letter != '.').unwrap_or(rest.len());
        let (number, behind) = rest.split_at(digits);
        let Some(count) = gcode::read_f32(number) else { return sum };
        let unit = behind.trim_start();
        let factor = match unit.as_bytes().first() {
            Some(b'd') => 86_400.0,
            Some(b'h') => 3_600.0,
            Some(b'm') => 60.0,
            Some(b's') => 1.0,
            _ => return sum,
        };
        sum = Some(sum.unwrap_or(0.0) + factor * count);
        rest = unit.trim_start_matches(|letter: char| letter.is_ascii_alphabetic()).trim_start();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn said(lines: &[&str]) -> (Option<f32>, Option<f32>) {
        let mut times = SlicerTimes::default();
        lines.iter().for_each(|line| times.read(line.as_bytes()));
        (times.total, times.left)
    }

    #[test]
    fn every_slicer_is_understood() {
        for (line, total) in [
            (";TIME:6345", 6_345.0),
            ("; estimated printing time (normal mode) = 1d 2h 3m 4s", 93_784.0),
            ("; estimated printing time (normal mode) = 8m 31s", 511.0),
            ("; model printing time: 13m 43s; total estimated time: 20m 5s", 1_205.0),
            (";   Build time: 1 hour 23 minutes", 4_980.0),
            ("; Build Time: 12 minutes", 720.0),
            (";Print Time: 4529", 4_529.0),
        ] {
            assert_eq!(said(&[line]), (Some(total), None), "{line}");
        }
    }

    #[test]
    fn what_is_left_comes_as_the_job_goes_on() {
        assert_eq!(said(&[";TIME:600", ";TIME_ELAPSED:120.5"]), (Some(600.0), Some(479.5)));
        assert_eq!(said(&[";TIME:600", ";TIME_ELAPSED:700"]), (Some(600.0), Some(0.0)));
        assert_eq!(said(&["M73 P0 R34", "M73 P50 R17"]), (Some(2_040.0), Some(1_020.0)));
        assert_eq!(said(&["M73 Q0 S34", "M73", "M731 R5", "M73 R-1", "M73 Rnan"]), (None, None));
    }

    #[test]
    fn other_comments_say_nothing() {
        for line in [
            ";TIME",
            ";TIME:",
            ";TIME:x",
            "; estimated printing time (silent mode) = 9m",
            ";LAYER:3",
            "; build time: soon",
            "; model printing time: 13m 43s",
            ";TIME_ELAPSED:12",
            "G1 X1",
            "; estimated printing time (normal mode) = ",
        ] {
            assert_eq!(said(&[line]), (None, None), "{line}");
        }
    }
}
