//! Outline of an object in Klipper's `EXCLUDE_OBJECT_DEFINE`.

use core::fmt::Write as _;

use gcode::Extended;

use super::row::{CodeLine, ExtendedFault, Names, label};

/// Writes M486 O with the rectangle around the outline, or M486 D for a missing or broken outline, because an
/// object can be left out without an outline.
pub(super) fn define(command: &Extended<'_>, _: &dyn Names, line: &mut CodeLine) -> Result<(), ExtendedFault> {
    let around = command.get("POLYGON").and_then(around);
    let (Some(name), Some([left, near, right, far])) = (command.get("NAME"), around) else {
        return label(command, "D", line);
    };
    write!(line, "M486 O{left},{near},{right},{far} {name}").map_err(|_| ExtendedFault::TooLong)
}

/// Returns least X and Y, greatest X and Y of `[[x,y],[x,y],...]`.
fn around(polygon: &str) -> Option<[f64; 4]> {
    let inner = polygon.trim().strip_prefix('[')?.strip_suffix(']')?;
    let mut around: Option<[f64; 4]> = None;
    for point in inner.split(']').map(|point| point.trim_start_matches([',', ' '])).filter(|point| !point.is_empty()) {
        let (x, y) = point.strip_prefix('[')?.split_once(',')?;
        let read = |text: &str| gcode::read_f64(text.trim()).filter(|number| number.is_finite());
        let (x, y) = (read(x)?, read(y)?);
        let [left, near, right, far] = around.unwrap_or([x, y, x, y]);
        around = Some([left.min(x), near.min(y), right.max(x), far.max(y)]);
    }
    around
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_rectangle_around_an_outline() {
        assert_eq!(around("[[10,20],[30.5,5],[12,40]]"), Some([10.0, 5.0, 30.5, 40.0]));
        assert_eq!(around("[[1,2]]"), Some([1.0, 2.0, 1.0, 2.0]));
        for text in ["", "[]", "[[1,2],[3", "[[1,2],[3]]", "[[1,x]]", "[1,2]", "[[nan,1]]"] {
            assert_eq!(around(text), None, "{text}");
        }
    }
}
