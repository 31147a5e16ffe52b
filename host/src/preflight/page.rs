//! The page of a preflight: the path of the moves by speed, flow, layer and object, with sliders. The page
//! needs no network.

use motion::{Motion, Passage};
use preflight::Finding;
use serde_json::json;
use units::Axis;

use crate::page::fill;
use crate::report::page::base64;

const TEMPLATE: &str = include_str!("../../assets/preflight.html");

/// Greatest number of places drawn; the rest is left out, and the page says so.
const MOST_PLACES: usize = 2_000_000;
/// Length of the chords that curves are drawn with, mm.
const CHORD_MM: f64 = 0.5;
/// Least distance between layers, mm.
const LAYER_MM: f64 = 0.01;
/// Cross-section of filament of slicers' default diameter, mm2, for which flow is drawn.
const FILAMENT_MM2: f64 = 2.405;

/// Path of a job's moves, as places.
#[derive(Default)]
pub struct Way {
    /// X Y Z, mm; speed, mm/s; flow, mm3/s; layer; object: seven numbers for each place.
    places: Vec<f32>,
    layers: Vec<f64>,
    objects: Vec<String>,
    /// Lines from which on another object is made, with the object.
    labels: Vec<(u32, usize)>,
    seconds: f64,
    is_cut: bool,
}

impl Way {
    /// Notes the object that a line begins or ends: the text of M486.
    pub fn labelled(&mut self, line: u32, text: &str) {
        let (letter, rest) = text.split_at_checked(1).unwrap_or(("", ""));
        let name = rest.trim().trim_matches('"');
        let name = match letter {
            "S" if name.starts_with('-') => "",
            "S" | "B" => name,
            "E" => "",
            _ => return,
        };
        let object = if name.is_empty() {
            0
        } else {
            let known = self.objects.iter().position(|known| known == name);
            1 + known.unwrap_or_else(|| {
                self.objects.push(name.to_owned());
                self.objects.len() - 1
            })
        };
        self.labels.push((line, object));
    }

    /// Adds the places of a passed block.
    pub fn passed(&mut self, passage: &Passage, motion: &Motion) {
        self.seconds += passage.seconds();
        let Some((path, length)) = motion.passed_path() else { return };
        if self.places.len() / 7 >= MOST_PLACES {
            self.is_cut = true;
            return;
        }
        let speed = length / passage.seconds().max(1e-9);
        let fed: f64 = [Axis::A, Axis::B, Axis::C].into_iter().map(|axis| path.direction[axis]).sum();
        let moves = Axis::PRIMARY.into_iter().any(|axis| path.direction[axis] != 0.0) || !path.curve.is_line();
        let flow = if moves { (fed * speed * FILAMENT_MM2).max(0.0) } else { 0.0 };
        let layer = self.layer(path.point(length)[Axis::Z], flow > 0.0);
        let object = self.labels.iter().rev().find(|(line, _)| *line < passage.tag.0).map_or(0, |(_, object)| *object);
        let chords = if path.curve.is_line() { 1 } else { (length / CHORD_MM).ceil().clamp(1.0, 500.0) as u32 };
        let first = u32::from(!self.places.is_empty());
        for chord in first..=chords {
            let [x, y, z, ..] = path.point(length * f64::from(chord) / f64::from(chords)).0;
            let row = [x, y, z, speed, flow, layer as f64, object as f64];
            self.places.extend(row.map(|number| number as f32));
        }
    }

    fn layer(&mut self, z: f64, prints: bool) -> usize {
        let is_new = self.layers.last().is_none_or(|last| (z - last).abs() > LAYER_MM);
        if prints && is_new {
            self.layers.push(z);
        }
        self.layers.len().saturating_sub(1)
    }

    /// Returns the whole HTML page of a job.
    pub fn page(&self, title: &str, findings: &[Finding], totals: &str) -> String {
        let rows: Vec<_> = findings
            .iter()
            .map(|finding| {
                json!({
                    "line": finding.line, "what": finding.what.as_str(), "fix": finding.kind.fix(),
                    "stops": finding.kind.severity() == preflight::Severity::Stop,
                })
            })
            .collect();
        let data = json!({
            "places": base64(self.places.iter().flat_map(|number| number.to_le_bytes())),
            "layers": self.layers, "objects": self.objects, "findings": rows, "totals": totals, "cut": self.is_cut,
        });
        fill(TEMPLATE, title, &data)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_page_stands_alone_and_a_name_cannot_break_it() {
        let mut way = Way::default();
        way.labelled(3, "B</script><b>cube");
        let page = way.page("</title><b>", &[], "");
        assert!(!page.contains("</script><b>") && !page.contains("</title><b>") && !page.contains("{{"));
        for outside in ["src=\"http", "href=\"http", "@import", "url(http"] {
            assert!(!page.contains(outside), "{outside}");
        }
        assert_eq!(way.labels, [(3, 1)]);
    }
}
