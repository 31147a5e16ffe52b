//! The figures that have limits, each over the commits that entered a ledger: `docs/images/performance.svg`.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use anyhow::{Context, Result};

use super::figures::Ledger;
use super::history::{self, State};

const FILE: &str = "docs/images/performance.svg";
/// Figures that are drawn, with their units.
const FIGURES: [(&str, &str); 16] = [
    ("flash_bytes", "bytes"),
    ("ram_bytes", "bytes"),
    ("dtcm_bytes", "bytes"),
    ("executor_stack_bytes", "bytes"),
    ("line_instructions", "instructions"),
    ("line_instructions_arcs", "instructions"),
    ("line_instructions_grbl", "instructions"),
    ("line_instructions_smooth", "instructions"),
    ("turn_instructions", "instructions"),
    ("per_step_total", "instructions"),
    ("feed_run_max_instructions", "instructions"),
    ("masked_window_max_instructions", "instructions"),
    ("hold_latency_us", "us"),
    ("hold_latency_shaped_us", "us"),
    ("usb_percent", "% of the processor"),
    ("network_flood_percent", "% of the processor"),
];
/// A cell and the curve in it, pixels.
const CELL: (f64, f64) = (320.0, 124.0);
const CURVE: (f64, f64) = (290.0, 60.0);
/// Top of the curve, below the texts.
const TOP: f64 = 36.0;
const COLUMNS: usize = 3;

/// Writes the curves as an SVG picture.
pub fn write(root: &Path, now: &Ledger) -> Result<()> {
    let states = history::states(root, now)?;
    let path = root.join(FILE);
    fs::write(&path, picture(&states)).context(FILE)
}

fn picture(states: &[State]) -> String {
    let rows = FIGURES.len().div_ceil(COLUMNS);
    let (width, height) = (CELL.0 * COLUMNS as f64, CELL.1 * rows as f64);
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" font-family=\"sans-serif\" font-size=\"12\">\n\
         <rect width=\"{width}\" height=\"{height}\" fill=\"white\"/>\n"
    );
    for (index, (key, unit)) in FIGURES.into_iter().enumerate() {
        let values: Vec<(usize, f64)> = states
            .iter()
            .enumerate()
            .filter_map(|(at, state)| state.ledger.get(key).map(|value| (at, *value)))
            .collect();
        let place = ((index % COLUMNS) as f64 * CELL.0 + 15.0, (index / COLUMNS) as f64 * CELL.1 + 10.0);
        // Writing to a string cannot fail.
        let _ = writeln!(
            svg,
            "<g transform=\"translate({} {})\">{}</g>",
            place.0,
            place.1,
            cell(key, unit, &values, states.len())
        );
    }
    svg + "</svg>\n"
}

/// A figure's name, where it began and where it is, and its curve from nothing up to its greatest.
fn cell(key: &str, unit: &str, values: &[(usize, f64)], states: usize) -> String {
    let (Some((_, first)), Some((_, last))) = (values.first(), values.last()) else {
        return format!("<text y=\"12\">{key}: not measured</text>");
    };
    let most = values.iter().map(|(_, value)| *value).fold(f64::MIN_POSITIVE, f64::max);
    let points: Vec<String> = values
        .iter()
        .map(|(at, value)| {
            let x = CURVE.0 * *at as f64 / states.saturating_sub(1).max(1) as f64;
            format!("{x:.1},{:.1}", TOP + CURVE.1 * (1.0 - value / most))
        })
        .collect();
    let (floor, line) = (TOP + CURVE.1, points.join(" "));
    let end = points.last().and_then(|point| point.split_once(',')).unwrap_or(("0", "0"));
    format!(
        "<text y=\"12\" font-weight=\"bold\">{key}</text><text y=\"27\">{first} &#8594; {last} {unit}</text>\
         <path d=\"M0 {floor}H{}\" stroke=\"#bbb\"/>\
         <polyline points=\"{line}\" fill=\"none\" stroke=\"#06c\" stroke-width=\"1.5\"/>\
         <circle cx=\"{}\" cy=\"{}\" r=\"2.5\" fill=\"#06c\"/>",
        CURVE.0, end.0, end.1
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_curve_begins_and_ends_where_its_figure_does() {
        let text = cell("a", "us", &[(0, 10.0), (2, 5.0)], 3);
        assert!(text.contains("10 &#8594; 5 us") && text.contains("points=\"0.0,36.0 290.0,66.0\""), "{text}");
        assert!(cell("b", "us", &[], 3).contains("not measured"));
    }
}
