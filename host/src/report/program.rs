//! What a G-code program asks for: the path, where it ends, how much filament it moves. A plain reading of
//! the text, with none of the firmware's code but its words.

use anyhow::{Context, Result};
use gcode::{Block, Code, Decoder, Letter, Line};
use std::collections::BTreeMap;
use std::path::Path;

/// Arcs become chords no further than this from the arc, mm.
const CHORD_ERROR_MM: f64 = 0.001;

/// A corner of the programmed path, machine coordinates in mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Vertex {
    /// X, Y, Z.
    pub at: [f64; 3],
    /// The move that ends here feeds filament.
    pub extrudes: bool,
}

/// A program, read.
#[derive(Clone, Debug, Default)]
pub struct Program {
    /// The path after the last homing, beginning where that left the machine.
    pub path: Vec<Vertex>,
    /// Lines of the file.
    pub lines: usize,
    /// Filament moved by each tool, mm.
    pub extruded: BTreeMap<u8, f64>,
    /// A code whose effect on the position this reading does not know.
    pub unknown: Option<String>,
    /// Corners are rounded on purpose (G64).
    pub rounds_corners: bool,
    /// Whether the program homes.
    pub homes: bool,
    /// What the first comment calls it.
    pub title: Option<String>,
}

struct Modal {
    position: [f64; 3],
    /// Work coordinates are machine coordinates less this (G92).
    offset: [f64; 3],
    e: f64,
    absolute: bool,
    absolute_e: bool,
    scale: f64,
    motion: u16,
    tool: u8,
    plane: [usize; 3],
}

impl Program {
    /// Reads a file. `home` is where homing leaves each axis.
    pub fn read(path: &Path, home: [Option<f64>; 3]) -> Result<Self> {
        let text = std::fs::read(path).with_context(|| format!("cannot read {}", path.display()))?;
        Ok(Self::parse(&text, home))
    }

    /// Where the program ends.
    pub fn end(&self) -> [f64; 3] {
        self.path.last().map_or([0.0; 3], |vertex| vertex.at)
    }

    /// Reads a text; see [`Self::read`].
    pub fn parse(text: &[u8], home: [Option<f64>; 3]) -> Self {
        let mut program = Self { path: vec![Vertex { at: [0.0; 3], extrudes: false }], ..Self::default() };
        let mut modal = Modal {
            position: [0.0; 3],
            offset: [0.0; 3],
            e: 0.0,
            absolute: true,
            absolute_e: true,
            scale: 1.0,
            motion: 0,
            tool: 0,
            plane: [0, 1, 2],
        };
        program.title = title(text);
        let mut decoder = Decoder::new();
        for line in text.split(|byte| *byte == b'\n') {
            program.lines += 1;
            let line = line.strip_suffix(b"\r").unwrap_or(line);
            match decoder.decode(line) {
                Ok(Line::Code(blocks)) => {
                    for block in blocks.map_while(Result::ok) {
                        program.take(&block, &mut modal, home);
                    }
                }
                Ok(_) => {}
                Err(refusal) => program.set_unknown(format!("line {}: {refusal}", program.lines)),
            }
        }
        if text.ends_with(b"\n") {
            program.lines -= 1;
        }
        program
    }

    fn set_unknown(&mut self, what: String) {
        self.unknown.get_or_insert(what);
    }

    fn take(&mut self, block: &Block<'_>, modal: &mut Modal, home: [Option<f64>; 3]) {
        let code = block.code.unwrap_or(Code::g(modal.motion));
        match (code.letter, code.number) {
            (Letter::G, 0..=3) => {
                modal.motion = code.number;
                self.travel(block, modal);
            }
            (Letter::G, 17) => modal.plane = [0, 1, 2],
            (Letter::G, 18) => modal.plane = [2, 0, 1],
            (Letter::G, 19) => modal.plane = [1, 2, 0],
            (Letter::G, 20) => modal.scale = 25.4,
            (Letter::G, 21) => modal.scale = 1.0,
            (Letter::G, 28) if code.subcode == 0 => self.home(block, modal, home),
            (Letter::G, 90) => modal.absolute = true,
            (Letter::G, 91) => modal.absolute = false,
            (Letter::G, 92) if code.subcode == 0 => set_position(block, modal),
            (Letter::G, 64) => self.rounds_corners = true,
            (Letter::G, 4 | 10 | 11 | 40 | 49 | 54 | 61 | 80 | 94) => {}
            (Letter::G, _) => self.set_unknown(format!("line {}: {code}", self.lines)),
            (Letter::M, 82) => modal.absolute_e = true,
            (Letter::M, 83) => modal.absolute_e = false,
            (Letter::M, 92 | 206 | 221 | 220 | 306 | 425) => self.set_unknown(format!("line {}: {code}", self.lines)),
            (Letter::M, _) => {}
            (Letter::T, _) => modal.tool = code.number.min(255) as u8,
        }
    }

