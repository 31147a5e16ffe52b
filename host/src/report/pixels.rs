//! Lines of pixels: powers of S that divide a straight move into equal parts, `S0.8:0:0.5`, or in runs of
//! equal pixels, `S255@12:0@5:40`.

use std::borrow::Cow;
use std::ops::Range;

/// Run of equal pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Run {
    /// S of each pixel.
    pub s: f64,
    /// Number of pixels.
    pub count: u32,
}

/// Returns the pixels of a line, and the line with only the first pixel's power left of them; none for a line
/// without pixels, or with a list that is none.
pub fn read(line: &[u8]) -> (Cow<'_, [u8]>, Vec<Run>) {
    let none = || (Cow::Borrowed(line), Vec::new());
    let Some(list) = list(line) else { return none() };
    let text = String::from_utf8_lossy(&line[list.clone()]);
    let runs: Option<Vec<Run>> = text.split(':').map(run).collect();
    let Some(runs) = runs else { return none() };
    let first = text.find([':', '@']).unwrap_or(text.len());
    let left = [&line[..list.start + first], &line[list.end..]].concat();
    (Cow::Owned(left), runs)
}

/// Returns where the list behind an S is; a comment holds none.
fn list(line: &[u8]) -> Option<Range<usize>> {
    let end = line.iter().position(|byte| matches!(byte, b';' | b'(' | b'"')).unwrap_or(line.len());
    let code = &line[..end];
    let start = 1 + code.iter().position(|byte| matches!(byte, b'S' | b's'))?;
    let length = code[start..].iter().take_while(|byte| matches!(byte, b'0'..=b'9' | b'.' | b':' | b'@')).count();
    let list = start..start + length;
    code[list.clone()].iter().any(|byte| matches!(byte, b':' | b'@')).then_some(list)
}

/// Reads `255` or `255@12`.
fn run(text: &str) -> Option<Run> {
    let (s, count) = text.split_once('@').unwrap_or((text, "1"));
    Some(Run { s: s.parse().ok()?, count: count.parse().ok().filter(|count| *count > 0)? })
}

/// Returns the end of each run on the way from one place to another, with its S.
pub fn ends(runs: &[Run], from: [f64; 3], to: [f64; 3]) -> impl Iterator<Item = ([f64; 3], f64)> {
    let total = runs.iter().map(|run| f64::from(run.count)).sum::<f64>();
    runs.iter().scan(0.0, move |passed, run| {
        *passed += f64::from(run.count);
        let share = *passed / total;
        // The last run ends where the line does.
        let at =
            if *passed < total { std::array::from_fn(|axis| from[axis] + share * (to[axis] - from[axis])) } else { to };
        Some((at, run.s))
    })
}

#[cfg(test)]
mod tests {
    use super::super::program::Program;
    use super::*;

    #[test]
    fn a_list_leaves_the_first_power_to_the_line() {
        let (line, runs) = read(b"G1 X2S255@12:0@5:40 F600 ; S1:2");
        assert_eq!(&*line, b"G1 X2S255 F600 ; S1:2");
        let runs: Vec<_> = runs.iter().map(|run| (run.s, run.count)).collect();
        assert_eq!(runs, [(255.0, 12), (0.0, 5), (40.0, 1)]);
    }

    #[test]
    fn other_lines_stay_as_they_are() {
        for line in
            ["G1 X1 S5", "M117 Saw 1:2", "G1 X1 ; S1:0", "G1 (S1:0) X2", "G1 S1:0@0", "G1 S1::0", "", "G0 @5 ^7"]
        {
            assert_eq!(read(line.as_bytes()), (Cow::Borrowed(line.as_bytes()), Vec::new()), "{line}");
        }
    }

    #[test]
    fn pixels_are_corners_of_the_path_with_powers_of_their_own() {
        let program = Program::parse(b"M4\nG1 X10 F600 S0\nG91\nG1 X8 S5@2:0:7\nG1 Y1\nM5\n", [Some(0.0); 3]);
        let corners: Vec<_> = program.path().iter().skip(1).map(|corner| (corner.at[0], corner.power)).collect();
        assert_eq!(corners, [(10.0, 0.0), (14.0, 5.0), (16.0, 0.0), (18.0, 7.0), (18.0, 7.0)]);
        assert_eq!(program.unknown, None);
    }
}
