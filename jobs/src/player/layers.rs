//! Layers, as slicers mark them in their files.

/// Layer that the lines being read make.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Layers {
    /// Number of the layer, from 1; 0 before the first mark.
    pub current: u32,
    /// Number of layers, once the file has said it.
    pub total: Option<u32>,
}

/// Klipper's command, which some slicers write beside their comments.
const STATS: &[u8] = b"SET_PRINT_STATS_INFO";

impl Layers {
    /// Looks at a line that may hold a mark. True when a layer begins.
    pub fn read(&mut self, line: &[u8]) -> bool {
        let line = line.trim_ascii_start();
        let mark = match line.first() {
            Some(b';') => line.trim_ascii_start().get(1..).and_then(of_comment),
            Some(b'S' | b's') => of_stats(line),
            _ => None,
        };
        let before = self.current;
        match mark {
            Some(Mark::Next) => self.current = before.saturating_add(1),
            Some(Mark::Is(layer)) => self.current = layer,
            Some(Mark::Total(count)) => self.total = Some(count),
            None => {}
        }
        self.current != before
    }
}

/// Statement of a line about layers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Mark {
    /// The next layer begins.
    Next,
    /// The layer of this number begins.
    Is(u32),
    /// The file has so many layers.
    Total(u32),
}

/// Reads marks of PrusaSlicer, OrcaSlicer and SuperSlicer (`LAYER_CHANGE`), of Bambu's (`CHANGE_LAYER`), of
/// Cura and ideaMaker (`LAYER:0`, from 0; a raft counts below), of Simplify3D (`layer 1, Z = 0.2`), of
/// KISSlicer.
fn of_comment(text: &[u8]) -> Option<Mark> {
    let text = core::str::from_utf8(text.trim_ascii()).ok()?;
    if matches!(text, "LAYER_CHANGE" | "CHANGE_LAYER") || text.starts_with("BEGIN_LAYER_OBJECT") {
        return Some(Mark::Next);
    }
    if let Some(number) = text.strip_prefix("LAYER:") {
        let number: i32 = number.trim().parse().ok()?;
        return Some(Mark::Is(number.saturating_add(1).max(0).unsigned_abs()));
    }
    for name in ["LAYER_COUNT:", "total layer number:", "total layers count ="] {
        if let Some(count) = text.strip_prefix(name) {
            return count.trim().parse().ok().map(Mark::Total);
        }
    }
    let number = text.strip_prefix("layer ")?.split(',').next()?;
    number.trim().parse().ok().map(Mark::Is)
}

fn of_stats(line: &[u8]) -> Option<Mark> {
    let name = line.get(..STATS.len())?;
    if !name.eq_ignore_ascii_case(STATS) {
        return None;
    }
    let text = core::str::from_utf8(line.get(STATS.len()..)?).ok()?;
    let value = |key: &str| {
        let mut words = text.split_ascii_whitespace();
        words.find_map(|word| word.split_once('=').filter(|(name, _)| name.eq_ignore_ascii_case(key)))
    };
    let number = |(_, value): (&str, &str)| value.parse().ok();
    let current = value("CURRENT_LAYER").and_then(number).map(Mark::Is);
    current.or_else(|| value("TOTAL_LAYER").and_then(number).map(Mark::Total))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_slicers_marks_are_known() {
        for (lines, current, total) in [
            (&[";LAYER_CHANGE", ";Z:0.2", "G1 X1", ";LAYER_CHANGE"][..], 2, None),
            (&["; CHANGE_LAYER", "; Z_HEIGHT: 0.2"], 1, None),
            (&[";LAYER_COUNT:20", ";LAYER:0"], 1, Some(20)),
            (&[";LAYER:-2", ";LAYER:-1"], 0, None),
            (&["; layer 7, Z = 1.4"], 7, None),
            (&["; layer height = 0.2"], 0, None),
            (&["SET_PRINT_STATS_INFO TOTAL_LAYER=9", "set_print_stats_info current_layer=3"], 3, Some(9)),
            (&[";LAYER_CHANGE", "SET_PRINT_STATS_INFO CURRENT_LAYER=1"], 1, None),
            (&["; total layer number: 55"], 0, Some(55)),
            (&["; \u{e4}", ";", "", "S", "SET"], 0, None),
        ] {
            let mut layers = Layers::default();
            for line in lines {
                layers.read(line.as_bytes());
            }
            assert_eq!(layers, Layers { current, total }, "{lines:?}");
        }
    }
}
