//! The layer, kind of feature and object of a file's lines, from a slicer's comments and from the commands
//! that name objects.
//!
//! | slicer | feature | object |
//! |---|---|---|
//! | PrusaSlicer, SuperSlicer, OrcaSlicer | `;TYPE:Perimeter` | `; printing object NAME id:0 copy 0` |
//! | Bambu Studio | `; FEATURE: Outer wall` | `; start printing object, unique label id: 15` |
//! | Cura | `;TYPE:WALL-OUTER` | `;MESH:part.stl` |
//! | ideaMaker | `;TYPE:WALL-OUTER` | `;PRINTING: part.stl` |
//! | Simplify3D | `; feature outer perimeter`, before version 4 `; outer perimeter` | |
//! | KISSlicer | `; 'Perimeter Path', 0.9 [feed mm/s]` | |
//! | any | | `EXCLUDE_OBJECT_START NAME=part`, `M486 S1` |
//!
//! Layers are those of [`jobs::player::Layers`]. If commands name objects, comments about objects count no
//! more: files have both.

use jobs::player::Layers;

/// Layer, feature and object of a line.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Label {
    /// Layer number from 1; 0 before the first.
    pub layer: u32,
    /// Place in [`Marks::features`] from 1; 0 if the file names none.
    pub feature: u32,
    /// Place in [`Marks::objects`] from 1; 0 if the file names none.
    pub object: u32,
}

/// Object that the file names.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Object {
    /// Name as in the file.
    pub name: String,
    /// Number that M486 gives the object.
    number: Option<u32>,
    /// The file itself says that the object is not to be made.
    pub is_left_out: bool,
}

/// Marks of the lines read so far.
#[derive(Clone, Debug, Default)]
pub struct Marks {
    /// Kinds of features in the order in which they come.
    pub features: Vec<String>,
    /// Objects in the order in which they come.
    pub objects: Vec<Object>,
    layers: Layers,
    feature: usize,
    object: usize,
    commands_name_objects: bool,
}

/// Features that Simplify3D before version 4 writes as the whole of a comment.
const PLAIN_FEATURES: [&str; 14] = [
    "outer perimeter",
    "inner perimeter",
    "external single extrusion",
    "internal single extrusion",
    "solid layer",
    "infill",
    "bridge",
    "gap fill",
    "support",
    "dense support",
    "skirt",
    "raft",
    "ooze shield",
    "prime pillar",
];

impl Marks {
    /// Makes marks for a text whose lines will be read.
    pub fn of(text: &[u8]) -> Self {
        let names = |line: &[u8]| {
            let line = line.trim_ascii_start().to_ascii_uppercase();
            line.starts_with(b"EXCLUDE_OBJECT_START") || line.starts_with(b"M486 S") || line.starts_with(b"M486S")
        };
        Self { commands_name_objects: text.split(|byte| *byte == b'\n').any(names), ..Self::default() }
    }

    /// Returns the layer, feature and object of the lines from here on.
    pub const fn label(&self) -> Label {
        Label { layer: self.layers.current, feature: self.feature as u32, object: self.object as u32 }
    }

    /// Returns whether the lines from here on make an object that is left out.
    pub fn is_left_out(&self) -> bool {
        self.object.checked_sub(1).and_then(|place| self.objects.get(place)).is_some_and(|object| object.is_left_out)
    }

    /// Reads a line that may mark a layer, a feature or an object.
    pub fn read(&mut self, line: &[u8]) {
        self.layers.read(line);
        let line = String::from_utf8_lossy(line);
        let line = line.trim();
        if let Some(comment) = line.strip_prefix(';') {
            self.read_comment(comment.trim());
        } else if let Some(words) = after_code(line, "M486") {
            self.read_m486(words);
        } else if line.get(..14).is_some_and(|name| name.eq_ignore_ascii_case("EXCLUDE_OBJECT")) {
            self.read_exclude(line);
        }
    }

    fn read_comment(&mut self, text: &str) {
        if let Some(feature) = feature_of(text) {
            self.feature = place_of(&mut self.features, feature);
        } else if let (false, Some(object)) = (self.commands_name_objects, object_of(text)) {
            self.object = if object.is_empty() { 0 } else { self.named(object) };
        }
    }

