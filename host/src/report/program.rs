//! The demands of a G-code program: its path, its end, the filament it moves, and its waits on the way. A
//! plain reading of the text that shares with the firmware only the decoder of words.

use anyhow::{Context, Result};
use gcode::{Block, Code, Decoder, Letter, Line};
use std::collections::BTreeMap;
use std::path::Path;

use super::arc;
use super::marks::{Label, Marks, Object};
use super::pixels::{self, Run};

/// Least distance between layers that no comment marks, mm.
const LAYER_MM: f64 = 0.01;

/// Corner of the programmed path, machine coordinates in mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Vertex {
    /// Coordinates X, Y and Z.
    pub at: [f64; 3],
    /// Whether the move that ends here feeds filament.
    pub extrudes: bool,
    /// Speed that the program asks of that move, mm/s.
    pub asked: f64,
    /// Line of the move, from 1.
    pub line: u32,
    /// Layer, feature and object of that line.
    pub label: Label,
    /// The machine is homed and then stands here: no move leads from the corner before.
    pub is_homed: bool,
    /// The S word that is in force on that move for a laser: zero after M5 and in G0.
    pub power: f64,
}

/// Event at a corner of a program's path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum EventKind {
    /// Filament moves and the tool does not.
    Filament,
    /// Waits for a temperature.
    Heat,
    /// Waits so many seconds.
    Dwell(f64),
    /// Waits for a person, a change of filament among them.
    Pause,
    /// Homing of the machine.
    Home,
    /// Something else that may let motion end.
    Other,
}

/// Event at a corner of the path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Event {
    /// Place of the event's corner in [`Program::corners`].
    pub at: usize,
    /// Kind of the event.
    pub kind: EventKind,
    /// Line of the event, from 1.
    pub line: u32,
    /// Layer, feature and object of that line.
    pub label: Label,
}

/// State of the machine at a program's beginning.
#[derive(Clone, Copy, Debug, Default)]
pub struct Beginning {
    /// Position of each axis after homing.
    pub home: [Option<f64>; 3],
    /// Speed of G1 until an F word, mm/s.
    pub feed: f64,
    /// Speed of G0 until an F word of its own, mm/s.
    pub seek: f64,
    /// G0 has no F words of its own.
    pub keeps_seek: bool,
}

impl From<[Option<f64>; 3]> for Beginning {
    fn from(home: [Option<f64>; 3]) -> Self {
        Self { home, ..Self::default() }
    }
}

/// Program that has been read.
#[derive(Clone, Debug, Default)]
pub struct Program {
    /// The whole path; each homing begins it anew.
    pub corners: Vec<Vertex>,
    /// Events on the way, in order.
    pub events: Vec<Event>,
    /// Index in `corners` at which the path after the last homing begins.
    begins: usize,
    /// Number of lines of the file.
    pub lines: usize,
    /// Filament moved by each tool, mm.
    pub extruded: BTreeMap<u8, f64>,
    /// First code whose effect on the position this reading does not know.
    pub unknown: Option<String>,
    /// Whether corners are rounded on purpose (G64).
    pub rounds_corners: bool,
    /// Whether the program homes.
    pub homes: bool,
    /// The program itself leaves an object out.
    pub leaves_out: bool,
    /// Title of the job, from the first comment.
    pub title: Option<String>,
    /// Kinds of features that the comments name.
    pub features: Vec<String>,
    /// Objects that the program names.
    pub objects: Vec<Object>,
    text: Vec<u8>,
}

struct Modal {
    position: [f64; 3],
    /// Difference by which machine coordinates exceed work coordinates (G92).
    offset: [f64; 3],
    e: f64,
    absolute: bool,
    absolute_e: bool,
    scale: f64,
    motion: u16,
    tool: u8,
    plane: [usize; 3],
    beginning: Beginning,
    label: Label,
    is_left_out: bool,
    /// The S word, and whether M3 or M4 has a laser follow it.
    s: f64,
    burns: bool,
    /// Pixels of the line at hand.
    pixels: Vec<Run>,
}

