//! Places at which a job is to pause: a layer, a line, a height.

use core::fmt;

use base::failure::Failure;
use config::Command;
use heapless::Vec;

/// Greatest number of places.
const MOST: usize = 8;
/// Command where no other is asked for: heaters stay on.
const SUSPEND: &str = "suspend h";

/// Place at which a job pauses.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Place {
    /// Before the first line behind this layer's mark.
    Layer(u32),
    /// Before this line of the file.
    Line(u32),
    /// Before the first line that prints at this height of the program or above, mm.
    Height(f64),
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Layer(layer) => write!(f, "layer {layer}"),
            Self::Line(line) => write!(f, "line {line}"),
            Self::Height(mm) => write!(f, "height {mm} mm"),
        }
    }
}

/// Progress of a job, with the next line that is to be carried out.
#[derive(Clone, Copy, Debug)]
pub struct Reached<'l> {
    pub layer: u32,
    pub line: u32,
    /// Z of the program.
    pub height: f64,
    pub text: &'l [u8],
}

/// Places that are still to come, with the commands for them.
#[derive(Clone, Debug, Default)]
pub struct Pauses {
    all: Vec<(Place, Command), MOST>,
}

impl Pauses {
    /// Returns whether no place to pause at is set.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.all.is_empty()
    }

    /// Returns all places with their commands.
    pub fn iter(&self) -> impl Iterator<Item = (Place, &str)> {
        self.all.iter().map(|(place, command)| (*place, command.as_str()))
    }

    /// Forgets all places to pause at.
    pub fn clear(&mut self) {
        self.all.clear();
    }

    /// Adds a place with its command, unless both are known. An empty `command` suspends the job, and heaters
    /// stay on.
    ///
    /// # Errors
    /// When there are too many, or the command is too long.
    pub fn add(&mut self, place: Place, command: &str) -> Result<(), Failure> {
        let command = if command.is_empty() { SUSPEND } else { command };
        let command = Command::try_from(command).map_err(|_| Failure::refused(&"the command is too long"))?;
        // A file that is read several times adds the same pauses each time.
        if self.all.iter().any(|(known, does)| *known == place && *does == command) {
            return Ok(());
        }
        let full = |_| Failure::refused(&"there are eight places already: pause clear forgets them");
        self.all.push((place, command)).map_err(full)
    }

    /// Takes out the place that has been reached, and with it all places that have been passed.
    pub fn take(&mut self, reached: &Reached<'_>) -> Option<(Place, Command)> {
        let is_reached = |place: &Place| match *place {
            Place::Layer(layer) => reached.layer >= layer,
            Place::Line(line) => reached.line >= line,
            Place::Height(mm) => reached.height >= mm && prints(reached.text),
        };
        let first = self.all.iter().position(|(place, _)| is_reached(place))?;
        let taken = self.all.get(first).cloned();
        self.all.retain(|(place, _)| !is_reached(place));
        taken
    }
}

/// Whether a line moves along while the extruder pushes: a lift between two islands is no height of the part.
pub(super) fn prints(line: &[u8]) -> bool {
    let has = |letter: u8| line.iter().any(|byte| byte.eq_ignore_ascii_case(&letter));
    has(b'E')
        && (has(b'X') || has(b'Y'))
        && line.trim_ascii_start().first().is_some_and(|first| matches!(first, b'G' | b'g'))
}

/// Reads a place and its command: `layer 12 command`.
///
/// # Errors
/// When the words are others, with those that are taken.
pub fn parse(text: &str) -> Result<(Place, &str), Failure> {
    const WORDS: &str = "pause takes: at layer N, at line N, at height MM, list, clear; a command may follow";
    let wrong = || Failure::refused(&WORDS);
    let (kind, rest) = text.trim().split_once(' ').ok_or_else(wrong)?;
    let (number, command) = rest.trim().split_once(' ').unwrap_or((rest.trim(), ""));
    let count = || number.parse::<u32>().ok().filter(|count| *count > 0).ok_or_else(wrong);
    let place = match kind {
        "layer" => Place::Layer(count()?),
        "line" => Place::Line(count()?),
        "height" => Place::Height(gcode::read_f64(number).filter(|mm| mm.is_finite()).ok_or_else(wrong)?),
        _ => return Err(wrong()),
    };
    Ok((place, command.trim()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn reached(layer: u32, line: u32, height: f64, text: &str) -> Reached<'_> {
        Reached { layer, line, height, text: text.as_bytes() }
    }

    #[test]
    fn places_are_read() {
        assert_eq!(parse("layer 12"), Ok((Place::Layer(12), "")));
        assert_eq!(parse(" line 3  M600 "), Ok((Place::Line(3), "M600")));
        assert_eq!(parse("height 1.25 M117 half of it"), Ok((Place::Height(1.25), "M117 half of it")));
        for wrong in ["", "layer", "layer 0", "layer -1", "line x", "height inf", "height", "time 3"] {
            assert!(parse(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn each_is_reached_once() {
        let mut pauses = Pauses::default();
        for text in ["layer 3 M600", "line 10", "height 2"] {
            let (place, command) = parse(text).unwrap();
            pauses.add(place, command).unwrap();
        }
        assert_eq!(pauses.take(&reached(2, 9, 0.5, "G1 X1 E1")), None);
        let (place, command) = pauses.take(&reached(3, 9, 0.6, "G1 X1 E1")).unwrap();
        assert_eq!((place, command.as_str()), (Place::Layer(3), "M600"));
        assert_eq!(pauses.take(&reached(3, 9, 0.6, "G1 X1 E1")), None);
        assert_eq!(
            pauses.take(&reached(3, 11, 2.5, "G1 X1 Y2")).unwrap().1.as_str(),
            SUSPEND,
            "a line that was passed"
        );
        assert_eq!(pauses.take(&reached(4, 12, 2.5, "G0 X1 Y2")), None, "a lift");
        assert_eq!(pauses.take(&reached(4, 12, 2.5, "G1 E-2")), None, "a retraction");
        assert!(pauses.take(&reached(4, 12, 2.5, "G1 X1 Y2 E3")).is_some() && pauses.is_empty());
    }

    #[test]
    fn there_is_room_for_eight() {
        let mut pauses = Pauses::default();
        for line in (1..=8).chain(1..=8) {
            pauses.add(Place::Line(line), "").unwrap();
        }
        assert!(pauses.add(Place::Line(9), "").is_err());
        assert!(Pauses::default().add(Place::Line(9), &"x".repeat(200)).is_err());
    }
}