    /// Reads Klipper's `EXCLUDE_OBJECT_START NAME=..` and the like.
    fn read_exclude(&mut self, line: &str) {
        let mut words = line.split_whitespace();
        let command = words.next().unwrap_or("").to_ascii_uppercase();
        let value = |key: &str| {
            let mut pairs = words.clone().filter_map(|word| word.split_once('='));
            pairs.find(|(name, _)| name.eq_ignore_ascii_case(key)).map(|(_, value)| value.trim_matches('"'))
        };
        let is_on = |key: &str| value(key).is_some_and(|value| value != "0");
        match (command.as_str(), value("NAME")) {
            ("EXCLUDE_OBJECT_DEFINE", Some(name)) => drop(self.named(name)),
            ("EXCLUDE_OBJECT_START", Some(name)) => self.object = self.named(name),
            ("EXCLUDE_OBJECT_END", _) => self.object = 0,
            ("EXCLUDE_OBJECT", Some(name)) => {
                let place = self.named(name);
                self.leave_out(place, !is_on("RESET"));
            }
            ("EXCLUDE_OBJECT", None) if is_on("RESET") => {
                self.objects.iter_mut().for_each(|object| object.is_left_out = false);
            }
            ("EXCLUDE_OBJECT", None) if is_on("CURRENT") => self.leave_out(self.object, true),
            _ => {}
        }
    }

    /// Reads Marlin's M486: `S1`, `S-1`, `AName`, `P1`, `U1`, `C`.
    fn read_m486(&mut self, words: &str) {
        let (letter, rest) = words.split_at_checked(1).unwrap_or(("", ""));
        let digits = rest.find(|letter: char| !letter.is_ascii_digit()).unwrap_or(rest.len());
        let number = rest.get(..digits).and_then(|digits| digits.parse::<u32>().ok());
        match (letter.to_ascii_uppercase().as_str(), number) {
            ("S", Some(number)) => {
                self.object = self.numbered(number);
                let name = rest.get(digits..).unwrap_or("").trim().strip_prefix(['A', 'a']);
                name.into_iter().for_each(|name| self.name_current(name));
            }
            ("S", None) => self.object = 0,
            ("A", _) => self.name_current(rest),
            ("P", Some(number)) => {
                let place = self.numbered(number);
                self.leave_out(place, true);
            }
            ("U", Some(number)) => {
                let place = self.numbered(number);
                self.leave_out(place, false);
            }
            ("C", _) => self.leave_out(self.object, true),
            _ => {}
        }
    }

    fn name_current(&mut self, name: &str) {
        let name = name.trim().trim_matches('"');
        if let (false, Some(object)) =
            (name.is_empty(), self.object.checked_sub(1).and_then(|place| self.objects.get_mut(place)))
        {
            name.clone_into(&mut object.name);
        }
    }

    fn leave_out(&mut self, place: usize, yes: bool) {
        if let Some(object) = place.checked_sub(1).and_then(|place| self.objects.get_mut(place)) {
            object.is_left_out = yes;
        }
    }

    /// Returns the object of this name, which may be new. Names differ by more than case, as for the
    /// machine.
    fn named(&mut self, name: &str) -> usize {
        let known = self.objects.iter().position(|object| object.name.eq_ignore_ascii_case(name));
        known.map_or_else(|| self.new_object(name.to_owned(), None), |place| place + 1)
    }

    fn numbered(&mut self, number: u32) -> usize {
        let known = self.objects.iter().position(|object| object.number == Some(number));
        known.map_or_else(|| self.new_object(format!("object {number}"), Some(number)), |place| place + 1)
    }

    fn new_object(&mut self, name: String, number: Option<u32>) -> usize {
        self.objects.push(Object { name, number, is_left_out: false });
        self.objects.len()
    }
}

fn place_of(names: &mut Vec<String>, name: &str) -> usize {
    let known = names.iter().position(|known| known == name);
    1 + known.unwrap_or_else(|| {
        names.push(name.to_owned());
        names.len() - 1
    })
}

/// Returns the rest of a line behind `code`, if the line begins with that code.
fn after_code<'a>(line: &'a str, code: &str) -> Option<&'a str> {
    let rest = line.get(code.len()..).filter(|_| line[..code.len()].eq_ignore_ascii_case(code))?;
    (!rest.starts_with(|letter: char| letter.is_ascii_digit() || letter == '.')).then(|| rest.trim_start())
}

/// Returns the kind of feature that begins with this comment.
fn feature_of(text: &str) -> Option<&str> {
    for prefix in ["TYPE:", "FEATURE:", "feature "] {
        if let Some(name) = text.strip_prefix(prefix) {
            return Some(name.trim()).filter(|name| !name.is_empty());
        }
    }
    if let Some((name, _)) = text.strip_prefix('\'').and_then(|rest| rest.split_once('\'')) {
        return Some(name);
    }
    PLAIN_FEATURES.contains(&text).then_some(text)
}