impl Program {
    /// Reads a program from a file.
    pub fn read(path: &Path, beginning: Beginning) -> Result<Self> {
        let text = std::fs::read(path).with_context(|| format!("cannot read {}", path.display()))?;
        Ok(Self::parse(&text, beginning))
    }

    /// Returns the path after the last homing, beginning at the machine's place then.
    pub fn path(&self) -> &[Vertex] {
        &self.corners[self.begins..]
    }

    /// Returns the program's last position.
    pub fn end(&self) -> [f64; 3] {
        self.corners.last().map_or([0.0; 3], |vertex| vertex.at)
    }

    /// Returns the text of a line, counted from 1.
    pub fn line(&self, number: u32) -> String {
        let mut lines = self.text.split(|byte| *byte == b'\n');
        let line = lines.nth(number.saturating_sub(1) as usize).unwrap_or_default();
        String::from_utf8_lossy(line).trim().to_owned()
    }

    /// Reads a text; see [`Self::read`].
    pub fn parse(text: &[u8], beginning: impl Into<Beginning>) -> Self {
        let mut program = Self { title: title(text), text: text.to_owned(), ..Self::default() };
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
            beginning: beginning.into(),
            label: Label::default(),
            is_left_out: false,
            s: 0.0,
            burns: false,
            pixels: Vec::new(),
        };
        program.corner(&modal, [0.0; 3], false);
        let mut marks = Marks::of(text);
        let mut decoder = Decoder::new();
        for line in text.split(|byte| *byte == b'\n') {
            program.lines += 1;
            let line = line.strip_suffix(b"\r").unwrap_or(line);
            marks.read(line);
            (modal.label, modal.is_left_out) = (marks.label(), marks.is_left_out());
            let (line, pixels) = pixels::read(line);
            modal.pixels = pixels;
            match decoder.decode(&line) {
                Ok(Line::Code(blocks)) => {
                    for block in blocks.map_while(Result::ok) {
                        program.take(&block, &mut modal);
                    }
                }
                Ok(Line::Extended(command)) if command.name().eq_ignore_ascii_case("TEMPERATURE_WAIT") => {
                    program.event(&modal, EventKind::Heat);
                }
                Ok(Line::Extended(command)) if command.name().eq_ignore_ascii_case("PAUSE") => {
                    program.event(&modal, EventKind::Pause);
                }
                Ok(_) => {}
                Err(refusal) => program.set_unknown(format!("line {}: {refusal}", program.lines)),
            }
        }
        if text.ends_with(b"\n") {
            program.lines -= 1;
        }
        (program.features, program.objects) = (marks.features, marks.objects);
        program.mark_layers();
        program
    }

    fn set_unknown(&mut self, what: String) {
        self.unknown.get_or_insert(what);
    }

    fn corner(&mut self, modal: &Modal, at: [f64; 3], extrudes: bool) {
        let Beginning { feed, seek, .. } = modal.beginning;
        let asked = if modal.motion == 0 { seek } else { feed };
        let line = self.lines as u32;
        let power = if modal.burns && modal.motion > 0 { modal.s } else { 0.0 };
        self.corners.push(Vertex { at, extrudes, asked, line, label: modal.label, is_homed: false, power });
    }

    fn event(&mut self, modal: &Modal, kind: EventKind) {
        let at = self.corners.len() - 1;
        self.events.push(Event { at, kind, line: self.lines as u32, label: modal.label });
    }

    /// Marks layers by their height if no comment marks them: the height of level moves with filament.
    fn mark_layers(&mut self) {
        if self.corners.iter().any(|corner| corner.label.layer > 0) {
            return;
        }
        let (mut layer, mut height, mut before) = (0, f64::NEG_INFINITY, None::<[f64; 3]>);
        let mut events = self.events.iter_mut().peekable();
        for (place, corner) in self.corners.iter_mut().enumerate() {
            let is_level = before.is_some_and(|before| before[2] == corner.at[2]);
            if corner.extrudes && is_level && (corner.at[2] - height).abs() > LAYER_MM {
                (layer, height) = (layer + 1, corner.at[2]);
            }
            corner.label.layer = layer;
            before = Some(corner.at);
            while let Some(event) = events.next_if(|event| event.at <= place) {
                event.label.layer = layer;
            }
        }
    }

    fn take(&mut self, block: &Block<'_>, modal: &mut Modal) {
        let code = block.code.unwrap_or(Code::g(modal.motion));
        if let (Letter::G, 0..=3) | (Letter::M, 3..=5) = (code.letter, code.number) {
            modal.s = block.get('S').unwrap_or(modal.s);
        }
        match (code.letter, code.number) {
            (Letter::G, 0..=3) => {
                modal.motion = code.number;
                self.travel(block, modal);
            }
            (Letter::G, 4) => {
                let milliseconds = block.get('P').unwrap_or(0.0);
                self.event(modal, EventKind::Dwell(block.get('S').unwrap_or(0.0) + 1e-3 * milliseconds));
            }
            (Letter::G, 10 | 11) => self.event(modal, EventKind::Filament),
            (Letter::G, 17) => modal.plane = [0, 1, 2],
            (Letter::G, 18) => modal.plane = [2, 0, 1],
            (Letter::G, 19) => modal.plane = [1, 2, 0],
            (Letter::G, 20) => modal.scale = 25.4,
            (Letter::G, 21) => modal.scale = 1.0,
            (Letter::G, 28) if code.subcode == 0 => self.home(block, modal),
            (Letter::G, 90) => modal.absolute = true,
            (Letter::G, 91) => modal.absolute = false,
            (Letter::G, 92) if code.subcode == 0 => set_position(block, modal),
            (Letter::G, 64) => self.rounds_corners = true,
            (Letter::G, 40 | 49 | 54 | 61 | 80 | 94) => {}
            (Letter::G, _) => {
                self.event(modal, EventKind::Other);
                self.set_unknown(format!("line {}: {code}", self.lines));
            }
            (Letter::M, 3..=5) => {
                modal.burns = code.number < 5;
                self.event(modal, EventKind::Other);
            }
            (Letter::M, 82) => modal.absolute_e = true,
            (Letter::M, 83) => modal.absolute_e = false,
            (Letter::M, 92 | 206 | 221 | 220 | 306 | 425) => self.set_unknown(format!("line {}: {code}", self.lines)),
            (Letter::M, 109 | 116 | 190 | 191) => self.event(modal, EventKind::Heat),
            (Letter::M, 0 | 1 | 25 | 125 | 226 | 600 | 601) => self.event(modal, EventKind::Pause),
            (Letter::M, number) if RIDES.contains(&number) => {}
            (Letter::M, _) => self.event(modal, EventKind::Other),
            (Letter::T, _) => {
                let tool = code.number.min(255) as u8;
                if tool != modal.tool {
                    self.event(modal, EventKind::Other);
                }
                modal.tool = tool;
            }
        }
    }

    fn home(&mut self, block: &Block<'_>, modal: &mut Modal) {
        let all = !['X', 'Y', 'Z'].into_iter().any(|letter| block.has(letter));
        for (index, letter) in ['X', 'Y', 'Z'].into_iter().enumerate() {
            if let (true, Some(home)) = (all || block.has(letter), modal.beginning.home[index]) {
                modal.position[index] = home;
            }
        }
        self.homes = true;
        self.event(modal, EventKind::Home);
        self.begins = self.corners.len();
        self.corner(modal, modal.position, false);
        if let Some(corner) = self.corners.last_mut() {
            corner.is_homed = true;
        }
    }

    fn travel(&mut self, block: &Block<'_>, modal: &mut Modal) {
        let from = modal.position;
        if let Some(rate) = block.get('F') {
            let Beginning { feed, seek, keeps_seek, .. } = &mut modal.beginning;
            *(if modal.motion == 0 && !*keeps_seek { seek } else { feed }) = rate * modal.scale / 60.0;
        }
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
        }
        if modal.is_left_out {
            self.leaves_out = true;
            return;
        }
        if block.has('E') {
            *self.extruded.entry(modal.tool).or_default() += fed;
        }
        if modal.motion >= 2 {
            let clockwise = modal.motion == 2;
            for at in arc::between(block, modal.scale, modal.plane, from, modal.position, clockwise) {
                self.corner(modal, at, fed > 0.0);
            }
        }
        if modal.position != from {
            let pixels = if modal.motion == 1 { std::mem::take(&mut modal.pixels) } else { Vec::new() };
            for (at, s) in pixels::ends(&pixels, from, modal.position) {
                modal.s = s;
                self.corner(modal, at, fed > 0.0);
            }
            if pixels.is_empty() {
                self.corner(modal, modal.position, fed > 0.0);
            }
        } else if fed != 0.0 {
            self.event(modal, EventKind::Filament);
        }
    }
}