    fn home(&mut self, block: &Block<'_>, modal: &mut Modal, home: [Option<f64>; 3]) {
        let all = !['X', 'Y', 'Z'].into_iter().any(|letter| block.has(letter));
        for (index, letter) in ['X', 'Y', 'Z'].into_iter().enumerate() {
            if let (true, Some(home)) = (all || block.has(letter), home[index]) {
                modal.position[index] = home;
            }
        }
        self.homes = true;
        self.path.clear();
        self.path.push(Vertex { at: modal.position, extrudes: false });
    }

    fn travel(&mut self, block: &Block<'_>, modal: &mut Modal) {
        let from = modal.position;
        for (index, letter) in ['X', 'Y', 'Z'].into_iter().enumerate() {
            if let Some(word) = block.get(letter) {
                let mm = word * modal.scale;
                modal.position[index] = if modal.absolute { mm + modal.offset[index] } else { from[index] + mm };
            }
        }
        let mut fed = 0.0;
        if let Some(word) = block.get('E') {
            let mm = word * modal.scale;
            fed = if modal.absolute_e { mm - modal.e } else { mm };
            modal.e += fed;
            *self.extruded.entry(modal.tool).or_default() += fed;
        }
        let extrudes = fed > 0.0;
        if modal.motion >= 2 {
            self.arc(block, modal, from, extrudes);
        }
        if modal.position != from {
            self.path.push(Vertex { at: modal.position, extrudes });
        }
    }

    /// Corners of an arc, its end excepted. RS-274: G2 clockwise seen from the positive third axis.
    fn arc(&mut self, block: &Block<'_>, modal: &Modal, from: [f64; 3], extrudes: bool) {
        let [a, b, along] = modal.plane;
        let to = modal.position;
        let offsets = ['I', 'J', 'K'].map(|letter| block.get(letter).map(|word| word * modal.scale));
        let center = match block.get('R') {
            Some(radius) => radius_center([from[a], from[b]], [to[a], to[b]], radius * modal.scale, modal.motion == 2),
            None => Some([from[a] + offsets[a].unwrap_or(0.0), from[b] + offsets[b].unwrap_or(0.0)]),
        };
        let Some([ca, cb]) = center else { return };
        let radius = (from[a] - ca).hypot(from[b] - cb);
        let start = (from[b] - cb).atan2(from[a] - ca);
        let mut sweep = (to[b] - cb).atan2(to[a] - ca) - start;
        let turn = std::f64::consts::TAU;
        if modal.motion == 2 && sweep >= -1e-9 {
            sweep -= turn;
        } else if modal.motion == 3 && sweep <= 1e-9 {
            sweep += turn;
        }
        let step = 2.0 * (1.0 - CHORD_ERROR_MM / radius.max(2.0 * CHORD_ERROR_MM)).acos();
        let pieces = (sweep.abs() / step).ceil().clamp(1.0, 10_000.0) as usize;
        for piece in 1..pieces {
            let share = piece as f64 / pieces as f64;
            let angle = start + share * sweep;
            let mut at = from;
            at[a] = ca + radius * angle.cos();
            at[b] = cb + radius * angle.sin();
            at[along] = from[along] + share * (to[along] - from[along]);
            self.path.push(Vertex { at, extrudes });
        }
    }
}

/// The first line, when it is a comment that names the job: up to a colon, since what follows is detail. What
/// slicers write there names only themselves.
fn title(text: &[u8]) -> Option<String> {
    let first = text.split(|byte| *byte == b'\n').next()?.strip_prefix(b";")?;
    let words = String::from_utf8_lossy(first);
    let title = words.split(": ").next()?.trim();
    let is_name = !title.is_empty() && title.len() <= 80 && !title.contains([':', '=', '_']);
    (is_name && !title.to_lowercase().contains("generated")).then(|| title.to_owned())
}

fn set_position(block: &Block<'_>, modal: &mut Modal) {
    let bare = !['X', 'Y', 'Z', 'E'].into_iter().any(|letter| block.has(letter));
    if bare {
        modal.offset = [0.0; 3];
    }
    for (index, letter) in ['X', 'Y', 'Z'].into_iter().enumerate() {
        if let Some(word) = block.get(letter) {
            modal.offset[index] = modal.position[index] - word * modal.scale;
        }
    }
    if bare || block.has('E') {
        modal.e = block.get('E').unwrap_or(0.0) * modal.scale;
    }
}

