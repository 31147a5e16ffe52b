//! Settings that probing a bed starts from, and the state of the mesh in force beside its heights.

use config::MachineConfig;

use crate::touches::Scatter;

/// Greatest number of places at which an axis twist is given.
pub const MOST_TWIST_POINTS: usize = config::MOST_TWIST_POINTS;

/// Error of the probe along an axis whose rail is twisted: how much too high the probe reads.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Twist {
    /// Whether the twist is along Y; else along X.
    pub along_y: bool,
    /// Places in rising order, and what the probe reads too high there, mm. Empty: none.
    points: [[f64; 2]; MOST_TWIST_POINTS],
    count: usize,
}

impl Twist {
    /// Takes the twist from the configuration.
    #[must_use]
    pub fn new(config: &MachineConfig) -> Self {
        let mut twist = Self { along_y: config.axis_twist.along_y, ..Self::default() };
        config.axis_twist.points.iter().for_each(|point| twist.push(*point));
        twist
    }

    /// Returns a twist without places, along Y or along X.
    #[must_use]
    pub fn along(along_y: bool) -> Self {
        Self { along_y, ..Self::default() }
    }

    /// Adds a place behind the others; a place beyond the room is left out.
    pub fn push(&mut self, point: [f64; 2]) {
        if let Some(slot) = self.points.get_mut(self.count) {
            *slot = point;
            self.count += 1;
        }
    }

    /// Returns the places of the twist, and the error there, mm.
    #[must_use]
    pub fn points(&self) -> &[[f64; 2]] {
        self.points.get(..self.count).unwrap_or(&[])
    }

    /// Returns what the probe reads too high with its tip here, mm: linear between places, and constant
    /// beyond the first and last.
    #[must_use]
    pub fn at(&self, [x, y]: [f64; 2]) -> f64 {
        let place = if self.along_y { y } else { x };
        let (Some(first), Some(last)) = (self.points().first(), self.points().last()) else { return 0.0 };
        if place <= first[0] {
            return first[1];
        }
        let between = self.points().windows(2).find_map(|pair| match pair {
            [[a, low], [b, high]] if place < *b && b > a => Some(low + (place - a) / (b - a) * (high - low)),
            _ => None,
        });
        between.unwrap_or(last[1])
    }
}

/// Longest name of a mesh.
pub const MESH_NAME: usize = 24;

/// Settings of the bed, from the configuration, codes and measuring.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Bed {
    /// Three points to probe, X and Y, mm.
    pub points: [[f64; 2]; 3],
    /// Offset of the probe from the tool, mm.
    pub probe_offsets: [f64; 3],
    /// Change of the probe's error along an axis.
    pub twist: Twist,
    /// Whether G31 and G32 take the area from their words: `only_by_two_corners`, until R0, or R1.
    pub two_corners: bool,
    /// Scatter of touches, since measuring began.
    pub scatter: Scatter,
    /// Height at which the mesh has faded out, starting from Z0, mm, in place of the configured one; 0: no
    /// fading. M376.
    pub fade_height: Option<f64>,
    /// Correction that is left at the fade height, mm, in place of the configured one. M376 T.
    pub fade_target: Option<f64>,
    /// Distance from the tool at which the mesh is looked up, mm. M420.1.
    pub mesh_offset: [f64; 2],
    /// Offset of a mesh that M420 S0 has set aside, and that S1 puts in force again.
    pub mesh_waits: Option<[f64; 2]>,
    /// Name of the file that the mesh in force is saved in.
    pub mesh_name: MeshName,
}

impl Bed {
    /// Takes the settings from the configuration.
    #[must_use]
    pub fn new(config: &MachineConfig) -> Self {
        Self {
            points: config.leveling.points,
            probe_offsets: config.probe_offsets(),
            twist: Twist::new(config),
            two_corners: config.leveling.grid.two_corners,
            ..Self::default()
        }
    }
}

/// The name of a saved mesh: letters, digits, `-` and `_`. Empty: it has none.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct MeshName {
    letters: [u8; MESH_NAME],
    length: u8,
}

impl MeshName {
    /// Reads a name, in quotes or not; of RepRapFirmware's paths only the part between folder and ending.
    ///
    /// # Errors
    /// The rule that the name breaks.
    pub fn read(text: &str) -> Result<Self, &'static str> {
        let path = text.trim().trim_matches('"');
        let file = path.rsplit_once('/').map_or(path, |(_, file)| file);
        let name = file.strip_suffix(".csv").or_else(|| file.strip_suffix(".mesh")).unwrap_or(file);
        let is_letter = |byte: u8| byte.is_ascii_alphanumeric() || byte == b'-' || byte == b'_';
        if name.is_empty() || !name.bytes().all(is_letter) {
            return Err("the name of a mesh is made of letters, digits, - and _");
        }
        // Files with these beginnings stand beside a file while it is replaced: see `files::safe_file`.
        if ["draft-", "new-", "previous-"].iter().any(|start| name.starts_with(start)) {
            return Err("the name of a mesh does not begin with draft-, new- or previous-");
        }
        let mut letters = [0; MESH_NAME];
        let room = letters.get_mut(..name.len()).ok_or("the name of a mesh has 24 letters at most")?;
        room.copy_from_slice(name.as_bytes());
        Ok(Self { letters, length: name.len() as u8 })
    }

    /// Returns the name as text.
    #[must_use]
    pub fn as_str(&self) -> &str {
        let letters = self.letters.get(..usize::from(self.length)).unwrap_or_default();
        core::str::from_utf8(letters).unwrap_or_default()
    }

    /// Returns whether the mesh has no name.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.length == 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_twist_goes_straight_from_place_to_place() {
        let mut twist = Twist::default();
        [[10.0, 0.1], [60.0, 0.0], [110.0, -0.3]].into_iter().for_each(|point| twist.push(point));
        for (x, reads) in [(-5.0, 0.1), (10.0, 0.1), (35.0, 0.05), (60.0, 0.0), (85.0, -0.15), (200.0, -0.3)] {
            assert!((twist.at([x, 7.0]) - reads).abs() < 1e-12, "{x}");
        }
        assert_eq!(Twist { along_y: true, ..twist }.at([60.0, 10.0]), 0.1);
        assert_eq!(Twist::default().at([60.0, 10.0]), 0.0);
    }

    #[test]
    fn names_are_read_as_people_write_them() {
        for text in ["pei-1", " \"pei-1\" ", "0:/sys/pei-1.csv", "pei-1.mesh "] {
            assert_eq!(MeshName::read(text).expect(text).as_str(), "pei-1");
        }
        assert_eq!(MeshName::read("Plate_2").expect("a name").as_str(), "Plate_2");
        for text in ["", "\"\"", "a b", "x/", "a.txt", "new-1", "\u{e4}", "abcdefghijklmnopqrstuvwxy"] {
            assert!(MeshName::read(text).is_err(), "{text}");
        }
        assert!(MeshName::default().is_empty());
    }
}