/// Codes for which motion does not stop: fans, targets, messages, accelerations, factors.
const RIDES: [u16; 20] =
    [73, 82, 83, 104, 105, 106, 107, 117, 118, 140, 201, 203, 204, 205, 220, 221, 486, 566, 572, 900];

/// Returns the first line, when it is a comment that names the job: up to a colon, since details follow it.
/// Slicers' own first comments name only themselves.
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

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(text: &str) -> Program {
        Program::parse(text.as_bytes(), [Some(0.0); 3])
    }

    #[test]
    fn a_print_is_read_as_a_person_reads_it() {
        let program = parse("G28\nG92 E0\nG1 X10 F600 E1\nG91\nG1 Y5\nG90\nM83\nG1 X20 Y7 E0.5 ; more\nG1 E-0.25\n");
        let corners: Vec<_> = program.path().iter().map(|v| (v.at, v.extrudes)).collect();
        assert_eq!(
            corners,
            [([0.0; 3], false), ([10.0, 0.0, 0.0], true), ([10.0, 5.0, 0.0], false), ([20.0, 7.0, 0.0], true)]
        );
        assert_eq!((program.extruded[&0], program.lines, program.homes), (1.25, 9, true));
        assert_eq!(program.unknown, None);
    }

    #[test]
    fn power_is_modal_and_none_in_g0_and_after_m5() {
        let program = parse("G1 X1 S5\nM4\nG1 X2\nG0 X3\nG1 X4 S7\nG1 X5\nM5\nG1 X6\nM3 S9\nG1 X7\nG4 S2\nG1 X8");
        let powers: Vec<_> = program.path().iter().skip(1).map(|v| v.power).collect();
        assert_eq!(powers, [0.0, 5.0, 0.0, 7.0, 7.0, 0.0, 9.0, 9.0]);
    }

    #[test]
    fn absolute_filament_counts_differences() {
        assert_eq!(parse("G1 E5\nG92 E0\nG1 E3\nG1 E2.5").extruded[&0], 7.5);
    }

    #[test]
    fn offsets_and_inches_are_taken_out() {
        let program = parse("G1 X10\nG92 X0\nG1 X5\nG20\nG1 Y1\nG92\nG1 X0\n");
        let xs: Vec<_> = program.path().iter().map(|v| v.at[0]).collect();
        assert_eq!(xs, [0.0, 10.0, 15.0, 15.0, 0.0]);
        assert_eq!(program.end()[1], 25.4);
    }

    #[test]
    fn homing_starts_the_path_again_where_the_switches_are() {
        let program = Program::parse(b"G1 X5 Y5\nG28 X\nG1 Z2", [Some(-3.0), Some(0.0), None]);
        assert_eq!(program.path().iter().map(|v| v.at).collect::<Vec<_>>(), [[-3.0, 5.0, 0.0], [-3.0, 5.0, 2.0]]);
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
}