/// Center of the arc of this radius; a negative one means the long way round.
fn radius_center(from: [f64; 2], to: [f64; 2], radius: f64, clockwise: bool) -> Option<[f64; 2]> {
    let [dx, dy] = [to[0] - from[0], to[1] - from[1]];
    let chord = dx.hypot(dy);
    let height = (radius * radius - chord * chord / 4.0).max(0.0).sqrt();
    if chord == 0.0 {
        return None;
    }
    let side = if clockwise == (radius > 0.0) { -1.0 } else { 1.0 };
    Some([(from[0] + to[0]) / 2.0 - side * height * dy / chord, (from[1] + to[1]) / 2.0 + side * height * dx / chord])
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn parse(text: &str) -> Program {
        Program::parse(text.as_bytes(), [Some(0.0), Some(0.0), Some(0.0)])
    }

    #[test]
    fn a_print_is_read_as_a_person_reads_it() {
        let program = parse("G28\nG92 E0\nG1 X10 F600 E1\nG91\nG1 Y5\nG90\nM83\nG1 X20 Y7 E0.5 ; more\nG1 E-0.25\n");
        let corners: Vec<_> = program.path.iter().map(|v| (v.at, v.extrudes)).collect();
        assert_eq!(
            corners,
            [([0.0; 3], false), ([10.0, 0.0, 0.0], true), ([10.0, 5.0, 0.0], false), ([20.0, 7.0, 0.0], true)]
        );
        assert_eq!((program.extruded[&0], program.lines, program.homes), (1.25, 9, true));
        assert_eq!(program.unknown, None);
    }

    #[test]
    fn absolute_filament_counts_differences() {
        assert_eq!(parse("G1 E5\nG92 E0\nG1 E3\nG1 E2.5").extruded[&0], 7.5);
    }

    #[test]
    fn offsets_and_inches_are_taken_out() {
        let program = parse("G1 X10\nG92 X0\nG1 X5\nG20\nG1 Y1\nG92\nG1 X0\n");
        let xs: Vec<_> = program.path.iter().map(|v| v.at[0]).collect();
        assert_eq!(xs, [0.0, 10.0, 15.0, 15.0, 0.0]);
        assert_eq!(program.end()[1], 25.4);
    }

    #[test]
    fn homing_starts_the_path_again_where_the_switches_are() {
        let program = Program::parse(b"G1 X5 Y5\nG28 X\nG1 Z2", [Some(-3.0), Some(0.0), None]);
        assert_eq!(program.path.iter().map(|v| v.at).collect::<Vec<_>>(), [[-3.0, 5.0, 0.0], [-3.0, 5.0, 2.0]]);
    }

    #[test]
    fn a_first_comment_is_a_title_unless_a_slicer_wrote_it() {
        assert_eq!(parse("; Owl, 20 mm: sliced by hand\nG28").title.as_deref(), Some("Owl, 20 mm"));
        for other in ["G28 ; home", ";FLAVOR:Marlin", "; generated by a slicer on a day", ";", "; HEADER_BLOCK_START"] {
            assert_eq!(parse(other).title, None, "{other}");
        }
    }

    #[test]
    fn what_moves_the_position_unseen_is_named() {
        assert_eq!(parse("G1 X1\nG29\n").unknown.as_deref(), Some("line 2: G29"));
    }

    proptest! {
        #[test]
        fn every_corner_of_an_arc_is_on_it(radius in 1.0_f64..50.0, angle in 0.1_f64..6.0, clockwise: bool) {
            let turn = if clockwise { -angle } else { angle };
            let (x, y) = (radius * turn.cos(), radius * turn.sin());
            let code = if clockwise { 2 } else { 3 };
            let program = parse(&format!("G1 X{radius}\nG{code} X{x:.9} Y{y:.9} I{:.9} J0\n", -radius));
            let mut length = 0.0;
            for pair in program.path[1..].windows(2) {
                length += (pair[1].at[0] - pair[0].at[0]).hypot(pair[1].at[1] - pair[0].at[1]);
                prop_assert!((pair[1].at[0].hypot(pair[1].at[1]) - radius).abs() < 1e-6);
            }
            prop_assert!((length / (radius * angle) - 1.0).abs() < 2e-3, "{} of {}", length, radius * angle);
        }

        #[test]
        fn a_radius_word_and_a_center_word_make_the_same_arc(radius in 1.0_f64..50.0, angle in 0.2_f64..6.0, clockwise: bool) {
            prop_assume!((angle - std::f64::consts::PI).abs() > 0.1);
            let turn = if clockwise { -angle } else { angle };
            let (x, y) = (radius * turn.cos(), radius * turn.sin());
            let signed = if angle > std::f64::consts::PI { -radius } else { radius };
            let center = radius_center([radius, 0.0], [x, y], signed, clockwise).unwrap();
            prop_assert!(center[0].abs() < 1e-6 && center[1].abs() < 1e-6, "{:?}", center);
        }
    }
}