/// Returns the object that begins with this comment; empty if one ends.
fn object_of(text: &str) -> Option<&str> {
    if text.starts_with("stop printing object") {
        return Some("");
    }
    if let Some(name) = text.strip_prefix("printing object ") {
        return Some(name.trim());
    }
    if let Some(number) = text.strip_prefix("start printing object, unique label id:") {
        return Some(number.trim());
    }
    let name = text.strip_prefix("MESH:").or_else(|| text.strip_prefix("PRINTING:"))?.trim();
    Some(if matches!(name, "NONMESH" | "NON-OBJECT") { "" } else { name })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(lines: &[&str]) -> Marks {
        let mut marks = Marks::of(lines.join("\n").as_bytes());
        lines.iter().for_each(|line| marks.read(line.as_bytes()));
        marks
    }

    #[test]
    fn every_slicers_features_are_known() {
        for (line, feature) in [
            (";TYPE:External perimeter", "External perimeter"),
            (";TYPE:WALL-OUTER", "WALL-OUTER"),
            ("; FEATURE: Outer wall", "Outer wall"),
            ("; feature outer perimeter", "outer perimeter"),
            ("; gap fill", "gap fill"),
            ("; 'Perimeter Path', 0.9 [feed mm/s], 20.0 [head mm/s]", "Perimeter Path"),
        ] {
            let marks = read(&[line]);
            assert_eq!((marks.features.as_slice(), marks.label().feature), (&[feature.to_owned()][..], 1), "{line}");
        }
        for line in
            ["; TYPES of plastic", ";TYPE:", "; infill extrusion width = 0.45mm", "; it's 'so'", "G1 X1 ; skirt"]
        {
            assert!(read(&[line]).features.is_empty(), "{line}");
        }
        let marks = read(&[";LAYER_CHANGE", ";TYPE:A", ";TYPE:B", ";LAYER_CHANGE", ";TYPE:A"]);
        assert_eq!((marks.label(), marks.features.len()), (Label { layer: 2, feature: 1, object: 0 }, 2));
    }

    #[test]
    fn every_way_to_name_objects_is_known() {
        for (lines, names, current) in [
            (
                &["; printing object Box id:0 copy 0", "; stop printing object Box id:0 copy 0"][..],
                &["Box id:0 copy 0"][..],
                0,
            ),
            (&["; start printing object, unique label id: 15"], &["15"], 1),
            (&[";MESH:a.stl", ";MESH:NONMESH", ";MESH:b.stl"], &["a.stl", "b.stl"], 2),
            (&[";PRINTING: a", ";PRINTING: NON-OBJECT"], &["a"], 0),
            (&["EXCLUDE_OBJECT_DEFINE NAME=a CENTER=1,2", "exclude_object_start name=A"], &["a"], 1),
            (&["EXCLUDE_OBJECT_START NAME=\"a\"", "EXCLUDE_OBJECT_END NAME=a"], &["a"], 0),
            (&["M486 T2", "M486 S0 A\"Cube (1)\"", "M486 S-1", "M486 S1", "M486 ABall"], &["Cube (1)", "Ball"], 2),
            (&["m486 s7"], &["object 7"], 1),
            // A file with both comments and commands does not count its objects twice.
            (&["; printing object a id:0", "EXCLUDE_OBJECT_START NAME=a_id_0"], &["a_id_0"], 1),
        ] {
            let marks = read(lines);
            let found: Vec<_> = marks.objects.iter().map(|object| object.name.as_str()).collect();
            assert_eq!((found.as_slice(), marks.label().object), (names, current), "{lines:?}");
        }
        assert!(read(&["M4860 S1", "M486.1 S2", "EXCLUDE_OBJECT", "M486"]).objects.is_empty());
    }

    #[test]
    fn what_the_file_leaves_out_is_known() {
        for (lines, is_left_out) in [
            (&["EXCLUDE_OBJECT_DEFINE NAME=a", "EXCLUDE_OBJECT NAME=a", "EXCLUDE_OBJECT_START NAME=a"][..], true),
            (&["EXCLUDE_OBJECT_START NAME=a", "EXCLUDE_OBJECT CURRENT=1"], true),
            (&["EXCLUDE_OBJECT NAME=a", "EXCLUDE_OBJECT NAME=a RESET=1", "EXCLUDE_OBJECT_START NAME=a"], false),
            (&["EXCLUDE_OBJECT NAME=a", "EXCLUDE_OBJECT RESET=1", "EXCLUDE_OBJECT_START NAME=a"], false),
            (&["EXCLUDE_OBJECT NAME=a", "EXCLUDE_OBJECT_START NAME=b"], false),
            (&["M486 P1", "M486 S1"], true),
            (&["M486 P1", "M486 S2"], false),
            (&["M486 S1", "M486 C"], true),
            (&["M486 S1", "M486 C", "M486 U1"], false),
            (&["M486 S1", "M486 C", "M486 S-1"], false),
        ] {
            assert_eq!(read(lines).is_left_out(), is_left_out, "{lines:?}");
        }
    }
}
