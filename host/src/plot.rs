//! `velvet plot`: a run's curves as text, for a terminal far from any browser. Two by four dots to a
//! character (Unicode braille patterns, U+2800).

/// Width and height of a plot, characters.
const WIDTH: usize = 72;
const HEIGHT: usize = 12;
const DOTS: [[u32; 4]; 2] = [[0x01, 0x02, 0x04, 0x40], [0x08, 0x10, 0x20, 0x80]];

/// Curve of values at times, with gaps at missing values.
pub struct Curve<'a> {
    /// Name of the quantity, with its unit.
    pub name: &'a str,
    /// Times of the values, seconds.
    pub time: &'a [f64],
    /// Values, none at a gap.
    pub values: &'a [Option<f64>],
}

/// Draws the curve as lines of text, with its range at the left and its time below.
pub fn draw(curve: &Curve<'_>) -> String {
    let known = || curve.values.iter().flatten().copied();
    let (low, high) = known().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)));
    let (Some(begin), Some(end)) = (curve.time.first(), curve.time.last()) else {
        return format!("{}: nothing recorded\n", curve.name);
    };
    if low > high {
        return format!("{}: nothing recorded\n", curve.name);
    }
    let span = if high > low { high - low } else { 1.0 };
    let mut cells = vec![[0_u32; WIDTH]; HEIGHT];
    let mut last: Option<(usize, usize)> = None;
    for (time, value) in curve.time.iter().zip(curve.values) {
        let Some(value) = value else {
            last = None;
            continue;
        };
        let x = scaled((time - begin) / (end - begin).max(f64::MIN_POSITIVE), 2 * WIDTH);
        let y = scaled((value - low) / span, 4 * HEIGHT);
        // A column begins at the dot before, so that a steep curve has no holes.
        let from = last.filter(|(column, _)| *column + 2 > x).map_or(y, |(_, row)| row);
        for row in from.min(y)..=from.max(y) {
            let down = 4 * HEIGHT - 1 - row;
            cells[down / 4][x / 2] |= DOTS[x % 2][down % 4];
        }
        last = Some((x, y));
    }
    let mut text = format!("{}\n", curve.name);
    for (row, line) in cells.iter().enumerate() {
        let label = match row {
            0 => format!("{high:>9.1}"),
            r if r == HEIGHT - 1 => format!("{low:>9.1}"),
            _ => " ".repeat(9),
        };
        let dots: String = line.iter().map(|cell| char::from_u32(0x2800 + cell).unwrap_or(' ')).collect();
        text += &format!("{label} \u{2502}{dots}\n");
    }
    let axis = format!("{begin:.0} s");
    let far = format!("{end:.0} s");
    text + &format!("{:>11}{axis}{far:>width$}\n", "", width = WIDTH - axis.len())
}

fn scaled(share: f64, count: usize) -> usize {
    ((share * count as f64) as usize).min(count - 1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn dots(text: &str) -> u32 {
        text.chars().filter(|c| ('\u{2800}'..='\u{28FF}').contains(c)).map(|c| (c as u32 - 0x2800).count_ones()).sum()
    }

    proptest! {
        #[test]
        fn a_plot_always_has_its_shape(values in prop::collection::vec(prop::option::of(-1e6_f64..1e6), 1..500)) {
            let time: Vec<f64> = (0..values.len()).map(|n| n as f64 * 0.1).collect();
            let text = draw(&Curve { name: "any", time: &time, values: &values });
            if values.iter().all(Option::is_none) {
                prop_assert!(text.contains("nothing recorded"));
            } else {
                prop_assert_eq!(text.lines().count(), HEIGHT + 2);
                prop_assert!(text.lines().skip(1).take(HEIGHT).all(|line| line.chars().count() == 11 + WIDTH));
                prop_assert!(dots(&text) >= 1);
            }
        }
    }

    #[test]
    fn a_rising_line_goes_from_the_lower_left_to_the_upper_right() {
        let time: Vec<f64> = (0..1_000).map(f64::from).collect();
        let values: Vec<_> = time.iter().map(|t| Some(*t)).collect();
        let text = draw(&Curve { name: "ramp", time: &time, values: &values });
        let lines: Vec<Vec<char>> = text.lines().map(|line| line.chars().collect()).collect();
        assert_ne!(lines[1][10 + WIDTH], '\u{2800}');
        assert_eq!(lines[1][11], '\u{2800}');
        assert_ne!(lines[HEIGHT][11], '\u{2800}');
        assert!(text.contains("999.0") && text.ends_with("999 s\n"));
    }
}
